//! For programs: the report as it is.
//!
//! The form is described by `generated/schemas/uavspec/report.schema.json`, which is made of the same types.

use super::Report;

pub(super) fn write(report: &Report) -> String {
    // Values of this kind can always be written.
    serde_json::to_string_pretty(report).map_or_else(|_| String::new(), |text| text + "\n")
}
