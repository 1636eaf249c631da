//! `PX-QUEUE-01`.

use uavspec_codegen::schema;

use super::{
    Change, Channel, Check, Checker, Detail, Interest, Level, Message, Mutant, PerChannel, Px4Rule, Rule,
    RuleContext, Status,
};
use crate::rules::sample::Flight;

pub(super) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-QUEUE-01",
        level: Level::Info,
        status: Status::Advisory,
        statement: "A topic doesn't publish more messages at one time than its queue holds: subscribers would miss some.",
        source: "ORB_QUEUE_LENGTH of the definition; 1 where it says nothing",
        applies_to: "messages over time",
        why: "",
        example: "",
        fix: "",
    },
    check: Check::State(|| Box::new(Bursts::default())),
    mutants: &[Mutant {
        name: "more messages at one time than the queue holds",
        change: Change::Flight(burst),
        also: &[],
    }],
};

/// What PX4 keeps of a topic that doesn't say.
const DEFAULT: u32 = 1;

#[derive(Default)]
struct Bursts {
    channels: PerChannel<Burst>,
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
    fn opened(&mut self, channel: &Channel<'_>, context: &mut RuleContext<'_>) -> Interest {
        let message = channel.definition.map(|id| context.definitions.schema.message(id));
        let length = message.map(|message| message.queue_length.unwrap_or(DEFAULT));
        self.channels.open(channel, Burst { length, ..Burst::default() });
        if length.is_some() { Interest::Times } else { Interest::Nothing }
    }

    fn message(&mut self, channel: &Channel<'_>, message: &Message<'_>, context: &mut RuleContext<'_>) {
        let Some(burst) = self.channels.get(channel) else { return };
        let (Some(timestamp), Some(length)) = (message.timestamp, burst.length) else { return };
        // 0 is the time of what was never published.
        if timestamp != burst.timestamp || timestamp == 0 {
            (burst.timestamp, burst.count) = (timestamp, 0);
        }
        burst.count += 1;
        context.covered();
        if burst.count == length.saturating_add(1) && length > DEFAULT {
            let definition = context.defined(channel.definition);
            context.violation_of(channel.topic, message.location, definition, || {
                Detail::new(format!(
                    "more than {length} messages at {timestamp} µs, which is all that its queue holds"
                ))
                .expected(format!("{length} messages at most"))
                .actual(format!("{} or more", length.saturating_add(1)))
            });
        }
    }
}

/// The last message of a topic, so often that its queue can't hold all.
fn burst<'d>(flight: &Flight<'d>) -> Option<Flight<'d>> {
    let length = |message: &schema::Message| message.queue_length.unwrap_or(DEFAULT);
    let topic = flight.regular(|message| length(message) > DEFAULT)?;
    let times = length(flight.definitions.schema.message(flight.topics[topic].message));
    let mut flight = flight.clone();
    let last = flight.messages[flight.last_of(topic)?].clone();
    flight.messages.extend((0..times).map(|_| last.clone()));
    Some(flight)
}
