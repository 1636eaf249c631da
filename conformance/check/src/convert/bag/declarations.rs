//! The schemas of a file, and the limits for its declarations.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use uavspec_model::limits::MAX_NAME;

use crate::digest;
use crate::limits::MAX_CONVERTED_SCHEMAS;

/// A schema: its name, encoding and text.
pub(crate) type Schema = (String, String, Vec<u8>);

/// The declaration of a channel.
pub(crate) struct Declared {
    pub(crate) id: u16,
    /// The id of the schema; 0 if there is none.
    pub(crate) schema: u16,
    pub(crate) topic: String,
    pub(crate) encoding: String,
    pub(crate) metadata: BTreeMap<String, String>,
    /// A hash of the declaration.
    pub(crate) digest: u64,
}

/// The schemas that were read so far.
#[derive(Default)]
pub(crate) struct Declarations {
    schemas: HashMap<u16, Schema>,
    /// The digests of the schemas.
    digests: HashMap<u16, u64>,
    /// The ids of the schemas that exceed a limit.
    left_out: BTreeSet<u16>,
    /// The total size of the schemas and channels, in bytes, including the names of attachments and metadata records.
    size: usize,
}

impl Declarations {
    /// The schema with an id.
    pub(crate) fn schema(&self, id: u16) -> Option<&Schema> {
        self.schemas.get(&id)
    }

    /// The digest of the schema with an id; 0 if there is no schema.
    pub(super) fn digest(&self, id: u16) -> u64 {
        self.digests.get(&id).copied().unwrap_or_default()
    }

    /// Reserves space. Returns false if the limit is reached.
    pub(crate) fn has_room(&mut self, size: usize) -> bool {
        fits(&mut self.size, size)
    }

    /// Stores a schema. Returns the problem if it is left out. Chunks and the summary repeat schemas; the first declaration
    /// of an id is used.
    pub(crate) fn add_schema(
        &mut self,
        id: u16,
        (name, encoding): (String, String),
        text: &[u8],
    ) -> Option<String> {
        if id == 0 {
            return Some("a schema has the reserved id 0".to_owned());
        }
        if let Some((known_name, known_encoding, known)) = self.schemas.get(&id) {
            let is_same = *known_name == name && *known_encoding == encoding && *known == text;
            return (!is_same).then(|| declared_again("schema", id));
        }
        if self.left_out.contains(&id) {
            return None;
        }
        let problem = if name.len() > MAX_NAME || encoding.len() > MAX_NAME {
            format!("the name or the encoding is longer than {MAX_NAME} bytes")
        } else if self.has_room(name.len() + encoding.len() + text.len()) {
            self.digests.insert(id, digest(&(&name, &encoding, text)));
            self.schemas.insert(id, (name, encoding, text.to_vec()));
            return None;
        } else {
            too_large()
        };
        self.left_out.insert(id);
        Some(format!("schema {id}: {problem}"))
    }

    /// The reason to leave out a new channel, if there is one: the channel exceeds a limit, or its schema is unknown.
    /// Without the schema, its topic could be confused with a PX4 topic.
    pub(crate) fn refusal(
        &mut self,
        schema: u16,
        topic: &str,
        encoding: &str,
        metadata: &BTreeMap<String, String>,
    ) -> Option<String> {
        if topic.len() > MAX_NAME || encoding.len() > MAX_NAME {
            return Some(format!("the topic or the encoding is longer than {MAX_NAME} bytes"));
        }
        if self.left_out.contains(&schema) {
            return Some(format!("its schema {schema} is left out"));
        }
        if schema != 0 && !self.schemas.contains_key(&schema) {
            return Some(format!("its schema {schema} hasn't been declared yet"));
        }
        let pairs: usize = metadata.iter().map(|(key, value)| key.len() + value.len()).sum();
        (!self.has_room(topic.len() + encoding.len() + pairs)).then(too_large)
    }
}

/// The name and the encoding of a schema.
pub(crate) fn names((name, encoding, _): &Schema) -> (&str, &str) {
    (name, encoding)
}

/// The problem to report for a declaration that differs from an earlier one with the same id.
pub(crate) fn declared_again(kind: &str, id: u16) -> String {
    format!("{kind} {id} is declared again with different content; the first declaration is used")
}

/// The problem to report for declarations that take too much space.
pub(super) fn too_large() -> String {
    format!("the schemas, channels and names take more than {} MiB", MAX_CONVERTED_SCHEMAS >> 20)
}

/// Adds a size to a total, unless this would exceed the limit. Returns true if it was added.
pub(super) fn fits(total: &mut usize, size: usize) -> bool {
    let sum = total.saturating_add(size);
    if sum > MAX_CONVERTED_SCHEMAS {
        return false;
    }
    *total = sum;
    true
}
