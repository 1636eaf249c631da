//! `breaking`: what changed since an earlier state, and whom it breaks.

use std::path::{Path, PathBuf};
use std::thread;
use std::time::Instant;

use clap::{Args, ValueEnum};

use super::arguments::{DefinitionsArgs, PackageArgs};
use super::print::plural;
use super::report::ReportArgs;
use super::revision::Checkout;
use crate::breaking::{Between, Category, RULES, breaking};
use crate::diagnostic::{Diagnostic, Level, has_errors};
use crate::failure::Failure;
use crate::finding::Finding;
use crate::load::{Config, Inputs, Plan};
use crate::load::{load, load_beside};
use crate::read::read;
use crate::render;
use crate::report::RuleInfo;

/// Arguments of `breaking`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  cargo xtask breaking --against main               what this branch changes
  cargo xtask breaking --against v1.15 --between releases
  cargo xtask breaking --against ../earlier/msg     compare with a folder
  cargo xtask breaking --package px4 --dialect px4 --input new/msg --against old/msg --format json

Categories: source (names and types in programs), json, cdr (DDS, ROS 2), uorb (memory, logs), version (PX4's
rule on MESSAGE_VERSION), semantic (units, frames, ranges, values of constants, error codes).

Exit status: 0 nothing of level error (or of the level that --deny names), 1 some, 2 it can't be carried out.")]
pub struct BreakingArgs {
    /// The earlier state: a folder, or a revision of the Git repository.
    #[arg(long, value_name = "REV | DIR")]
    against: String,
    /// Between which states: a change raises the version of its message by one; between releases it may be more.
    #[arg(long, default_value = "commits")]
    between: BetweenName,
    #[command(flatten)]
    definitions: DefinitionsArgs,
    #[command(flatten)]
    report: ReportArgs,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum BetweenName {
    /// Two commits, such as a branch and what it started from.
    Commits,
    /// Two releases.
    Releases,
}

impl From<BetweenName> for Between {
    fn from(name: BetweenName) -> Self {
        match name {
            BetweenName::Commits => Self::Commits,
            BetweenName::Releases => Self::Releases,
        }
    }
}

pub(super) fn run(args: &BreakingArgs) -> Result<bool, Failure> {
    let started = Instant::now();
    let new_plan = args.definitions.plan()?;
    // The files of a revision are there until both states are read.
    let (old_plan, _checkout) = old_plan(args, &new_plan)?;
    let mut old = load(&old_plan)?;
    let sources = std::mem::take(&mut old.sources);
    let new = load_beside(&new_plan, sources)?;
    let sources = &new.sources;
    let ((old_schema, mut old_diagnostics), (new_schema, mut new_diagnostics)) = thread::scope(|scope| {
        let old = scope.spawn(|| read(sources, &old.packages));
        let new = read(sources, &new.packages);
        // A panic in a thread is a defect here, and goes on in the caller.
        (old.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)), new)
    });
    old_diagnostics.append(&mut old.diagnostics);
    new_diagnostics.extend(new.diagnostics.iter().cloned());
    if has_errors(&old_diagnostics) {
        let shown = render::render(&errors(old_diagnostics), &new.sources, false);
        return Err(Failure::new(format!("the earlier definitions have mistakes\n{shown}")));
    }
    let findings = if has_errors(&new_diagnostics) {
        errors(new_diagnostics).iter().map(Finding::from).collect()
    } else {
        breaking(&new.sources, &old_schema, &new_schema, args.between.into())
    };
    let rules = RULES.iter().map(|rule| {
        let level = rule.breaks.iter().map(|(_, level)| *level).max().unwrap_or(Level::Note);
        RuleInfo::new(rule.id, rule.purpose(), level)
    });
    let is_fine = args.report.show("breaking", rules.collect(), &findings, &new.sources);
    let files = plural(new.files.len(), "file");
    let elapsed = started.elapsed().as_millis();
    anstream::eprintln!(
        "breaking: {files} compared with {}: {} ({elapsed} ms)",
        old.files.len(),
        summary(&findings)
    );
    Ok(is_fine)
}

/// How to read the earlier state, and its files where they had to be taken out of the repository.
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
    // The revision's own configuration says what there was then; before there was one, today's has to do.
    let config = match place.parent() {
        Some(folder) if !place.is_file() => config.moved_to(folder.to_path_buf()),
        _ => Config::read(&place)?,
    };
    let root = checkout.folder().to_path_buf();
    Ok((Plan { root, revision, ..config.plan()? }, Some(checkout)))
}

/// A folder with a configuration file of its own, or with nothing but the definitions of one package.
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
        let message = format!("{} has no uavspec.toml, and there are several packages", folder.display());
        let names: Vec<&str> = new.packages.iter().map(|package| package.name.as_str()).collect();
        return Err(Failure::new(message).with_hint(format!(
            "compare one at a time with --package, --dialect and --input ({}), or put a uavspec.toml there",
            names.join(", ")
        )));
    }
    for package in &mut plan.packages {
        package.inputs = Inputs::Paths(vec![folder.to_path_buf()]);
    }
    Ok(Plan { root: PathBuf::new(), config: None, ..plan })
}

/// How many changes there are, and how many of them break each category.
fn summary(findings: &[Finding]) -> String {
    let is_one = |left: &Finding, right: &Finding| {
        (left.rule, left.span, &left.message) == (right.rule, right.span, &right.message)
    };
    let changes = findings.chunk_by(is_one).count();
    if changes == 0 {
        return "nothing changed that anybody would notice".to_owned();
    }
    let broken = |category: Category| {
        let is_broken =
            |finding: &&Finding| finding.category == Some(category.name()) && finding.level > Level::Note;
        let count = findings.iter().filter(is_broken).count();
        (count > 0).then(|| format!("{} {count}", category.name()))
    };
    let broken: Vec<String> = Category::ALL.into_iter().filter_map(broken).collect();
    let broken =
        if broken.is_empty() { "break nobody".to_owned() } else { format!("break {}", broken.join(", ")) };
    format!("{}; they {broken}", plural(changes, "change"))
}

fn errors(mut diagnostics: Vec<Diagnostic>) -> Vec<Diagnostic> {
    diagnostics.retain(|diagnostic| diagnostic.level() == Level::Error);
    diagnostics
}
