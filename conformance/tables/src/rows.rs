//! The rows of all tables, and their batches.

use arrow_array::RecordBatch;
use arrow_schema::ArrowError;
use uavspec_check::timeline::Timeline;
use uavspec_report::{Origin, Subject};

use super::captures::{self, CaptureRow};
use super::events::{self, EventRow};
use super::findings::{self, FindingRow};
use super::rules::{self, RuleRow};
use super::timeline::{self, TimelineRow};
use super::topics::{self, TopicRow};

/// The names of the tables, in the order in which they are written.
pub(super) const TABLES: [&str; 6] = [
    timeline::TABLE.name,
    events::TABLE.name,
    topics::TABLE.name,
    findings::TABLE.name,
    rules::TABLE.name,
    captures::TABLE.name,
];

/// The length of event texts that counts as an additional row, in bytes.
const ROW_TEXTS: usize = 1 << 10;

/// True if a table exists only in a run with timelines.
pub(super) fn is_of_timeline(table: &str) -> bool {
    [timeline::TABLE.name, events::TABLE.name].contains(&table)
}

/// The rows of some captures, by table.
#[derive(Default)]
pub(super) struct Rows {
    timeline: Vec<TimelineRow>,
    events: Vec<EventRow>,
    topics: Vec<TopicRow>,
    findings: Vec<FindingRow>,
    rules: Vec<RuleRow>,
    captures: Vec<CaptureRow>,
}

impl Rows {
    pub(super) fn num_captures(&self) -> usize {
        self.captures.len()
    }

    /// The number of rows. Long event texts count as additional rows.
    pub(super) fn num_rows(&self) -> usize {
        self.timeline.len()
            + self.events.iter().map(|row| 1 + row.size() / ROW_TEXTS).sum::<usize>()
            + self.topics.len()
            + self.findings.len()
            + self.rules.len()
            + self.captures.len()
    }

    /// Adds the rows of a capture.
    pub(super) fn add(&mut self, subject: &Subject, origin: Origin, timeline: Option<&Timeline>) {
        self.timeline.extend(timeline.into_iter().flat_map(TimelineRow::of));
        self.events.extend(timeline.into_iter().flat_map(EventRow::of));
        self.topics.extend(TopicRow::of(subject));
        self.findings.extend(FindingRow::of(subject));
        self.rules.extend(RuleRow::of(subject));
        self.captures.push(CaptureRow::of(subject, origin));
    }

    /// Sorts each table by the columns that queries use to select rows.
    pub(super) fn sort(&mut self) {
        // The sort is stable, so the changes in a capture remain in chronological order.
        self.timeline.sort_by(|one, other| one.key().cmp(&other.key()));
        self.events.sort_by(|one, other| one.key().cmp(&other.key()));
        self.topics.sort_by(|one, other| one.key().cmp(&other.key()));
        self.findings.sort_by(|one, other| one.key().cmp(&other.key()));
        self.rules.sort_by(|one, other| one.key().cmp(&other.key()));
    }

    /// The batches of the tables, in the order of [`TABLES`].
    pub(super) fn batches(&self) -> Result<[RecordBatch; TABLES.len()], ArrowError> {
        Ok([
            timeline::TABLE.batch(&self.timeline)?,
            events::TABLE.batch(&self.events)?,
            topics::TABLE.batch(&self.topics)?,
            findings::TABLE.batch(&self.findings)?,
            rules::TABLE.batch(&self.rules)?,
            captures::TABLE.batch(&self.captures)?,
        ])
    }
}
