//! `PX-QUEUE-01`.

use super::{Channel, Check, Checker, Judged, Level, Message, Rule};

pub(super) const RULE: Rule = Rule {
    id: "PX-QUEUE-01",
    level: Level::Info,
    statement: "A topic doesn't publish more messages at one time than its queue holds: subscribers would miss some.",
    source: "ORB_QUEUE_LENGTH of the definition; 1 where it says nothing",
    check: Check::State(|| Box::new(Bursts::default())),
};

/// What PX4 keeps of a topic that doesn't say.
const DEFAULT: u32 = 1;

#[derive(Default)]
struct Bursts {
    channels: Vec<Burst>,
}

/// Messages of the same time.
#[derive(Clone, Copy, Default)]
struct Burst {
    timestamp: u64,
    count: u32,
    /// What the queue holds; none where nobody knows.
    length: Option<u32>,
}

impl Checker for Bursts {
    fn opened(&mut self, channel: &Channel<'_>, judged: &mut Judged<'_>) {
        let count = self.channels.len().max(channel.index + 1);
        self.channels.resize(count, Burst::default());
        let message = channel.definition.map(|id| judged.definitions.schema.message(id));
        let length = message.map(|message| message.queue_length.unwrap_or(DEFAULT));
        self.channels[channel.index] = Burst { length, ..Burst::default() };
    }

    fn message(&mut self, channel: &Channel<'_>, message: &Message<'_>, judged: &mut Judged<'_>) {
        let Some(burst) = self.channels.get_mut(channel.index) else { return };
        let (Some(timestamp), Some(length)) = (message.timestamp, burst.length) else { return };
        // 0 is the time of what was never published.
        if timestamp != burst.timestamp || timestamp == 0 {
            (burst.timestamp, burst.count) = (timestamp, 0);
        }
        burst.count += 1;
        judged.exercise();
        if burst.count == length.saturating_add(1) && length > DEFAULT {
            judged.report(channel.topic, message.place, || {
                format!("more than {length} messages at {timestamp} µs, which is all that its queue holds")
            });
        }
    }
}
