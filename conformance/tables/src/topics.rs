//! The topics of the captures.

use uavspec_check::{Part, PartResult, ReleaseMatch};
use uavspec_report::{About, Subject};

use super::captures::main_release;
use super::column::{Column, Table};

pub(super) static TABLE: Table<TopicRow> = Table {
    name: "topics",
    description: "A topic of a capture, or a type of messages in a session or in JSON.",
    columns: &[
        Column::text("capture", "The path or URL.", |row| Some(&row.capture)),
        Column::text("topic", "The topic or type.", |row| Some(&row.topic)),
        Column::text("release", "The release that the topic was checked against.", |row| {
            row.release.as_deref()
        }),
        Column::count("records", "The number of records.", |row| row.records),
        Column::count("checked_records", "The number of records that were checked.", |row| {
            Some(row.checked_records)
        }),
        Column::count("checked_values", "The number of values that were checked.", |row| {
            Some(row.checked_values)
        }),
        Column::number("rate", "The mean rate.", |row: &TopicRow| row.rate).in_unit("Hz"),
        Column::number(
            "first",
            "The time of the first record: since boot, or since 1970.",
            |row: &TopicRow| row.first,
        )
        .in_unit("s"),
        Column::number("last", "The time of the last record.", |row: &TopicRow| row.last).in_unit("s"),
        Column::flag("is_checked", "True if all records were fully checked.", |row| Some(row.is_checked)),
        Column::text("result", "The result, or the reason why something wasn't checked.", |row| {
            Some(row.result)
        }),
    ],
};

/// A topic.
#[derive(Debug)]
pub(super) struct TopicRow {
    capture: String,
    topic: String,
    release: Option<String>,
    records: Option<u64>,
    checked_records: u64,
    checked_values: u64,
    rate: Option<f64>,
    first: Option<f64>,
    last: Option<f64>,
    is_checked: bool,
    result: &'static str,
}

impl TopicRow {
    pub(super) fn of(subject: &Subject) -> impl Iterator<Item = Self> {
        let releases = match &subject.about {
            About::Capture(summary) => summary.releases(),
            About::Testee(_) => &[],
        };
        #[allow(clippy::cast_precision_loss, reason = "µs are exact for centuries")]
        let seconds = |time: u64| time as f64 / 1e6;
        subject.coverage.parts.iter().map(move |part| Self {
            capture: subject.path.clone(),
            topic: part.name.clone(),
            release: release_of(part, releases),
            records: part.records.total,
            checked_records: part.records.checked,
            checked_values: part.values.checked,
            rate: part.rate,
            first: part.first.map(seconds),
            last: part.last.map(seconds),
            is_checked: part.result.is_covered(),
            result: part.result.phrase(),
        })
    }

    /// The sort key: queries select topics by name.
    pub(super) fn key(&self) -> (&str, &str) {
        (&self.topic, &self.capture)
    }
}

/// The release that a topic was checked against.
fn release_of(part: &Part, releases: &[ReleaseMatch]) -> Option<String> {
    let is_undefined = matches!(part.result, PartResult::Undefined | PartResult::OwnSchema);
    let other = releases.iter().find_map(|release| release.other_of(&part.name));
    let main = || main_release(releases).filter(|_| !is_undefined);
    other.or_else(main).map(str::to_owned)
}
