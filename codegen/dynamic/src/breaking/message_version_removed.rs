//! `message-version-removed`: the version of a message was removed.

use super::message_version::{VERSIONED, places};
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "message-version-removed",
    statement: "MESSAGE_VERSION was removed.",
    why: "Peers can't detect later changes, and PX4's translation node ignores the message.",
    fix: "Keep `MESSAGE_VERSION`.",
    breaks: &[(Category::Version, Level::Warning)],
    old: &[VERSIONED],
    new: &[Example { path: "Glider.msg", text: "uint64 timestamp  # [us] Time since system start\n" }],
    check: Check::Message(check),
};

fn check(pair: &Pair<'_>, sink: &mut Sink<'_>) {
    let (Some(before), None) = (pair.old.version, pair.new.version) else { return };
    let message = format!("the version of `{}` ({before}) was removed", pair.name());
    sink.change(pair.head(), places(pair), message)
        .breaks(Category::Version, "existing peers can no longer detect changes by comparing versions");
}
