//! The schemas that a file brings, and what they are beside the definitions.

use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;
use std::sync::Arc;

use uavspec_codegen::schema::MessageId;

use super::{Basis, MAX_NAME, Stated, digest, json_schema};
use crate::definitions::Definitions;
use crate::px4::comparison::{Comparison, compare_declared};

/// Most bytes of all schemas that are kept: those of five hundred types of ROS 2 with all that they nest take half.
const MAX_SCHEMAS: usize = 8 << 20;

/// Most bytes of one of them.
const MAX_SCHEMA: usize = 1 << 20;

/// What a schema is beside a definition; the types that it states, where CDR has to be read by them; and the version
/// that it says its message has.
type ComparedSchema = (Basis, Option<Rc<Stated>>, Option<u32>);

/// The schemas of a file, by id.
#[derive(Default)]
pub(super) struct Schemas {
    by_id: HashMap<u16, Schema>,
    /// Bytes of all that are kept.
    num_bytes: usize,
}

struct Schema {
    name: String,
    encoding: String,
    /// Nothing where it is too long to be kept.
    text: Option<Vec<u8>>,
    /// What tells it from another of the same id.
    digest: u64,
    /// What it is beside definitions, for those that channels asked for; whether they have JSON.
    compared: BTreeMap<(MessageId, bool), ComparedSchema>,
}

impl Schemas {
    /// Adds a schema; an error says what is wrong with it.
    pub(super) fn add(&mut self, id: u16, name: String, encoding: String, text: &[u8]) -> Result<(), String> {
        if id == 0 {
            return Err("a schema of the id 0, which stands for none".to_owned());
        }
        let digest = digest(&(&name, &encoding, text));
        match self.by_id.get(&id) {
            // Summaries and chunks repeat what was said.
            Some(known) if known.digest == digest => return Ok(()),
            Some(_) => return Err(format!("schema {id} is another than before; the first one is used")),
            None => {}
        }
        if name.len() > MAX_NAME || encoding.len() > MAX_NAME {
            return Err(format!("schema {id} has a name or an encoding of more than {MAX_NAME} bytes"));
        }
        let fits = text.len() <= MAX_SCHEMA && self.num_bytes + text.len() <= MAX_SCHEMAS;
        let num_bytes = fits.then(|| text.to_vec());
        self.num_bytes += num_bytes.as_ref().map_or(0, Vec::len);
        self.by_id.insert(id, Schema { name, encoding, text: num_bytes, digest, compared: BTreeMap::new() });
        if fits {
            return Ok(());
        }
        Err(format!(
            "schema {id} has {} bytes; those of more than {MAX_SCHEMA}, or of more than {MAX_SCHEMAS} together, \
             aren't compared",
            text.len()
        ))
    }

    /// The name and the encoding of a schema.
    pub(super) fn get(&self, id: u16) -> Option<(&str, &str)> {
        self.by_id.get(&id).map(|schema| (schema.name.as_str(), schema.encoding.as_str()))
    }

    /// What a schema is beside a definition, for messages as CDR or as JSON.
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
            // So rosbag2 writes types whose definitions it doesn't find.
            _ if text.is_empty() => (Basis::NoSchema, None, None),
            ("ros2msg", false) => types(&schema.name, text, message_id, definitions),
            ("jsonschema", true) => (json(text, message_id, definitions), None, None),
            (encoding, _) => (Basis::Encoding(encoding.escape_debug().to_string()), None, None),
        });
        compared.clone()
    }
}

/// What the text of a schema as `ros2msg` is beside a definition.
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

/// What the text of a JSON Schema is beside a definition.
fn json(text: &[u8], message_id: MessageId, definitions: &Definitions) -> Basis {
    match json_schema::compare(text, message_id, &definitions.schema) {
        Ok(Some(comparison)) => Basis::Compared(Arc::new(comparison)),
        Ok(None) => Basis::NoSchema,
        Err(error) => Basis::Unreadable(error),
    }
}
