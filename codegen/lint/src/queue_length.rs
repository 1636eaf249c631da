//! `queue-length`: a queue length that is not a power of two.

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "queue-length",
    statement: "A queue length that is not a power of two.",
    why: "PX4 rounds the length up to the next power of two, so the queue is longer than defined.",
    fix: "Use a power of two.",
    levels: Levels::both(Level::Warning),
    bad: glider!["", "uint8 ORB_QUEUE_LENGTH = 12"],
    good: glider!["", "uint8 ORB_QUEUE_LENGTH = 16"],
    measured: Some(Measured { findings: 0, sample: 0, right: 0 }),
    check: Check::Message(Scope::All, check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    let Some(length) = subject.message.queue_length.filter(|length| !length.is_power_of_two()) else {
        return;
    };
    let constants = &subject.message.constants;
    if let Some(constant) = constants.iter().find(|constant| constant.name == "ORB_QUEUE_LENGTH") {
        let help = match length.checked_next_power_of_two() {
            Some(next) => format!("PX4 rounds the length up to {next}: write {next}"),
            None => "the length is too large".to_owned(),
        };
        sink.report(constant.span, format!("queue length {length} is not a power of two"), help);
    }
}
