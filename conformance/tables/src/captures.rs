//! The captures.

use uavspec_check::{ReleaseMatch, Summary};
use uavspec_report::{About, Origin, Subject};

use super::column::{Column, Table};

pub(super) static TABLE: Table<CaptureRow> = Table {
    name: "captures",
    description: "A capture that was checked.",
    columns: &[
        Column::text("capture", "The path or URL.", |row| Some(&row.path)),
        Column::count("size", "The size before decompression.", |row: &CaptureRow| row.origin.size)
            .in_unit("B"),
        Column::text("etag", "The version in the object store.", |row| row.origin.etag.as_deref()),
        Column::text(
            "kind",
            "The kind: `ulog`, `mcap`, `rosbag2`, `json`, `flockwave` or `unknown`.",
            |row| row.kind,
        ),
        Column::text("firmware", "The name and version of the firmware in a log.", |row| {
            row.firmware.as_deref()
        }),
        Column::text("release", "The release that matches the capture best, such as `px4@1.16`.", |row| {
            row.release.as_deref()
        }),
        Column::time(
            "start",
            "The time of the first record, if the capture contains the time in UTC.",
            |row| row.start,
        ),
        Column::number("duration", "The time from the first to the last record.", |row: &CaptureRow| {
            row.duration
        })
        .in_unit("s"),
        Column::count("records", "The number of records.", |row| row.records),
        Column::count("checked_records", "The number of records that were checked.", |row| {
            row.checked_records
        }),
        Column::count("topics", "The number of topics or types with records.", |row| row.topics),
        Column::count("checked_topics", "The number of topics or types that were fully checked.", |row| {
            row.checked_topics
        }),
        Column::count("checked_values", "The number of values that were checked.", |row| row.checked_values),
        Column::count("violated_must", "The number of violated rules of level MUST.", |row| row.violated[0]),
        Column::count("violated_should", "The number of violated rules of level SHOULD.", |row| {
            row.violated[1]
        }),
        Column::text("outcome", "The outcome, as in the JSON report.", |row| Some(row.outcome)),
        Column::text("text", "The outcome as a sentence.", |row| Some(&row.text)),
        Column::text(
            "problem",
            "The first reason why the capture wasn't read or checked completely.",
            |row| row.problem.as_deref(),
        ),
    ],
};

/// A capture.
#[derive(Debug, Default)]
pub(super) struct CaptureRow {
    path: String,
    origin: Origin,
    kind: Option<&'static str>,
    firmware: Option<String>,
    release: Option<String>,
    start: Option<u64>,
    duration: Option<f64>,
    records: Option<u64>,
    checked_records: Option<u64>,
    topics: Option<u64>,
    checked_topics: Option<u64>,
    checked_values: Option<u64>,
    /// The numbers of violated MUST and SHOULD rules.
    violated: [Option<u64>; 2],
    outcome: &'static str,
    text: String,
    problem: Option<String>,
}

impl CaptureRow {
    pub(super) fn of(subject: &Subject, origin: Origin) -> Self {
        let (kind, firmware, releases) = match &subject.about {
            About::Capture(summary) => (kind(summary), firmware(summary), summary.releases()),
            About::Testee(_) => ("testee", None, &[][..]),
        };
        let coverage = &subject.coverage;
        #[allow(clippy::cast_precision_loss, reason = "µs are exact for centuries")]
        let duration = subject.duration_us as f64 / 1e6;
        Self {
            path: subject.path.clone(),
            origin,
            kind: Some(kind),
            firmware,
            release: main_release(releases).map(str::to_owned),
            start: subject.start_utc,
            duration: Some(duration),
            records: Some(subject.records),
            checked_records: Some(subject.checked),
            topics: coverage.units.total,
            checked_topics: Some(coverage.units.checked),
            checked_values: Some(coverage.values.checked),
            violated: subject.violated().map(Some),
            outcome: subject.outcome.kind.name(),
            text: subject.outcome.text.clone(),
            problem: subject.incomplete.first().cloned(),
        }
    }
}

/// The release that a capture matches best.
pub(super) fn main_release(releases: &[ReleaseMatch]) -> Option<&str> {
    releases.iter().max_by_key(|release| release.matching).map(|release| release.release.as_str())
}

/// The kind of a capture, as in JSON reports.
fn kind(summary: &Summary) -> &'static str {
    match summary {
        Summary::Log(_) => "ulog",
        Summary::Json(_) => "json",
        Summary::Mcap(_) => "mcap",
        Summary::Bag(_) => "rosbag2",
        Summary::Flockwave(_) => "flockwave",
        Summary::Unknown(_) => "unknown",
    }
}

fn firmware(summary: &Summary) -> Option<String> {
    match summary {
        Summary::Log(log) => log.firmware.clone(),
        _ => None,
    }
}
