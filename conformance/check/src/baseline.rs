//! Baselines: lists of known failures and flaky results, each with a reason and an optional expiry date.
//!
//! ```toml
//! [[known]]
//! rule = "PX-RANGE-01"                   # or case = "decode-cdr/px4/Event/*"
//! subject = "battery_status.max_error"   # only with rule; optional, default: all subjects
//! file = "logs/2019-*.ulg"               # only with rule; optional, default: all files
//! reason = "firmware 1.11 leaves it 0"
//! link = "https://example.org/issues/7"  # optional, like the following keys
//! expires = 2027-06-30                   # the last day on which the entry is valid
//! message = "0 is outside the range"     # the start of the failure's message
//!
//! [[flaky]]
//! case = "decode-cdr/px4/Event/typical"
//! reason = "the codec reads uninitialized memory"
//! ```
//!
//! Patterns are globs. `*` matches any text, but in `file` it doesn't match `/`. `file` is compared with the path that
//! was passed to the run. `subject` is compared with the name in reports, and also with the name without the instance
//! and the namespace of the topic.
//!
//! Listed rules and cases still run, but their failures don't count. Lists must stay accurate. An entry is therefore
//! reported as stale ([`Stale`]) in these cases:
//!
//! - The entry has a `case` and isn't flaky, and a matching case passes.
//! - The entry has a `rule` and isn't flaky, and all matching results pass.
//! - A matching failure has a different message.
//! - Nothing that matches the entry was checked.
//! - The expiry date has passed.
//!
//! One list serves all commands. Each command ignores entries that don't concern it.
//!
//! ```text
//!  text ──read──▶ entries ──check (with the results of a run)──▶ stale entries ──fix──▶ text
//!                    └───────excuse (a failure)──▶ its reason
//! ```

mod fix;
mod new;
mod pattern;
mod read;
mod run;
mod stale;
#[cfg(test)]
mod tests;

use std::fmt;
use std::fs::{self, File};
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};

use uavspec_model::text::terminal;
use uavspec_model::{Excuse, Reason, Rule};
use uavspec_schema::diagnostic::Level;
use uavspec_schema::finding::Finding;
use uavspec_schema::rewrite::{self, Change};
use uavspec_schema::source::{SourceId, Span};
use uavspec_schema::{Failure, SourceMap, render};

pub use self::new::{NewEntry, list as new_list};
use self::pattern::Pattern;
pub use self::run::{excuse_findings, rule_outcomes, unread_outcome};
pub use self::stale::{Checked, Name, Outcome, Scope, Stale, StaleReason, Sums};

/// The maximum size of a list, in bytes. Several thousand entries fit.
const MAX_LEN: u64 = 1 << 20;

/// An entry of a list.
#[derive(Debug)]
struct Entry {
    names: Selector,
    /// The prefix that each matching failure's message must have.
    message: Option<String>,
    excuse: Excuse,
    spans: EntrySpans,
}

/// The results that an entry matches.
#[derive(Debug)]
enum Selector {
    Rule { rule: &'static Rule, subject: Option<Pattern>, file: Option<Pattern> },
    Case(Pattern),
}

/// The locations of an entry's parts.
#[derive(Clone, Copy, Debug)]
struct EntrySpans {
    /// The first line, which names the table.
    header: Span,
    /// The value of `rule` or `case`.
    selector: Span,
    message: Option<Span>,
    expires: Option<Span>,
    /// The range from the header to the end of the last value.
    whole: Span,
}

/// The lists of a run.
#[derive(Debug, Default)]
pub struct Lists {
    sources: SourceMap,
    ids: Vec<SourceId>,
    entries: Vec<Entry>,
    /// The files from which lists were read, with symbolic links resolved, in the order of `ids`.
    paths: Vec<PathBuf>,
}

/// The reason why lists can't be read.
#[derive(Debug)]
pub enum ListError {
    /// An I/O error.
    Unreadable(PathBuf, io::Error),
    /// The errors in all lists.
    Mistaken(Vec<Finding>, SourceMap),
}

impl std::error::Error for ListError {}

impl fmt::Display for ListError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable(path, error) => write!(formatter, "error: {}: {error}", terminal::path(path)),
            Self::Mistaken(findings, sources) => {
                formatter.write_str(render::findings(findings, sources, false).trim_end())
            }
        }
    }
}

impl Lists {
    /// Reads lists from files. Each file is read once, even if it is named twice.
    pub fn read(paths: &[PathBuf]) -> Result<Self, ListError> {
        let mut texts = Vec::new();
        let mut files: Vec<PathBuf> = Vec::new();
        for path in paths {
            let unreadable = |error| ListError::Unreadable(path.clone(), error);
            // Two paths may lead to the same file.
            let file = fs::canonicalize(path).map_err(unreadable)?;
            if !files.contains(&file) {
                texts.push((terminal::path(path), bytes(&file).map_err(unreadable)?));
                files.push(file);
            }
        }
        let mut lists = Self::parse(texts)?;
        lists.paths = files;
        Ok(lists)
    }

    /// Parses lists, each with the path to show in messages.
    pub fn parse(texts: impl IntoIterator<Item = (String, Vec<u8>)>) -> Result<Self, ListError> {
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

    /// True if there are no entries.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Renders the findings for stale entries, in colour if `is_styled`. `level` is an error, or a note after a fix.
    pub fn render(&self, stale: &[Stale], level: Level, is_styled: bool) -> String {
        let findings: Vec<Finding> = stale.iter().filter_map(|stale| self.finding(stale, level)).collect();
        render::findings(&findings, &self.sources, is_styled)
    }

    /// The findings for stale entries, in the form that reports use.
    pub fn reasons(&self, stale: &[Stale]) -> Vec<Reason> {
        let findings = stale.iter().filter_map(|stale| self.finding(stale, Level::Error));
        let reason = |finding: Finding| Reason {
            message: finding.message,
            path: self.sources.path(self.sources.source_of(finding.span)).to_owned(),
            line: Some(self.sources.position(finding.span).line as u64),
        };
        findings.map(reason).collect()
    }

    /// Creates lists without the stale entries.
    ///
    /// An entry is removed if it matches nothing, if it has expired, or if all its results pass. If only some cases
    /// pass, the entry keeps the failing cases. If messages differ, the entry gets the messages' common prefix, or
    /// stays unchanged if there is none. Everything else stays unchanged, byte for byte. No entries are added, since
    /// only a person can give the reason.
    pub fn fixed(&self, stale: &[Stale]) -> Result<Self, ListError> {
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
    pub fn texts(&self) -> impl Iterator<Item = &str> {
        self.ids.iter().map(|source| self.sources.text(*source))
    }

    /// Writes each list that differs from `old` to its file. Either all such lists are written, or none.
    pub fn write(&self, old: &Self) -> Result<(), Failure> {
        let files = self.ids.iter().zip(&self.paths);
        let changes = files.filter(|(source, _)| self.sources.text(**source) != old.sources.text(**source));
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
            format!("larger than {MAX_LEN} bytes, the limit for a baseline"),
        ));
    }
    Ok(bytes)
}
