//! The findings.

use uavspec_report::{Example, Finding, Subject};

use super::column::{Column, Table};

pub(super) static TABLE: Table<FindingRow> = Table {
    name: "findings",
    description: "The findings of a rule in a topic or field of a capture. Apart from the count, a row describes the \
                  first finding.",
    columns: &[
        Column::text("rule", "The id of the rule.", |row| Some(row.rule)),
        Column::text("capture", "The path or URL.", |row| Some(&row.capture)),
        Column::text("level", "The level of the rule: `MUST`, `SHOULD` or `INFO`.", |row| Some(row.level)),
        Column::text("verdict", "The verdict: `fail`, `warning`, `known` or `info`.", |row| {
            Some(row.verdict)
        }),
        Column::text("field", "The topic or field that violates the rule.", |row| Some(&row.field)),
        Column::count("count", "The number of findings.", |row| Some(row.count)),
        Column::text("message", "The description.", |row| row.message.as_deref()),
        Column::text("expected", "The expected value.", |row| row.expected.as_deref()),
        Column::text("actual", "The actual value.", |row| row.actual.as_deref()),
        Column::text("location", "The location in the file, such as `byte 4096` or `message 7`.", |row| {
            row.location.as_deref()
        }),
        Column::text("path", "The location in the record.", |row| row.path.as_deref()),
        Column::number("time", "The time since the start of the capture.", |row: &FindingRow| row.time)
            .in_unit("s"),
        Column::time("utc", "The time in UTC, if the capture contains it.", |row| row.utc),
        Column::text("definition", "The file and line of the definition.", |row| row.definition.as_deref()),
        Column::text("known", "The reason in a baseline.", |row| row.known.as_deref()),
    ],
};

/// The findings of a rule in a topic or field.
#[derive(Debug)]
pub(super) struct FindingRow {
    rule: &'static str,
    capture: String,
    level: &'static str,
    verdict: &'static str,
    field: String,
    count: u64,
    message: Option<String>,
    expected: Option<String>,
    actual: Option<String>,
    location: Option<String>,
    path: Option<String>,
    time: Option<f64>,
    utc: Option<u64>,
    definition: Option<String>,
    known: Option<String>,
}

impl FindingRow {
    pub(super) fn of(subject: &Subject) -> impl Iterator<Item = Self> {
        subject.findings.iter().map(|finding| Self::new(&subject.path, finding))
    }

    fn new(capture: &str, finding: &Finding) -> Self {
        let example = finding.examples.first();
        let text =
            |value: fn(&Example) -> &String| example.map(value).filter(|text| !text.is_empty()).cloned();
        Self {
            rule: finding.rule,
            capture: capture.to_owned(),
            level: finding.level.name(),
            verdict: finding.verdict.name(),
            field: finding.subject.clone(),
            count: finding.count,
            message: text(|example| &example.message),
            expected: text(|example| &example.expected),
            actual: text(|example| &example.actual),
            location: example.map(|example| example.location.to_string()),
            path: text(|example| &example.path),
            time: example.and_then(|example| example.time_s),
            utc: example.and_then(|example| example.utc_us),
            definition: finding.definition.as_ref().map(ToString::to_string),
            known: finding.known.as_ref().map(|known| known.reason.clone()),
        }
    }

    /// The sort key: queries select findings by rule.
    pub(super) fn key(&self) -> (&str, &str, &str) {
        (self.rule, &self.field, &self.capture)
    }
}
