//! The shapes of the bodies of all messages of some definitions.

use std::collections::{BTreeMap, HashMap};

use uavspec_codegen::schema::json_type::Direction;
use uavspec_codegen::source::Span;

use super::defined::{Object, Tuple, ValueSchema};

/// The shapes of the bodies of all messages of some definitions.
#[derive(Debug, Default)]
pub struct DefinedSchemas {
    /// By the type of the message, the body for each direction that it has.
    pub(super) messages: HashMap<String, [Option<Body>; 3]>,
    /// The shapes of all types and bodies, by the names that test vectors give them: `flockwave/Weather`,
    /// `flockwave/WTH-AT.response`.
    pub(super) named: BTreeMap<String, ValueSchema>,
    /// The objects that bodies are and hold.
    pub(super) objects: Vec<Object>,
    /// The tuples that bodies hold.
    pub(super) tuples: Vec<Tuple>,
    /// Whether they are of other definitions than those that places are looked up in.
    pub(super) is_foreign: bool,
}

/// The body of a message for a direction.
#[derive(Debug)]
pub(super) struct Body {
    /// Its object, by its index.
    pub(super) object: usize,
    /// Where it is defined.
    pub(super) span: Span,
}

impl DefinedSchemas {
    /// The same, for a use beside other definitions: where they are defined isn't told.
    #[must_use]
    pub(crate) fn foreign(self) -> Self {
        Self { is_foreign: true, ..self }
    }

    /// Whether there are messages of this type.
    pub(crate) fn has(&self, type_name: &str) -> bool {
        self.messages.contains_key(type_name)
    }

    /// Whether messages of this type go this way.
    pub(crate) fn is_defined(&self, type_name: &str, direction: Direction) -> bool {
        self.body(type_name, direction).is_some()
    }

    /// The names of all types and bodies, as test vectors have them.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.named.keys().map(String::as_str)
    }

    /// Whether there is a shape of this name.
    pub fn has_schema(&self, name: &str) -> bool {
        self.named.contains_key(name)
    }

    pub(super) fn body(&self, type_name: &str, direction: Direction) -> Option<&Body> {
        self.messages.get(type_name)?[direction as usize].as_ref()
    }
}
