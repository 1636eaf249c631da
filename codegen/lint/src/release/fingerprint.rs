//! Fingerprints of definitions, used to compare captures with many releases.

use std::collections::{BTreeSet, HashMap};

use sha2::{Digest as _, Sha256};
use uavspec_dynamic::{MessageType, Types};
use uavspec_schema::fingerprint::{interface_name, ros_name};
use uavspec_schema::msg::Kind;
use uavspec_schema::{Element, Form, Schema, shape_text};

/// The fingerprints of a definition. The fingerprints don't depend on comments, units and constants, except the
/// version.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Fingerprint {
    /// The full ROS name: `px4_msgs/msg/BatteryStatus`.
    pub name: String,
    /// The topics of the message (PX4).
    pub topics: Vec<String>,
    /// The hash of the layout in memory, if the size is fixed.
    pub layout: Option<u64>,
    /// The size in CDR including the encapsulation header, in bytes, if it is fixed.
    pub cdr_size: Option<u64>,
    /// The hash of the keys in JSON; see [`keys_hash`]. `None` for services.
    pub keys: Option<u64>,
    /// PX4's hash of the fields.
    pub hash: u32,
    /// The ROS type hash (RIHS01). An event of a service has the hash of the service.
    pub type_hash: String,
    /// The version of the message (PX4); 0 if it has none.
    pub version: u32,
}

/// The fingerprints of all messages and services, by name.
pub fn fingerprints(schema: &Schema) -> Vec<Fingerprint> {
    let types = Types::new(schema);
    let mut layouts = LayoutHashes::default();
    let packages = schema.packages.iter().filter(|package| matches!(package.form, Form::Msg(_)));
    let mut found = Vec::new();
    for package in packages {
        found.extend(package.messages.iter().map(|id| {
            let message = schema.message(*id);
            Fingerprint {
                name: ros_name(schema, message),
                topics: message.topics.clone(),
                layout: layouts.get(types.get(*id)),
                cdr_size: message.cdr.is_fixed.then_some(message.cdr.min),
                keys: Some(keys_hash(message.fields.iter().map(|field| field.name.as_str()))),
                hash: message.hash,
                type_hash: message.type_hash.clone(),
                version: message.version.unwrap_or_default(),
            }
        }));
        let services = package.interfaces.iter().filter(|interface| interface.kind == Kind::Service);
        found.extend(services.filter_map(|service| {
            Some(Fingerprint {
                name: interface_name(package, service),
                topics: Vec::new(),
                layout: None,
                cdr_size: None,
                keys: None,
                hash: 0,
                type_hash: service.type_hash.clone()?,
                version: 0,
            })
        }));
    }
    found.sort();
    found
}

/// The hash of a message's keys in JSON, without the keys of nested messages. The order of the keys doesn't matter.
pub fn keys_hash<'k>(keys: impl Iterator<Item = &'k str>) -> u64 {
    let keys: BTreeSet<&str> = keys.collect();
    let mut hasher = Sha256::new();
    for key in keys {
        hasher.update(key);
        hasher.update("\n");
    }
    hash_of(hasher)
}

/// The first 8 bytes of a hash.
fn hash_of(hasher: Sha256) -> u64 {
    hasher.finalize().first_chunk().map_or(0, |first| u64::from_be_bytes(*first))
}

/// The maximum nesting depth of a layout. PX4's messages have a depth of 2.
const MAX_DEPTH: usize = 32;

/// The hashes of the layouts of messages: the names, types and offsets of their fields, but not the names of nested
/// messages. A format in a log has the same hash as the definition from which it was created.
#[derive(Debug, Default)]
pub struct LayoutHashes<'t>(HashMap<(&'t str, &'t str), Option<u64>>);

impl<'t> LayoutHashes<'t> {
    /// The hash of a message. All messages must be from the same [`Types`]. `None` if the size varies.
    pub fn get(&mut self, message_type: MessageType<'t>) -> Option<u64> {
        self.nested(message_type, 0)
    }

    fn nested(&mut self, message_type: MessageType<'t>, depth: usize) -> Option<u64> {
        let key = (message_type.package(), message_type.name());
        if let Some(known) = self.0.get(&key) {
            return *known;
        }
        let size = message_type.size().filter(|_| depth < MAX_DEPTH)?;
        let mut fields: Vec<_> = message_type.fields().iter().collect();
        fields.sort_by_key(|field| field.offset);
        let mut hasher = Sha256::new();
        for field in fields {
            let element = match field.element {
                Element::Scalar(scalar) => scalar.name().to_owned(),
                Element::Text(length) => format!("char[{length}]"),
                Element::String { .. } => return None,
                Element::Message(id) => format!("{:016x}", self.nested(message_type.nested(id), depth + 1)?),
            };
            hasher.update(format!("{element}{} {} {}\n", shape_text(field.shape), field.name, field.offset));
        }
        hasher.update(size.padded.to_string());
        let hash = Some(hash_of(hasher));
        self.0.insert(key, hash);
        hash
    }
}
