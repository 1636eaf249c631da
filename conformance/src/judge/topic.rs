//! What topics are called, wherever they come from, and what that means.

use uavspec_codegen::schema::MessageId;

use crate::definitions::Definitions;

/// The definition of a topic of PX4, behind which programs that convert logs write an instance: `sensor_accel_1`,
/// `sensor_accel.01`.
pub(super) fn message_of(topic: &str, definitions: &Definitions) -> Option<MessageId> {
    definitions.message_of_topic(topic).or_else(|| {
        let name = topic.trim_end_matches(|character: char| character.is_ascii_digit());
        let name = name.strip_suffix(['_', '.']).filter(|_| name.len() < topic.len())?;
        definitions.message_of_topic(name)
    })
}

/// The topic of PX4 in a name of ROS 2, `/fmu/out/failsafe_flags`; behind it may stand the number of an instance,
/// `/sensor_accel/1`.
pub(super) fn topic_of(topic: &str) -> &str {
    let mut segments = topic.rsplit('/').filter(|segment| !segment.is_empty());
    let last = segments.next().unwrap_or(topic);
    if last.bytes().all(|byte| byte.is_ascii_digit()) { segments.next().unwrap_or(last) } else { last }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn topics_are_known_with_their_namespace_and_their_instance() {
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
            assert_eq!(message_of(topic_of(name), &definitions), flags, "{name}");
        }
        for name in
            ["", "///", "12", "/12", "_12", "/failsafe_flags_", "/failsafe_flags12", "/failsafe_flags/x"]
        {
            assert_eq!(message_of(topic_of(name), &definitions), None, "{name}");
        }
    }
}
