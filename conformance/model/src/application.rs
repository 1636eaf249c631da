//! The PX4 message types that an application was built with.

use std::collections::BTreeMap;

use uavspec_schema::fingerprint::{hashed_text, ros_name};
use uavspec_schema::{Message, Schema};

/// A PX4 message type that an application was built with.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ApplicationType {
    /// The full ROS name: `px4_msgs/msg/VehicleStatus`.
    pub name: String,
    /// The topics, without a version.
    pub topics: Vec<String>,
    /// The version of the message, if it is defined.
    pub version: Option<u32>,
    /// PX4's hash of the fields.
    pub hash: u32,
    /// The text that the hash covers.
    pub fields: String,
}

impl ApplicationType {
    /// Describes a message type.
    pub fn new(schema: &Schema, message: &Message) -> Self {
        Self {
            name: ros_name(schema, message),
            topics: message.topics.clone(),
            version: message.version,
            hash: message.hash,
            fields: hashed_text(schema, message),
        }
    }

    /// Describes all message types that have topics.
    pub fn all(schema: &Schema) -> Vec<Self> {
        let messages = schema.messages.iter().filter(|message| !message.topics.is_empty());
        messages.map(|message| Self::new(schema, message)).collect()
    }

    /// Converts the type to key-value pairs, to be stored in a recording.
    pub fn to_values(&self) -> BTreeMap<String, String> {
        let Self { name, topics, version, hash, fields } = self;
        let mut values = BTreeMap::from([
            ("type".to_owned(), name.clone()),
            ("topics".to_owned(), topics.join(" ")),
            ("hash".to_owned(), format!("{hash:08x}")),
            ("fields".to_owned(), fields.clone()),
        ]);
        values.extend(version.map(|version| ("version".to_owned(), version.to_string())));
        values
    }

    /// Parses the key-value pairs from a recording. `None` if a required value is missing or invalid.
    pub fn from_values(values: &BTreeMap<String, String>) -> Option<Self> {
        let version = values.get("version").map(|version| version.parse()).transpose().ok()?;
        Some(Self {
            name: values.get("type")?.clone(),
            topics: values.get("topics")?.split_whitespace().map(str::to_owned).collect(),
            version,
            hash: u32::from_str_radix(values.get("hash")?, 16).ok()?,
            fields: values.get("fields")?.clone(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_read_as_it_is_written() {
        let status = ApplicationType {
            name: "px4_msgs/msg/VehicleStatus".to_owned(),
            topics: vec!["vehicle_status".to_owned(), "vehicle_status_v2".to_owned()],
            version: Some(2),
            hash: 0xab,
            fields: "uint64 timestamp\n".to_owned(),
        };
        assert_eq!(ApplicationType::from_values(&status.to_values()), Some(status.clone()));
        let unversioned = ApplicationType { version: None, ..status };
        assert_eq!(ApplicationType::from_values(&unversioned.to_values()), Some(unversioned.clone()));
        let mut invalid = unversioned.to_values();
        invalid.insert("hash".to_owned(), "none".to_owned());
        assert_eq!(ApplicationType::from_values(&invalid), None);
    }
}
