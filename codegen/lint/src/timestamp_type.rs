//! `timestamp-type`: a timestamp that is not a `uint64`.

use uavspec_runtime::Scalar;
use uavspec_schema::{Element, Shape, Type};

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "timestamp-type",
    statement: "A PX4 message whose `timestamp` field is not a `uint64`.",
    why: "The middleware, the logger and the ROS 2 bridge read eight bytes, regardless of the defined type.",
    fix: "Change the type to `uint64`, in microseconds since system start.",
    levels: Levels::both(Level::Error),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint32 timestamp  # [us] Time since system start\n",
    },
    good: glider![],
    measured: Some(Measured { findings: 0, sample: 0, right: 0 }),
    check: Check::Message(Scope::Px4Messages, check),
};

const EXPECTED: Type = Type { element: Element::Scalar(Scalar::UInt64), shape: Shape::Single };

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    for field in &subject.message.fields {
        if field.name == "timestamp" && field.ty != EXPECTED {
            let found = subject.schema.type_text(subject.message, field.ty);
            sink.report(field.span, format!("`timestamp` has type `{found}`"), "change the type to `uint64`");
        }
    }
}
