//! The extent to which the records of a capture were checked, in total and for each topic or type.
//!
//! A value is one field of one record. An array or a nested message counts as one value.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;
use uavspec_model::text::{plural, shown, thousands};
use uavspec_px4::comparison::Comparison;

use super::Line;
use crate::limits::MAX_PARTS;

/// The extent to which a capture, a session or a testee was checked.
#[derive(Clone, Debug, Default, Serialize, schemars::JsonSchema)]
pub struct Coverage {
    /// The things that are counted: topics or types.
    pub unit: Unit,
    /// The number of topics or types that were fully checked. For a testee, types with at least one checked case.
    /// Topics and types without records don't count.
    pub units: Share,
    /// The number of records that were checked, at least in part. For a testee, the number of cases.
    pub records: Share,
    /// The number of values that were checked. The total is unknown if some records can't be decoded.
    pub values: Share,
    /// The topics or types, by name.
    pub parts: Vec<Part>,
    /// The number of topics or types that aren't listed. They weren't checked.
    pub more_parts: u64,
    /// The number of declared topics without records.
    pub empty: u64,
}

/// The unit of coverage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Unit {
    /// The topics of a log or bag.
    #[default]
    Topic,
    /// The types of JSON messages, of a session or of a testee.
    Type,
}

/// A number of things that were checked, and the number of all such things.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct Share {
    /// The number of things that were checked.
    pub checked: u64,
    /// The number of all things, if known.
    pub total: Option<u64>,
}

/// A topic or type with its coverage.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
#[schemars(rename = "CoveragePart")]
pub struct Part {
    /// The name of the topic or type.
    pub name: String,
    /// The result.
    pub result: PartResult,
    /// The number of records.
    pub records: Share,
    /// The number of values.
    pub values: Share,
    /// The time of the first record, in µs; `null` if unknown. The time is counted from boot if the timestamps are.
    #[serde(rename = "first_us")]
    pub first: Option<u64>,
    /// The time of the last record, in µs.
    #[serde(rename = "last_us")]
    pub last: Option<u64>,
    /// The mean number of records per second, with three decimals, if there are at least two times.
    #[serde(rename = "rate_hz")]
    pub rate: Option<f64>,
    /// The number of records with a time.
    #[serde(skip)]
    timed: u64,
}

/// The reason why a topic or type was fully checked, or why it was not. A later value takes precedence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum PartResult {
    /// All records were checked against the definition.
    Checked,
    /// There is no definition. All records were checked against the schema in the capture.
    #[serde(rename = "own schema")]
    OwnSchema,
    /// The format differs from the definition. Only the fields that match were checked.
    #[serde(rename = "different format")]
    Different,
    /// Some records can't be decoded.
    Undecodable,
    /// The type was only known once a JSON message had keys. The messages before it weren't checked.
    #[serde(rename = "messages without keys")]
    Keyless,
    /// The encoding isn't supported, or the definition can't be used with it.
    #[serde(rename = "unsupported encoding")]
    Unsupported,
    /// The capture has too many fields. The records weren't checked.
    #[serde(rename = "too many fields")]
    TooMany,
    /// There is no definition.
    #[serde(rename = "no definition")]
    Undefined,
}

/// Counts the records of a topic or type.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    /// All records.
    pub(super) records: u64,
    /// The records that were decoded.
    pub(super) decoded: u64,
    /// The records whose values were checked.
    pub(super) checked: u64,
    first: Option<u64>,
    last: u64,
    timed: u64,
}

/// The topics or types of a capture.
#[derive(Debug, Default)]
pub(super) struct Parts {
    by_name: BTreeMap<String, Part>,
    more: u64,
    /// The names without records.
    empty: BTreeSet<String>,
}

impl Share {
    /// A share of a known total.
    pub fn of(checked: u64, total: u64) -> Self {
        Self { checked, total: Some(total) }
    }

    /// The share of values for `records` records, of which `checked` were checked. Each record has the same number of
    /// values.
    pub(super) fn times(self, checked: u64, records: u64) -> Self {
        Self { checked: self.checked * checked, total: self.total.map(|total| total * records) }
    }

    fn add(&mut self, other: Self) {
        self.checked += other.checked;
        self.total = self.total.zip(other.total).map(|(total, other)| total + other);
    }

    /// True if everything was checked.
    pub(crate) fn is_full(self) -> bool {
        self.total == Some(self.checked)
    }

    /// The checked percentage, rounded down; 100 if the total is 0.
    pub fn percent(self) -> u64 {
        match self.total {
            Some(0) => 100,
            Some(total) => (u128::from(self.checked) * 100 / u128::from(total)).try_into().unwrap_or(100),
            None => 0,
        }
    }

    /// True if at least this percentage was checked.
    pub fn reaches(self, percent: f64) -> bool {
        #[allow(clippy::cast_precision_loss)] // counts are small enough
        self.total.is_none_or(|total| self.checked as f64 * 100.0 >= total as f64 * percent)
    }

    /// The numbers with a noun, such as `3 of 41 topics`.
    pub fn text(self, noun: &str) -> String {
        match self.total {
            Some(total) => format!("{} of {}", thousands(self.checked), plural(total, noun)),
            None => plural(self.checked, noun),
        }
    }
}

impl Unit {
    /// The noun.
    pub const fn noun(self) -> &'static str {
        match self {
            Self::Topic => "topic",
            Self::Type => "type",
        }
    }
}

impl PartResult {
    const UNCHECKED: [Self; 6] = [
        Self::Undefined,
        Self::Different,
        Self::Keyless,
        Self::Unsupported,
        Self::TooMany,
        Self::Undecodable,
    ];

    /// True if all records were checked, against a definition or their own schema.
    pub fn is_covered(self) -> bool {
        matches!(self, Self::Checked | Self::OwnSchema)
    }

    /// The result as a phrase that describes a topic or type.
    pub const fn phrase(self) -> &'static str {
        match self {
            Self::Checked => "fully checked",
            Self::OwnSchema => "checked against its own schema",
            Self::Different => "with a different format (partly checked)",
            Self::Undecodable => "with undecodable records",
            Self::Keyless => "with empty messages (partly checked)",
            Self::Unsupported => "in an unsupported encoding",
            Self::TooMany => "with too many fields",
            Self::Undefined => "without a definition",
        }
    }
}

impl From<&Comparison> for PartResult {
    fn from(comparison: &Comparison) -> Self {
        match comparison {
            Comparison::Equal => Self::Checked,
            Comparison::Differs(_) => Self::Different,
            Comparison::Undefined => Self::Undefined,
        }
    }
}

impl Tally {
    /// A tally for records that weren't decoded.
    pub(super) fn of(records: u64) -> Self {
        Self { records, ..Self::default() }
    }

    /// Counts a decoded record, and its time in µs.
    #[inline]
    pub(super) fn count(&mut self, is_checked: bool, time: Option<u64>) {
        self.decoded += 1;
        self.checked += u64::from(is_checked);
        self.time(time);
    }

    /// Counts a time in µs. A time of 0 is unknown.
    #[inline]
    pub(super) fn time(&mut self, time: Option<u64>) {
        if let Some(time) = time.filter(|time| *time > 0) {
            self.first = Some(self.first.map_or(time, |first| first.min(time)));
            self.last = self.last.max(time);
            self.timed += 1;
        }
    }

    /// The first and the last time, in µs.
    pub(super) fn span(&self) -> impl Iterator<Item = u64> + use<> {
        let last = self.last;
        self.first.into_iter().flat_map(move |first| [first, last])
    }

    /// The mean number of records per second, with three decimals.
    pub(super) fn rate(&self) -> Option<f64> {
        rate(self.first, self.last, self.timed)
    }
}

impl Parts {
    /// Adds the records of a topic or type. Channels with the same name share a part.
    pub(super) fn add(&mut self, name: &str, result: PartResult, tally: Tally, values: Share) {
        if tally.records == 0 {
            if self.empty.len() < MAX_PARTS && !name.is_empty() {
                self.empty.insert(name.to_owned());
            }
            return;
        }
        let last = tally.first.map(|_| tally.last);
        let part = Part {
            name: name.to_owned(),
            result,
            records: Share::of(tally.checked, tally.records),
            values,
            first: tally.first,
            last,
            rate: None,
            timed: tally.timed,
        };
        let is_full = name.is_empty() || self.by_name.len() >= MAX_PARTS;
        match self.by_name.entry(name.to_owned()) {
            Entry::Occupied(known) => known.into_mut().merge(&part),
            Entry::Vacant(_) if is_full => self.more += 1,
            Entry::Vacant(new) => _ = new.insert(part),
        }
    }

    /// Adds a result to the part with this name, if it exists.
    pub(super) fn add_result(&mut self, name: &str, result: PartResult) {
        if let Some(part) = self.by_name.get_mut(name) {
            part.result = part.result.max(result);
        }
    }

    /// The coverage of a capture with this many records.
    pub(super) fn finish(self, unit: Unit, records: u64) -> Coverage {
        let empty = self.empty.iter().filter(|name| !self.by_name.contains_key(*name)).count() as u64;
        let mut parts: Vec<Part> = self.by_name.into_values().collect();
        parts.iter_mut().for_each(Part::finish);
        let covered = parts.iter().filter(|part| part.result.is_covered()).count() as u64;
        let mut values = Share::of(0, 0);
        for part in &parts {
            values.add(part.values);
        }
        if self.more > 0 {
            values.total = None;
        }
        Coverage {
            unit,
            units: Share::of(covered, parts.len() as u64 + self.more),
            records: Share::of(parts.iter().map(|part| part.records.checked).sum(), records),
            values,
            parts,
            more_parts: self.more,
            empty,
        }
    }
}

impl Part {
    fn merge(&mut self, other: &Self) {
        self.result = self.result.max(other.result);
        self.records.add(other.records);
        self.values.add(other.values);
        self.first = self.first.into_iter().chain(other.first).min();
        self.last = self.last.max(other.last);
        self.timed += other.timed;
    }

    fn finish(&mut self) {
        // If some records of a decodable type were skipped, they can't be decoded.
        if self.result < PartResult::Undecodable && !self.records.is_full() {
            self.result = PartResult::Undecodable;
        }
        self.rate = rate(self.first, self.last.unwrap_or_default(), self.timed);
    }

    fn text(&self) -> String {
        let rate = self.rate.map(|rate| format!(", {rate:.1} Hz")).unwrap_or_default();
        let (name, records) = (shown(&self.name), plural(self.records.total.unwrap_or_default(), "record"));
        format!("{name}: {}, {records}{rate}", self.result.phrase())
    }
}

/// The mean number of records per second, with three decimals.
#[allow(clippy::cast_precision_loss)] // a rate needs no more than 15 digits
fn rate(first: Option<u64>, last: u64, timed: u64) -> Option<f64> {
    let time = last.checked_sub(first?).filter(|time| *time > 0)?;
    Some(((timed - 1) as f64 * 1e9 / time as f64).round() / 1e3)
}

impl Coverage {
    /// True if all topics or types were fully checked.
    pub fn is_full(&self) -> bool {
        self.units.is_full()
    }

    /// True if nothing was checked: no value, no topic and no type. Messages without fields have no values, but count.
    pub fn is_empty(&self) -> bool {
        self.values.checked == 0 && self.units.checked == 0
    }

    /// The number of topics or types with this result.
    fn count(&self, result: PartResult) -> u64 {
        self.parts.iter().filter(|part| part.result == result).count() as u64
    }

    /// The number of topics or types with undecodable records.
    pub fn undecodable(&self) -> u64 {
        self.count(PartResult::Undecodable)
    }

    /// The number of topics that were checked against their own schema, with the noun; `None` if there are none.
    pub fn own_schema(&self) -> Option<String> {
        let count = self.count(PartResult::OwnSchema);
        (count > 0).then(|| plural(count, self.unit.noun()))
    }

    /// The checked topics, records and values, on one line. `noun` is the word for records.
    fn checked(&self, noun: &str) -> String {
        let mut parts = vec![format!("{} ({} %)", self.units.text(self.unit.noun()), self.units.percent())];
        parts.push(self.records.text(noun));
        if self.values.checked > 0 || self.values.total > Some(0) {
            parts.push(self.values.text("value"));
        }
        parts.join(", ")
    }

    /// The numbers of topics or types that weren't fully checked, by reason; `None` if there are none.
    pub fn unchecked(&self) -> Option<String> {
        let mut noun = Some(self.unit.noun());
        let mut reasons: Vec<String> = Vec::new();
        let mut add = |count: u64, phrase: &str| {
            if count > 0 {
                let number = noun.take().map_or_else(|| thousands(count), |noun| plural(count, noun));
                reasons.push(format!("{number} {phrase}"));
            }
        };
        for result in PartResult::UNCHECKED {
            add(self.count(result), result.phrase());
        }
        add(self.more_parts, "not listed");
        (!reasons.is_empty()).then(|| reasons.join(", "))
    }

    /// The lines of reports for people. `noun` is the word for records. The details list the topics or types that weren't
    /// fully checked.
    pub fn lines(&self, noun: &str) -> Vec<Line> {
        if self.units.total == Some(0) {
            return Vec::new();
        }
        let mut lines = vec![Line::new("checked", self.checked(noun))];
        if let Some(text) = self.unchecked() {
            let unchecked = self.parts.iter().filter(|part| !part.result.is_covered());
            let details = unchecked.map(Part::text).collect();
            lines.push(Line { details, ..Line::new("not checked", text) });
        }
        if let Some(topics) = self.own_schema() {
            lines.push(Line::new("own schema", format!("{topics} checked against the schema in the file")));
        }
        if self.empty > 0 {
            lines.push(Line::new("no records", plural(self.empty, self.unit.noun())));
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::{MAX_PARTS, PartResult, Parts, Share, Tally, Unit};

    /// Counts checked records with these times, in s.
    fn tally(seconds: &[u64]) -> Tally {
        let mut tally = Tally::default();
        for second in seconds {
            tally.records += 1;
            tally.count(true, Some(second * 1_000_000));
        }
        tally
    }

    fn added(all: &[(&str, Tally)]) -> Parts {
        let mut parts = Parts::default();
        for (name, tally) in all {
            let values = Share::of(2, 3).times(tally.checked, tally.records);
            parts.add(name, PartResult::Checked, *tally, values);
        }
        parts
    }

    #[test]
    fn parts_of_the_same_name_are_one() {
        let all = [
            ("kite", tally(&[4, 5, 6])),
            ("kite", tally(&[1])),
            ("owl", tally(&[])),
            ("owl", tally(&[7])),
            ("gull", tally(&[])),
        ];
        let coverage = added(&all).finish(Unit::Topic, 9);
        let text = |share: Share| share.text("value");
        let total = [coverage.units, coverage.records, coverage.values].map(text);
        assert_eq!(total, ["2 of 2 values", "5 of 9 values", "10 of 15 values"]);
        assert_eq!((coverage.more_parts, coverage.empty), (0, 1));
        let parts: Vec<_> = coverage
            .parts
            .iter()
            .map(|part| (part.name.as_str(), text(part.records), part.first, part.last, part.rate))
            .collect();
        let kite = ("kite", "4 of 4 values".to_owned(), Some(1_000_000), Some(6_000_000), Some(0.6));
        assert_eq!(parts, [kite, ("owl", "1 of 1 value".to_owned(), Some(7_000_000), Some(7_000_000), None)]);
    }

    #[test]
    fn unknown_times_do_not_count() {
        let mut tally = tally(&[3, 0, 4]);
        tally.records += 1;
        tally.count(true, None);
        let coverage = added(&[("kite", tally)]).finish(Unit::Topic, 4);
        let part = &coverage.parts[0];
        assert_eq!((part.first, part.last, part.rate), (Some(3_000_000), Some(4_000_000), Some(1.0)));
        assert!(coverage.is_full() && !coverage.is_empty());
    }

    #[test]
    fn messages_without_fields_are_checked() {
        let coverage_of = |result, tally, values| {
            let mut parts = Parts::default();
            parts.add("kite", result, tally, values);
            parts.finish(Unit::Topic, 1)
        };
        let coverage = coverage_of(PartResult::Checked, tally(&[1]), Share::of(0, 0));
        assert!(coverage.is_full() && !coverage.is_empty());
        let coverage = coverage_of(PartResult::Undefined, Tally::of(1), Share::of(0, 3));
        assert!(!coverage.is_full() && coverage.is_empty());
    }

    #[test]
    fn parts_beyond_the_limit_are_counted() {
        let mut parts = Parts::default();
        for name in 0..MAX_PARTS + 2 {
            parts.add(&name.to_string(), PartResult::Checked, Tally::of(0), Share::of(0, 0));
            parts.add(&name.to_string(), PartResult::Checked, tally(&[1]), Share::of(1, 1));
        }
        parts.add("", PartResult::Checked, tally(&[1]), Share::of(1, 1));
        parts.add("", PartResult::Checked, Tally::of(0), Share::of(0, 0));
        for name in 0..MAX_PARTS + 2 {
            parts.add(&format!("empty {name}"), PartResult::Checked, Tally::of(0), Share::of(0, 0));
        }
        let coverage = parts.finish(Unit::Type, 10_003);
        assert_eq!((coverage.parts.len(), coverage.more_parts, coverage.empty), (MAX_PARTS, 3, 0));
        assert_eq!(coverage.units.text("type"), "10,000 of 10,003 types");
        assert_eq!(coverage.unchecked().as_deref(), Some("3 types not listed"));
        assert_eq!(coverage.values.total, None);
    }

    /// The label and text of each line, followed by its details.
    fn lines(coverage: &super::Coverage) -> Vec<String> {
        let text = |line: &crate::Line| format!("{}: {}", line.label, line.text);
        coverage
            .lines("record")
            .iter()
            .flat_map(|line| [vec![text(line)], line.details.clone()].concat())
            .collect()
    }

    #[test]
    fn lines_name_the_parts_that_were_not_fully_checked() {
        let mut parts = Parts::default();
        let mut undecodable = tally(&[1, 3]);
        undecodable.records += 1;
        for (name, result, tally) in [
            ("kite", PartResult::Checked, tally(&[1, 2, 3])),
            ("owl", PartResult::Checked, undecodable),
            ("gull", PartResult::OwnSchema, tally(&[5])),
            ("duck", PartResult::Different, tally(&[4, 4])),
            ("wren", PartResult::Undefined, Tally::of(1)),
            ("stork", PartResult::Checked, Tally::of(0)),
        ] {
            parts.add(name, result, tally, Share::of(1, 2));
        }
        let coverage = parts.finish(Unit::Topic, 10);
        assert_eq!(
            lines(&coverage),
            [
                "checked: 2 of 5 topics (40 %), 8 of 10 records, 5 of 10 values",
                "not checked: 1 topic without a definition, 1 with a different format (partly checked), \
                 1 with undecodable records",
                "duck: with a different format (partly checked), 2 records",
                "owl: with undecodable records, 3 records, 0.5 Hz",
                "wren: without a definition, 1 record",
                "own schema: 1 topic checked against the schema in the file",
                "no records: 1 topic",
            ]
        );
        assert_eq!(coverage.undecodable(), 1);
        assert_eq!(lines(&Parts::default().finish(Unit::Topic, 0)), [""; 0]);
    }

    #[test]
    fn lines_count_values_if_there_are_any() {
        for (checked, total, expected) in [
            (0, Some(0), ""),
            (0, None, ""),
            (0, Some(5), ", 0 of 5 values"),
            (3, None, ", 3 values"),
            (3, Some(3), ", 3 of 3 values"),
        ] {
            let (units, values) = (Share::of(2, 2), Share { checked, total });
            let coverage =
                super::Coverage { unit: Unit::Type, units, records: units, values, ..Default::default() };
            assert_eq!(
                lines(&coverage),
                [format!("checked: 2 of 2 types (100 %), 2 of 2 records{expected}")]
            );
        }
    }
}
