//! The report of a comparison.

use std::fmt::Write as _;

use schemars::JsonSchema;
use serde::Serialize;
use uavspec_lint::report::{Entry, Format, Report, RuleInfo};
use uavspec_model::text::{plural, shown, wrapped};
use uavspec_rules::definitions::versioned;
use uavspec_schema::diagnostic::Level;
use uavspec_schema::finding::Finding;
use uavspec_schema::json_text;
use uavspec_schema::source::SourceMap;
use uavspec_schema::span::Span;

use crate::application::{Application, Use};
use crate::source::Version;
use crate::verdict::{Kind, Side, Verdict};

/// The version of the JSON form.
const VERSION: u32 = 1;

/// The version that the application appends to the name of a topic.
const APPENDED: &str = "{version}";

/// The id of unread parts in a SARIF report.
const UNREAD: &str = "compat-unread";

/// The note for versions of PX4 whose DDS topics are unknown.
const UNKNOWN_DDS: &str = "Not checked: which topics PX4 offers over DDS. `--dds-topics FILE` names them.";

/// The help for topics that can't be read.
const HINTS: &str = "list these topics in a file, and pass it with `--hints FILE`";

/// A comparison of an application with versions of PX4.
#[derive(Debug, Serialize, JsonSchema)]
pub struct CompatReport {
    /// The version of this format.
    pub version: u32,
    /// The version of the program.
    pub uavspec: String,
    /// The path of the application.
    pub application: String,
    /// The definitions with which the application is built.
    pub definitions: String,
    /// The number of source files.
    pub files: usize,
    /// The versions of PX4.
    pub px4: Vec<String>,
    /// True if the topics that PX4 offers over DDS are known for all versions.
    pub knows_dds: bool,
    /// The topics of the application.
    pub topics: Vec<TopicReport>,
    /// The parts of the sources that can't be read.
    pub unread: Vec<UnreadReport>,
}

/// A topic of the application.
#[derive(Debug, Serialize, JsonSchema)]
pub struct TopicReport {
    /// The name, such as `/fmu/out/vehicle_status`. It ends with a version if the sources name one.
    pub topic: String,
    /// The name of its type, if it is known.
    pub r#type: Option<String>,
    /// The places that name the topic.
    pub places: Vec<Place>,
    /// The verdict for each version of PX4, in the order of `px4`.
    pub verdicts: Vec<Verdict>,
    /// The name without its version.
    #[serde(skip)]
    name: String,
}

/// Something in the sources that can't be read.
#[derive(Debug, Serialize, JsonSchema)]
pub struct UnreadReport {
    /// The reason.
    pub reason: String,
    /// The place; `null` for a whole file, which the reason names.
    pub place: Option<Place>,
}

/// A place in the sources.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Place {
    /// The path, with `/` on every system.
    pub file: String,
    /// The line, from 1.
    pub line: usize,
    /// The column in characters, from 1.
    pub column: usize,
    #[serde(skip)]
    span: Span,
}

impl Place {
    fn new(span: Span, sources: &SourceMap) -> Self {
        let position = sources.position(span);
        let file = sources.path(sources.source_of(span)).to_owned();
        Self { file, line: position.line, column: position.column, span }
    }

    fn text(&self) -> String {
        format!("{}:{}:{}", shown(&self.file), self.line, self.column)
    }
}

impl TopicReport {
    fn new(used: &Use, sources: &SourceMap, verdicts: Vec<Verdict>) -> Self {
        let name = format!("/{}{}", used.topic.direction.folder(), used.topic.name);
        let topic = match used.topic.version {
            Version::Stated(version) => versioned(&name, Some(version)),
            Version::OfDefinition => format!("{name}{APPENDED}"),
        };
        Self {
            topic,
            name,
            r#type: used.ty.clone(),
            places: used.places.iter().map(|span| Place::new(*span, sources)).collect(),
            verdicts,
        }
    }

    /// The reasons, each with the versions of PX4 to which it applies.
    fn reasons<'r>(&'r self, px4: &'r [String]) -> Vec<(Kind, &'r str, Vec<&'r str>)> {
        let mut reasons: Vec<(Kind, &str, Vec<&str>)> = Vec::new();
        for (verdict, name) in self.verdicts.iter().zip(px4) {
            match reasons.iter_mut().find(|known| (known.0, known.1) == (verdict.verdict, &verdict.reason)) {
                _ if verdict.reason.is_empty() => {}
                Some(known) => known.2.push(name),
                None => reasons.push((verdict.verdict, &verdict.reason, vec![name])),
            }
        }
        reasons
    }

    /// The limited rates, as text.
    fn rates(&self, px4: &[String]) -> Vec<String> {
        let rates = self.verdicts.iter().zip(px4).filter_map(|(verdict, name)| Some((verdict.rate?, name)));
        rates.map(|(rate, name)| format!("{name} sends at most {rate} messages a second")).collect()
    }
}

impl CompatReport {
    /// Creates a report. `verdicts` are the verdicts of each topic for each version of PX4.
    pub fn new(
        path: &str,
        definitions: &str,
        application: &Application,
        px4: &[Side<'_>],
        verdicts: Vec<Vec<Verdict>>,
    ) -> Self {
        let sources = &application.sources;
        let topics = application.uses.iter().zip(verdicts);
        let mut topics: Vec<TopicReport> =
            topics.map(|(used, verdicts)| TopicReport::new(used, sources, verdicts)).collect();
        // An application may name a topic both with and without the version of its definition.
        topics.dedup_by(|next, topic| {
            let is_same = next.topic.ends_with(APPENDED)
                && (&next.name, &next.r#type, &next.verdicts)
                    == (&topic.name, &topic.r#type, &topic.verdicts);
            if is_same {
                topic.places.append(&mut next.places);
            }
            is_same
        });
        let unread = application.unread.iter().map(|unread| UnreadReport {
            reason: unread.reason.clone(),
            place: unread.place.map(|span| Place::new(span, sources)),
        });
        Self {
            version: VERSION,
            uavspec: env!("CARGO_PKG_VERSION").to_owned(),
            application: path.to_owned(),
            definitions: definitions.to_owned(),
            files: application.files,
            px4: px4.iter().map(|side| side.name.clone()).collect(),
            knows_dds: px4.iter().all(|side| side.dds.is_some()),
            topics,
            unread: unread.collect(),
        }
    }

    /// True if a topic doesn't work with one of the versions of PX4.
    pub fn has_problems(&self) -> bool {
        self.topics.iter().flat_map(|topic| &topic.verdicts).any(|verdict| verdict.verdict.is_problem())
    }

    /// The report as JSON.
    pub fn to_json(&self) -> String {
        json_text::pretty(self)
    }

    /// The first line of the report.
    fn title(&self) -> String {
        format!(
            "{} of {} in {}, built with {}",
            plural(self.topics.len(), "topic"),
            shown(&self.application),
            plural(self.files, "source file"),
            shown(&self.definitions)
        )
    }

    /// The rows of the table, with the heading.
    fn rows(&self) -> Vec<Vec<String>> {
        let heading = ["Topic", "Type"].map(str::to_owned).into_iter().chain(self.px4.iter().cloned());
        let rows = self.topics.iter().map(|topic| {
            let start = [topic.topic.clone(), topic.r#type.clone().unwrap_or_else(|| "unknown".to_owned())];
            let verdicts = topic.verdicts.iter().map(|verdict| verdict.verdict.text().to_owned());
            start.into_iter().chain(verdicts).collect()
        });
        std::iter::once(heading.collect()).chain(rows).collect()
    }

    /// The report as text for a terminal.
    pub fn to_text(&self) -> String {
        let rows = self.rows();
        let columns = rows.first().map_or(0, Vec::len);
        let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..columns).map(width).collect();
        let mut text = self.title() + "\n\n";
        // Without topics, there is only the heading.
        for row in rows.iter().filter(|_| rows.len() > 1) {
            let mut line = String::new();
            for (cell, width) in row.iter().zip(&widths) {
                let _ = write!(line, "{cell:width$}  ");
            }
            text += line.trim_end();
            text.push('\n');
        }
        for topic in &self.topics {
            let (reasons, rates) = (topic.reasons(&self.px4), topic.rates(&self.px4));
            if reasons.is_empty() && rates.is_empty() {
                continue;
            }
            let place = topic.places.first().map(|place| format!(" ({})", place.text())).unwrap_or_default();
            let _ = writeln!(text, "\n{}{place}", topic.topic);
            for (kind, reason, px4) in &reasons {
                let line = format!("  {}: {}: {reason}", px4.join(", "), kind.text());
                let _ = writeln!(text, "{}", wrapped(&line, 0, 4));
            }
            for rate in rates {
                let _ = writeln!(text, "  {rate}");
            }
        }
        if !self.unread.is_empty() {
            let _ = writeln!(text, "\nNot read:");
            for unread in &self.unread {
                let _ = writeln!(text, "  {}", unread.text());
            }
            if self.unread.iter().any(|unread| unread.place.is_some()) {
                let _ = writeln!(text, "  help: {HINTS}");
            }
        }
        if !self.knows_dds {
            let _ = writeln!(text, "\n{UNKNOWN_DDS}");
        }
        text
    }

    /// The report as Markdown.
    pub fn to_markdown(&self) -> String {
        let (mut text, mut notes) = (String::new(), Vec::new());
        for (at, row) in self.rows().iter().enumerate() {
            let cells = row.iter().enumerate().map(|(column, cell)| match (at, column) {
                (1.., 0) => format!("`{cell}`"),
                _ => cell.clone(),
            });
            let _ = writeln!(text, "| {} |", cells.collect::<Vec<_>>().join(" | "));
            if at == 0 {
                let _ = writeln!(text, "|{}", "---|".repeat(row.len()));
            }
        }
        for topic in &self.topics {
            for (kind, reason, px4) in topic.reasons(&self.px4) {
                notes.push(format!("- `{}`, {}: {}: {reason}", topic.topic, px4.join(", "), kind.text()));
            }
            notes.extend(topic.rates(&self.px4).iter().map(|rate| format!("- `{}`: {rate}", topic.topic)));
        }
        notes.extend(self.unread.iter().map(|unread| format!("- not read: {}", unread.text())));
        notes.extend((!self.knows_dds).then(|| format!("- {UNKNOWN_DDS}")));
        if !notes.is_empty() {
            let _ = write!(text, "\n{}\n", notes.join("\n"));
        }
        text
    }

    /// The report as SARIF: a finding at each place that names a topic that doesn't work.
    pub fn to_sarif(&self, sources: &SourceMap) -> String {
        let mut findings = Vec::new();
        for topic in &self.topics {
            for (kind, reason, px4) in topic.reasons(&self.px4) {
                let Some((rule, _)) = kind.rule() else { continue };
                for place in &topic.places {
                    let message =
                        format!("`{}` with {}: {}: {reason}", topic.topic, px4.join(", "), kind.text());
                    findings.push(Finding::new(rule, kind.level(), place.span, message));
                }
            }
        }
        for unread in &self.unread {
            let span = unread.place.as_ref().map(|place| place.span).unwrap_or_default();
            findings.push(Finding::new(UNREAD, Level::Note, span, unread.text()));
        }
        let entries = findings.iter().map(|finding| Entry::of(finding, sources)).collect();
        let rule = |id: &'static str, purpose: &'static str, level| RuleInfo {
            id: id.into(),
            purpose: purpose.into(),
            level,
            url: String::new(),
        };
        let mut rules = vec![rule(UNREAD, "The sources name each topic.", Level::Note)];
        let reported = Kind::ALL.into_iter().filter_map(|kind| Some((kind.rule()?, kind.level())));
        rules.extend(reported.map(|((id, purpose), level)| rule(id, purpose, level)));
        Report { command: "compat", rules, entries }.to_text(Format::Sarif)
    }
}

impl UnreadReport {
    fn text(&self) -> String {
        match &self.place {
            Some(place) => format!("{}: {}", place.text(), self.reason),
            None => self.reason.clone(),
        }
    }
}

impl Kind {
    /// The id and the purpose of the rule for this kind in a SARIF report. `None` if the topic needs no attention.
    fn rule(self) -> Option<(&'static str, &'static str)> {
        match self {
            Self::Works | Self::Unused => None,
            Self::Translated => {
                Some(("compat-translated", "The topic needs PX4's message translation node."))
            }
            Self::Breaks => Some((
                "compat-breaks",
                "The application and PX4 use the same definition of a topic, and the same name.",
            )),
            Self::Absent => Some(("compat-absent", "PX4 has the topic.")),
            Self::NotOffered => Some(("compat-not-offered", "PX4 offers the topic over DDS.")),
        }
    }

    fn level(self) -> Level {
        if self.is_problem() { Level::Error } else { Level::Note }
    }
}
