//! Renders reports as JSON.
//!
//! The schema is `generated/schemas/uavspec/report.schema.json`, which is generated from the same types.

use uavspec_codegen::json_text;

use super::Report;

pub(super) fn write(report: &Report) -> String {
    json_text::pretty(report)
}
