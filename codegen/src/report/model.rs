//! A report, whatever its format.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt;

use crate::diagnostic::{Level, Problem, ProblemKind};
use crate::finding::Finding;
use crate::lint;
use crate::source::{Position, SourceMap, Span};

/// Where the project presents itself.
pub(super) const PROJECT_URL: &str = "https://uavspec.dev/";

/// The URL of the guide, to which page names such as `lint.html` are appended.
pub const GUIDE_URL: &str = "https://uavspec.dev/guide/";

/// The URL of the rule pages.
pub const RULES_URL: &str = "https://uavspec.dev/docs/rules/";

/// The page there on all that the readers report and that is no rule.
pub const READING_PAGE: &str = "reading";

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// What judged: `lint`, `breaking`, `check`.
    pub command: &'static str,
    /// All rules that were applied, by id.
    pub rules: Vec<RuleInfo>,
    /// What they found, in the order in which it is to be shown.
    pub entries: Vec<Entry>,
}

/// A rule, as far as a report tells it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RuleInfo {
    /// Its id.
    pub id: Cow<'static, str>,
    /// What it demands, in Markdown.
    pub purpose: Cow<'static, str>,
    /// How grave a breach is.
    pub level: Level,
    /// A page that says more; empty where there is none.
    pub url: String,
}

/// Something that a rule found.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The id of the rule.
    pub rule: Cow<'static, str>,
    /// Whom it breaks, where rules tell that.
    pub category: Option<&'static str>,
    /// How grave it is.
    pub level: Level,
    /// What is the matter.
    pub message: String,
    /// What to do about it, or what comes of it; may be empty.
    pub help: String,
    /// Where.
    pub place: Place,
    /// Which part of what stands there, where that has a name: a JSON pointer, or the path of a field. May be empty.
    pub part: String,
    /// What else is known of it, each under a name.
    pub facts: Vec<(&'static str, String)>,
    /// Where it was, and where it is, where two sets were compared.
    pub sides: Option<(Option<Place>, Option<Place>)>,
    /// Other places that have to do with it, each with a word on how.
    pub related: Vec<(Place, String)>,
    /// Whether it can be mended without a person.
    pub is_fixable: bool,
    /// A page that says more of its rule; empty where there is none.
    pub url: String,
}

/// A file, or a part of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file, with `/` on every system.
    pub path: String,
    /// Which part.
    pub region: Region,
}

/// A part of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Region {
    /// All of it.
    Whole,
    /// A range of characters.
    Text {
        /// The first character.
        start: Position,
        /// The position after the last character.
        end: Position,
    },
    /// A line, from 1.
    Line(u64),
    /// What starts at a byte, from 0; how long it is isn't known.
    Byte(u64),
}

impl Region {
    /// The line where it starts; none where lines mean nothing.
    pub fn line(self) -> Option<u64> {
        match self {
            Self::Text { start, .. } => Some(start.line as u64),
            Self::Line(line) => Some(line),
            Self::Whole | Self::Byte(_) => None,
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.path)?;
        match self.region {
            Region::Whole => Ok(()),
            Region::Text { start, .. } => write!(formatter, ":{}:{}", start.line, start.column),
            Region::Line(line) => write!(formatter, ":{line}"),
            Region::Byte(offset) => write!(formatter, ": byte {offset}"),
        }
    }
}

impl RuleInfo {
    /// Describes a rule that has a page in the documentation.
    pub fn new(id: &'static str, purpose: impl Into<Cow<'static, str>>, level: Level) -> Self {
        Self { id: id.into(), purpose: purpose.into(), level, url: rule_url(id) }
    }
}

/// A format of reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// A JSON list of findings.
    Json,
    /// Annotations of a workflow on GitHub.
    Github,
    /// SARIF 2.1.0, which code scanners exchange.
    Sarif,
    /// The results of tests, as `JUnit` writes them and CI systems show them.
    #[cfg(feature = "junit")]
    Junit,
}

impl Place {
    /// Of a span.
    pub fn of(span: Span, sources: &SourceMap) -> Self {
        let path = sources.path(sources.source_of(span)).to_owned();
        let end = Span { start: span.end, end: span.end };
        let region = Region::Text { start: sources.position(span), end: sources.position(end) };
        Self { path, region }
    }
}

impl Entry {
    /// Of a finding in definitions.
    pub fn of(finding: &Finding, sources: &SourceMap) -> Self {
        let place = |span: Span| Place::of(span, sources);
        Self {
            rule: finding.rule.into(),
            category: finding.category,
            level: finding.level,
            message: finding.message.clone(),
            help: finding.help.clone(),
            place: place(finding.span),
            sides: finding.sides.map(|sides| (sides.old.map(place), sides.new.map(place))),
            related: finding.related.iter().map(|(span, label)| (place(*span), label.clone())).collect(),
            part: String::new(),
            facts: Vec::new(),
            is_fixable: !finding.fix.is_empty(),
            url: rule_url(finding.rule),
        }
    }
}

/// The page of the documentation on a rule, or the place in one on an error of the readers.
pub fn rule_url(rule: &str) -> String {
    match reader_kind(rule) {
        Some(_) => format!("{RULES_URL}{READING_PAGE}.html#{rule}"),
        None => format!("{RULES_URL}{rule}.html"),
    }
}

/// What the readers report under this id, where it is no rule of `lint` too.
fn reader_kind(id: &str) -> Option<&'static ProblemKind> {
    let kind = Problem::KINDS.iter().find(|kind| kind.code == id)?;
    lint::rule(id).is_none().then_some(kind)
}

impl Report {
    /// The rules that were applied, and after them those that entries name beside: errors of the readers.
    pub(super) fn all_rules(&self) -> Vec<RuleInfo> {
        let mut rules = self.rules.clone();
        let mut known: BTreeSet<&str> = self.rules.iter().map(|rule| &*rule.id).collect();
        for entry in &self.entries {
            if known.insert(&entry.rule) {
                let purpose = reader_kind(&entry.rule).map_or("", |kind| kind.message);
                rules.push(RuleInfo {
                    id: entry.rule.clone(),
                    purpose: purpose.into(),
                    level: entry.level,
                    url: entry.url.clone(),
                });
            }
        }
        rules
    }
}
