//! `field-removed`: a field that is gone.

use super::field_added::uorb;
use super::message::{FieldChange, Pair};
use super::rule::{Category, Check, Rule, Sink};
use crate::diagnostic::Level;
use crate::example::Example;
use crate::finding::Sides;

pub(super) const RULE: Rule = Rule {
    id: "field-removed",
    purpose: "A field is gone. Programs that use it don't compile, and messages have other bytes, so peers \
              have to change together.",
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
               float32 bank      # [rad] Bank angle\n\
               float32 sink      # [m/s] Sink rate\n",
    }],
    new: &[Example {
        path: "Glider.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n\
               float32 sink      # [m/s] Sink rate\n",
    }],
    check: Check::Message(check),
};

fn check(pair: &Pair<'_>, sink: &mut Sink<'_>) {
    for change in &pair.fields {
        let FieldChange::Removed(at) = *change else { continue };
        let field = &pair.old.fields[at];
        let message = format!("`{}.{}` ({}) is gone", pair.name(), field.name, pair.old_type(field.ty));
        let cdr = if at + 1 == pair.old.fields.len() {
            "messages are shorter: readers of before miss it, new ones refuse what old messages have left over"
        } else {
            "all that followed it stands elsewhere: readers of before take other bytes for it"
        };
        let mut change = sink.change(pair.head(), Sides { old: Some(field.span), new: None }, message);
        change
            .breaks(Category::Source, "programs that use it don't compile")
            .breaks(Category::Json, "readers of before miss it, and what they write has one member too many")
            .breaks(Category::Cdr, cdr);
        if pair.is_uorb() {
            change.breaks(Category::Uorb, uorb(pair));
        }
    }
}
