//! `field-enum-changed`: a field that holds other constants.

use super::message::Pair;
use super::message::both;
use super::rule::{Category, Check, Rule, Sink};
use crate::diagnostic::Level;
use crate::example::Example;
use crate::schema::{Field, Schema};

pub(super) const RULE: Rule = Rule {
    id: "field-enum-changed",
    purpose: "A field is annotated with other constants than before. Its values are the same numbers; its \
              type in Rust is another one.",
    breaks: &[(Category::Source, Level::Note)],
    old: &[Example {
        path: "Glider.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n\
               uint8 MODE_THERMAL = 0  # Circling in lift\n\
               uint8 mode              # What it does\n",
    }],
    new: &[Example {
        path: "Glider.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n\
               uint8 MODE_THERMAL = 0  # Circling in lift\n\
               uint8 mode              # [@enum MODE] What it does\n",
    }],
    check: Check::Field(check),
};

fn check(pair: &Pair<'_>, old: &Field, new: &Field, sink: &mut Sink<'_>) {
    let name = |schema: &Schema, field: &Field| {
        let found = schema.enumeration(field.enumeration?);
        let of = if found.is_flags { "flags" } else { "enum" };
        Some(format!("the {of} {}", found.prefixes.join(", ")))
    };
    let (before, now) = (name(pair.old_schema, old), name(pair.new_schema, new));
    if before == now {
        return;
    }
    let plain = || "a plain number".to_owned();
    let (before, now) = (before.unwrap_or_else(plain), now.unwrap_or_else(plain));
    let message = format!("`{}.{}` is {now}, and was {before}", pair.name(), new.name);
    sink.change(new.span, both(old.span, new.span), message)
        .breaks(Category::Source, "its type in Rust is another one; values and bytes are the same");
}
