//! `message-renamed`: a message under another name.

use super::comparison::MessageChange;
use super::message::both;
use super::rule::{Category, Check, Rule, Sink};
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "message-renamed",
    purpose: "A message has another name: recognised as one by its fields. What refers to it by name no \
              longer finds it, while its bytes may be the same.",
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
    let message = format!("`{}` is now called `{}`", old.name, new.name);
    sink.change(new.span.part(0..0), places, message)
        .breaks(Category::Source, "programs that use its type don't compile")
        .breaks(
            Category::Json,
            "messages that name their type, and references to its schema, name another one",
        )
        .breaks(Category::Cdr, "DDS and ROS 2 match types by name and hash: peers of before find no partner")
        .breaks(
            Category::Uorb,
            "logs name another format, and topics that are called after it change with it",
        );
}
