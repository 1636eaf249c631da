//! The events that PX4 sent.

use serde_json::{Map, Value};
use uavspec_check::timeline::{SentEvent, Timeline, full_name};
use uavspec_dynamic::event::{DecodedEvent, EventValue};
use uavspec_runtime::event::{LogLevel, Profile};

use super::column::{Column, Table};

/// The maximum total length of the texts of a capture's events, in bytes. Real events take a few hundred bytes each.
const MAX_TEXTS: usize = 16 << 20;

pub(super) static TABLE: Table<EventRow> = Table {
    name: "events",
    description: "An event that PX4 sent on the topic `event`. The texts come from the event metadata, and are empty if \
                  it doesn't define the event. Only with `--timeline`. A capture yields at most 100,000 rows, with \
                  at most 16 MiB of text.",
    columns: &[
        Column::text("name", "The name, such as `px4::commander_armed_by`.", |row| row.name.as_deref()),
        Column::text("capture", "The path or URL.", |row| Some(&row.capture)),
        Column::number(
            "time",
            "The time since the start of the capture; negative for events from before the start.",
            |row: &EventRow| Some(row.time),
        )
        .in_unit("s"),
        Column::time("utc", "The time in UTC, if the capture contains it.", |row: &EventRow| row.utc),
        Column::text("subject", "The instance or the topic, if there are several.", |row| {
            row.subject.as_deref()
        }),
        Column::count(
            "sequence",
            "The number of the event, which increases by one with each event.",
            |row| row.sequence,
        ),
        Column::count("id", "The id. Its highest byte is the component.", |row| Some(row.id)),
        Column::text("event_group", "The group, such as `arming_check`, `health` or `default`.", |row| {
            row.group.as_deref()
        }),
        Column::text("level", "The level for ground stations, such as `error` or `info`.", |row| row.level),
        Column::text("log_level", "The level for logs.", |row| row.log_level),
        Column::text("message", "The message.", |row| row.message.as_deref()),
        Column::text("description", "The description.", |row| row.description.as_deref()),
        Column::text("arguments", "The arguments as a JSON object: numbers by name.", |row| {
            row.arguments.as_deref()
        }),
        Column::text(
            "event_metadata",
            "The source of the event metadata: the capture, a file, or the built-in events.",
            |row| row.event_metadata.as_deref(),
        ),
    ],
};

/// An event.
#[derive(Debug)]
pub(super) struct EventRow {
    name: Option<String>,
    capture: String,
    time: f64,
    utc: Option<u64>,
    subject: Option<String>,
    sequence: Option<u64>,
    id: u64,
    group: Option<String>,
    level: Option<&'static str>,
    log_level: Option<&'static str>,
    message: Option<String>,
    description: Option<String>,
    arguments: Option<String>,
    event_metadata: Option<String>,
}

impl EventRow {
    pub(super) fn of(timeline: &Timeline) -> impl Iterator<Item = Self> {
        let mut room = MAX_TEXTS;
        let rows = timeline.events.iter().map(|event| Self::new(timeline, event));
        rows.map_while(move |row| {
            room = room.checked_sub(row.size())?;
            Some(row)
        })
    }

    fn new(timeline: &Timeline, SentEvent { time_us, subject, event }: &SentEvent) -> Self {
        let decoded = event.decode(timeline.metadata.events()).ok();
        let text = |text: fn(&DecodedEvent<'_>) -> String| decoded.as_ref().map(text);
        #[allow(clippy::cast_precision_loss, reason = "µs are exact for centuries")]
        let time = *time_us as f64 / 1e6;
        Self {
            name: text(full_name),
            capture: timeline.capture.clone(),
            time,
            utc: timeline.utc_micros(*time_us),
            subject: subject.as_deref().map(str::to_owned),
            sequence: event.sequence.map(u64::from),
            id: event.id.into(),
            group: text(|event| event.event.group.clone()),
            level: LogLevel::external(event.levels).map(LogLevel::name),
            log_level: LogLevel::internal(event.levels).map(LogLevel::name),
            message: text(|event| event.message(Profile::Normal)),
            description: text(|event| event.description(Profile::Normal)).filter(|text| !text.is_empty()),
            arguments: text(arguments),
            event_metadata: timeline.event_metadata.clone(),
        }
    }

    /// The sort key: queries select events by name.
    pub(super) fn key(&self) -> (Option<&str>, &str) {
        (self.name.as_deref(), &self.capture)
    }

    /// The length of the texts, in bytes.
    pub(super) fn size(&self) -> usize {
        let texts = [&self.name, &self.group, &self.message, &self.description, &self.arguments];
        texts.into_iter().flatten().map(String::len).sum()
    }
}

/// The arguments as JSON.
fn arguments(event: &DecodedEvent<'_>) -> String {
    let values = event.event.arguments.iter().zip(&event.values).map(|(argument, value)| {
        let value = match *value {
            EventValue::Integer(value) => serde_json::Number::from_i128(value).into(),
            // The shortest digits that denote the same value.
            EventValue::Float(value) => value.to_string().parse::<f64>().ok().into(),
        };
        (argument.name.clone(), value)
    });
    Value::Object(values.collect::<Map<_, _>>()).to_string()
}
