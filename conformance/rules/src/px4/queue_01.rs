//! `PX-QUEUE-01`.

use uavspec_types::px4::Event;

use super::prelude::*;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-QUEUE-01",
    name: "Queue length",
    level: Level::Info,
    status: Status::Advisory,
    statement: "All messages with the same timestamp on a topic fit into the topic's queue.",
    source: "`ORB_QUEUE_LENGTH` in the definition",
    applies_to: "message sequences",
    why: "If the queue is full, a new message overwrites the oldest one. A subscriber that runs after the \
          burst misses the overwritten messages.",
    example: "definition: uint8 ORB_QUEUE_LENGTH = 4\n\
              log:        5 messages on the topic, all with timestamp 1000000",
    fix: "Increase `ORB_QUEUE_LENGTH` to a power of two that is large enough for the burst, or publish \
          fewer messages at a time.",
})
.check(Check::State(|| Box::new(Bursts::default())))
.bug(Bug::message(Side::Autopilot, "Every second Event is sent 20 times with the same `timestamp`.", |out| {
    for _ in 1..20 {
        out.follow(2, |_: &mut Event| {});
    }
}))
.mutants(&[Mutant::flight("more messages with the same timestamp than fit into the queue", burst)]);

/// PX4's default queue length.
const DEFAULT: u32 = 1;

#[derive(Default)]
struct Bursts {
    channels: PerChannel<Burst>,
}

/// Messages with the same timestamp.
#[derive(Clone, Copy, Default)]
struct Burst {
    timestamp: u64,
    count: u32,
    /// The length of the queue.
    length: u32,
}

impl Checker for Bursts {
    fn opened(&mut self, channel: &Channel<'_>, context: &mut RuleContext<'_>) -> Interest {
        let message = channel.definition.map(|id| context.definitions.schema.message(id));
        let length = message.and_then(|message| message.queue_length).unwrap_or(DEFAULT);
        self.channels.open(channel, Burst { length, ..Burst::default() });
        // Publishers rely on a longer queue only if the definition specifies one.
        if length > DEFAULT { Interest::Times } else { Interest::Nothing }
    }

    fn message(&mut self, channel: &Channel<'_>, message: &Message<'_>, context: &mut RuleContext<'_>) {
        let Some(burst) = self.channels.get(channel) else { return };
        let length = burst.length;
        // A message that was never published has time 0.
        let Some(timestamp) = message.timestamp.filter(|timestamp| *timestamp != 0) else { return };
        if timestamp != burst.timestamp {
            (burst.timestamp, burst.count) = (timestamp, 0);
        }
        burst.count += 1;
        context.covered();
        if burst.count == length.saturating_add(1) {
            let definition = context.defined(channel.definition);
            context.violation_of(channel.subject(), message.location, definition, || {
                Detail::new(format!(
                    "more than {length} messages with timestamp {timestamp} µs, but the queue holds only {length}"
                ))
                .expected(format!("at most {length} messages"))
                .actual(format!("{} or more", length.saturating_add(1)))
            });
        }
    }
}

/// Repeats the last message of a topic until the topic's queue overflows.
fn burst<'d>(flight: &Flight<'d>) -> Option<Flight<'d>> {
    let length = |message: &uavspec_schema::Message| message.queue_length.unwrap_or(DEFAULT);
    let topic = flight.regular(|message| length(message) > DEFAULT)?;
    let times = length(flight.definitions.schema.message(flight.topics[topic].message));
    let mut flight = flight.clone();
    let last = flight.messages[flight.last_of(topic)?].clone();
    flight.messages.extend((0..times).map(|_| last.clone()));
    Some(flight)
}
