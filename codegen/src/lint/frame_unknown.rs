//! `frame-unknown`: a coordinate frame that nobody knows.

use super::{Check, Example, Levels, Rule, Sink, Subject, annotations};
use crate::diagnostic::Level;
use crate::msg::annotation::Statement;
use crate::schema::Message;

pub(super) const RULE: Rule = Rule {
    id: "frame-unknown",
    purpose: "A coordinate frame is one of those known, or with `@` the name of a field that says which. North \
              of a frame that only its author knows can't be told from south.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               float32[3] wind  # [m/s] [@frame local] Wind\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               float32[3] wind  # [m/s] [@frame NED] Wind\n",
    },
    measured: None,
    check: Check::Message(check),
};

/// Coordinate frames, in lower case: of the world, of the vehicle, and both.
const FRAMES: &[&str] = &[
    "ned",
    "enu",
    "nwu",
    "ecef",
    "wgs84", // world
    "frd",
    "flu",
    "body",
    "body frd",
    "body flu",
    "body frame",
    "body frame frd",
    "body frame flu", // vehicle
    "local ned",
    "local enu",
    "local frd",
];

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    for annotation in subject.part.lines.iter().flat_map(annotations) {
        let Statement::Frame(frame) = annotation.statement else { continue };
        let is_known = match frame.strip_prefix('@') {
            Some(name) => is_declared(name, subject.message),
            None => FRAMES.contains(&frame.to_lowercase().as_str()),
        };
        if !is_known {
            sink.report(
                annotation.span,
                format!("`{frame}` is no known coordinate frame"),
                "write NED, ENU, ECEF, FRD, FLU or Body, or `@` and the name of the field that says which",
            );
        }
    }
}

fn is_declared(name: &str, message: &Message) -> bool {
    message.fields.iter().any(|field| field.name == name)
        || message.constants.iter().any(|constant| constant.name == name)
}
