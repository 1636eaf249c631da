//! The body schemas of all defined messages.

use std::collections::{BTreeMap, HashMap};

use uavspec_schema::json_type::Direction;
use uavspec_schema::source::Span;

use super::defined::{Object, Tuple, ValueSchema};

/// The body schemas of all defined messages.
#[derive(Debug, Default)]
pub struct DefinedSchemas {
    /// The bodies by message type, one for each direction.
    pub(super) messages: HashMap<String, [Option<Body>; 3]>,
    /// The schemas of all types and bodies, by their names in test vectors, such as `flockwave/Weather` or
    /// `flockwave/WTH-AT.response`.
    pub(super) named: BTreeMap<String, ValueSchema>,
    /// The schemas of the objects in bodies.
    pub(super) objects: Vec<Object>,
    /// The schemas of the tuples in bodies.
    pub(super) tuples: Vec<Tuple>,
    /// True if the spans in these schemas don't refer to the current definitions.
    pub(super) is_foreign: bool,
}

/// The body of a message in one direction.
#[derive(Debug)]
pub(super) struct Body {
    /// The index of the body's object schema.
    pub(super) object: usize,
    /// The location of the body's definition.
    pub(super) span: Span,
}

impl DefinedSchemas {
    /// Marks the schemas as belonging to other definitions, so that no locations are reported.
    #[must_use]
    pub fn foreign(self) -> Self {
        Self { is_foreign: true, ..self }
    }

    /// True if messages of this type exist.
    pub fn has(&self, type_name: &str) -> bool {
        self.messages.contains_key(type_name)
    }

    /// True if messages of this type exist in this direction.
    pub fn is_defined(&self, type_name: &str, direction: Direction) -> bool {
        self.body(type_name, direction).is_some()
    }

    /// The message types that exist in this direction, in no particular order.
    pub fn types(&self, direction: Direction) -> impl Iterator<Item = &str> {
        let is_defined =
            move |(_, bodies): &(&String, &[Option<Body>; 3])| bodies[direction as usize].is_some();
        self.messages.iter().filter(is_defined).map(|(name, _)| name.as_str())
    }

    /// True if a body of this type and direction has a required field. `type` is not part of a body's definition.
    pub fn has_required_fields(&self, type_name: &str, direction: Direction) -> bool {
        let object = self.body(type_name, direction).map(|body| &self.objects[body.object]);
        object.is_some_and(|object| {
            object.fields.iter().any(|field| field.is_required && *field.name != *"type")
        })
    }

    /// The names of all types and bodies, as used in test vectors.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.named.keys().map(String::as_str)
    }

    /// True if a schema with this name exists.
    pub fn has_schema(&self, name: &str) -> bool {
        self.named.contains_key(name)
    }

    pub(super) fn body(&self, type_name: &str, direction: Direction) -> Option<&Body> {
        self.messages.get(type_name)?[direction as usize].as_ref()
    }
}
