//! `field-moved`: a field moved relative to the other fields.

use uavspec_schema::Element;

use super::message::Kept;
use super::prelude::*;
use crate::limits::MAX_COMPARISONS;

pub(super) const RULE: Rule = Rule {
    id: "field-moved",
    statement: "The order of the fields changed.",
    why: "CDR writes fields in the order of the definition. uORB sorts fields by size, so the uORB layout \
        changes only if fields of the same size swap places.",
    fix: "Restore the order.",
    breaks: &[(Category::Cdr, Level::Error), (Category::Uorb, Level::Error)],
    old: &[glider!["float32 sink      # [m/s] Sink rate", "float32 bank      # [rad] Bank angle"]],
    new: &[glider!["float32 bank      # [rad] Bank angle", "float32 sink      # [m/s] Sink rate"]],
    check: Check::Message(check),
};

fn check(pair: &Pair<'_>, sink: &mut Sink<'_>) {
    let kept: Vec<&Kept> = pair.kept().collect();
    let mut comparisons = 0;
    for moved in kept.iter().filter(|kept| kept.is_moved) {
        let (old, new) = (&pair.old.fields[moved.old], &pair.new.fields[moved.new]);
        comparisons += kept.len();
        let partner = kept.iter().filter(|_| comparisons <= MAX_COMPARISONS).find(|other| {
            let is_crossed = (other.old < moved.old) != (other.new < moved.new);
            is_crossed && size(pair, moved) == size(pair, other)
        });
        let message = format!("`{}.{}` has a different position in the message", pair.name(), new.name);
        let cdr = "existing readers decode this field's bytes as other fields";
        let mut change = sink.change(new.span, both(old.span, new.span), message);
        if !pair.is_uorb() {
            change.breaks(Category::Cdr, cdr);
        } else if let Some(partner) = partner {
            let name = &pair.new.fields[partner.new].name;
            change.breaks(Category::Cdr, cdr).breaks(
                Category::Uorb,
                format!("the layout changes: this field swaps places with `{name}`, which has the same size"),
            );
        } else {
            let help =
                format!("{cdr}; the field's uORB position stays the same, because uORB sorts fields by size");
            change.breaks(Category::Cdr, help);
        }
    }
}

/// The sort key that uORB uses for a field: the size of the field's elements. Nested messages come last.
fn size(pair: &Pair<'_>, kept: &Kept) -> (usize, bool) {
    match pair.new.fields[kept.new].ty.element {
        Element::Scalar(scalar) => (scalar.size(), false),
        Element::Text(_) => (1, false),
        Element::String { .. } | Element::Message(_) => (0, true),
    }
}
