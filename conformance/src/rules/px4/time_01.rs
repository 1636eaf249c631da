//! `PX-TIME-01`.

use uavspec::px4::BatteryStatus;

use super::bug::{Bug, Side};
use super::{
    Change, Channel, Check, Checker, Detail, Interest, Level, Location, Message, Mutant, PerChannel, Px4Rule,
    Rule, RuleContext, Status,
};
use crate::rules::sample::{Flight, START};

pub(super) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-TIME-01",
        name: "Timestamps do not decrease",
        level: Level::Must,
        status: Status::Normative,
        statement: "The `timestamp` field does not decrease from one message of a subscription to the next. A \
                    timestamp may repeat, and it may be 0.",
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
        name: "a final message with an earlier timestamp than the ones before it",
        change: Change::Flight(back),
        also: &[],
    }],
};

/// The time of the latest message of each channel.
#[derive(Default)]
struct Times {
    latest: PerChannel<u64>,
}

impl Checker for Times {
    fn opened(&mut self, channel: &Channel<'_>, _: &mut RuleContext<'_>) -> Interest {
        self.latest.open(channel, 0);
        Interest::Times
    }

    fn message(&mut self, channel: &Channel<'_>, message: &Message<'_>, context: &mut RuleContext<'_>) {
        let (Some(timestamp), Some(latest)) = (message.timestamp, self.latest.get(channel)) else {
            return;
        };
        if timestamp < *latest && timestamp != 0 {
            let latest = *latest;
            context.violation_in_field(channel, "timestamp", message.location, || {
                Detail::new(format!("timestamp {timestamp} is earlier than the previous timestamp, {latest}"))
                    .expected(format!("{latest} or later"))
                    .actual(timestamp.to_string())
            });
        }
        context.covered();
        // Later messages are compared with this message, even if its time is wrong. Otherwise, a single wrong time or a
        // restart would make all later messages wrong.
        if timestamp != 0 {
            *latest = timestamp;
        }
    }

    fn corruption(&mut self, _: Location) {
        // The latest message may be corrupt too.
        self.latest.iter_mut().for_each(|latest| *latest = 0);
    }
}

/// Sets the time of a topic's last message to the time of its first message.
fn back<'d>(flight: &Flight<'d>) -> Option<Flight<'d>> {
    flight.with_last(flight.regular(|_| true)?, |message| message["timestamp"] = START.into())
}
