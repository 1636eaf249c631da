//! The `breaking` command, which reports changes since an earlier version.

use std::path::{Path, PathBuf};
use std::thread;

use clap::Args;
use uavspec_dynamic::breaking::{Between, Category, RULES, Rule, breaking, rule};
use uavspec_lint::report::{RuleInfo, Totals};
use uavspec_schema::diagnostic::{Diagnostic, Level, has_errors};
use uavspec_schema::failure::Failure;
use uavspec_schema::finding::Finding;
use uavspec_schema::read::read;
use uavspec_schema::wording::plural;
use uavspec_schema::{render, terminal};

use super::arguments::{DefinitionsArgs, PackageArgs};
use super::baseline::{self, BaselineArgs, Subjects};
use super::report::{ReportArgs, Results, Selection, rule_ids};
use super::revision::Checkout;
use super::status::Status;
use super::stopwatch::Stopwatch;
use crate::load::{Config, Inputs, Plan, load, load_into};

/// Arguments of `breaking`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  cargo xtask breaking --against main
  cargo xtask breaking --against v1.15 --between releases
  cargo xtask breaking --against ../earlier/msg
  cargo xtask breaking --against v1.15 --summary
  cargo xtask breaking --against main --category cdr --category uorb
  cargo xtask breaking --package px4 --dialect px4 --input new --against old

Accept changes:
  cargo xtask breaking --against v1.15 --write-baseline baseline.toml
  cargo xtask breaking --against v1.15 --baseline baseline.toml

Categories:
  source      names and types in programs
  json        JSON messages
  cdr         DDS and ROS 2 messages
  uorb        uORB memory and logs
  version     PX4's rule for MESSAGE_VERSION
  semantic    units, frames, ranges, constant values and error codes

Exit status:
  0    no findings at the --deny level or above
  1    at least one finding at the --deny level or above
  2    the command failed
  4    no such finding, but a baseline is out of date")]
pub struct BreakingArgs {
    /// Compare with this Git revision or folder
    #[arg(long, value_name = "REV | DIR")]
    against: String,
    /// Kind of the two versions, which determines by how much message versions must increase
    #[arg(long, default_value = "commits")]
    between: Between,
    #[command(flatten)]
    definitions: DefinitionsArgs,
    /// Report only this kind of change (repeatable)
    #[arg(
        long,
        value_name = "ID",
        value_parser = rule_ids(RULES.iter().map(|rule| rule.id)),
        hide_possible_values = true,
        conflicts_with = "write_baseline"
    )]
    rule: Vec<String>,
    /// Report only changes that affect this category (repeatable)
    #[arg(
        long,
        value_name = "NAME",
        value_parser = rule_ids(Category::ALL.map(Category::name)),
        hide_possible_values = true,
        conflicts_with = "write_baseline"
    )]
    category: Vec<String>,
    #[command(flatten)]
    report: ReportArgs,
    #[command(flatten)]
    baseline: BaselineArgs,
}

pub(super) fn run(args: &BreakingArgs) -> Result<Status, Failure> {
    args.report.check()?;
    let started = Stopwatch::start();
    let new_plan = args.definitions.plan()?;
    // Keep the files of the old revision until both versions are read.
    let (old_plan, _checkout) = old_plan(args, &new_plan)?;
    let mut old = load(&old_plan)?;
    let sources = std::mem::take(&mut old.sources);
    let new = load_into(&new_plan, sources)?;
    let sources = &new.sources;
    let inputs = new
        .inputs(&new_plan)
        .chain(old.inputs(&old_plan))
        .chain(args.baseline.inputs())
        .chain(args.baseline.output());
    args.report.protect(inputs)?;
    let ((old_schema, mut old_diagnostics), (new_schema, mut new_diagnostics)) = thread::scope(|scope| {
        let old = scope.spawn(|| read(sources, &old.packages));
        let new = read(sources, &new.packages);
        // A panic in the thread is a bug; propagate it.
        (old.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)), new)
    });
    old_diagnostics.append(&mut old.diagnostics);
    new_diagnostics.extend(new.diagnostics.iter().cloned());
    if has_errors(&old_diagnostics) {
        let shown = render::render(&errors(old_diagnostics), &new.sources, false);
        return Err(Failure::new(format!("the earlier definitions contain errors\n{shown}")));
    }
    let has_errors = has_errors(&new_diagnostics);
    let mut findings = if has_errors {
        errors(new_diagnostics).iter().map(Finding::from).collect()
    } else {
        breaking(&new.sources, &old_schema, &new_schema, args.between)
    };
    let subjects = Subjects::new(sources, new.packages.iter().chain(&old.packages));
    let selection = args.selection();
    let is_applied = |id: &str| !has_errors && selection.has_rule(id) && rule(id).is_some();
    let (known, is_outdated) = baseline::compare(&args.baseline, &mut findings, subjects, &is_applied)?;
    let hidden = selection.apply(|id| rule(id).is_some(), sources, &mut findings);
    let totals = Totals { known, hidden, ..Totals::of("breaking", &findings, sources, new.files.len()) };
    let rules = RULES.iter().filter(|rule| selection.has_rule(rule.id)).map(|rule| rule_info(rule)).collect();
    args.report.show(&Results { rules, findings: &findings, totals: &totals }, &new.sources_from_here())?;
    let files = plural(new.files.len(), "file");
    let elapsed = started.milliseconds();
    terminal::eprintln!("breaking: {files} compared with {} ({elapsed} ms)", old.files.len());
    Ok(Status::new(args.report.is_success(&findings), is_outdated))
}

fn rule_info(rule: &Rule) -> RuleInfo {
    let level = rule.breaks.iter().map(|(_, level)| *level).max().unwrap_or(Level::Note);
    RuleInfo::new(rule.id, rule.purpose(), level)
}

impl BreakingArgs {
    fn selection(&self) -> Selection {
        let names = Category::ALL.map(Category::name).into_iter();
        let selected = names.filter(|name| self.category.iter().any(|selected| selected == name));
        Selection { rules: self.rule.clone(), categories: selected.collect(), ..Selection::default() }
    }
}

/// The plan for the earlier version, along with its checkout if that version is a Git revision.
fn old_plan(args: &BreakingArgs, new: &Plan) -> Result<(Plan, Option<Checkout>), Failure> {
    let against = Path::new(&args.against);
    if against.exists() {
        return plan_of_folder(args, new, against).map(|plan| (plan, None));
    }
    let revision = Some(args.against.clone());
    if let Some(package) = &args.definitions.package {
        let near = package.input.first().map_or(Path::new("."), PathBuf::as_path);
        let checkout = Checkout::of(&args.against, near, new)?;
        let places: Result<Vec<PathBuf>, Failure> =
            package.input.iter().map(|input| checkout.place_of(input)).collect();
        let moved = PackageArgs { input: places?, ..package.clone() };
        let root = checkout.folder().to_path_buf();
        let plan = Plan { root, revision, ..moved.plan(Path::new(""), &[]) };
        return Ok((plan, Some(checkout)));
    }
    let config = Config::find(args.definitions.config.as_deref())?;
    let checkout = Checkout::of(&args.against, config.file(), new)?;
    let place = checkout.place_of(config.file())?;
    // Use the revision's configuration file if it exists, otherwise the current one.
    let config = match place.parent() {
        Some(folder) if !place.is_file() => config.moved_to(folder.to_path_buf()),
        _ => Config::read(&place)?,
    };
    let root = checkout.folder().to_path_buf();
    Ok((Plan { root, revision, ..config.plan()? }, Some(checkout)))
}

/// The plan for a folder. The folder contains either a configuration file or the definitions of one package.
fn plan_of_folder(args: &BreakingArgs, new: &Plan, folder: &Path) -> Result<Plan, Failure> {
    if let Some(package) = &args.definitions.package {
        let of_folder = PackageArgs { input: vec![folder.to_path_buf()], ..package.clone() };
        return Ok(of_folder.plan(Path::new(""), &[]));
    }
    if let Some(file) = Config::in_folder(folder) {
        return Config::read(&file)?.plan();
    }
    let mut plan = args.definitions.plan()?;
    if plan.packages.len() > 1 {
        let message = format!(
            "{} contains no uavspec.toml, but several packages are configured",
            terminal::path(folder)
        );
        let names: Vec<&str> = new.packages.iter().map(|package| package.name.as_str()).collect();
        return Err(Failure::new(message).with_hint(format!(
            "add a uavspec.toml, or compare each package ({}) separately with --package, --dialect and \
                --input",
            names.join(", ")
        )));
    }
    for package in &mut plan.packages {
        package.inputs = Inputs::Paths(vec![folder.to_path_buf()]);
    }
    Ok(Plan { root: PathBuf::new(), config: None, ..plan })
}

fn errors(mut diagnostics: Vec<Diagnostic>) -> Vec<Diagnostic> {
    diagnostics.retain(|diagnostic| diagnostic.level() == Level::Error);
    diagnostics
}
