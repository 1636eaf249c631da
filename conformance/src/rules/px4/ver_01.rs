//! `PX-VER-01`.

use super::{
    Change, Channel, Check, Checker, Detail, Interest, Level, Mutant, Px4Rule, Rule, RuleContext, Status,
};

pub(super) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-VER-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "The version behind the name of a topic, `_vN`, is that of the message.",
        source: "MESSAGE_VERSION of the type that a file brings along, or else of the definition",
        applies_to: "names of topics",
        why: "",
        example: "",
        fix: "",
    },
    check: Check::State(|| Box::new(Versions)),
    mutants: &[Mutant {
        name: "a topic of another version",
        change: Change::Flight(|flight| {
            let topic = flight.regular(|message| message.version.is_some())?;
            let mut flight = flight.clone();
            flight.topics[topic].name += "_v9999";
            Some(flight)
        }),
        also: &[],
    }],
};

struct Versions;

impl Checker for Versions {
    fn opened(&mut self, channel: &Channel<'_>, context: &mut RuleContext<'_>) -> Interest {
        let message = channel.definition.map(|id| context.definitions.schema.message(id));
        // A topic may well be called so itself.
        let message = message.filter(|message| message.topics.iter().all(|topic| topic != channel.topic));
        let Some((message, version)) = message.zip(version_of(channel.topic)) else {
            return Interest::Nothing;
        };
        context.covered();
        // A source of another version than the definition may well agree with itself.
        let (whose, stated) = match channel.version {
            Some(stated) => ("its schema", stated),
            None => ("the definition", message.version.unwrap_or(0)),
        };
        if version != stated.to_string() {
            let definition = context.defined(channel.definition);
            context.violation_of(channel.topic, channel.location, definition, || {
                Detail::new(format!("the topic is of version {version}, {whose} of version {stated}"))
                    .expected(stated.to_string())
                    .actual(version)
            });
        }
        Interest::Nothing
    }
}

/// The version behind the name of a topic; behind that may stand the number of an instance, `battery_status_v1_0`.
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
    fn a_version_is_a_number() {
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
