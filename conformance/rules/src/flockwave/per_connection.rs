//! The state of a check, stored separately for each connection.

use uavspec_flockwave::session::{ConnectionId, Exchange, Role};

use crate::limits::MAX_CONNECTIONS;

/// A state for each connection. The state is reset when the connection is reopened, or when some of the connection's
/// records may be missing.
#[derive(Debug)]
pub(super) struct PerConnection<T>(Vec<(ConnectionId, T)>);

impl<T> Default for PerConnection<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T: Default> PerConnection<T> {
    /// The state of a record's connection.
    pub(super) fn get(&mut self, exchange: &Exchange<'_>) -> &mut T {
        self.at(exchange.connection_id())
    }

    /// The state of a connection.
    pub(super) fn at(&mut self, connection: ConnectionId) -> &mut T {
        let at = self.position(connection.index).unwrap_or_else(|| {
            if self.0.len() >= MAX_CONNECTIONS
                && let Some(first) = (0..self.0.len()).min_by_key(|at| self.0[*at].0.index)
            {
                self.0.swap_remove(first);
            }
            self.0.push((connection, T::default()));
            self.0.len() - 1
        });
        let (id, state) = &mut self.0[at];
        if *id != connection {
            (*id, *state) = (connection, T::default());
        }
        state
    }

    /// Removes and returns the state of a connection, if this record reports that the connection closed. Drops the
    /// state if records may be missing: after unreadable data, and if the connection reopens without having closed.
    pub(super) fn closed(&mut self, exchange: &Exchange<'_>) -> Option<T> {
        let is_closed = match exchange.role {
            Role::Event if exchange.record.text == "closed" => true,
            Role::Event if exchange.record.text == "connect" => false,
            Role::Unreadable if exchange.is_from_server() => false,
            _ => return None,
        };
        let at = self.position(exchange.record.connection.index)?;
        let (_, state) = self.0.swap_remove(at);
        is_closed.then_some(state)
    }

    /// The position of the state that belongs to the connection with this index.
    fn position(&self, index: usize) -> Option<usize> {
        self.0.iter().position(|(id, _)| id.index == index)
    }

    /// Removes all states.
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::{ConnectionId, MAX_CONNECTIONS, PerConnection};

    fn id(index: usize) -> ConnectionId {
        ConnectionId { index, serial: 1 }
    }

    #[test]
    fn a_reopened_connection_has_a_new_state() {
        let mut states = PerConnection::<u32>::default();
        *states.at(id(0)) = 7;
        assert_eq!(*states.at(id(0)), 7);
        assert_eq!(*states.at(ConnectionId { index: 0, serial: 2 }), 0);
    }

    #[test]
    fn the_state_of_the_first_connection_is_dropped_if_there_are_too_many() {
        let mut states = PerConnection::<u32>::default();
        (0..MAX_CONNECTIONS).for_each(|index| *states.at(id(index)) = 7);
        assert_eq!((*states.at(id(3)), *states.at(id(0))), (7, 7));
        *states.at(id(MAX_CONNECTIONS)) = 7;
        assert_eq!((*states.at(id(1)), *states.at(id(0))), (7, 0));
    }
}
