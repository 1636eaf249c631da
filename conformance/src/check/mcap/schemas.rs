//! The schemas in a file, and their comparison with the definitions.

use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;
use std::sync::Arc;

use uavspec_codegen::schema::MessageId;

use super::{Basis, MAX_NAME, Stated, digest, json_schema};
use crate::definitions::Definitions;
use crate::px4::comparison::{Comparison, compare_declared};

/// The maximum total size of stored schemas, in bytes. Five hundred ROS 2 types with their nested types take up half of
/// this space.
const MAX_SCHEMAS: usize = 8 << 20;

/// The maximum size of a stored schema, in bytes.
const MAX_SCHEMA: usize = 1 << 20;

/// The result of comparing a schema with a definition. The second item contains the types of the schema if they are
/// needed to decode CDR. The third item is the message version that the schema states.
type ComparedSchema = (Basis, Option<Rc<Stated>>, Option<u32>);

/// The schemas of a file, by id.
#[derive(Default)]
pub(super) struct Schemas {
    by_id: HashMap<u16, Schema>,
    /// The total size of the stored schemas, in bytes.
    num_bytes: usize,
}

struct Schema {
    name: String,
    encoding: String,
    /// The text; `None` if it is too long to store.
    text: Option<Vec<u8>>,
    /// A hash that distinguishes the schema from others with the same id.
    digest: u64,
    /// The comparisons that channels requested, by definition. The flag is true for JSON messages.
    compared: BTreeMap<(MessageId, bool), ComparedSchema>,
}

impl Schemas {
    /// Adds a schema. An error describes the problem.
    pub(super) fn add(&mut self, id: u16, name: String, encoding: String, text: &[u8]) -> Result<(), String> {
        if id == 0 {
            return Err("a schema has the reserved id 0".to_owned());
        }
        let digest = digest(&(&name, &encoding, text));
        match self.by_id.get(&id) {
            // Summaries and chunks repeat schemas.
            Some(known) if known.digest == digest => return Ok(()),
            Some(_) => {
                return Err(format!(
                    "schema {id} is declared again with different content; the first declaration is used"
                ));
            }
            None => {}
        }
        if name.len() > MAX_NAME || encoding.len() > MAX_NAME {
            return Err(format!("schema {id}: the name or the encoding is longer than {MAX_NAME} bytes"));
        }
        let fits = text.len() <= MAX_SCHEMA && self.num_bytes + text.len() <= MAX_SCHEMAS;
        let num_bytes = fits.then(|| text.to_vec());
        self.num_bytes += num_bytes.as_ref().map_or(0, Vec::len);
        self.by_id.insert(id, Schema { name, encoding, text: num_bytes, digest, compared: BTreeMap::new() });
        if fits {
            return Ok(());
        }
        Err(format!(
            "schema {id} is too long to compare: it has {} bytes; the limit is {MAX_SCHEMA} bytes per \
             schema and {MAX_SCHEMAS} bytes in total",
            text.len()
        ))
    }

    /// The name and the encoding of a schema.
    pub(super) fn get(&self, id: u16) -> Option<(&str, &str)> {
        self.by_id.get(&id).map(|schema| (schema.name.as_str(), schema.encoding.as_str()))
    }

    /// Compares a schema with a definition, for messages in CDR or JSON.
    pub(super) fn compared(
        &mut self,
        id: u16,
        message_id: MessageId,
        is_json: bool,
        definitions: &Definitions,
    ) -> ComparedSchema {
        let Some(schema) = self.by_id.get_mut(&id) else { return (Basis::NoSchema, None, None) };
        let Some(text) = &schema.text else { return (Basis::TooLong, None, None) };
        let compared = schema.compared.entry((message_id, is_json));
        let compared = compared.or_insert_with(|| match (schema.encoding.as_str(), is_json) {
            // rosbag2 writes an empty schema for types whose definitions it can't find.
            _ if text.is_empty() => (Basis::NoSchema, None, None),
            ("ros2msg", false) => types(&schema.name, text, message_id, definitions),
            ("jsonschema", true) => (json(text, message_id, definitions), None, None),
            (encoding, _) => (Basis::Encoding(encoding.escape_debug().to_string()), None, None),
        });
        compared.clone()
    }
}

/// Compares the text of a `ros2msg` schema with a definition.
fn types(name: &str, text: &[u8], message_id: MessageId, definitions: &Definitions) -> ComparedSchema {
    match Stated::read(name, text) {
        Err(error) => (Basis::Unreadable(error), None, None),
        Ok(stated) => {
            let comparison = compare_declared(stated.root(), definitions.types().get(message_id));
            let (differs, version) = (comparison != Comparison::Equal, stated.version());
            (Basis::Compared(Arc::new(comparison)), differs.then(|| Rc::new(stated)), version)
        }
    }
}

/// Compares the text of a JSON Schema with a definition.
fn json(text: &[u8], message_id: MessageId, definitions: &Definitions) -> Basis {
    match json_schema::compare(text, message_id, &definitions.schema) {
        Ok(Some(comparison)) => Basis::Compared(Arc::new(comparison)),
        Ok(None) => Basis::NoSchema,
        Err(error) => Basis::Unreadable(error),
    }
}
