//! The number of messages of each type.

use std::collections::BTreeMap;

use uavspec_rules::definitions::Definitions;
use uavspec_schema::json_type::Direction;

use super::TypeCount;
use crate::coverage::Tally;
use crate::limits::{MAX_TYPE_NAME, MAX_UNKNOWN_TYPES};

/// The counts of all types.
#[derive(Default)]
pub(super) struct Types {
    by_name: BTreeMap<String, TypeCounts>,
    num_unknown: usize,
}

/// The counts of a type.
pub(super) struct TypeCounts {
    /// True if the definitions contain the type.
    pub(super) is_known: bool,
    pub(super) messages: TypeCount,
    /// The messages that the server sent, by direction.
    from_server: [FromServer; 3],
}

/// The messages of a type that the server sent in one direction.
#[derive(Clone, Copy, Default)]
pub(super) struct FromServer {
    /// True if there is a body schema for the direction. A type may lack a schema for some directions.
    pub(super) is_checked: bool,
    pub(super) tally: Tally,
    /// The number of values in the bodies.
    pub(super) values: u64,
}

impl TypeCounts {
    fn new(name: &str, definitions: &Definitions) -> Self {
        let schemas = definitions.body_schemas();
        let from_server = Direction::ALL.map(|direction| FromServer {
            is_checked: schemas.is_defined(name, direction),
            ..FromServer::default()
        });
        let messages = TypeCount { name: name.to_owned(), from_client: 0, from_server: 0 };
        Self { is_known: schemas.has(name), messages, from_server }
    }

    /// The counts of the messages that the server sent in a direction.
    pub(super) fn sent_by_server(&mut self, direction: Direction) -> &mut FromServer {
        &mut self.from_server[direction as usize]
    }

    /// The counts of the messages that the server sent, by direction. Directions without messages are left out.
    pub(super) fn directions(&self) -> impl Iterator<Item = (Direction, &FromServer)> {
        let all = Direction::ALL.into_iter().zip(&self.from_server);
        all.filter(|(_, found)| found.tally.records > 0)
    }
}

impl Types {
    /// The counts of a type. Returns `None` if the type isn't counted by name.
    pub(super) fn get(&mut self, name: &str, definitions: &Definitions) -> Option<&mut TypeCounts> {
        if !self.by_name.contains_key(name) {
            let counts = TypeCounts::new(name, definitions);
            let is_known = counts.is_known;
            if !is_known && (self.num_unknown == MAX_UNKNOWN_TYPES || name.len() > MAX_TYPE_NAME) {
                return None;
            }
            self.num_unknown += usize::from(!is_known);
            self.by_name.insert(name.to_owned(), counts);
        }
        self.by_name.get_mut(name)
    }

    /// The counts of all types, by name.
    pub(super) fn iter(&self) -> impl Iterator<Item = &TypeCounts> {
        self.by_name.values()
    }
}
