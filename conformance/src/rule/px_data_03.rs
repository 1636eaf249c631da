//! `PX-DATA-03`.

use std::collections::HashMap;

use super::{Channel, Check, Checker, Judged, Level, Rule};

pub(super) const RULE: Rule = Rule {
    id: "PX-DATA-03",
    level: Level::Must,
    statement: "No two subscriptions of a log have the same topic and the same instance.",
    source: "ULog file format, section on subscription messages",
    check: Check::State(|| Box::new(Instances::default())),
};

/// The channel of each topic and instance.
#[derive(Default)]
struct Instances {
    known: HashMap<(String, u8), usize>,
}

impl Checker for Instances {
    fn opened(&mut self, channel: &Channel<'_>, judged: &mut Judged<'_>) {
        let Some(multi_id) = channel.multi_id else { return };
        judged.exercise();
        let first = *self.known.entry((channel.topic.to_owned(), multi_id)).or_insert(channel.index);
        if first != channel.index {
            judged.report(channel.topic, channel.place, || {
                format!("a second subscription of instance {multi_id}")
            });
        }
    }
}
