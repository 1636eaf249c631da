//! The schemas in a file, and their comparison with the definitions.

use std::cell::OnceCell;
use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;
use std::sync::Arc;

use uavspec_model::limits::MAX_NAME;
use uavspec_px4::comparison::{Comparison, Differences, compare_declared};
use uavspec_px4::json::SharedFields;
use uavspec_rules::definitions::{Definitions, Stated};
use uavspec_schema::MessageId;

use super::{Basis, digest, json_schema};
use crate::limits::{MAX_BAG_CHANNELS, MAX_SCHEMA, MAX_SCHEMAS};
use crate::topic::full_name;

/// The result of comparing a schema with a definition.
#[derive(Clone)]
pub(super) struct ComparedSchema {
    pub(super) basis: Basis,
    /// The types of the schema, if they are needed to decode CDR.
    pub(super) stated: Option<Arc<Stated>>,
    /// The fields that JSON messages share with the definition, if the schema differs from it.
    pub(super) shared: Option<Rc<SharedFields>>,
    /// The message version in the schema.
    pub(super) version: Option<u32>,
}

impl From<Basis> for ComparedSchema {
    fn from(basis: Basis) -> Self {
        Self { basis, stated: None, shared: None, version: None }
    }
}

/// The schemas of a bag.
#[derive(Default)]
pub(super) struct Schemas {
    all: Vec<Schema>,
    /// The indices of the schemas, by their hash.
    by_digest: HashMap<u64, usize>,
    /// The total size of the stored schemas, in bytes.
    num_bytes: usize,
}

struct Schema {
    name: String,
    encoding: String,
    /// The text, or the size of the text if it is too long to store.
    text: Result<Vec<u8>, usize>,
    /// A hash that distinguishes the schema from others.
    digest: u64,
    /// The comparisons that channels requested, by definition. The flag is true for JSON messages.
    compared: BTreeMap<(MessageId, bool), ComparedSchema>,
    /// The types, or the reason why they can't be read. Set when first requested by a channel without a definition.
    own: OnceCell<Result<Arc<Stated>, Basis>>,
}

impl Schemas {
    /// Adds a schema, and returns its index. Files may repeat the schemas of other files. The error describes the
    /// problem.
    pub(super) fn add(&mut self, name: String, encoding: String, text: &[u8]) -> Result<usize, String> {
        let digest = digest(&(&name, &encoding, text));
        if let Some(known) = self.by_digest.get(&digest) {
            return Ok(*known);
        }
        if name.len() > MAX_NAME || encoding.len() > MAX_NAME {
            return Err(format!("the name or the encoding is longer than {MAX_NAME} bytes"));
        }
        if self.all.len() >= MAX_BAG_CHANNELS {
            return Err(format!("the bag has more than {MAX_BAG_CHANNELS} schemas"));
        }
        let fits = text.len() <= MAX_SCHEMA && self.num_bytes + text.len() <= MAX_SCHEMAS;
        let text = if fits { Ok(text.to_vec()) } else { Err(text.len()) };
        self.num_bytes += text.as_ref().map_or(0, Vec::len);
        self.by_digest.insert(digest, self.all.len());
        self.all.push(Schema {
            name,
            encoding,
            text,
            digest,
            compared: BTreeMap::new(),
            own: OnceCell::new(),
        });
        Ok(self.all.len() - 1)
    }

    /// The reason why a schema can't be compared, as a predicate.
    pub(super) fn problem(&self, index: usize) -> Option<String> {
        let length = self.all[index].text.as_ref().err()?;
        Some(format!(
            "is too long to compare: it has {length} bytes; the limit is {MAX_SCHEMA} bytes per schema and \
             {MAX_SCHEMAS} bytes in total"
        ))
    }

    /// True if a schema has this name, encoding and text.
    pub(super) fn is(&self, index: usize, name: &str, encoding: &str, text: &[u8]) -> bool {
        self.all[index].digest == digest(&(name, encoding, text))
    }

    /// The name and the encoding of a schema.
    pub(super) fn name(&self, index: usize) -> (&str, &str) {
        (&self.all[index].name, &self.all[index].encoding)
    }

    /// The types of a schema. The error is the reason why they can't be read. It is `None` if the schema has no text.
    pub(super) fn own(
        &self,
        index: Option<usize>,
        definitions: &Definitions,
    ) -> Result<Arc<Stated>, Option<String>> {
        let schema = index.and_then(|index| self.all.get(index)).ok_or(None)?;
        let read = || match &schema.text {
            Err(_) => Err(Basis::TooLong),
            Ok(text) if text.is_empty() => Err(Basis::NoSchema),
            Ok(text) if is_name(&schema.name, text) => Err(Basis::OnlyName),
            Ok(text) if schema.encoding == "ros2msg" => {
                definitions.shared.stated(&schema.name, text).map_err(Basis::Unreadable)
            }
            Ok(_) => Err(Basis::Encoding(schema.encoding.escape_debug().to_string())),
        };
        schema.own.get_or_init(read).clone().map_err(|basis| basis.problem())
    }

    /// The reason why a schema isn't used for JSON messages without a definition. `None` if the schema has no text.
    pub(super) fn unused(&self, index: Option<usize>) -> Option<String> {
        let schema = self.all.get(index?)?;
        let has_text = schema.text.as_ref().is_ok_and(|text| !text.is_empty());
        has_text.then(|| {
            "JSON messages are checked against definitions, not against schemas in the file".to_owned()
        })
    }

    /// Compares a schema with a definition, for messages in CDR or JSON.
    pub(super) fn compared(
        &mut self,
        index: Option<usize>,
        message_id: MessageId,
        is_json: bool,
        definitions: &Definitions,
    ) -> ComparedSchema {
        let Some(schema) = index.and_then(|index| self.all.get_mut(index)) else {
            return Basis::NoSchema.into();
        };
        let Ok(text) = &schema.text else { return Basis::TooLong.into() };
        let compared = schema.compared.entry((message_id, is_json));
        let compared = compared.or_insert_with(|| match (schema.encoding.as_str(), is_json) {
            // rosbag2 writes an empty schema for types whose definitions it can't find.
            _ if text.is_empty() => Basis::NoSchema.into(),
            _ if is_name(&schema.name, text) => Basis::OnlyName.into(),
            ("ros2msg", false) => types(&schema.name, text, message_id, definitions),
            ("jsonschema", true) => json(text, message_id, definitions),
            (encoding, _) => Basis::Encoding(encoding.escape_debug().to_string()).into(),
        });
        compared.clone()
    }
}

/// True if the text of a schema is only the name of the type.
fn is_name(name: &str, text: &[u8]) -> bool {
    let text = std::str::from_utf8(text).unwrap_or_default().trim();
    !name.is_empty() && text.len() <= 2 * MAX_NAME && (text == name || full_name(text) == full_name(name))
}

/// Compares the text of a `ros2msg` schema with a definition.
fn types(name: &str, text: &[u8], message_id: MessageId, definitions: &Definitions) -> ComparedSchema {
    match definitions.shared.stated(name, text) {
        Err(error) => Basis::Unreadable(error).into(),
        Ok(stated) => {
            let comparison = compare_declared(stated.root(), definitions.types().get(message_id));
            let (differs, version) = (comparison != Comparison::Equal, stated.version);
            ComparedSchema {
                stated: differs.then_some(stated),
                version,
                ..Basis::Compared(Arc::new(comparison)).into()
            }
        }
    }
}

/// Compares the text of a JSON Schema with a definition.
fn json(text: &[u8], message_id: MessageId, definitions: &Definitions) -> ComparedSchema {
    match json_schema::compare(text, message_id, &definitions.schema) {
        Ok(Some((differences, _))) if differences == Differences::default() => {
            Basis::Compared(Arc::new(Comparison::Equal)).into()
        }
        Ok(Some((differences, shared))) => ComparedSchema {
            shared: Some(Rc::new(shared)),
            ..Basis::Compared(Arc::new(Comparison::Differs(differences))).into()
        },
        Ok(None) => Basis::NoSchema.into(),
        Err(error) => Basis::Unreadable(error).into(),
    }
}
