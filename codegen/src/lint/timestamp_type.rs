//! `timestamp-type`: a timestamp of another type.

use uavspec_runtime::Scalar;

use super::rule::{Check, Levels, Measured, Rule, Sink};
use super::subject::Subject;
use crate::diagnostic::Level;
use crate::example::Example;
use crate::schema::{Element, Shape, Type};

pub(super) const RULE: Rule = Rule {
    id: "timestamp-type",
    purpose: "The field `timestamp` of a message of PX4 is a `uint64`, in microseconds since system start. The \
              middleware, logs and the bridge to ROS 2 read eight bytes there, whatever the definition says.",
    levels: Levels::both(Level::Error),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint32 timestamp  # [us] Time since system start\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n",
    },
    measured: Some(Measured { findings: 0, sample: 0, right: 0, remark: "" }),
    check: Check::Message(check),
};

const EXPECTED: Type = Type { element: Element::Scalar(Scalar::UInt64), shape: Shape::Single };

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    if !subject.is_px4_message() {
        return;
    }
    for field in &subject.message.fields {
        if field.name == "timestamp" && field.ty != EXPECTED {
            let found = subject.schema.type_text(subject.message, field.ty);
            sink.report(field.span, format!("`timestamp` is of type `{found}`"), "make it a `uint64`");
        }
    }
}
