//! `message-version-removed`: a message that has no version any more.

use super::message::Pair;
use super::message_version::places;
use super::rule::{Category, Check, Rule, Sink};
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "message-version-removed",
    purpose: "A message was versioned and isn't any more: peers can no longer tell its states apart, and \
              PX4's translation between versions leaves it out.",
    breaks: &[(Category::Version, Level::Warning)],
    old: &[Example {
        path: "Glider.msg",
        text: "uint32 MESSAGE_VERSION = 0\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n",
    }],
    new: &[Example { path: "Glider.msg", text: "uint64 timestamp  # [us] Time since system start\n" }],
    check: Check::Message(check),
};

fn check(pair: &Pair<'_>, sink: &mut Sink<'_>) {
    let (Some(before), None) = (pair.old.version, pair.new.version) else { return };
    let message = format!("`{}` was versioned ({before}), and isn't any more", pair.name());
    sink.change(pair.head(), places(pair), message)
        .breaks(Category::Version, "peers of before can't tell by a version that it may have changed");
}
