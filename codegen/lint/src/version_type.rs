//! `version-type`: special PX4 constants of an unexpected type.

use uavspec_runtime::Scalar;
use uavspec_schema::Element;

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "version-type",
    statement: "A MESSAGE_VERSION or ORB_QUEUE_LENGTH constant of an unexpected type.",
    why: "Generated code that uses these constants expects `uint32 MESSAGE_VERSION` and `uint8 \
        ORB_QUEUE_LENGTH`.",
    fix: "Use the expected type.",
    levels: Levels::both(Level::Warning),
    bad: glider!["", "uint32 ORB_QUEUE_LENGTH = 8"],
    good: glider!["", "uint8 ORB_QUEUE_LENGTH = 8"],
    measured: Some(Measured { findings: 1, sample: 1, right: 1 }),
    check: Check::Message(Scope::Px4Messages, check),
};

const TYPES: [(&str, Scalar); 2] = [("MESSAGE_VERSION", Scalar::UInt32), ("ORB_QUEUE_LENGTH", Scalar::UInt8)];

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    for constant in &subject.message.constants {
        let expected = TYPES.iter().find(|(name, _)| *name == constant.name);
        if let Some((name, scalar)) = expected.filter(|(_, scalar)| constant.ty != Element::Scalar(*scalar)) {
            let expected = scalar.name();
            sink.report(
                constant.span,
                format!("`{name}` is not a `{expected}`"),
                format!("write `{expected} {name} = {}`", constant.value),
            );
        }
    }
}
