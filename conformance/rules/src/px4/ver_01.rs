//! `PX-VER-01`.

use super::ext::px4_message;
use super::prelude::*;
use crate::definitions::is_exchanged;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-VER-01",
    name: "Version suffix of a topic",
    level: Level::Must,
    status: Status::Normative,
    statement: "The version suffix (`_vN`) of a topic in `/fmu/in/` or `/fmu/out/` matches the version of \
                the topic's message type. Names of topics in logs have no suffix.",
    source: "`MESSAGE_VERSION` in the capture's schema, or in the definition if the schema has none",
    applies_to: "topic names",
    why: "Subscribers select a message version by the topic name. If the suffix is wrong, subscribers \
          decode the message with a different definition.",
    example: "topic:      /fmu/out/arming_check_request_v2\n\
              definition: uint32 MESSAGE_VERSION = 1",
    fix: "Change the topic suffix to the version of the message, or build the publisher with the message \
          version in the suffix.",
})
.check(Check::State(|| Box::new(Versions)))
.mutants(&[Mutant::flight_in(
    "a topic name with a different version",
    &[Encoding::Mcap, Encoding::Rosbridge],
    |flight| {
        let topic = flight.regular(|message| message.version.is_some())?;
        let mut flight = flight.clone();
        flight.topics[topic].name += "_v9999";
        Some(flight)
    },
)]);

struct Versions;

impl Checker for Versions {
    fn opened(&mut self, channel: &Channel<'_>, context: &mut RuleContext<'_>) -> Interest {
        // Only PX4 appends versions to its topics in ROS. Other names may end with any number.
        let has_version = channel.multi_id.is_none() && is_exchanged(channel.full_topic);
        if !has_version || px4_message(channel, context).is_none() {
            return Interest::Nothing;
        }
        let message = channel.definition.map(|id| context.definitions.schema.message(id));
        // The definition may list the name with its suffix as a topic.
        let message = message.filter(|message| message.topics.iter().all(|topic| topic != channel.topic));
        let Some((message, version)) = message.zip(version_of(channel.topic)) else {
            return Interest::Nothing;
        };
        context.covered();
        // The capture may use a different version than the definition. In that case, the capture's schema applies.
        let (source, expected) = match channel.version {
            Some(version) => ("its schema", version),
            None => ("the definition", message.version.unwrap_or(0)),
        };
        let is_elsewhere = || {
            let id = channel.definition.filter(|_| channel.version.is_none());
            id.is_some_and(|id| context.definitions.has_version_elsewhere(id, version))
        };
        if version != expected.to_string() && !is_elsewhere() {
            let definition = context.defined(channel.definition);
            context.violation_of(channel.subject(), channel.location, definition, || {
                Detail::new(format!(
                    "the topic name has version {version}, but {source} has version {expected}"
                ))
                .expected(expected.to_string())
                .actual(version)
            });
        }
        Interest::Nothing
    }
}

/// The version suffix of a topic name. An instance may follow the suffix: `battery_status_v1_0`.
fn version_of(topic: &str) -> Option<&str> {
    let (_, behind) = topic.rsplit_once("_v")?;
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let (version, instance) = match behind.split_once(['_', '.']) {
        Some((version, instance)) => (version, Some(instance)),
        None => (behind, None),
    };
    (is_number(version) && instance.is_none_or(is_number)).then_some(version)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_versions_in_topic_names() {
        for (topic, version) in [
            ("glider_v1", Some("1")),
            ("glider_v12_0", Some("12")),
            ("glider_v12.01", Some("12")),
            ("glider", None),
            ("glider_v", None),
            ("glider_velocity", None),
            ("glider_v1_left", None),
            ("glider_v1_", None),
        ] {
            assert_eq!(version_of(topic), version, "{topic}");
        }
    }
}
