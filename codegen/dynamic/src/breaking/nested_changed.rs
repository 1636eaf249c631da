//! `nested-changed`: a nested message changed.

use uavspec_schema::Element;

use super::field_added::uorb;
use super::message::Held;
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "nested-changed",
    statement: "A nested message changed, so the message that contains it changed as well.",
    why: "The encoding of the outer message changes, although its own definition stays the same.",
    fix: "Raise `MESSAGE_VERSION` of the outer message as well, and update all peers together.",
    breaks: &[
        (Category::Cdr, Level::Error),
        (Category::Uorb, Level::Error),
        (Category::Version, Level::Warning),
    ],
    old: &[GLIDER, Example { path: "Flap.msg", text: "# A flap\n\nfloat32 angle  # [rad] Deflection\n" }],
    new: &[
        GLIDER,
        Example {
            path: "Flap.msg",
            text: "# A flap\n\nfloat32 angle  # [rad] Deflection\nbool is_stuck  # True if it is stuck\n",
        },
    ],
    check: Check::Message(check),
};

const GLIDER: Example = Example {
    path: "Glider.msg",
    text: "# State of a glider\n\nuint32 MESSAGE_VERSION = 0\n\nuint64 timestamp  # [us] Time since system start\n\
           Flap[2] flaps     # Left and right\n",
};

fn check(pair: &Pair<'_>, sink: &mut Sink<'_>) {
    for kept in pair.kept() {
        let Held::Changed { cdr, uorb: memory } = kept.held else { continue };
        let (old, new) = (&pair.old.fields[kept.old], &pair.new.fields[kept.new]);
        let Element::Message(id) = new.ty.element else { continue };
        let nested = pair.new_schema.message(id);
        let message = format!("`{}.{}` contains `{}`, which changed", pair.name(), new.name, nested.name);
        let mut change = sink.change(new.span, both(old.span, new.span), message);
        change.relate(nested.span.part(0..0), "changed message");
        if cdr {
            change.breaks(
                Category::Cdr,
                "existing readers decode the nested message incorrectly, and fields after it may move",
            );
        }
        if memory && pair.is_uorb() {
            change.breaks(Category::Uorb, uorb(pair));
        }
        let is_silent = pair.old.version.is_some() && pair.old.version == pair.new.version;
        if is_silent && !pair.has_changed_fields() {
            let help = format!("the version of `{}` is the same: peers can't detect the change", pair.name());
            change.breaks(Category::Version, help);
        }
    }
}
