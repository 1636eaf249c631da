//! What channels are called, and what that means.

use uavspec_codegen::schema::fingerprint::ros_name;
use uavspec_codegen::schema::{Message, MessageId, Schema};

use crate::definitions::Definitions;
use crate::judge::topic::{message_of, topic_of};

/// The definition of a channel, by its topic and by the name and the encoding of its schema.
///
/// The name of a schema of ROS 2 says it: a type of another package is another type, although its topic may be called
/// like one that is defined. Names of other schemas are anyone's choice, so the topic says it where they don't.
pub(super) fn definition_of(
    topic: &str,
    schema: Option<(&str, &str)>,
    definitions: &Definitions,
) -> Option<MessageId> {
    let by_topic = || message_of(topic_of(topic), definitions);
    let Some((name, encoding)) = schema.filter(|(name, _)| !name.is_empty()) else { return by_topic() };
    let name = plain(name);
    if let Some(id) = definitions.message_of_type(&name) {
        return Some(id);
    }
    let last = name.rsplit(['/', '.']).next().unwrap_or(&name);
    let is_called_so = |id: &MessageId| definitions.schema.message(*id).name == last;
    if encoding.starts_with("ros2") {
        return by_topic().filter(is_called_so);
    }
    message_of(last, definitions).or_else(by_topic)
}

/// Whether the name of a schema is that of a message of ROS 2.
pub(super) fn is_same_type(name: &str, message: &Message, schema: &Schema) -> bool {
    let full = ros_name(schema, message);
    let name = plain(name);
    name == full || full.replacen("/msg/", "/", 1) == name
}

/// A name as ROS 2 writes it, where it is written as DDS does: `px4_msgs::msg::dds_::VehicleStatus_`.
fn plain(name: &str) -> String {
    match name.strip_suffix('_') {
        Some(dds) if dds.contains("::dds_::") => dds.replacen("::dds_::", "::", 1).replace("::", "/"),
        _ => name.replace("::", "/"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_are_known_by_their_schema_or_their_topic() {
        let definitions = Definitions::built_in();
        let name = |topic, schema| {
            definition_of(topic, schema, &definitions).map(|id| definitions.schema.message(id).name.clone())
        };
        let flags = Some("FailsafeFlags".to_owned());
        let ros = |name| Some((name, "ros2msg"));
        let json = |name| Some((name, "jsonschema"));
        for (topic, schema) in [
            ("/any", ros("px4_msgs/msg/FailsafeFlags")),
            ("/any", ros("px4_msgs/FailsafeFlags")),
            ("/any", ros("px4_msgs::msg::dds_::FailsafeFlags_")),
            ("/any", json("px4/FailsafeFlags")),
            ("/any", json("failsafe_flags")),
            ("/any", json("px4.failsafe_flags")),
            ("/fmu/out/failsafe_flags", None),
            ("/fmu/out/failsafe_flags_v1", None),
            ("/failsafe_flags/0", None),
            ("/failsafe_flags_1", None),
            ("/failsafe_flags.01", None),
            ("failsafe_flags", ros("")),
            ("failsafe_flags", ros("my_msgs/msg/FailsafeFlags")),
            ("failsafe_flags", json("Anything")),
        ] {
            assert_eq!(name(topic, schema), flags, "{topic} {schema:?}");
        }
        for (topic, schema) in [
            ("/any", None),
            ("", None),
            ("///", None),
            ("12", None),
            ("/failsafe_flags_", None),
            ("/failsafe_flags12", None),
            ("_12", None),
            ("/failsafe_flags", ros("std_msgs/msg/String")),
            ("/any", json("Anything")),
        ] {
            assert_eq!(name(topic, schema), None, "{topic} {schema:?}");
        }
    }
}
