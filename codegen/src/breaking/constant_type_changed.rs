//! `constant-type-changed`: a constant of another type.

use super::message::both;
use super::message::{ConstantChange, Pair};
use super::rule::{Category, Check, Rule, Sink};
use crate::diagnostic::Level;
use crate::example::Example;
use crate::schema::{Shape, Type};

pub(super) const RULE: Rule = Rule {
    id: "constant-type-changed",
    purpose: "A constant has another type. Its value is the same; programs that compare it with a field of \
              the old type don't compile.",
    breaks: &[(Category::Source, Level::Warning)],
    old: &[Example {
        path: "Glider.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n\
               uint8 MODE_CRUISE = 0   # Straight on\n",
    }],
    new: &[Example {
        path: "Glider.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n\
               int8 MODE_CRUISE = 0    # Straight on\n",
    }],
    check: Check::Constant(check),
};

fn check(pair: &Pair<'_>, change: &ConstantChange<'_>, sink: &mut Sink<'_>) {
    let (ConstantChange::Same(old, new) | ConstantChange::Renamed(old, new)) = change else { return };
    if old.ty == new.ty {
        return;
    }
    let text = |element| Type { element, shape: Shape::Single };
    let (before, now) = (pair.old_type(text(old.ty)), pair.new_type(text(new.ty)));
    let message = format!("`{}.{}` is of type {now}, and was {before}", pair.name(), new.name);
    sink.change(new.span, both(old.span, new.span), message)
        .breaks(Category::Source, "programs that use it as the old type may not compile");
}
