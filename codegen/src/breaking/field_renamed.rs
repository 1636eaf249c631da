//! `field-renamed`: a field under another name.

use super::message::Pair;
use super::message::both;
use super::rule::{Category, Check, Rule, Sink};
use crate::diagnostic::Level;
use crate::example::Example;
use crate::schema::Field;

pub(super) const RULE: Rule = Rule {
    id: "field-renamed",
    purpose: "A field has another name: recognised as one where its type and its position are the same. \
              Its bytes are too, but PX4 and ROS 2 hash the names of fields with their types, and peers \
              that compare hashes refuse each other.",
    breaks: &[
        (Category::Source, Level::Error),
        (Category::Json, Level::Error),
        (Category::Cdr, Level::Warning),
        (Category::Uorb, Level::Warning),
    ],
    old: &[Example {
        path: "Glider.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n\
               float32 descent   # [m/s] Sink rate\n",
    }],
    new: &[Example {
        path: "Glider.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n\
               float32 sink      # [m/s] Sink rate\n",
    }],
    check: Check::Field(check),
};

fn check(pair: &Pair<'_>, old: &Field, new: &Field, sink: &mut Sink<'_>) {
    if old.name == new.name {
        return;
    }
    let message =
        format!("`{}.{}` ({}) is now called `{}`", pair.name(), old.name, pair.new_type(new.ty), new.name);
    let mut change = sink.change(new.span, both(old.span, new.span), message);
    change
        .breaks(Category::Source, "programs that use it by its old name don't compile")
        .breaks(Category::Json, "readers of before miss the old member, and don't know the new one")
        .breaks(
            Category::Cdr,
            "the bytes are the same; but the type's hash isn't, so peers that compare hashes refuse",
        );
    if pair.is_uorb() {
        let help =
            "the bytes are the same; but the message's hash isn't, and readers of logs look for the old name";
        change.breaks(Category::Uorb, help);
    }
}
