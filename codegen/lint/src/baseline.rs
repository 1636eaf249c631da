//! Baselines: lists of known findings and failures, each with a reason. All commands that report findings read
//! baselines.
//!
//! ```toml
//! [[known]]
//! rule = "PX-RANGE-01"                   # or case = "decode-cdr/px4/Event/*"; all other keys except reason are optional
//! subject = "battery_status.max_error"   # only with rule; default: all subjects
//! file = "logs/2019-*.ulg"               # only with rule; default: all files
//! count = 1                              # only for rules of `lint` and `breaking`; default: any number
//! message = "0 is outside the range"     # the start of the finding's message
//! reason = "firmware 1.11 leaves it 0"
//! link = "https://example.org/issues/7"
//! expires = 2027-06-30                   # the last day on which the entry is valid
//!
//! [[flaky]]
//! case = "decode-cdr/px4/Event/typical"
//! reason = "the codec reads uninitialized memory"
//! ```
//!
//! Patterns are globs. `*` matches any text, but in `file` it doesn't match `/`.
//!
//! Known findings don't count. To keep lists accurate, an entry that no longer applies is [stale](Lists::stale). One
//! list serves all commands: each command ignores the entries for other commands.
//!
//! ```text
//!  text ──read──▶ entries ──stale (with the results of a run)──▶ findings ──updated──▶ text
//!                    └───────find (a finding)──▶ its entry
//! ```

mod edit;
mod pattern;
mod read;
mod stale;

use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap};
use std::fmt;
use std::fs::{self, File};
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::path::{Path, PathBuf};

use uavspec_schema::finding::Finding;
use uavspec_schema::rewrite::{self, Change};
use uavspec_schema::source::{SourceId, Span};
use uavspec_schema::stage::write_file;
use uavspec_schema::{Date, Failure, SourceMap, render, terminal};

use self::pattern::Pattern;
pub use self::stale::{Outcome, Scope, Sums};

/// The number of bytes that are read from a list. [`SourceMap`] rejects this length.
const MAX_READ: u64 = (4 << 20) + 1;

/// The maximum number of entries that a run adds. A list with more entries would be too long to be read.
const MAX_ADDED: usize = 25_000;

/// The reason in added entries.
const REASON: &str = "not assessed yet";

/// An entry of a list.
#[derive(Debug, Default)]
pub struct Entry {
    /// The id of the rule; `None` for an entry about cases.
    pub rule: Option<String>,
    /// True if the failure occurs only sometimes.
    pub is_flaky: bool,
    /// The reason, without control characters.
    pub reason: String,
    /// A link to more information, without control characters.
    pub link: Option<String>,
    /// The last day on which the entry is valid.
    pub expires: Option<Date>,
    /// The subjects of the rule, or the cases. `None` for all subjects.
    name: Option<Pattern>,
    file: Option<Pattern>,
    /// The number of findings; `None` for any number.
    count: Option<usize>,
    /// The prefix that each finding's message must have.
    message: Option<String>,
    /// True if there are more findings than `count`. The entry then covers no findings, because the new findings can't
    /// be distinguished.
    is_exceeded: bool,
    spans: Spans,
}

/// The locations of an entry's parts.
#[derive(Clone, Copy, Debug, Default)]
struct Spans {
    /// The first line, which names the table.
    header: Span,
    /// The value of `case`, `subject` or `rule`: the first of these keys that the entry has.
    name: Span,
    count: Option<Span>,
    message: Option<Span>,
    expires: Option<Span>,
    /// The range from the header to the end of the last value.
    whole: Span,
}

/// The name of a result.
#[derive(Clone, Debug)]
pub struct Name<'n> {
    /// The id of the rule; `None` for a case.
    pub rule: Option<&'n str>,
    /// The names of the case, or of the finding's subject, that patterns can match. The full name comes first. Empty
    /// for the result of a rule without a finding.
    pub forms: Vec<Cow<'n, str>>,
    /// The path of the file; empty for a case.
    pub file: &'n str,
}

impl<'n> Name<'n> {
    /// The name of a case.
    pub fn case(name: &'n str) -> Self {
        Self { rule: None, forms: vec![name.into()], file: "" }
    }

    /// The name of a rule's result for a file, without a finding.
    pub fn rule(rule: &'n str, file: &'n str) -> Self {
        Self { rule: Some(rule), forms: Vec::new(), file }
    }
}

/// The lists of a run.
#[derive(Debug, Default)]
pub struct Lists {
    sources: SourceMap,
    files: Vec<(SourceId, PathBuf)>,
    /// The list to which entries are added.
    target: Option<SourceId>,
    /// The valid ids in `rule`, in addition to the rules of `lint` and `breaking`. If empty, other ids aren't checked.
    rules: Vec<&'static str>,
    /// The entries in the order of `files`, followed by the added entries.
    entries: Vec<Entry>,
    num_read: usize,
    is_full: bool,
    /// The entries of each rule. Entries about cases have the key "".
    index: HashMap<String, Index>,
}

/// The entries of a rule, or all entries about cases. Lists may have thousands of entries.
#[derive(Debug, Default)]
struct Index {
    all: Vec<usize>,
    exact: HashMap<String, Vec<usize>>,
    patterns: Vec<usize>,
}

/// The mistakes in lists, each with its location.
#[derive(Debug)]
pub struct Mistakes {
    /// The mistakes, in the order of the lists.
    pub findings: Vec<Finding>,
    /// The lists.
    pub sources: SourceMap,
}

impl std::error::Error for Mistakes {}

impl fmt::Display for Mistakes {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(render::findings(&self.findings, &self.sources, false).trim_end())
    }
}

impl From<Mistakes> for Failure {
    fn from(mistakes: Mistakes) -> Self {
        Self::new(format!("a baseline contains mistakes\n{mistakes}"))
    }
}

impl Lists {
    /// Reads lists from files. `target` is the list to which entries can be added; its file may be absent. A file that
    /// is named twice is read once. `rules` contains the valid rule ids in addition to the rules of `lint` and
    /// `breaking`; if it is empty, other ids aren't checked.
    pub fn read(paths: &[PathBuf], target: Option<&Path>, rules: &[&'static str]) -> Result<Self, Failure> {
        let mut texts = Vec::new();
        let mut files: Vec<PathBuf> = Vec::new();
        let named = paths.iter().map(|path| (path.as_path(), false)).chain(target.map(|path| (path, true)));
        for (path, is_target) in named {
            let shown = terminal::path(path);
            let (file, text) = match fs::canonicalize(path).and_then(|file| Ok((bytes(&file)?, file))) {
                Ok((text, file)) => (file, text),
                Err(error) if is_target && error.kind() == ErrorKind::NotFound => {
                    (path.to_owned(), Vec::new())
                }
                Err(error) => {
                    let failure = Failure::new(format!("{shown}: {error}"));
                    return Err(failure.with_hint("`--write-baseline FILE` writes a baseline"));
                }
            };
            if !files.contains(&file) {
                files.push(file);
                texts.push((shown, text));
            }
        }
        let lists = Self::parse(texts, rules)?;
        let files = lists.files.iter().zip(files).map(|((source, _), path)| (*source, path));
        let files: Vec<(SourceId, PathBuf)> = files.collect();
        // Resolve links, because the target may be one of the lists.
        let target = target.map(|path| fs::canonicalize(path).unwrap_or_else(|_| path.to_owned()));
        let target = files.iter().find(|(_, file)| Some(file) == target.as_ref()).map(|(source, _)| *source);
        Ok(Self { files, target, ..lists })
    }

    /// Parses lists, each with the path to show in messages. For `rules`, see [`Lists::read`].
    pub fn parse(
        texts: impl IntoIterator<Item = (String, Vec<u8>)>,
        rules: &[&'static str],
    ) -> Result<Self, Mistakes> {
        let mut lists = Self { rules: rules.to_vec(), ..Self::default() };
        let mut findings = Vec::new();
        for (path, bytes) in texts {
            match lists.sources.add(path, bytes) {
                Ok(source) => {
                    lists.files.push((source, PathBuf::new()));
                    let (entries, mistakes) = read::entries(&lists.sources, source, rules);
                    for entry in entries {
                        lists.push(entry);
                    }
                    findings.extend(mistakes);
                }
                Err(diagnostic) => findings.push(Finding::from(&diagnostic)),
            }
        }
        lists.num_read = lists.entries.len();
        if findings.is_empty() { Ok(lists) } else { Err(Mistakes { findings, sources: lists.sources }) }
    }

    fn push(&mut self, entry: Entry) {
        let at = self.entries.len();
        let index = self.index.entry(entry.rule.clone().unwrap_or_default()).or_default();
        index.all.push(at);
        match &entry.name {
            Some(Pattern::Exact(name)) => index.exact.entry(name.clone()).or_default().push(at),
            _ => index.patterns.push(at),
        }
        self.entries.push(entry);
    }

    /// True if there are no entries.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// True if there is a list to which entries can be added, and it isn't empty.
    pub fn has_target(&self) -> bool {
        self.target.is_some_and(|target| !self.sources.text(target).is_empty())
    }

    /// The displayed path of the list to which entries are added, and the number of entries that were added.
    pub fn added(&self) -> Option<(&str, usize)> {
        Some((self.sources.path(self.target?), self.entries.len() - self.num_read))
    }

    /// True if a finding is in the list to which entries are added.
    pub fn is_in_target(&self, finding: &Finding) -> bool {
        self.target == Some(self.sources.source_of(finding.span))
    }

    /// The indexes of the entries that match a name.
    fn matching(&self, name: &Name<'_>) -> BTreeSet<usize> {
        let Some(index) = self.index.get(name.rule.unwrap_or_default()) else { return BTreeSet::new() };
        let exact = name.forms.iter().filter_map(|form| index.exact.get(&**form)).flatten();
        let all = if name.forms.is_empty() { &index.all } else { &index.patterns };
        exact.chain(all).copied().filter(|at| self.entries[*at].is_match(name)).collect()
    }

    /// The entry that covers a finding: it matches the name and all messages. Known failures take precedence over flaky
    /// ones, and names over patterns.
    pub fn find(&self, name: &Name<'_>, messages: &[String]) -> Option<&Entry> {
        let entry = &self.entries[self.covering(&self.matching(name), messages)?];
        (!entry.is_exceeded).then_some(entry)
    }

    /// Like [`Lists::find`]. If no entry covers the finding and there is a target, adds an entry, unless there are too many.
    pub fn find_or_add(
        &mut self,
        name: &Name<'_>,
        messages: &[String],
        count: Option<usize>,
    ) -> Option<&Entry> {
        if self.target.is_some() && self.covering(&self.matching(name), messages).is_none() {
            self.is_full |= self.entries.len() - self.num_read >= MAX_ADDED;
            if self.is_full {
                return None;
            }
            self.push(Entry {
                rule: name.rule.map(str::to_owned),
                reason: REASON.to_owned(),
                name: name.forms.first().map(|form| Pattern::Exact(form.clone().into_owned())),
                count,
                ..Entry::default()
            });
        }
        self.find(name, messages)
    }

    fn covering(&self, matching: &BTreeSet<usize>, messages: &[String]) -> Option<usize> {
        let expects = |at: &&usize| messages.iter().all(|message| self.entries[**at].expects(message));
        let order = |at: &&usize| {
            let entry = &self.entries[**at];
            (entry.is_flaky, !matches!(entry.name, Some(Pattern::Exact(_))))
        };
        matching.iter().filter(expects).min_by_key(order).copied()
    }

    /// The sources of the findings about stale entries.
    pub fn sources(&self) -> &SourceMap {
        &self.sources
    }

    /// Applies the fixes of findings about stale entries, appends the text of the added entries, and returns
    /// the resulting lists.
    ///
    /// An entry is removed if it matches nothing, if it has expired, or if all its results pass. If only some cases
    /// pass, the entry keeps the failing cases. If messages differ, the entry gets the messages' common prefix, or
    /// stays unchanged if there is none. If the number of findings differs, the count changes. Everything else stays
    /// unchanged, byte for byte.
    pub fn updated(&self, fixes: &[Finding]) -> Result<Self, Mistakes> {
        let texts = self.texts_with(fixes).into_iter();
        let texts = texts.map(|(source, text)| (self.sources.path(source).to_owned(), text.into_bytes()));
        let lists = Self::parse(texts, &self.rules)?;
        Ok(Self { files: self.files.clone(), target: self.target, ..lists })
    }

    /// The text of each list.
    pub fn texts(&self) -> impl Iterator<Item = &str> {
        self.files.iter().map(|(source, _)| self.sources.text(*source))
    }

    /// Writes each list that differs from `old` to its file. Either all files that exist are changed, or none.
    pub fn write(&self, old: &Self) -> Result<(), Failure> {
        if old.is_full {
            let message = format!("the baseline is not written: more than {MAX_ADDED} new entries");
            return Err(Failure::new(message));
        }
        let mut changes = Vec::new();
        for (source, path) in &self.files {
            let [old, new] = [old, self].map(|lists| lists.sources.text(*source).to_owned());
            let shown = self.sources.path(*source).to_owned();
            if old == new {
            } else if path.exists() {
                changes.push(Change { path: path.clone(), shown, old, new });
            } else {
                write_file(path, |file| file.write_all(new.as_bytes()))
                    .map_err(|error: io::Error| Failure::new(format!("{shown}: {error}")))?;
            }
        }
        rewrite::write(&changes)
    }
}

impl Entry {
    /// True if the entry matches this name. A result without a finding has no subject to match.
    fn is_match(&self, name: &Name<'_>) -> bool {
        let has_name =
            |pattern: &Pattern| name.forms.is_empty() || name.forms.iter().any(|form| pattern.is_match(form));
        self.name.as_ref().is_none_or(has_name)
            && self.file.as_ref().is_none_or(|file| file.is_match(pattern::plain(name.file)))
    }

    fn expects(&self, message: &str) -> bool {
        self.message.as_ref().is_none_or(|prefix| message.starts_with(prefix))
    }
}

/// The bytes of a list.
fn bytes(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(MAX_READ).read_to_end(&mut bytes)?;
    Ok(bytes)
}
