//! `frame-unknown`: an unknown coordinate frame.

use std::collections::HashSet;

use uavspec_schema::Message;
use uavspec_schema::msg::attribute::FRAME;
use uavspec_schema::msg::statement::Statement;

use super::prelude::*;
use super::subject::annotations;

pub(super) const RULE: Rule = Rule {
    id: "frame-unknown",
    statement: "A coordinate frame that is not in the list of known frames.",
    why: "Readers can't tell the direction of the axes, so they may use a value with the wrong sign.",
    fix: "Write a known frame, such as NED, ENU, FRD or FLU, or `@` and the name of the field that \
        contains the frame.",
    levels: Levels::both(Level::Warning),
    bad: glider!["float32[3] wind  # [m/s] [@frame local] Wind"],
    good: glider!["float32[3] wind  # [m/s] [@frame NED] Wind"],
    measured: Some(Measured { findings: 2, sample: 2, right: 2 }),
    check: Check::Message(Scope::All, check),
};

/// World coordinate frames, in lower case.
const WORLD: [&str; 8] = ["ned", "enu", "nwu", "ecef", "wgs84", "local ned", "local enu", "local frd"];

/// Vehicle coordinate frames, in lower case.
const VEHICLE: [&str; 8] =
    ["frd", "flu", "body", "body frd", "body flu", "body frame", "body frame frd", "body frame flu"];

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    let mut declared = None;
    for annotation in subject.part.lines.iter().flat_map(annotations) {
        let Statement::Attribute(attribute, frame) = annotation.statement else { continue };
        if *attribute != FRAME {
            continue;
        }
        let is_known = if let Some(name) = frame.strip_prefix('@') {
            declared.get_or_insert_with(|| names(subject.message)).contains(name)
        } else {
            let frame = frame.to_lowercase();
            WORLD.contains(&frame.as_str()) || VEHICLE.contains(&frame.as_str())
        };
        if !is_known {
            sink.report(
                annotation.span,
                format!("unknown coordinate frame `{frame}`"),
                "write NED, ENU, ECEF, FRD, FLU or Body, or `@` and the name of the field that contains the frame",
            );
        }
    }
}

/// The names of the fields and constants of a message.
fn names(message: &Message) -> HashSet<&str> {
    let fields = message.fields.iter().map(|field| field.name.as_str());
    fields.chain(message.constants.iter().map(|constant| constant.name.as_str())).collect()
}
