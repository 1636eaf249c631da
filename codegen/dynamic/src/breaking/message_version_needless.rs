//! `message-version-needless`: a new version without a change.

use super::message_version::{VERSIONED, places};
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "message-version-needless",
    statement: "MESSAGE_VERSION was raised, but no field changed.",
    why: "Peers with the old and the new version reject each other unnecessarily.",
    fix: "Restore the version.",
    breaks: &[(Category::Version, Level::Note)],
    old: &[VERSIONED],
    new: &[Example {
        path: "Glider.msg",
        text: "uint32 MESSAGE_VERSION = 1\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n",
    }],
    check: Check::Message(check),
};

fn check(pair: &Pair<'_>, sink: &mut Sink<'_>) {
    let (Some(before), Some(now)) = (pair.old.version, pair.new.version) else { return };
    if now <= before || pair.has_changes() {
        return;
    }
    let message =
        format!("the version of `{}` increases from {before} to {now}, but no field changed", pair.name());
    let sides = places(pair);
    sink.change(sides.new.unwrap_or(pair.head()), sides, message).breaks(
        Category::Version,
        "peers with the old and the new version reject each other, although their messages are compatible",
    );
}
