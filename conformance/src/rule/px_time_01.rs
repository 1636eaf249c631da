//! `PX-TIME-01`.

use super::{Channel, Check, Checker, Judged, Level, Message, Rule};

pub(super) const RULE: Rule = Rule {
    id: "PX-TIME-01",
    level: Level::Must,
    statement: "The field `timestamp` doesn't go back from one message of a subscription to the next. It may repeat, and \
                it may be 0.",
    source: "uORB publishes in order; `timestamp` is the time since system start",
    check: Check::State(|| Box::new(Times::default())),
};

/// The latest time of each channel.
#[derive(Default)]
struct Times {
    latest: Vec<u64>,
}

impl Checker for Times {
    fn opened(&mut self, channel: &Channel<'_>, _: &mut Judged<'_>) {
        let count = self.latest.len().max(channel.index + 1);
        self.latest.resize(count, 0);
        self.latest[channel.index] = 0;
    }

    fn message(&mut self, channel: &Channel<'_>, message: &Message<'_>, judged: &mut Judged<'_>) {
        let (Some(timestamp), Some(latest)) = (message.timestamp, self.latest.get_mut(channel.index)) else {
            return;
        };
        if timestamp < *latest && timestamp != 0 {
            let latest = *latest;
            judged.report(&format!("{}.timestamp", channel.topic), message.place, || {
                format!("timestamp is {timestamp}, and was {latest} before")
            });
        }
        judged.exercise();
        *latest = timestamp.max(*latest);
    }
}
