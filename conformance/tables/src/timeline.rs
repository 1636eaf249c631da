//! The changes in the timeline of a capture.

use uavspec_check::timeline::{Change, Lane, LaneKind, Part, Severity, Timeline};

use super::column::{Column, Table};

pub(super) static TABLE: Table<TimelineRow> = Table {
    name: "timeline",
    description: "A change of a failsafe flag, an error code, a mode or another state of the vehicle, or an event. Only \
                  with `--timeline`. `uavspec explain` shows the changes in one capture.",
    columns: &[
        Column::text("name", "The field or the error code.", |row| Some(&row.name)),
        Column::text("capture", "The path or URL.", |row| Some(&row.capture)),
        Column::number(
            "time",
            "The time since the start of the capture; negative for messages from before the start.",
            |row: &TimelineRow| Some(row.time),
        )
        .in_unit("s"),
        Column::time("utc", "The time in UTC, if the capture contains it.", |row: &TimelineRow| row.utc),
        Column::text("topic", "The topic or type of the message.", |row| Some(&row.topic)),
        Column::text(
            "subject",
            "The instance, component, UAV or connection, if there can be several.",
            |row| row.subject.as_deref(),
        ),
        Column::text("kind", "The kind: `flag`, `state`, `check` or `event`.", |row| Some(row.kind)),
        Column::text(
            "value",
            "The new value: `set` or `cleared` for a flag, the names of the value for other fields.",
            |row| Some(&row.value),
        ),
        Column::text("label", "The meaning of the flag or of the value, in English.", |row| {
            row.label.as_deref()
        }),
        Column::text("severity", "The severity: `normal`, `info`, `warning` or `error`.", |row| {
            Some(row.severity)
        }),
        Column::flag(
            "is_first",
            "True for the first known value, which may be older than the capture.",
            |row| Some(row.is_first),
        ),
    ],
};

/// A change.
#[derive(Debug)]
pub(super) struct TimelineRow {
    name: String,
    capture: String,
    time: f64,
    utc: Option<u64>,
    topic: String,
    subject: Option<String>,
    kind: &'static str,
    value: String,
    label: Option<String>,
    severity: &'static str,
    is_first: bool,
}

impl TimelineRow {
    pub(super) fn of(timeline: &Timeline) -> impl Iterator<Item = Self> {
        let changes = timeline.lanes.iter().flat_map(|lane| lane.listed().map(move |change| (lane, change)));
        changes.filter_map(|(lane, change)| Self::new(timeline, lane, *change))
    }

    fn new(timeline: &Timeline, lane: &Lane, change: Change) -> Option<Self> {
        let value = lane.values.get(change.value)?;
        let (kind, labels) = match lane.kind {
            LaneKind::Flag => ("flag", lane.label.iter().collect()),
            LaneKind::State => ("state", labels(&value.parts)),
            LaneKind::Event => ("event", labels(&value.parts)),
            LaneKind::Check => ("check", labels(&value.parts)),
        };
        let texts: Vec<&str> = labels.into_iter().map(|label| label.text.as_str()).collect();
        let names: Vec<&str> = value.parts.iter().map(|part| part.name.as_str()).collect();
        #[allow(clippy::cast_precision_loss, reason = "µs are exact for centuries")]
        let time = change.time_us as f64 / 1e6;
        Some(Self {
            name: lane.name.clone(),
            capture: timeline.capture.clone(),
            time,
            utc: timeline.utc_micros(change.time_us),
            topic: lane.topic.clone(),
            subject: lane.subject.clone(),
            kind,
            value: names.join(", "),
            label: (!texts.is_empty()).then(|| texts.join(", ")),
            severity: match value.severity {
                Severity::Normal => "normal",
                Severity::Info => "info",
                Severity::Warning => "warning",
                Severity::Error => "error",
            },
            is_first: change.is_first,
        })
    }

    /// The sort key: queries select flags and states by name.
    pub(super) fn key(&self) -> (&str, &str) {
        (&self.name, &self.capture)
    }
}

fn labels(parts: &[Part]) -> Vec<&uavspec_check::timeline::Label> {
    parts.iter().filter_map(|part| part.label.as_ref()).collect()
}
