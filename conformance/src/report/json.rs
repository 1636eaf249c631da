//! Renders reports as JSON.
//!
//! The schema is `generated/schemas/uavspec/report.schema.json`, which is generated from the same types.

use super::Report;

pub(super) fn write(report: &Report) -> String {
    // Serializing a report can't fail.
    serde_json::to_string_pretty(report).map_or_else(|_| String::new(), |text| text + "\n")
}
