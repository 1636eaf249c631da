//! The number of findings for each rule, level and category.
//!
//! ```
//! use uavspec_schema::{SourceMap, diagnostic::Level, finding::Finding, source::Span};
//! use uavspec_lint::report::Totals;
//!
//! let finding = Finding::new("unit-missing", Level::Warning, Span::default(), "`speed` has no unit");
//! let totals = Totals::of("lint", &[finding], &SourceMap::default(), 12);
//! assert_eq!(totals.headline(), "1 warning in 1 of 12 files");
//! ```

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use serde_json::{Value, json};
use uavspec_dynamic::breaking::Category;
use uavspec_schema::diagnostic::Level;
use uavspec_schema::finding::Finding;
use uavspec_schema::source::{SourceId, SourceMap};
use uavspec_schema::wording::plural;

/// The totals of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Totals {
    /// The command: `lint` or `breaking`.
    pub command: &'static str,
    /// The number of files that were read.
    pub files: usize,
    /// The number of files with findings.
    pub affected_files: usize,
    /// The rules with findings: the most severe first, then the most frequent.
    pub rules: Vec<RuleTotal>,
    /// The number of findings that the baseline contains.
    pub known: usize,
    /// The number of findings that options such as `--rule` hide.
    pub hidden: usize,
}

/// The totals of a rule at one level.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RuleTotal {
    /// The id of the rule.
    pub rule: &'static str,
    /// The level. In a comparison, this is the highest level of all affected categories.
    pub level: Level,
    /// The number of findings. A change that affects several categories counts once.
    pub count: usize,
    /// The number of findings with an automatic fix.
    pub fixable: usize,
    /// The number of incompatible changes in each category.
    pub categories: BTreeMap<&'static str, usize>,
}

impl Totals {
    /// Counts findings in their report order. `files` is the number of files that were read.
    pub fn of(command: &'static str, findings: &[Finding], sources: &SourceMap, files: usize) -> Self {
        let affected: BTreeSet<SourceId> =
            findings.iter().map(|finding| sources.source_of(finding.span)).collect();
        let mut rules: BTreeMap<(&str, Level), RuleTotal> = BTreeMap::new();
        for same in findings.chunk_by(Finding::is_same_change) {
            let level = same.iter().map(|finding| finding.level).max().unwrap_or(Level::Note);
            let rule = same[0].rule;
            let total = rules.entry((rule, level)).or_insert_with(|| RuleTotal {
                rule,
                level,
                count: 0,
                fixable: 0,
                categories: BTreeMap::new(),
            });
            total.count += 1;
            total.fixable += usize::from(!same[0].fix.is_empty());
            for finding in same.iter().filter(|finding| finding.level > Level::Note) {
                if let Some(category) = finding.category {
                    *total.categories.entry(category).or_default() += 1;
                }
            }
        }
        let mut rules: Vec<RuleTotal> = rules.into_values().collect();
        rules.sort_by_key(|total| (std::cmp::Reverse((total.level, total.count)), total.rule));
        Self { command, files, affected_files: affected.len(), rules, known: 0, hidden: 0 }
    }

    /// The number of findings.
    pub fn count(&self) -> usize {
        self.rules.iter().map(|total| total.count).sum()
    }

    /// The number of findings with an automatic fix.
    pub fn fixable(&self) -> usize {
        self.rules.iter().map(|total| total.fixable).sum()
    }

    /// The number of findings at a level.
    fn at(&self, level: Level) -> usize {
        self.rules.iter().filter(|total| total.level == level).map(|total| total.count).sum()
    }

    /// The number of incompatible changes in each category, in the order of the report.
    fn categories(&self) -> Vec<(&'static str, usize)> {
        let count = |category: Category| {
            let counts = self.rules.iter().filter_map(|total| total.categories.get(category.name()));
            (category.name(), counts.sum())
        };
        Category::ALL.into_iter().map(count).filter(|(_, count)| *count > 0).collect()
    }

    /// True if the findings are changes between two versions.
    fn is_comparison(&self) -> bool {
        self.command == "breaking"
    }

    /// The totals in one line.
    pub fn headline(&self) -> String {
        let mut line = if self.is_comparison() { self.changes() } else { self.findings() };
        let noun = if self.is_comparison() { "change" } else { "finding" };
        if self.known > 0 {
            let _ = write!(line, "; {} not shown", plural(self.known, &format!("known {noun}")));
        }
        if self.hidden > 0 {
            let _ = write!(line, "; {} hidden by options", plural(self.hidden, &format!("other {noun}")));
        }
        line
    }

    /// The number of findings at each level, most severe first.
    fn findings(&self) -> String {
        if self.count() == 0 {
            let new = if self.known > 0 { "new " } else { "" };
            return format!("no {new}findings in {}", plural(self.files, "file"));
        }
        let levels = Level::ALL.into_iter().rev().filter(|level| self.at(*level) > 0);
        let counts: Vec<String> = levels.map(|level| plural(self.at(level), level.name())).collect();
        format!("{} in {} of {}", counts.join(", "), self.affected_files, plural(self.files, "file"))
    }

    /// The number of changes, and the number of incompatible changes in each category.
    fn changes(&self) -> String {
        if self.count() == 0 {
            return if self.known > 0 { "no new changes" } else { "no relevant changes" }.to_owned();
        }
        let changes = plural(self.count(), "change");
        match &self.categories()[..] {
            [] => format!("{changes}; all compatible"),
            categories => format!("{changes}; incompatible: {}", list(categories)),
        }
    }

    /// The totals as a table with a line for each rule, followed by the headline.
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        let is_comparison = self.is_comparison();
        let (number, last) = if is_comparison { ("changes", "incompatible") } else { ("count", "fixable") };
        let digits = number.len();
        let width = self.rules.iter().map(|total| total.rule.len()).chain(["rule".len()]).max().unwrap_or(0);
        let mut line = |level: &str, rule: &str, count: &str, last: &str| {
            let _ = writeln!(text, "{level:<7}  {rule:<width$}  {count:>digits$}  {last}");
        };
        if !self.rules.is_empty() {
            line("level", "rule", number, last);
        }
        for total in &self.rules {
            let last = match total.fixable {
                _ if is_comparison => {
                    let categories = Category::ALL.map(Category::name).into_iter();
                    let counts = categories.filter_map(|name| Some((name, *total.categories.get(name)?)));
                    list(&counts.collect::<Vec<_>>())
                }
                0 => String::new(),
                fixable => format!("{fixable:>7}"),
            };
            let last = if last.is_empty() { "-".to_owned() } else { last };
            let last = if is_comparison { last } else { format!("{last:>7}") };
            line(total.level.name(), total.rule, &total.count.to_string(), &last);
        }
        if !self.rules.is_empty() {
            text.push('\n');
        }
        text + &self.headline() + "\n"
    }

    /// The totals as a JSON object.
    pub fn to_json(&self) -> Value {
        let levels: serde_json::Map<String, Value> =
            Level::ALL.iter().rev().map(|level| (level.name().to_owned(), json!(self.at(*level)))).collect();
        let is_comparison = self.is_comparison();
        let rule = |total: &RuleTotal| {
            let mut object = json!({ "rule": total.rule, "level": total.level.name(), "count": total.count });
            if is_comparison {
                object["categories"] = json!(total.categories);
            } else {
                object["fixable"] = json!(total.fixable);
            }
            object
        };
        let mut object = json!({
            "command": self.command,
            "count": self.count(),
            "levels": levels,
            "files": self.files,
            "affectedFiles": self.affected_files,
            "known": self.known,
            "hidden": self.hidden,
            "rules": self.rules.iter().map(rule).collect::<Vec<_>>(),
        });
        if is_comparison {
            object["categories"] = json!(self.categories().into_iter().collect::<BTreeMap<_, _>>());
        } else {
            object["fixable"] = json!(self.fixable());
        }
        object
    }
}

fn list(categories: &[(&str, usize)]) -> String {
    categories.iter().map(|(name, count)| format!("{name} {count}")).collect::<Vec<_>>().join(", ")
}
