//! `PX-VER-01`.

use super::{Channel, Check, Checker, Detail, Interest, Judged, Level, Mutant, Rule, Status};

pub(super) static RULE: Rule = Rule {
    id: "PX-VER-01",
    level: Level::Must,
    status: Status::Normative,
    statement: "The version behind the name of a topic, `_vN`, is that of the message.",
    source: "MESSAGE_VERSION of the definition",
    applies_to: "names of topics",
    check: Check::State(|| Box::new(Versions)),
    mutants: &[
        Mutant {
            name: "a topic of another version",
            make: |flight| {
                let topic = flight.regular(|message| message.version.is_some())?;
                let mut flight = flight.clone();
                flight.topics[topic].name += "_v9999";
                Some(flight.log().to_bytes())
            },
            also: &[],
        },
        Mutant {
            name: "a topic of another version, as JSON",
            make: |flight| {
                let topic = flight.regular(|message| message.version.is_some())?;
                let mut flight = flight.clone();
                flight.topics[topic].name += "_v9999";
                Some(flight.rosbridge().to_bytes())
            },
            also: &[],
        },
        Mutant {
            name: "a topic of another version, in MCAP",
            make: |flight| {
                let topic = flight.regular(|message| message.version.is_some())?;
                let mut bag = flight.bag();
                bag.channels[topic].topic += "_v9999";
                Some(bag.to_bytes())
            },
            also: &[],
        },
    ],
};

struct Versions;

impl Checker for Versions {
    fn opened(&mut self, channel: &Channel<'_>, judged: &mut Judged<'_>) -> Interest {
        let message = channel.definition.map(|id| judged.definitions.schema.message(id));
        // A topic may well be called so itself.
        let message = message.filter(|message| message.topics.iter().all(|topic| topic != channel.topic));
        let version = channel.topic.rsplit_once("_v").map(|(_, version)| version);
        let Some((message, version)) = message.zip(version) else { return Interest::Nothing };
        judged.exercise();
        let defined = message.version.unwrap_or(0);
        if version != defined.to_string() {
            judged.report(channel.topic, channel.place, || {
                Detail::new(format!("the topic is of version {version}, the definition of version {defined}"))
                    .expected(defined.to_string())
                    .actual(version)
            });
        }
        Interest::Nothing
    }
}
