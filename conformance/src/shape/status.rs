//! The shape of `UAVStatusInfo`, field by field.

use super::{Deviation, Element, INTEGER, MAX_DEVIATIONS, Mismatch, Shape};
use crate::json::Tree;

/// A field.
#[derive(Debug)]
pub struct StatusField {
    /// Its name.
    pub name: &'static str,
    /// Whether it has to be there.
    pub is_required: bool,
    /// What it has to be.
    pub shape: Shape,
}

const fn required(name: &'static str, shape: Shape) -> StatusField {
    StatusField { name, is_required: true, shape }
}

const fn optional(name: &'static str, shape: Shape) -> StatusField {
    StatusField { name, is_required: false, shape }
}

/// A direction in tenths of a degree.
const HEADING: Shape = Shape::Integer(0, 3599);

/// An angle in tenths of a degree.
const ANGLE: Shape = Shape::Integer(-1800, 1799);

/// A number that may be unknown.
const UNSURE: Shape = Shape::Nullable(&INTEGER);

/// In units of 1e-7 degrees, and millimetres. The text leaves a latitude of 90° itself out and the schema lets it in;
/// with the longitude of 180° it is the other way round, and -180° says the same.
const POSITION: &[Element] = &[
    ("latitude", Shape::Integer(-900_000_000, 900_000_000)),
    ("longitude", Shape::Integer(-1_800_000_000, 1_799_999_999)),
    ("altitude above sea level", UNSURE),
    ("altitude above home", UNSURE),
    ("altitude above ground", UNSURE),
];

const GPS: &[Element] = &[
    ("fix", Shape::Integer(0, 7)),
    ("satellites", UNSURE),
    ("horizontal accuracy", UNSURE),
    ("vertical accuracy", UNSURE),
];

const ATTITUDE: &[Element] = &[("roll", ANGLE), ("pitch", ANGLE), ("yaw", HEADING)];

const XYZ: &[Element] = &[("x", INTEGER), ("y", INTEGER), ("z", INTEGER)];

const NED: &[Element] = &[("north", INTEGER), ("east", INTEGER), ("down", INTEGER)];

/// The percentage is negative where it is unknown.
const BATTERY: &[Element] = &[
    ("voltage", Shape::Integer(0, i128::MAX)),
    ("percentage", Shape::Nullable(&Shape::Integer(i128::MIN, 100))),
    ("charging", Shape::Nullable(&Shape::Bool)),
];

/// All fields, in the order in which the specification has them.
pub static FIELDS: [StatusField; 15] = [
    required("id", Shape::ObjectId),
    required("timestamp", INTEGER),
    optional("mode", Shape::Text),
    optional("position", Shape::Tuple(POSITION, 2)),
    optional("positionXYZ", Shape::Tuple(XYZ, 3)),
    optional("gps", Shape::Tuple(GPS, 1)),
    optional("heading", HEADING),
    optional("attitude", Shape::Tuple(ATTITUDE, 3)),
    optional("velocity", Shape::Tuple(NED, 3)),
    optional("velocityXYZ", Shape::Tuple(XYZ, 3)),
    optional("battery", Shape::Tuple(BATTERY, 1)),
    optional("light", Shape::Integer(0, 0xffff)),
    optional("rssi", Shape::List(&Shape::Integer(-1, 100))),
    optional("errors", Shape::List(&INTEGER)),
    optional("debug", Shape::Base64),
];

/// What deviates in the states of a body.
pub(super) fn check(body: &Tree<'_>) -> Vec<Deviation> {
    let Some(Tree::Object(states)) = body.get("status") else { return Vec::new() };
    let mut deviations = Vec::new();
    for (uav, state) in states {
        if deviations.len() >= MAX_DEVIATIONS {
            break;
        }
        for field in &FIELDS {
            let mismatch = match state.get(field.name) {
                Some(value) => field.shape.mismatch(value).map(|found| found.below(field.name)),
                None if field.is_required => {
                    let expected = format!("{}: {}", field.name, field.shape);
                    Some(Mismatch::new(expected, "nothing"))
                }
                None => None,
            };
            let found = mismatch.map(|mismatch| mismatch.below(uav).below("status").below("body"));
            deviations.extend(found.map(|mismatch| Deviation { field: field.name, mismatch }));
        }
    }
    deviations
}
