//! `queue-length`: queues as PX4 makes them.

use super::rule::{Check, Levels, Measured, Rule, Sink};
use super::subject::Subject;
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "queue-length",
    purpose: "The length of a queue is a power of two. PX4 rounds any other up to the next one, so that the \
              queue holds more than the definition says.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\n\
               uint8 ORB_QUEUE_LENGTH = 12\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\n\
               uint8 ORB_QUEUE_LENGTH = 16\n",
    },
    measured: Some(Measured { findings: 0, sample: 0, right: 0, remark: "" }),
    check: Check::Message(check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    let Some(length) = subject.message.queue_length.filter(|length| !length.is_power_of_two()) else {
        return;
    };
    let constants = &subject.message.constants;
    if let Some(constant) = constants.iter().find(|constant| constant.name == "ORB_QUEUE_LENGTH") {
        let help = match length.checked_next_power_of_two() {
            Some(next) => format!("PX4 makes it {next}: write that"),
            None => "no queue is that long".to_owned(),
        };
        sink.report(constant.span, format!("a queue of {length} messages"), help);
    }
}
