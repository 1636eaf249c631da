//! `timestamp-missing`: a message without a timestamp.

use super::prelude::*;
use super::topics;

pub(super) const RULE: Rule = Rule {
    id: "timestamp-missing",
    statement: "A PX4 message without a `timestamp` field.",
    why: "The middleware and log tools use the timestamp to order samples, and the PX4 build fails if a \
        topic has no timestamp. Messages used only as nested types don't need a timestamp.",
    fix: "Add `uint64 timestamp  # [us] Time since system start`.",
    levels: Levels::both(Level::Warning),
    bad: Example { path: "Glider.msg", text: "# State of a glider\n\nfloat32 sink  # [m/s] Sink rate\n" },
    good: glider!["float32 sink  # [m/s] Sink rate"],
    measured: Some(Measured { findings: 0, sample: 0, right: 0 }),
    check: Check::Message(Scope::Px4Messages, check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    let has_topics = || topics::lines(subject).any(|line| topics::words(line).next().is_some());
    if subject.message.fields.iter().all(|field| field.name != "timestamp")
        && (!subject.is_nested || has_topics())
    {
        let help =
            "add `uint64 timestamp  # [us] Time since system start`, or remove the message if it is not used";
        sink.report(subject.head(), format!("`{}` has no timestamp", subject.message.name), help);
    }
}
