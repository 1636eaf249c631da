//! `message-renamed`: a message was renamed.

use super::comparison::MessageChange;
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "message-renamed",
    statement: "A message was renamed; most of its fields are the same.",
    why: "Programs, topics and logs refer to a message by name. Even if the encoding is the same, peers \
        can't find each other.",
    fix: "Keep the name, or update all peers together.",
    breaks: &[
        (Category::Source, Level::Error),
        (Category::Json, Level::Error),
        (Category::Cdr, Level::Error),
        (Category::Uorb, Level::Error),
    ],
    old: &[glider!["float32 sink      # [m/s] Sink rate"]],
    new: &[Example {
        path: "GliderState.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n\
               float32 sink      # [m/s] Sink rate\n",
    }],
    check: Check::Interface(check),
};

fn check(change: &MessageChange<'_>, sink: &mut Sink<'_>) {
    let MessageChange::Renamed(old, new) = change else { return };
    let places = both(old.span.part(0..0), new.span.part(0..0));
    let message = format!("`{}` was renamed to `{}`", old.name, new.name);
    let mut change = sink.change(new.span.part(0..0), places, message);
    change
        .breaks(Category::Source, "programs that use this type no longer compile")
        .breaks(Category::Json, "the type names in messages change, and so do references to the schema")
        .breaks(Category::Cdr, "DDS and ROS 2 match types by name and hash: existing peers no longer match");
    if old.is_uorb {
        change.breaks(
            Category::Uorb,
            "the format name in logs changes, and so do topics named after the message",
        );
    }
}
