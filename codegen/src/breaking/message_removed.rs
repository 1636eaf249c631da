//! `message-removed`: a message, service or action that is gone.

use super::comparison::MessageChange;
use super::rule::{Category, Check, Rule, Sink};
use crate::diagnostic::Level;
use crate::example::Example;
use crate::finding::Sides;
use crate::schema::Kind;

pub(super) const RULE: Rule = Rule {
    id: "message-removed",
    purpose: "A message, a service or an action is gone. Nothing that was built on it goes on: programs \
              don't compile, and nobody sends or takes it any more.",
    breaks: &[
        (Category::Source, Level::Error),
        (Category::Json, Level::Error),
        (Category::Cdr, Level::Error),
        (Category::Uorb, Level::Error),
    ],
    old: &[Example {
        path: "Glider.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n",
    }],
    new: &[Example {
        path: "Winch.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n",
    }],
    check: Check::Interface(check),
};

fn check(change: &MessageChange<'_>, sink: &mut Sink<'_>) {
    let MessageChange::Removed(old) = change else { return };
    let place = old.span.part(0..0);
    let what = what(old.kind);
    let message = format!("the {what} `{}` is gone", old.name);
    let mut change = sink.change(place, Sides { old: Some(place), new: None }, message);
    change
        .breaks(Category::Source, "programs that use its type don't compile")
        .breaks(Category::Json, "nothing in JSON is of this type any more")
        .breaks(Category::Cdr, "peers that send or expect it find no partner");
    if old.kind == Kind::Message {
        change.breaks(Category::Uorb, "its topics are gone, and new logs don't have them");
    }
}

/// What a kind of file defines, in words.
pub(super) fn what(kind: Kind) -> &'static str {
    match kind {
        Kind::Message => "message",
        Kind::Service => "service",
        Kind::Action => "action",
    }
}
