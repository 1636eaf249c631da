//! Resolves the names of topics and types to definitions.

use std::collections::BTreeSet;

use uavspec_model::json::Tree;
use uavspec_rules::definitions::{Definitions, is_exchanged, plain_name};
use uavspec_schema::fingerprint::ros_name;
use uavspec_schema::{Message, MessageId, Schema};

/// The definition of a PX4 topic. Log converters may append an instance number: `sensor_accel_1`, `sensor_accel.01`.
fn message_of(topic: &str, definitions: &Definitions) -> Option<MessageId> {
    definitions.message_of_topic(topic).or_else(|| {
        let name = topic.trim_end_matches(|character: char| character.is_ascii_digit());
        let name = name.strip_suffix(['_', '.']).filter(|_| name.len() < topic.len())?;
        definitions.message_of_topic(name)
    })
}

/// The name of a PX4 topic, from a ROS 2 name such as `/fmu/out/failsafe_flags`. An instance number may follow:
/// `/sensor_accel/1`.
pub fn topic_of(topic: &str) -> &str {
    let mut segments = topic.rsplit('/').filter(|segment| !segment.is_empty());
    let last = segments.next().unwrap_or(topic);
    if last.bytes().all(|byte| byte.is_ascii_digit()) { segments.next().unwrap_or(last) } else { last }
}

/// Finds the definition of a topic from its name, and from the name and encoding of its schema.
///
/// For ROS 2, only the schema name counts: a type from another package is a different type, even if the topic's name is
/// defined. The package name may differ only in PX4's folders, such as `/fmu/out/`. For other encodings, schema names
/// are arbitrary. If the schema name matches no definition, the topic name decides, although it may be misleading: see
/// `is_guess`.
pub fn definition_of(
    topic: &str,
    schema: Option<(&str, &str)>,
    definitions: &Definitions,
) -> Option<MessageId> {
    let by_topic = || message_of(topic_of(topic), definitions);
    let Some((name, encoding)) = schema.filter(|(name, _)| !name.is_empty()) else { return by_topic() };
    let name = plain_name(name);
    if let Some(id) = definitions.message_of_type(&name) {
        return Some(id);
    }
    // rosbag2 writes no encoding if it can't find the definition.
    let is_ros = |name: &str| ["/msg/", "/srv/", "/action/"].iter().any(|folder| name.contains(folder));
    let last = name.rsplit(['/', '.']).next().unwrap_or(&name);
    let has_name = |id: &MessageId| definitions.schema.message(*id).name == last;
    if encoding.starts_with("ros2") || encoding.is_empty() && is_ros(&name) {
        // Vendors rename the package of PX4's messages. Outside of PX4's folders, such a type is unrelated: many
        // packages have an `Event`.
        return by_topic().filter(|id| has_name(id) && is_exchanged(topic));
    }
    message_of(last, definitions).or_else(by_topic)
}

/// Finds the definition of a topic, like `definition_of`. If the definition is only a guess, a JSON message must
/// confirm it.
pub fn definition_of_json(
    topic: &str,
    schema: Option<(&str, &str)>,
    message: &Tree<'_>,
    definitions: &Definitions,
) -> Option<MessageId> {
    definition_of(topic, schema, definitions)
        .filter(|id| !is_guess(topic, schema, *id, definitions) || resembles(message, *id, definitions))
}

/// True if only the name of a topic or schema indicates its definition, and another type may have the same name.
///
/// Outside of PX4's folders, other programs also use names such as `battery_status`. Definitions that the user passes
/// belong to the capture, so their names aren't ambiguous.
pub fn is_guess(topic: &str, schema: Option<(&str, &str)>, id: MessageId, definitions: &Definitions) -> bool {
    let states_type =
        schema.is_some_and(|(name, _)| definitions.message_of_type(&plain_name(name)) == Some(id));
    !states_type && !is_exchanged(topic) && !definitions.is_given
}

/// True if a JSON message clearly has a type: it has a timestamp, most of its keys are fields of the type, and most
/// fields of the type are among its keys.
fn resembles(message: &Tree<'_>, id: MessageId, definitions: &Definitions) -> bool {
    let Tree::Object(members) = message else { return false };
    let keys: BTreeSet<&str> = members.iter().map(|(key, _)| &**key).collect();
    let fields = &definitions.schema.message(id).fields;
    let shared = fields.iter().filter(|field| keys.contains(field.name.as_str())).count();
    keys.contains("timestamp") && shared * 2 > keys.len().max(fields.len())
}

/// True if a JSON message isn't empty. Empty messages don't indicate their type.
pub fn shows_type(message: &Tree<'_>) -> bool {
    matches!(message, Tree::Object(members) if !members.is_empty())
}

/// True if a JSON message confirms a guess, false if it refutes the guess. `None` if the message is empty.
pub fn confirms(message: &Tree<'_>, id: MessageId, definitions: &Definitions) -> Option<bool> {
    shows_type(message).then(|| resembles(message, id, definitions))
}

/// True if a schema name denotes a ROS 2 message.
pub(super) fn is_same_type(name: &str, message: &Message, schema: &Schema) -> bool {
    let full = ros_name(schema, message);
    let name = plain_name(name);
    name == full || full.replacen("/msg/", "/", 1) == name
}

/// The full ROS name of a type: `package/msg/Name`. For a service event, the name of the service.
pub(super) fn full_name(name: &str) -> String {
    let name = plain_name(name);
    match name.split_once('/') {
        Some((package, last)) if !last.contains('/') => format!("{package}/msg/{last}"),
        _ => service_of(&name).map(str::to_owned).unwrap_or(name),
    }
}

/// The name of the service, if the type is a service event.
pub(super) fn service_of(name: &str) -> Option<&str> {
    name.strip_suffix("_Event").filter(|service| service.contains("/srv/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resolves_topics_with_a_namespace_or_an_instance() {
        let definitions = Definitions::built_in();
        let flags = definitions.message_of_topic("failsafe_flags");
        assert!(flags.is_some());
        for name in [
            "failsafe_flags",
            "/fmu/out/failsafe_flags",
            "/fmu/out/failsafe_flags_v1",
            "/failsafe_flags/",
            "/failsafe_flags/0",
            "/failsafe_flags_1",
            "/failsafe_flags.01",
        ] {
            assert_eq!(definition_of(name, None, &definitions), flags, "{name}");
        }
        for name in
            ["", "///", "12", "/12", "_12", "/failsafe_flags_", "/failsafe_flags12", "/failsafe_flags/x"]
        {
            assert_eq!(definition_of(name, None, &definitions), None, "{name}");
        }
    }

    #[test]
    fn resolves_channels_by_their_schema_or_their_topic() {
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
            ("failsafe_flags", ros("")),
            ("/fmu/out/failsafe_flags", ros("my_msgs/msg/FailsafeFlags")),
            ("failsafe_flags", json("Anything")),
        ] {
            assert_eq!(name(topic, schema), flags, "{topic} {schema:?}");
        }
        for (topic, schema) in [
            ("/any", None),
            ("/failsafe_flags", ros("std_msgs/msg/String")),
            ("/failsafe_flags", ros("my_msgs/msg/FailsafeFlags")),
            ("/any", json("Anything")),
        ] {
            assert_eq!(name(topic, schema), None, "{topic} {schema:?}");
        }
    }
}
