//! The `lint` command, which checks and fixes the style of definitions.

use std::collections::BTreeMap;
use std::fs;

use clap::Args;
use uavspec_lint::report::{RuleInfo, Totals};
use uavspec_lint::{Preset, RULES, Settings, apply, lint, rule};
use uavspec_schema::diagnostic::Level;
use uavspec_schema::failure::Failure;
use uavspec_schema::finding::Finding;
use uavspec_schema::rewrite::{self, Change};
use uavspec_schema::source::SourceId;
use uavspec_schema::terminal;
use uavspec_schema::wording::plural;

use super::arguments::{DefinitionsArgs, FilesArgs};
use super::baseline::{self, BaselineArgs, Subjects};
use super::report::{ReportArgs, Results, Selection, rule_ids};
use super::status::Status;
use super::stopwatch::Stopwatch;
use crate::load::{self, Loaded, Plan};

/// The maximum number of `--fix` passes. Several passes may be needed, because one fix may make another fix possible.
const MAX_PASSES: usize = 10;

/// Arguments of `lint`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  cargo xtask lint              check all files that uavspec.toml lists
  cargo xtask lint --summary    print only the totals for each rule
  cargo xtask lint --rule unit-missing --rule unit-alias
  cargo xtask lint --level warning --format json | jq length
  cargo xtask lint --preset strict --deny note
  cargo xtask lint --fix        apply all automatic fixes
  cargo xtask lint msg/Wind.msg
  cargo xtask lint --report sarif=lint.sarif,junit=lint.xml
  cargo xtask lint --package px4 --dialect px4 --input msg

Report only new findings:
  cargo xtask lint --write-baseline baseline.toml
  cargo xtask lint --baseline baseline.toml --deny note

Exit status:
  0    no findings at the --deny level or above
  1    at least one finding at the --deny level or above
  2    the command failed
  4    no such finding, but a baseline is out of date")]
pub struct LintArgs {
    #[command(flatten)]
    definitions: DefinitionsArgs,
    /// Set of rules [default: the preset in uavspec.toml, otherwise px4]
    #[arg(long)]
    preset: Option<Preset>,
    /// Check only this rule, even if it is off (repeatable)
    #[arg(
        long,
        value_name = "ID",
        value_parser = rule_ids(RULES.iter().map(|rule| rule.id)),
        hide_possible_values = true,
        conflicts_with = "write_baseline"
    )]
    rule: Vec<String>,
    /// Report only findings of this level and more severe ones
    #[arg(long, conflicts_with = "write_baseline")]
    level: Option<Level>,
    /// Apply all automatic fixes, and report the remaining findings
    #[arg(long)]
    fix: bool,
    #[command(flatten)]
    report: ReportArgs,
    #[command(flatten)]
    baseline: BaselineArgs,
    /// List all rules with their levels instead of checking
    #[arg(long)]
    rules: bool,
    #[command(flatten)]
    files: FilesArgs,
}

pub(super) fn run(args: &LintArgs) -> Result<Status, Failure> {
    if args.rules {
        list_rules();
        return Ok(Status::Success);
    }
    args.report.check()?;
    let started = Stopwatch::start();
    let plan = args.definitions.plan()?;
    let mut loaded = load::load_with_catalogues(&plan)?;
    args.report.protect(loaded.inputs(&plan).chain(args.baseline.inputs()).chain(args.baseline.output()))?;
    let selection = args.selection(&loaded)?;
    let settings = settings(&plan, &loaded, args);
    let mut findings = check(&loaded, &settings);
    let fixed = if args.fix { fix(&mut loaded, &mut findings, &settings, &selection)? } else { 0 };
    let subjects = Subjects::new(&loaded.sources, &loaded.packages);
    // The other findings are incomplete if a definition has errors.
    let has_errors = findings.iter().any(|finding| rule(finding.rule).is_none());
    let is_applied = |id: &str| {
        !has_errors && selection.has_rule(id) && rule(id).is_some_and(|rule| settings.level(rule).is_some())
    };
    let (known, is_outdated) = baseline::compare(&args.baseline, &mut findings, subjects, &is_applied)?;
    let hidden = selection.apply(|id| rule(id).is_some(), &loaded.sources, &mut findings);
    let totals =
        Totals { known, hidden, ..Totals::of("lint", &findings, &loaded.sources, loaded.files.len()) };
    let rules = RULES.iter().filter(|rule| selection.has_rule(rule.id)).filter_map(|rule| {
        let level = settings.level(rule)?;
        Some(RuleInfo::new(rule.id, rule.purpose(), level))
    });
    let results = Results { rules: rules.collect(), findings: &findings, totals: &totals };
    args.report.show(&results, &loaded.sources_from_here())?;
    let read = plural(loaded.files.len(), "file");
    let elapsed = started.milliseconds();
    terminal::eprintln!("lint: {read} read ({elapsed} ms){}", fix_summary(fixed, totals.fixable()));
    Ok(Status::new(args.report.is_success(&findings), is_outdated))
}

/// The number of fixes that were applied, or that `--fix` would apply.
fn fix_summary(fixed: usize, fixable: usize) -> String {
    match (fixed, fixable) {
        (0, 0) => String::new(),
        (0, count) => format!("; run with `--fix` to fix {count}"),
        (count, _) => format!("; {count} fixed"),
    }
}

impl LintArgs {
    fn selection(&self, loaded: &Loaded) -> Result<Selection, Failure> {
        let files = self.files.sources(loaded)?;
        Ok(Selection { rules: self.rule.clone(), level: self.level, files, ..Selection::default() })
    }
}

fn list_rules() {
    let level = |level: Option<Level>| level.map_or("-", Level::name);
    terminal::println!("{:<32} {:<8} {:<8}", "rule", "px4", "strict");
    for rule in RULES {
        terminal::println!("{:<32} {:<8} {:<8}", rule.id, level(rule.levels.px4), level(rule.levels.strict));
    }
}

fn settings(plan: &Plan, loaded: &Loaded, args: &LintArgs) -> Settings {
    let mut settings = load::lint_settings(plan, loaded);
    if let Some(preset) = args.preset {
        settings.preset = preset;
    }
    for rule in args.rule.iter().filter_map(|id| rule(id)) {
        if settings.level(rule).is_none() {
            settings.levels.insert(rule.id.to_owned(), rule.levels.strict.or(rule.levels.px4));
        }
    }
    settings
}

fn check(loaded: &Loaded, settings: &Settings) -> Vec<Finding> {
    let mut findings: Vec<Finding> = loaded.diagnostics.iter().map(Finding::from).collect();
    findings.extend(lint(&loaded.sources, &loaded.packages, &loaded.catalogues, settings));
    findings
}

/// Applies the automatic fixes of selected findings until none remains, and writes the changed files. Returns the
/// number of fixes.
fn fix(
    loaded: &mut Loaded,
    findings: &mut Vec<Finding>,
    settings: &Settings,
    selection: &Selection,
) -> Result<usize, Failure> {
    let mut texts: BTreeMap<SourceId, String> = BTreeMap::new();
    let mut fixed = 0;
    for _ in 0..MAX_PASSES {
        // Never change the configuration file.
        for finding in findings.iter_mut() {
            if !loaded.paths.contains_key(&loaded.sources.source_of(finding.span)) {
                finding.fix.clear();
            }
        }
        let mut selected = findings.clone();
        selection.apply(|id| rule(id).is_some(), &loaded.sources, &mut selected);
        let new = apply(&selected, &loaded.sources);
        if new.is_empty() {
            break;
        }
        fixed += selected.iter().filter(|finding| !finding.fix.is_empty()).count();
        loaded.set_texts(&new);
        texts.extend(new);
        *findings = check(loaded, settings);
    }
    let mut changes = Vec::new();
    for (source, new) in texts {
        let Some(path) = loaded.paths.get(&source) else { continue };
        let shown = loaded.sources.path(source).to_owned();
        let unreadable = |error: std::io::Error| Failure::new(format!("{shown}: {error}"));
        // Write to the target of a symbolic link.
        let path = fs::canonicalize(path).map_err(unreadable)?;
        let old = fs::read_to_string(&path).map_err(unreadable)?;
        changes.push(Change { path, shown, old, new });
    }
    rewrite::write(&changes)?;
    Ok(fixed)
}
