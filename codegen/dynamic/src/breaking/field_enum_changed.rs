//! `field-enum-changed`: the enum annotation of a field changed.

use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::Example;
use uavspec_schema::{Field, Schema};

use super::message::{Pair, both};
use super::rule::{Category, Check, Rule, Sink};

pub(super) const RULE: Rule = Rule {
    id: "field-enum-changed",
    statement: "The enum annotation of a field changed.",
    why: "The numeric values stay the same, but the Rust type of the field changes.",
    fix: "Update the Rust programs that use the field.",
    breaks: &[(Category::Source, Level::Note)],
    old: &[Example {
        path: "Glider.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n\
               uint8 MODE_THERMAL = 0  # Circling in lift\n\
               uint8 mode              # Current mode\n",
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
        let kind = if found.is_flags { "flags" } else { "enum" };
        Some(format!("the {kind} {}", found.prefixes.join(", ")))
    };
    let (before, now) = (name(pair.old_schema, old), name(pair.new_schema, new));
    if before == now {
        return;
    }
    let plain = || "a plain number".to_owned();
    let (before, now) = (before.unwrap_or_else(plain), now.unwrap_or_else(plain));
    let message = format!("`{}.{}` is {now} instead of {before}", pair.name(), new.name);
    sink.change(new.span, both(old.span, new.span), message)
        .breaks(Category::Source, "the field's Rust type changes; values and bytes stay the same");
}
