//! `PX-VER-01`.

use super::{Channel, Check, Checker, Judged, Level, Rule};

pub(super) const RULE: Rule = Rule {
    id: "PX-VER-01",
    level: Level::Must,
    statement: "The version behind the name of a topic, `_vN`, is that of the message.",
    source: "MESSAGE_VERSION of the definition",
    check: Check::State(|| Box::new(Versions)),
};

struct Versions;

impl Checker for Versions {
    fn opened(&mut self, channel: &Channel<'_>, judged: &mut Judged<'_>) {
        let Some(message) = channel.definition.map(|id| judged.definitions.schema.message(id)) else {
            return;
        };
        // A topic may well be called so itself.
        if message.topics.iter().any(|topic| topic == channel.topic) {
            return;
        }
        let Some((_, version)) = channel.topic.rsplit_once("_v") else { return };
        judged.exercise();
        let defined = message.version.unwrap_or(0);
        if version != defined.to_string() {
            judged.report(channel.topic, channel.place, || {
                format!("the topic is of version {version}, the definition of version {defined}")
            });
        }
    }
}
