//! `message-removed`: a message, service or action was removed.

use uavspec_schema::Kind;

use super::comparison::MessageChange;
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "message-removed",
    statement: "A message, service or action was removed.",
    why: "Programs that use the message no longer compile, and updated peers no longer send or accept it.",
    fix: "Keep the message until no program uses it.",
    breaks: &[
        (Category::Source, Level::Error),
        (Category::Json, Level::Error),
        (Category::Cdr, Level::Error),
        (Category::Uorb, Level::Error),
    ],
    old: &[glider![]],
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
    let message = format!("the {what} `{}` was removed", old.name);
    let mut change = sink.change(place, Sides { old: Some(place), new: None }, message);
    change
        .breaks(Category::Source, "programs that use this type no longer compile")
        .breaks(Category::Json, "programs no longer recognize JSON messages of this type")
        .breaks(Category::Cdr, "updated peers no longer send or accept messages of this type");
    if old.is_uorb {
        change.breaks(Category::Uorb, "the message's topics no longer exist, and are missing from new logs");
    }
}

/// The name of a kind.
pub(super) fn what(kind: Kind) -> &'static str {
    match kind {
        Kind::Message => "message",
        Kind::Service => "service",
        Kind::Action => "action",
    }
}
