//! `message-version`: a message version that doesn't reflect a change.

use uavspec_schema::Message;

use super::message::{Between, VERSION};
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "message-version",
    statement: "A versioned PX4 message changed, but MESSAGE_VERSION did not increase by exactly one. \
        Between releases, the version may increase by more than one.",
    why: "Two different definitions of the message have the same version, so peers and PX4's translation node can't \
        distinguish them.",
    fix: "Raise `MESSAGE_VERSION` by one, and never lower it.",
    breaks: &[(Category::Version, Level::Error)],
    old: &[VERSIONED],
    new: &[Example {
        path: "Glider.msg",
        text: "uint32 MESSAGE_VERSION = 0\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n\
               float32 sink      # [m/s] Sink rate\n",
    }],
    check: Check::Message(check),
};

/// A message with a version.
pub(super) const VERSIONED: Example = Example {
    path: "Glider.msg",
    text: "uint32 MESSAGE_VERSION = 0\n\
           \n\
           uint64 timestamp  # [us] Time since system start\n",
};

fn check(pair: &Pair<'_>, sink: &mut Sink<'_>) {
    let (Some(before), Some(now)) = (pair.old.version, pair.new.version) else { return };
    let next = before.saturating_add(1);
    let name = pair.name();
    let (message, help) = if now < before {
        (
            format!("the version of `{name}` decreases from {before} to {now}"),
            "a version must not decrease".to_owned(),
        )
    } else if now == before && pair.has_changed_fields() {
        let message = format!("the fields of `{name}` changed, but its version is still {now}");
        (message, format!("raise {VERSION} to {next}"))
    } else if now > next && pair.between == Between::Commits && pair.has_changes() {
        let message = format!("the version of `{name}` jumps from {before} to {now}");
        (
            message,
            format!(
                "raise {VERSION} by exactly one, to {next}; `--between releases` allows larger increases"
            ),
        )
    } else {
        return;
    };
    let sides = places(pair);
    sink.change(sides.new.unwrap_or(pair.head()), sides, message).breaks(Category::Version, help);
}

/// The locations of the version constants in the old and the new message.
pub(super) fn places(pair: &Pair<'_>) -> Sides {
    let place = |message: &Message| {
        message.constants.iter().find(|constant| constant.name == VERSION).map(|found| found.span)
    };
    Sides { old: place(pair.old), new: place(pair.new) }
}
