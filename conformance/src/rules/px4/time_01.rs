//! `PX-TIME-01`.

use super::{
    Change, Channel, Check, Checker, Detail, Interest, Level, Message, Mutant, PerChannel, Px4Rule, Rule,
    RuleContext, Status,
};
use crate::rules::sample::{Flight, START};

pub(super) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-TIME-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "The field `timestamp` doesn't go back from one message of a subscription to the next. It may repeat, and \
                it may be 0.",
        source: "uORB publishes in order; `timestamp` is the time since system start",
        applies_to: "messages over time",
        why: "",
        example: "",
        fix: "",
    },
    check: Check::State(|| Box::new(Times::default())),
    mutants: &[Mutant {
        name: "the last message is older than those before",
        change: Change::Flight(back),
        also: &[],
    }],
};

/// The latest time of each channel.
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
                Detail::new(format!("timestamp is {timestamp}, and was {latest} before"))
                    .expected(format!("{latest} or later"))
                    .actual(timestamp.to_string())
            });
        }
        context.covered();
        // What follows is judged by this message: one that is wrong, or a flight controller that starts again, doesn't
        // make all others wrong.
        if timestamp != 0 {
            *latest = timestamp;
        }
    }
}

/// The last message of a topic has the time of the first.
fn back<'d>(flight: &Flight<'d>) -> Option<Flight<'d>> {
    flight.with_last(flight.regular(|_| true)?, |message| message["timestamp"] = START.into())
}
