//! `PX-TIME-01`.

use uavspec::px4::BatteryStatus;

use super::bug::{Bug, Side};
use super::ext::is_of_px4;
use super::{
    Change, Channel, Check, Checker, Detail, Interest, Level, Location, Message, Mutant, PerChannel, Px4Rule,
    Rule, RuleContext, Status,
};
use crate::definitions::TO_PX4;
use crate::rules::sample::{Flight, START};

pub(super) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-TIME-01",
        name: "Timestamps do not decrease",
        level: Level::Must,
        status: Status::Normative,
        statement: "The `timestamp` field does not decrease from one message of a subscription to the next. A \
                    timestamp may repeat, and it may be 0. In bags and JSON, only messages from PX4 are checked. \
                    There, PX4 may set its clock. Therefore, an earlier timestamp is a violation only if the step \
                    back is less than an hour, and the next message is not earlier than the message before the step.",
        source: "uORB publishes in order; `timestamp` is the time since system start",
        applies_to: "message sequences",
        why: "Tools sort and interpolate samples by time. If the time steps back, the order, rates and derivatives are \
              wrong.",
        example: "battery_status {\"timestamp\": 2000000, …}\n\
            battery_status {\"timestamp\": 1000000, …}",
        fix: "Set `timestamp` from the monotonic system clock when you publish the message. Check \
            that only one module publishes each topic instance.",
    },
    check: Check::State(|| Box::new(Times::default())),
    bug: Some(Bug::message(
        Side::Autopilot,
        "The `timestamp` of every third BatteryStatus is 3 s too early.",
        |out| {
            out.edit(3, |battery: &mut BatteryStatus| {
                battery.timestamp = battery.timestamp.saturating_sub(3_000_000);
            });
        },
    )),
    mutants: &[Mutant {
        name: "a message with an earlier timestamp than the ones before and after it",
        change: Change::Flight(back),
        also: &[],
    }],
};

/// The greatest step back of a message whose time is wrong, in µs. PX4 sends the time since 1970 once its clock is
/// synchronised with that of the computer, and the time since boot before that.
const MAX_STEP: u64 = 3_600_000_000;

#[derive(Default)]
struct Times {
    channels: PerChannel<Time>,
}

/// The times of a channel.
#[derive(Clone, Default)]
struct Time {
    /// The time of the latest message; 0 if it is unknown.
    latest: u64,
    /// The latest message, if its time is earlier than that of the message before it, and the next message shows whether
    /// the clock was set.
    early: Option<Early>,
}

/// A message with an earlier time than the one before it.
#[derive(Clone, Copy)]
struct Early {
    timestamp: u64,
    previous: u64,
    location: Location,
}

impl Checker for Times {
    fn opened(&mut self, channel: &Channel<'_>, context: &mut RuleContext<'_>) -> Interest {
        let is_to_px4 = channel.multi_id.is_none() && channel.full_topic.contains(TO_PX4);
        if is_to_px4 || !is_of_px4(channel, context) {
            return Interest::Nothing;
        }
        self.channels.open(channel, Time::default());
        Interest::Times
    }

    fn message(&mut self, channel: &Channel<'_>, message: &Message<'_>, context: &mut RuleContext<'_>) {
        let Some(timestamp) = message.timestamp.filter(|timestamp| *timestamp != 0) else { return };
        let Some(time) = self.channels.get(channel) else { return };
        // Later messages are compared with this message, even if its time is wrong. Otherwise, a single wrong time or a
        // restart would make all later messages wrong.
        let Time { latest: previous, early } =
            std::mem::replace(time, Time { latest: timestamp, early: None });
        if previous == 0 {
            return;
        }
        context.covered();
        let now = (timestamp < previous).then_some(Early { timestamp, previous, location: message.location });
        if channel.multi_id.is_some() {
            return report(now, channel, context);
        }
        time.early = now.filter(|early| early.previous - early.timestamp < MAX_STEP);
        report(early.filter(|early| timestamp >= early.previous), channel, context);
    }

    fn corruption(&mut self, _: Location) {
        // The latest message may be corrupt too.
        self.channels.iter_mut().for_each(|time| *time = Time::default());
    }
}

fn report(early: Option<Early>, channel: &Channel<'_>, context: &mut RuleContext<'_>) {
    let Some(Early { timestamp, previous, location }) = early else { return };
    context.violation_in_field(channel, "timestamp", location, || {
        Detail::new(format!("timestamp {timestamp} is earlier than the previous timestamp, {previous}"))
            .expected(format!("{previous} or later"))
            .actual(timestamp.to_string())
    });
}

/// Sets the time of a topic's last message but one to the time of its first message.
fn back<'d>(flight: &Flight<'d>) -> Option<Flight<'d>> {
    let topic = flight.regular(|_| true)?;
    let last = flight.messages[flight.last_of(topic)?].clone();
    let mut flight = flight.with_last(topic, |message| message["timestamp"] = START.into())?;
    flight.messages.push(last);
    Some(flight)
}
