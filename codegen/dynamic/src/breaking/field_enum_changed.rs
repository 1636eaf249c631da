//! `field-enum-changed`: the enum annotation of a field changed.

use uavspec_schema::Schema;

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "field-enum-changed",
    statement: "The enum annotation of a field changed.",
    why: "The numeric values stay the same, but the Rust type of the field changes.",
    fix: "Update the Rust programs that use the field.",
    breaks: &[(Category::Source, Level::Note)],
    old: &[glider!["uint8 MODE_THERMAL = 0  # Circling in lift", "uint8 mode              # Current mode"]],
    new: &[glider![
        "uint8 MODE_THERMAL = 0  # Circling in lift",
        "uint8 mode              # [@enum MODE] What it does"
    ]],
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
