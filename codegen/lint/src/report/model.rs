//! The format-independent report.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt;

use uavspec_schema::diagnostic::{Level, Problem, ProblemKind};
use uavspec_schema::finding::Finding;
use uavspec_schema::source::{Position, SourceMap, Span};

/// The address of the documentation site: `homepage` in the workspace's `Cargo.toml`. `None` if it is in the domain
/// `.invalid`, which RFC 6761 reserves: the site is then not published.
pub fn site_url() -> Option<&'static str> {
    let homepage = env!("CARGO_PKG_HOMEPAGE");
    (!homepage.ends_with(".invalid")).then_some(homepage)
}

/// The page for parser errors that are not rules.
pub const READING_PAGE: &str = "reading";

/// The result of a command.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// The command: `lint`, `breaking` or `check`.
    pub command: &'static str,
    /// The applied rules, by id.
    pub rules: Vec<RuleInfo>,
    /// The findings, in output order.
    pub entries: Vec<Entry>,
}

/// A rule in a report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RuleInfo {
    /// The id.
    pub id: Cow<'static, str>,
    /// The requirement, in Markdown.
    pub purpose: Cow<'static, str>,
    /// The severity of a violation.
    pub level: Level,
    /// The URL of its page; empty if there is none.
    pub url: String,
}

/// A finding.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The id of the rule.
    pub rule: Cow<'static, str>,
    /// The affected category, if any.
    pub category: Option<&'static str>,
    /// The severity.
    pub level: Level,
    /// The problem.
    pub message: String,
    /// The advice or the consequence; may be empty.
    pub help: String,
    /// The location.
    pub place: Place,
    /// The affected part of the item, as a JSON pointer or field path; may be empty.
    pub part: String,
    /// Further facts, each with a name.
    pub facts: Vec<(&'static str, String)>,
    /// The old and the new location, in a comparison.
    pub sides: Option<(Option<Place>, Option<Place>)>,
    /// Other relevant locations, each with a label.
    pub related: Vec<(Place, String)>,
    /// True if there is an automatic fix.
    pub is_fixable: bool,
    /// The URL of the rule's page; empty if there is none.
    pub url: String,
}

/// A file, or a part of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The path of the file, with `/` on every system.
    pub path: String,
    /// The part.
    pub region: Region,
}

/// A part of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Region {
    /// The whole file.
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
    /// Data of unknown length that starts at a byte offset.
    Byte(u64),
}

impl Region {
    /// The line where the region starts, or `None` for a region without lines.
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
    /// Creates an entry for a rule that has a page.
    pub fn new(id: &'static str, purpose: impl Into<Cow<'static, str>>, level: Level) -> Self {
        Self { id: id.into(), purpose: purpose.into(), level, url: rule_url(id) }
    }
}

/// A format of reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// A JSON list of findings.
    Json,
    /// GitHub workflow annotations.
    Github,
    /// SARIF 2.1.0, for code scanning.
    Sarif,
    /// The Code Quality format of GitLab.
    Codequality,
    /// `JUnit` XML, for CI systems.
    Junit,
}

impl Place {
    /// The location of a span.
    pub fn of(span: Span, sources: &SourceMap) -> Self {
        let path = sources.path(sources.source_of(span)).to_owned();
        let end = Span { start: span.end, end: span.end };
        let region = Region::Text { start: sources.position(span), end: sources.position(end) };
        Self { path, region }
    }
}

impl Entry {
    /// Converts a finding.
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

/// The path of a rule's page on the documentation site, or of the section about a parser error.
pub fn rule_page(rule: &str) -> String {
    match reader_kind(rule) {
        Some(_) => format!("docs/rules/{READING_PAGE}.html#{rule}"),
        None => format!("docs/rules/{rule}.html"),
    }
}

/// The URL of a rule's page; empty if the documentation site is not published.
pub fn rule_url(rule: &str) -> String {
    site_url().map_or_else(String::new, |site| format!("{site}/{}", rule_page(rule)))
}

/// The parser error with this id, unless it is also a rule of `lint`.
fn reader_kind(id: &str) -> Option<&'static ProblemKind> {
    let kind = Problem::KINDS.iter().find(|kind| kind.code == id)?;
    crate::rule(id).is_none().then_some(kind)
}

impl Report {
    /// The applied rules, followed by the parser errors that occurred.
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
