//! `PX-TIME-01`.

use uavspec_types::px4::BatteryStatus;

use super::ext::is_of_px4;
use super::prelude::*;
use crate::definitions::FROM_PX4;
use crate::sample::START;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-TIME-01",
    name: "Timestamps do not decrease",
    level: Level::Must,
    status: Status::Normative,
    statement: "The `timestamp` field does not decrease from one message of a subscription to the next. A \
                timestamp may repeat, and it may be 0. In bags and JSON, only the topics in `/fmu/out/` \
                are checked: other topics may have several instances or publishers. Because PX4 may set \
                its clock, an earlier timestamp there is a violation only if the step back is less than \
                an hour, the next message is not earlier than the message before the step, and the time \
                from the early timestamp to the next one is longer than the pause between the two \
                messages. Messages of a bag are compared only in the order of their log times.",
    source: "uORB publishes in order; `timestamp` is the time since system start",
    applies_to: "message sequences",
    why: "Tools sort and interpolate samples by time. If the time steps back, the order, rates and \
          derivatives are wrong.",
    example: "battery_status {\"timestamp\": 2000000, …}\n\
              battery_status {\"timestamp\": 1000000, …}",
    fix: "Set `timestamp` from the monotonic system clock when you publish the message. Check that only \
          one module publishes each topic instance.",
})
.check(Check::State(|| Box::new(Times::default())))
.bug(Bug::message(Side::Autopilot, "The `timestamp` of every third BatteryStatus is 3 s too early.", |out| {
    out.edit(3, |battery: &mut BatteryStatus| {
        battery.timestamp = battery.timestamp.saturating_sub(3_000_000);
    });
}))
.mutants(&[Mutant::flight_in(
    "a message with an earlier timestamp than the ones before and after it",
    &[Encoding::Ulog, Encoding::Mcap, Encoding::Rosbridge],
    back,
)]);

/// The smallest change of time, in µs, that means that the clock was set. A smaller step back means that a time is
/// wrong. PX4 sends the time since 1970 once its clock is synchronised with the computer's clock, and the time since
/// boot before that.
const MAX_STEP: u64 = 3_600_000_000;

#[derive(Default)]
struct Times {
    /// The times of the latest messages of logs; 0 if they are unknown. Logs need no more, and have so many messages that
    /// copying a [`Time`] for each would take noticeable time.
    logged: PerChannel<u64>,
    /// The times of other channels.
    sent: PerChannel<Time>,
}

/// The times of a channel.
#[derive(Clone, Default)]
struct Time {
    /// The time of the latest message; 0 if it is unknown.
    latest: u64,
    /// The log time of the latest message, if it is known.
    logged: Option<u64>,
    /// The longest recent pause between two messages, in µs; 0 if there was none.
    pause: u64,
    /// The latest message, if its time is earlier than the time of the previous message. The next message shows whether
    /// the clock was set.
    early: Option<Early>,
}

/// A message with an earlier time than the previous message.
#[derive(Clone, Copy)]
struct Early {
    timestamp: u64,
    previous: u64,
    logged: Option<u64>,
    location: Location,
}

impl Early {
    /// The difference from the time of the previous message, in µs.
    const fn step(self) -> u64 {
        self.previous - self.timestamp
    }

    /// True if only the time of this message is wrong, which the time of the next message shows. If the clock was set
    /// back, the next message is later by the pause between the two messages. Otherwise, it is later by the sum of this
    /// pause, the step back and the pause before this message. The limit is halfway between these values, because times
    /// vary. `pause` is the longest recent pause. Log times show longer pauses.
    fn is_alone(self, next: u64, logged: Option<u64>, pause: u64) -> bool {
        let passed = self.logged.zip(logged).map_or(0, |(early, next)| next.saturating_sub(early));
        let longest = passed.max(pause).saturating_add(u64::midpoint(pause, self.step()));
        pause > 0 && next >= self.previous && next - self.timestamp > longest
    }
}

impl Checker for Times {
    fn opened(&mut self, channel: &Channel<'_>, context: &mut RuleContext<'_>) -> Interest {
        let is_log = channel.multi_id.is_some();
        // Outside of logs, any other topic may merge the messages of several instances or publishers.
        let has_one_publisher = is_log || channel.full_topic.contains(FROM_PX4);
        if !has_one_publisher || !is_of_px4(channel, context) {
            return Interest::Nothing;
        }
        if is_log {
            self.logged.open(channel, 0);
        } else {
            self.sent.open(channel, Time::default());
        }
        Interest::Times
    }

    fn message(&mut self, channel: &Channel<'_>, message: &Message<'_>, context: &mut RuleContext<'_>) {
        let Some(timestamp) = message.timestamp.filter(|timestamp| *timestamp != 0) else { return };
        if channel.multi_id.is_none() {
            return self.sent(channel, message, timestamp, context);
        }
        let Some(latest) = self.logged.get(channel) else { return };
        // Later messages are compared with this message, even if its time is wrong. Otherwise, a single wrong time or a
        // restart would make all later messages wrong.
        let previous = std::mem::replace(latest, timestamp);
        if previous == 0 {
            return;
        }
        context.covered();
        if timestamp < previous {
            report(timestamp, previous, message.location, channel, context);
        }
    }

    fn corruption(&mut self, _: Location) {
        // The latest message may be corrupt too.
        self.logged.reset();
        self.sent.reset();
    }
}

impl Times {
    /// Checks a message outside of logs.
    fn sent(
        &mut self,
        channel: &Channel<'_>,
        message: &Message<'_>,
        timestamp: u64,
        context: &mut RuleContext<'_>,
    ) {
        let Some(time) = self.sent.get(channel) else { return };
        let Time { latest: previous, logged, pause, early } = std::mem::take(time);
        *time = Time { latest: timestamp, logged: message.logged, pause, early: None };
        // The messages of a bag may be in any order.
        let is_unordered = logged.zip(message.logged).is_some_and(|(before, now)| now < before);
        if previous == 0 || is_unordered {
            return;
        }
        context.covered();
        let (logged, location) = (message.logged, message.location);
        let now = (timestamp < previous).then_some(Early { timestamp, previous, logged, location });
        // The influence of a long pause decreases with each message. The clock may also be set forward. An early message is
        // between two pauses.
        let (since, pauses) = early.map_or((previous, 1), |early| (early.previous, 2));
        let passed =
            timestamp.checked_sub(since).map(|passed| passed / pauses).filter(|passed| *passed < MAX_STEP);
        if let Some(passed) = passed {
            time.pause = passed.max(pause - pause / 16);
        }
        time.early = now.filter(|early| early.step() < MAX_STEP);
        if let Some(early) = early.filter(|early| early.is_alone(timestamp, logged, pause)) {
            report(early.timestamp, early.previous, early.location, channel, context);
        }
    }
}

fn report(
    timestamp: u64,
    previous: u64,
    location: Location,
    channel: &Channel<'_>,
    context: &mut RuleContext<'_>,
) {
    context.violation_in_field(channel, "timestamp", location, || {
        Detail::new(format!("timestamp {timestamp} is earlier than the previous timestamp, {previous}"))
            .expected(format!("{previous} or later"))
            .actual(timestamp.to_string())
    });
}

/// Sets the time of a topic's second-to-last message to the time of its first message.
fn back<'d>(flight: &Flight<'d>) -> Option<Flight<'d>> {
    let topic = flight.regular(|_| true)?;
    let last = flight.messages[flight.last_of(topic)?].clone();
    let mut flight = flight.with_last(topic, |message| message["timestamp"] = START.into())?;
    flight.messages.push(last);
    Some(flight)
}
