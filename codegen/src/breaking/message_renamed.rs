//! `message-renamed`: a message was renamed.

use super::comparison::MessageChange;
use super::message::both;
use super::rule::{Category, Check, Rule, Sink};
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "message-renamed",
    statement: "A message was renamed; most of its fields are the same.",
    why: "Programs, topics and logs refer to it by name. Its bytes may be the same, but peers don't \
        find each other.",
    fix: "Keep the name, or update all peers together.",
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
               uint64 timestamp  # [us] Time since system start\n\
               float32 sink      # [m/s] Sink rate\n",
    }],
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
    sink.change(new.span.part(0..0), places, message)
        .breaks(Category::Source, "programs that use its type don't compile")
        .breaks(Category::Json, "messages with a type name, and references to the schema, use another name")
        .breaks(Category::Cdr, "DDS and ROS 2 match types by name and hash: existing peers have no partner")
        .breaks(
            Category::Uorb,
            "the name of the format in logs changes, and so do topics that are named after the message",
        );
}
