//! What rules keep of connections.

use std::collections::BTreeMap;

use super::{Exchange, Role};

/// Of how many connections something is kept; more at the same time are rare, and of the oldest it is forgotten.
const MAX_CONNECTIONS: usize = 16;

/// A state for each connection. It begins anew with the connection, and where nothing is known any more of what went
/// over it.
#[derive(Debug)]
pub(in crate::rules) struct PerConnection<T>(BTreeMap<usize, (u64, T)>);

impl<T> Default for PerConnection<T> {
    fn default() -> Self {
        Self(BTreeMap::new())
    }
}

impl<T: Default> PerConnection<T> {
    /// The state of the connection over which something goes.
    pub(in crate::rules) fn of(&mut self, exchange: &Exchange<'_>) -> &mut T {
        let index = exchange.record.connection.index;
        if self.0.len() >= MAX_CONNECTIONS && !self.0.contains_key(&index) {
            self.0.pop_first();
        }
        let (serial, state) = self.0.entry(index).or_default();
        if *serial != exchange.serial {
            (*serial, *state) = (exchange.serial, T::default());
        }
        state
    }

    /// The state of a connection that comes to its end here, and is known to.
    pub(in crate::rules) fn closed(&mut self, exchange: &Exchange<'_>) -> Option<T> {
        if exchange.role != Role::Event || exchange.record.text != "closed" {
            return None;
        }
        self.0.remove(&exchange.record.connection.index).map(|(_, state)| state)
    }

    /// Forgets all.
    pub(in crate::rules) fn clear(&mut self) {
        self.0.clear();
    }
}
