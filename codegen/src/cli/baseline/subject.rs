//! The subjects of findings: a definition, or one of its fields, constants or table rows.

use std::collections::HashMap;

use uavspec_schema::Form;
use uavspec_schema::finding::Finding;
use uavspec_schema::msg::ast::{Definition, Item};
use uavspec_schema::msg::{self, Kind};
use uavspec_schema::read::PackageInput;
use uavspec_schema::source::{SourceId, SourceMap, Span, stem};

/// Finds the subjects of findings.
pub(in crate::cli) struct Subjects<'s> {
    pub(super) sources: &'s SourceMap,
    packages: HashMap<SourceId, &'s PackageInput>,
    /// The subjects in each source; created lazily.
    lines: HashMap<SourceId, Lines>,
}

/// The subjects in a source.
#[derive(Default)]
struct Lines {
    /// The start and the subject of each line.
    subjects: Vec<(u32, String)>,
    /// The first line of each message, with the name of the message. Findings about a whole message are located there.
    heads: Vec<(Span, String)>,
}

impl<'s> Subjects<'s> {
    pub(in crate::cli) fn new(
        sources: &'s SourceMap,
        packages: impl IntoIterator<Item = &'s PackageInput>,
    ) -> Self {
        let packages = packages.into_iter();
        let packages =
            packages.flat_map(|package| package.sources.iter().map(move |source| (*source, package)));
        Self { sources, packages: packages.collect(), lines: HashMap::new() }
    }

    /// The subject of a finding, such as `px4/Airspeed.confidence`. It doesn't contain a line number.
    pub(super) fn of(&mut self, finding: &Finding) -> String {
        let side = finding.sides.and_then(|sides| sides.new.or(sides.old));
        let span = side.unwrap_or(finding.span);
        let source = self.sources.source_of(span);
        let (sources, packages) = (self.sources, &self.packages);
        let lines = self.lines.entry(source).or_insert_with(|| lines(sources, source, packages.get(&source)));
        if let Some((_, name)) = lines.heads.iter().find(|(head, _)| *head == span) {
            return name.clone();
        }
        let after = lines.subjects.partition_point(|(start, _)| *start <= span.start);
        let subject = after.checked_sub(1).map(|at| lines.subjects[at].1.clone());
        subject.unwrap_or_else(|| file_name(sources.path(source)))
    }
}

fn lines(sources: &SourceMap, source: SourceId, package: Option<&&PackageInput>) -> Lines {
    let (path, text, whole) = (sources.path(source), sources.text(source), sources.span(source));
    let only = |subjects| Lines { subjects, heads: Vec::new() };
    let Some(package) = package else { return only(catalogue_lines(text, whole, path)) };
    let name = format!("{}/{}", package.name, stem(path));
    match (package.form, Kind::of(path)) {
        (Form::Msg(dialect), Some(kind)) => {
            let (definition, _) = msg::parse(sources, source, kind, dialect);
            message_lines(&definition, kind, &name)
        }
        _ => only(page_lines(text, whole, &name)),
    }
}

fn message_lines(definition: &Definition<'_>, kind: Kind, name: &str) -> Lines {
    let mut lines = Lines::default();
    let suffixes = kind.part_suffixes().iter().chain(std::iter::repeat(&""));
    for (part, suffix) in definition.parts.iter().zip(suffixes) {
        let name = format!("{name}{suffix}");
        lines.heads.extend(part.lines.first().map(|line| (line.span, name.clone())));
        lines.subjects.extend(part.lines.iter().map(|line| {
            let subject = match line.item.as_deref() {
                Some(Item::Field(field)) => format!("{name}.{}", field.name.text),
                Some(Item::Constant(constant)) => format!("{name}.{}", constant.name.text),
                None => name.clone(),
            };
            (line.span.start, subject)
        }));
    }
    lines
}

/// The lines of a page. The subject of a table row consists of the heading and the first cell.
fn page_lines(text: &str, whole: Span, name: &str) -> Vec<(u32, String)> {
    let mut heading = String::new();
    let mut lines = Vec::new();
    for (start, line) in starts(text, whole) {
        if let Some(title) = ["#", "="].iter().find_map(|mark| line.strip_prefix(mark)) {
            let title = title.trim_start_matches(['#', '=']).trim();
            heading = if title.is_empty() { heading } else { format!(": {title}") };
        }
        let cell = line.strip_prefix('|').and_then(|cells| cells.split('|').next()).map(str::trim);
        let cell = cell.filter(|cell| !cell.is_empty()).map(|cell| format!(".{}", cell.trim_matches('`')));
        lines.push((start, format!("{name}{heading}{}", cell.unwrap_or_default())));
    }
    lines
}

/// The lines of a translation catalogue or another file without definitions. The subject of a translation is its key.
fn catalogue_lines(text: &str, whole: Span, path: &str) -> Vec<(u32, String)> {
    let name = file_name(path);
    let mut subject = name.clone();
    let lines = starts(text, whole).map(|(start, line)| {
        if let Some(key) = line.strip_prefix("msgctxt ") {
            subject = format!("{name}: {}", key.trim().trim_matches('"'));
        }
        (start, subject.clone())
    });
    lines.collect()
}

/// The lines of a text, each with its start.
fn starts(text: &str, whole: Span) -> impl Iterator<Item = (u32, &str)> {
    text.split_inclusive('\n').scan(0, move |at, line| {
        let start = whole.part(*at..*at).start;
        *at += line.len();
        Some((start, line.trim_end()))
    })
}

fn file_name(path: &str) -> String {
    path.rsplit(['/', '\\']).next().unwrap_or(path).to_owned()
}
