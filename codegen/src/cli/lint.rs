//! `lint`: what should be written otherwise.

use std::collections::BTreeSet;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;

use super::config::{Config, Plan, PresetName};
use super::load::{self, Loaded};
use super::{Failure, PackageArgs, plural};
use crate::diagnostic::{Level, render};
use crate::finding::Finding;
use crate::lint::{Ignore, Preset, RULES, Settings, apply, lint};
use crate::report::{Entry, Format, Report, RuleInfo};
use crate::source::SourceId;

/// How often mending is tried again: a fix may leave room for the next.
const MAX_PASSES: usize = 10;

/// Arguments of `lint`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  cargo xtask lint                        look at all that uavspec.toml names
  cargo xtask lint --preset strict --deny note
  cargo xtask lint --fix                  mend what can be mended without a doubt
  cargo xtask lint --package px4 --dialect px4 --input msg --format sarif > lint.sarif

Exit status: 0 nothing of level error (or of the level that --deny names), 1 some, 2 it can't be carried out.")]
pub struct LintArgs {
    /// The configuration file, where it is not found by itself.
    #[arg(long, value_name = "FILE", conflicts_with = "package")]
    config: Option<PathBuf>,
    #[command(flatten)]
    package: Option<PackageArgs>,
    /// The set of rules, instead of that in uavspec.toml; px4, where none is chosen.
    #[arg(long)]
    preset: Option<PresetName>,
    /// Mend all that can be mended without a doubt, and report what is left.
    #[arg(long)]
    fix: bool,
    /// The least level that makes the command fail.
    #[arg(long, value_name = "LEVEL", default_value = "error")]
    deny: DenyLevel,
    /// How to report.
    #[arg(long, default_value = "text")]
    format: FormatName,
    /// List all rules with their levels, and look at nothing.
    #[arg(long)]
    rules: bool,
}

/// A level.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub(super) enum DenyLevel {
    /// Anything.
    Note,
    /// Warnings and errors.
    Warning,
    /// Errors.
    Error,
}

impl From<DenyLevel> for Level {
    fn from(level: DenyLevel) -> Self {
        match level {
            DenyLevel::Note => Self::Note,
            DenyLevel::Warning => Self::Warning,
            DenyLevel::Error => Self::Error,
        }
    }
}

/// A format of reports.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub(super) enum FormatName {
    /// For people: each finding with its line.
    Text,
    /// A JSON list.
    Json,
    /// Annotations of a workflow on GitHub.
    Github,
    /// SARIF 2.1.0, for code scanning.
    Sarif,
    /// Results of tests as XML, for CI systems that show them.
    Junit,
}

impl FormatName {
    /// The format of the report; none for people.
    fn format(self) -> Option<Format> {
        match self {
            Self::Text => None,
            Self::Json => Some(Format::Json),
            Self::Github => Some(Format::Github),
            Self::Sarif => Some(Format::Sarif),
            Self::Junit => Some(Format::Junit),
        }
    }
}

pub(super) fn run(args: &LintArgs) -> Result<bool, Failure> {
    if args.rules {
        list_rules();
        return Ok(true);
    }
    let started = Instant::now();
    let plan = match &args.package {
        Some(package) => package.plan(Path::new(""), &[]),
        None => Config::find(args.config.as_deref())?.plan()?,
    };
    let mut loaded = load::load(&plan)?;
    let mut findings = judge(&plan, &loaded, args.preset);
    let mut mended = 0;
    if args.fix {
        for _ in 0..MAX_PASSES {
            let texts = apply(&findings, &loaded.sources);
            if texts.is_empty() {
                break;
            }
            mended += findings.iter().filter(|finding| !finding.fix.is_empty()).count();
            for (source, text) in &texts {
                // The configuration file is the user's own.
                let Some(path) = loaded.paths.get(source) else { continue };
                replace(path, text)?;
            }
            loaded = load::load(&plan)?;
            findings = judge(&plan, &loaded, args.preset);
        }
    }
    let summary = summary("lint", &findings, &loaded, started);
    let fixes = match (mended, findings.iter().filter(|finding| !finding.fix.is_empty()).count()) {
        (0, 0) => String::new(),
        (0, count) => format!("; `--fix` mends {count}"),
        (count, _) => format!("; {count} mended"),
    };
    let rules = RULES.iter().filter_map(|rule| {
        let level = settings(&plan, &loaded, args.preset).level(rule)?;
        Some(RuleInfo { id: rule.id, purpose: rule.purpose, level })
    });
    print("lint", rules.collect(), &findings, &loaded, args.format);
    anstream::eprintln!("{summary}{fixes}");
    Ok(!findings.iter().any(|finding| finding.level >= args.deny.into()))
}

fn list_rules() {
    let level = |level: Option<Level>| level.map_or("-", Level::name);
    anstream::println!("{:<32} {:<8} {:<8}", "rule", "px4", "strict");
    for rule in RULES {
        anstream::println!("{:<32} {:<8} {:<8}", rule.id, level(rule.levels.px4), level(rule.levels.strict));
    }
}

fn settings(plan: &Plan, loaded: &Loaded, preset: Option<PresetName>) -> Settings {
    let ignores = plan.lint.ignores.iter().map(|ignore| Ignore {
        rule: ignore.rule.clone(),
        sources: ignore.files.as_ref().map(|files| {
            let matching = loaded.paths.iter().filter(|(_, path)| files.is_match(path));
            matching.map(|(source, _)| *source).collect::<BTreeSet<SourceId>>()
        }),
        reason: ignore.reason.clone(),
        span: loaded.config.unwrap_or_default().part(ignore.range.clone()),
    });
    Settings {
        preset: preset.or(plan.lint.preset).map_or_else(Preset::default, Preset::from),
        levels: plan.lint.levels.clone(),
        ignores: ignores.collect(),
    }
}

fn judge(plan: &Plan, loaded: &Loaded, preset: Option<PresetName>) -> Vec<Finding> {
    let mut findings: Vec<Finding> = loaded.diagnostics.iter().map(Finding::from).collect();
    findings.extend(lint(&loaded.sources, &loaded.packages, &settings(plan, loaded, preset)));
    findings
}

/// Prints findings: those in text to standard error, as all commands do, others to standard output.
pub(super) fn print(
    command: &'static str,
    rules: Vec<RuleInfo>,
    findings: &[Finding],
    loaded: &Loaded,
    format: FormatName,
) {
    let sources = &loaded.sources;
    let Some(format) = format.format() else {
        let _ = write!(anstream::stderr(), "{}", render::findings(findings, sources, true));
        return;
    };
    let entries = findings.iter().map(|finding| Entry::of(finding, sources)).collect();
    let text = Report { command, rules, entries }.to_text(format);
    // A reader that has seen enough closes the pipe: that is no failure.
    let _ = std::io::stdout().write_all(text.as_bytes());
}

/// How many findings of each level there are.
pub(super) fn summary(command: &str, findings: &[Finding], loaded: &Loaded, started: Instant) -> String {
    let count = |level| findings.iter().filter(|finding| finding.level == level).count();
    let counts: Vec<String> = Level::ALL
        .into_iter()
        .rev()
        .filter(|level| count(*level) > 0)
        .map(|level| plural(count(level), level.name()))
        .collect();
    let counts = if counts.is_empty() { "nothing found".to_owned() } else { counts.join(", ") };
    let elapsed = started.elapsed().as_millis();
    format!("{command}: {} read: {counts} ({elapsed} ms)", plural(loaded.files.len(), "file"))
}

/// Replaces a file as a whole, or leaves it as it is.
fn replace(path: &Path, text: &str) -> Result<(), Failure> {
    let unwritable = |error: std::io::Error| Failure::new(format!("{}: {error}", path.display()));
    // Behind a link stands the file that is meant.
    let path = fs::canonicalize(path).map_err(unwritable)?;
    let folder = path.parent().unwrap_or(Path::new("."));
    let mut file = tempfile::NamedTempFile::new_in(folder).map_err(unwritable)?;
    file.write_all(text.as_bytes()).map_err(unwritable)?;
    let permissions = fs::metadata(&path).map_err(unwritable)?.permissions();
    file.as_file().set_permissions(permissions).map_err(unwritable)?;
    file.persist(&path).map_err(|error| unwritable(error.error))?;
    Ok(())
}
