//! What rules keep of connections.

use std::collections::BTreeMap;

use super::{Exchange, Role};
use crate::flockwave::session::ConnectionId;

/// Of how many connections something is kept; more at the same time are rare, and of the oldest it is forgotten.
const MAX_CONNECTIONS: usize = 16;

/// A state for each connection. It begins anew with the connection, and where nothing is known any more of what went
/// over it.
#[derive(Debug)]
pub(super) struct PerConnection<T>(BTreeMap<usize, (u64, T)>);

impl<T> Default for PerConnection<T> {
    fn default() -> Self {
        Self(BTreeMap::new())
    }
}

impl<T: Default> PerConnection<T> {
    /// The state of the connection over which something goes.
    pub(super) fn get(&mut self, exchange: &Exchange<'_>) -> &mut T {
        self.at(exchange.connection_id())
    }

    /// The state of a connection.
    pub(super) fn at(&mut self, connection: ConnectionId) -> &mut T {
        let ConnectionId { index, serial: now } = connection;
        if self.0.len() >= MAX_CONNECTIONS && !self.0.contains_key(&index) {
            self.0.pop_first();
        }
        let (serial, state) = self.0.entry(index).or_default();
        if *serial != now {
            (*serial, *state) = (now, T::default());
        }
        state
    }

    /// The state of a connection that comes to its end here, and is known to.
    pub(super) fn closed(&mut self, exchange: &Exchange<'_>) -> Option<T> {
        if exchange.role != Role::Event || exchange.record.text != "closed" {
            return None;
        }
        self.0.remove(&exchange.record.connection.index).map(|(_, state)| state)
    }

    /// Forgets all.
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }
}
