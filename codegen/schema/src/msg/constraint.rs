//! Constraints: annotations that restrict the values of a field.
//!
//! ```
//! # use uavspec_schema::{Form, PackageInput, SourceMap, msg::Dialect, read};
//! # let mut sources = SourceMap::default();
//! # let id = sources.add("Wind.msg", "uint64 timestamp  # [us] Time\nfloat32 speed  # [m/s] [@range 0, 60] Speed\n".into()).unwrap();
//! # let packages = [PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])];
//! # let (schema, diagnostics) = read(&sources, &packages);
//! use uavspec_schema::msg::constraint::RANGE;
//!
//! let speed = &schema.messages[0].fields[1];
//! assert_eq!(speed.constraint(&RANGE).unwrap().valid_values().unwrap(), "0 to 60");
//! ```

mod model;
pub mod number;
mod range;
mod special;

pub use self::model::{Argument, Constraint, ConstraintKind, Effect, Probe, Range, Stated};
pub use self::range::RANGE;
pub(crate) use self::range::read as read_range;
pub use self::special::{INVALID, UNCONTROLLED};

/// All kinds of constraints, in the order of output.
pub static CONSTRAINTS: &[&ConstraintKind] = &[&RANGE, &INVALID, &UNCONTROLLED];

/// The constraint of the given kind.
pub fn find<'c>(constraints: &'c [Constraint], kind: &ConstraintKind) -> Option<&'c Constraint> {
    constraints.iter().find(|constraint| constraint.kind == kind)
}

/// Replaces the constraint of the given kind, and keeps the order of [`CONSTRAINTS`].
pub(crate) fn replace(
    constraints: &mut Vec<Constraint>,
    kind: &ConstraintKind,
    constraint: Option<Constraint>,
) {
    constraints.retain(|found| found.kind != kind);
    constraints.extend(constraint);
    constraints.sort_by_key(|found| rank(found.kind));
}

/// The position of a kind in [`CONSTRAINTS`].
pub(crate) fn rank(kind: &ConstraintKind) -> Option<usize> {
    CONSTRAINTS.iter().position(|known| *known == kind)
}
