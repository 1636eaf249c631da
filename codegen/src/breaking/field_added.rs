//! `field-added`: a field that is new.

use super::message::{FieldChange, Pair};
use super::rule::{Category, Check, Rule, Sink};
use crate::diagnostic::Level;
use crate::example::Example;
use crate::finding::Sides;
use crate::schema::Message;

pub(super) const RULE: Rule = Rule {
    id: "field-added",
    purpose: "A field is new. Messages of before lack it and have other bytes, so peers have to change \
              together.",
    breaks: &[
        (Category::Source, Level::Warning),
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
        path: "Glider.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n\
               float32 bank      # [rad] Bank angle\n\
               float32 sink      # [m/s] Sink rate\n",
    }],
    check: Check::Message(check),
};

fn check(pair: &Pair<'_>, sink: &mut Sink<'_>) {
    for change in &pair.fields {
        let FieldChange::Added(at) = *change else { continue };
        let field = &pair.new.fields[at];
        let last = pair.new.fields.len()
            - pair.fields.iter().rev().take_while(|change| matches!(change, FieldChange::Added(_))).count();
        let cdr = if at >= last {
            "messages are longer: readers of before refuse what is left over, new ones miss it in old messages"
        } else {
            "all that follows it stands elsewhere: readers of before take its bytes for other fields"
        };
        let message = format!("`{}.{}` ({}) is new", pair.name(), field.name, pair.new_type(field.ty));
        let mut change = sink.change(field.span, Sides { old: None, new: Some(field.span) }, message);
        change
            .breaks(Category::Source, "Rust code that names all fields of a value doesn't compile")
            .breaks(Category::Json, "it is missing in messages of before, and unknown to their readers")
            .breaks(Category::Cdr, cdr);
        if pair.is_uorb() {
            change.breaks(Category::Uorb, uorb(pair));
        }
    }
}

/// What becomes of the layout in memory.
pub(super) fn uorb(pair: &Pair<'_>) -> String {
    let size = |message: &Message| message.uorb.as_ref().map_or(0, |layout| layout.size);
    let (before, now) = (size(pair.old), size(pair.new));
    if before == now {
        "the layout differs, though not the size: programs of before take the bytes for other fields"
            .to_owned()
    } else {
        format!("the layout differs: {now} bytes, {before} before; logs say so and can still be read by name")
    }
}
