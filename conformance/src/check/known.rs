//! Lists of known failures and of flaky results: what is let stand, why, and until when.
//!
//! ```toml
//! [[known]]
//! rule = "PX-RANGE-01"                   # or case = "decode-cdr/px4/Event/*"
//! subject = "battery_status.max_error"   # only with rule; all subjects, where absent
//! file = "logs/2019-*.ulg"               # only with rule; all files, where absent
//! reason = "firmware 1.11 leaves it 0"
//! link = "https://example.org/issues/7"  # may be absent, as what follows
//! expires = 2027-06-30                   # the last day that it holds
//! message = "0 is out of range"          # how the failure's message begins
//!
//! [[flaky]]
//! case = "decode-cdr/px4/Event/typical"
//! reason = "the codec reads memory that it never wrote"
//! ```
//!
//! Patterns are globs. `*` matches anything, in `file` all but `/`; `file` is compared with the path as the run
//! was given it.
//!
//! What is listed runs as ever, and its failures don't count. But a list must hold true ([`Stale`]): an entry is
//! stale when something that it names passes, or fails with another message, when it names nothing that was judged,
//! and after its last day. What a flaky entry names may pass; so may some of the files and subjects that an entry of
//! a rule names, if not all. One list serves all commands: each leaves alone the entries that are of no matter to
//! it.
//!
//! ```text
//!  text ──read──▶ entries ──check (with what came of the run)──▶ stale entries ──fix──▶ text
//!                    └───────excuse (a failure)──▶ its reason
//! ```

mod fix;
mod pattern;
mod read;
mod run;
mod stale;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::fmt;
use std::fs::{self, File};
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};

use uavspec_codegen::diagnostic::Level;
use uavspec_codegen::finding::Finding;
use uavspec_codegen::rewrite::{self, Change};
use uavspec_codegen::source::{SourceId, Span};
use uavspec_codegen::{Failure, SourceMap, render};

use self::pattern::Pattern;
pub(crate) use self::run::{excuse_findings, rule_outcomes, unread_outcome};
pub(crate) use self::stale::{Checked, Name, Outcome, Scope, Stale, StaleReason};
use crate::model::{Excuse, Reason, Rule};

/// The longest list that is read, in bytes: room for some thousand entries.
const MAX_LEN: u64 = 1 << 20;

/// An entry of a list.
#[derive(Debug)]
struct Entry {
    names: Selector,
    /// How the messages of its failures begin.
    message: Option<String>,
    excuse: Excuse,
    spans: EntrySpans,
}

/// What an entry names.
#[derive(Debug)]
enum Selector {
    Rule { rule: &'static Rule, subject: Option<Pattern>, file: Option<Pattern> },
    Case(Pattern),
}

/// Where an entry stands.
#[derive(Clone, Copy, Debug)]
struct EntrySpans {
    /// Its first line, the name of its table.
    header: Span,
    /// The rule or the pattern of cases.
    selector: Span,
    message: Option<Span>,
    expires: Option<Span>,
    /// From its header to the end of its last value.
    whole: Span,
}

/// The lists of a run.
#[derive(Debug, Default)]
pub(crate) struct Lists {
    sources: SourceMap,
    ids: Vec<SourceId>,
    entries: Vec<Entry>,
    /// The file of each list that was read from one; no link leads on from there.
    paths: BTreeMap<SourceId, PathBuf>,
}

/// Why lists can't be read.
#[derive(Debug)]
pub(crate) enum ListError {
    /// There is no such file, or the like.
    Unreadable(PathBuf, io::Error),
    /// What stands in them is no list: every mistake in all of them.
    Mistaken(Vec<Finding>, SourceMap),
}

impl std::error::Error for ListError {}

impl fmt::Display for ListError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable(path, error) => write!(formatter, "error: {}: {error}", path.display()),
            Self::Mistaken(findings, sources) => {
                formatter.write_str(render::findings(findings, sources, false).trim_end())
            }
        }
    }
}

impl Lists {
    /// Reads the lists in files. A file that is named twice is read once.
    pub(crate) fn read(paths: &[PathBuf]) -> Result<Self, ListError> {
        let mut texts = Vec::new();
        let mut files: Vec<PathBuf> = Vec::new();
        for path in paths {
            let unreadable = |error| ListError::Unreadable(path.clone(), error);
            // Behind a link stands the file that is meant.
            let file = fs::canonicalize(path).map_err(unreadable)?;
            if !files.contains(&file) {
                texts.push((path.display().to_string(), bytes(&file).map_err(unreadable)?));
                files.push(file);
            }
        }
        let mut lists = Self::parse(texts)?;
        lists.paths = lists.ids.iter().copied().zip(files).collect();
        Ok(lists)
    }

    /// Reads lists, each under the path that is shown for it.
    pub(crate) fn parse(texts: impl IntoIterator<Item = (String, Vec<u8>)>) -> Result<Self, ListError> {
        let mut lists = Self::default();
        let mut mistakes = Vec::new();
        for (path, bytes) in texts {
            match lists.sources.add(path, bytes) {
                Ok(source) => {
                    lists.ids.push(source);
                    let (entries, found) = read::entries(&lists.sources, source);
                    lists.entries.extend(entries);
                    mistakes.extend(found);
                }
                Err(diagnostic) => mistakes.push(Finding::from(&diagnostic)),
            }
        }
        if mistakes.is_empty() { Ok(lists) } else { Err(ListError::Mistaken(mistakes, lists.sources)) }
    }

    /// Whether nothing is listed.
    pub(crate) fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// What is said of stale entries, with colours where `is_styled`: errors, or notes on what was mended.
    pub(crate) fn render(&self, stale: &[Stale], level: Level, is_styled: bool) -> String {
        let findings: Vec<Finding> = stale.iter().filter_map(|stale| self.finding(stale, level)).collect();
        render::findings(&findings, &self.sources, is_styled)
    }

    /// The same for reports: each with its place.
    pub(crate) fn reasons(&self, stale: &[Stale]) -> Vec<Reason> {
        let findings = stale.iter().filter_map(|stale| self.finding(stale, Level::Error));
        let reason = |finding: Finding| Reason {
            message: finding.message,
            path: self.sources.path(self.sources.source_of(finding.span)).to_owned(),
            line: Some(self.sources.position(finding.span).line as u64),
        };
        findings.map(reason).collect()
    }

    /// The lists without what is stale in them, and those of their texts that change.
    ///
    /// Entries go that pass, name nothing or are over. Those that pass in part name only the rest, and those that
    /// fail otherwise get the beginning of the new message, but where messages have none in common: the entry stays.
    /// All else stays as it is, byte for byte. None is added: only a person knows a reason.
    pub(crate) fn fixed(&self, stale: &[Stale]) -> Result<Self, ListError> {
        let texts = fix::texts(self, stale);
        let text =
            |source: SourceId| texts.get(&source).map_or_else(|| self.sources.text(source), String::as_str);
        let all = self
            .ids
            .iter()
            .map(|source| (self.sources.path(*source).to_owned(), text(*source).as_bytes().to_vec()));
        Ok(Self { paths: self.paths.clone(), ..Self::parse(all)? })
    }

    /// The text of each list.
    #[cfg(test)]
    pub(crate) fn texts(&self) -> impl Iterator<Item = &str> {
        self.ids.iter().map(|source| self.sources.text(*source))
    }

    /// Writes to their files the texts that differ from those of `old`, all or none.
    pub(crate) fn write(&self, old: &Self) -> Result<(), Failure> {
        let changes =
            self.paths.iter().filter(|(source, _)| self.sources.text(**source) != old.sources.text(**source));
        let change = |(source, path): (&SourceId, &PathBuf)| Change {
            path: path.clone(),
            shown: self.sources.path(*source).to_owned(),
            old: old.sources.text(*source).to_owned(),
            new: self.sources.text(*source).to_owned(),
        };
        rewrite::write(&changes.map(change).collect::<Vec<_>>())
    }
}

/// The bytes of a list.
fn bytes(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(MAX_LEN + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MAX_LEN {
        return Err(io::Error::new(
            io::ErrorKind::FileTooLarge,
            format!("more than {MAX_LEN} bytes, is this a list?"),
        ));
    }
    Ok(bytes)
}
