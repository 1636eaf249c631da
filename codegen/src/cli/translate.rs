//! The `translate` command, which updates translation catalogues.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use clap::Args;
use uavspec_schema::diagnostic::Level;
use uavspec_schema::failure::Failure;
use uavspec_schema::path::normalise;
use uavspec_schema::rewrite::{self, Change};
use uavspec_schema::source::stem;
use uavspec_schema::translation::catalogue::{Catalogue, parse, print};
use uavspec_schema::translation::{self, SOURCE_LANGUAGE, Text, is_tag, new_catalogue, update};
use uavspec_schema::wording::{plural, similar};
use uavspec_schema::{Schema, terminal};

use super::print::report;
use super::stopwatch::Stopwatch;
use crate::load::{Config, Loaded, Plan, literal_base, read_translated};

/// Arguments of `translate`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  cargo xtask translate              update all catalogues
  cargo xtask translate --check      write nothing; fail if outdated
  cargo xtask translate uk           create a Ukrainian catalogue
  cargo xtask translate uk --select px4/FailsafeFlags,flockwave/error-codes

A catalogue is a gettext PO file, named after its language. The key `translations.include` in uavspec.toml lists the \
catalogues. Untranslated texts get an empty entry. If a text has changed, its entry is marked as fuzzy and keeps the \
previous text. Entries of removed texts become obsolete.")]
pub struct TranslateArgs {
    /// Languages to update or create, as BCP 47 tags [default: all catalogues]
    #[arg(value_name = "LANGUAGE")]
    languages: Vec<String>,
    /// Texts to add, such as px4/FailsafeFlags, flockwave/error-codes or px4
    ///
    /// A new catalogue contains all texts by default.
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    select: Vec<String>,
    /// Write nothing; list outdated catalogues and fail if there are any
    #[arg(long)]
    check: bool,
    /// Configuration file [default: nearest uavspec.toml]
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
}

pub(super) fn run(args: &TranslateArgs) -> Result<bool, Failure> {
    let started = Stopwatch::start();
    let plan = Config::find(args.config.as_deref())?.plan()?;
    let (loaded, schema, _, mut diagnostics) = read_translated(&plan)?;
    // This command updates catalogues, so warnings about them are not reported.
    diagnostics.retain(|diagnostic| diagnostic.level() == Level::Error);
    report("translate", &loaded, &diagnostics, "nothing written");
    if !diagnostics.is_empty() {
        return Ok(false);
    }
    let outcomes = outcomes(args, &plan, &loaded, &schema)?;
    if !args.check {
        write(&outcomes)?;
    }
    let mut succeeded = true;
    for outcome in &outcomes {
        succeeded &= !args.check || !outcome.is_changed();
        terminal::eprintln!("{}: {}", outcome.shown, outcome.summary(args.check));
    }
    let read = plural(loaded.files.len(), "file");
    let advice = if succeeded { "" } else { "; run `translate`" };
    let elapsed = started.milliseconds();
    terminal::eprintln!(
        "translate: {read} read, {}{advice} ({elapsed} ms)",
        plural(outcomes.len(), "catalogue")
    );
    Ok(succeeded)
}

/// A catalogue before and after the update.
struct Outcome {
    path: PathBuf,
    shown: String,
    /// The text and the entries of the file, or `None` for a new catalogue.
    old: Option<(String, Catalogue)>,
    new: Catalogue,
}

impl Outcome {
    /// True if the entries differ. Changes that only rewrap lines are ignored.
    fn is_changed(&self) -> bool {
        self.old.as_ref().is_none_or(|(_, old)| *old != self.new)
    }

    fn summary(&self, is_check: bool) -> String {
        let entries = || self.new.entries.iter().filter(|entry| !entry.is_header());
        let active = || entries().filter(|entry| !entry.is_obsolete);
        let untranslated = active().filter(|entry| !entry.is_translated()).count();
        let fuzzy = active().filter(|entry| entry.is_translated() && entry.is_fuzzy()).count();
        let all = active().count();
        let state = match (self.is_changed(), is_check) {
            (false, _) => "up to date",
            (true, true) => "outdated",
            (true, false) => "updated",
        };
        let counts = [
            (all - untranslated - fuzzy, "translated"),
            (fuzzy, "fuzzy"),
            (untranslated, "untranslated"),
            (entries().count() - all, "obsolete"),
        ];
        let counts: Vec<String> = counts
            .into_iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("{count} {what}"))
            .collect();
        if counts.is_empty() { state.to_owned() } else { format!("{state}, {}", counts.join(", ")) }
    }
}

fn outcomes(
    args: &TranslateArgs,
    plan: &Plan,
    loaded: &Loaded,
    schema: &Schema,
) -> Result<Vec<Outcome>, Failure> {
    let texts = translation::texts(schema);
    let select = selected(&args.select, &texts)?;
    let sources = &loaded.sources;
    let is_named = |tag: &str| args.languages.iter().any(|language| language.eq_ignore_ascii_case(tag));
    let mut outcomes = Vec::new();
    for id in &loaded.catalogues {
        let Some(path) = loaded.paths.get(id) else { continue };
        if !args.languages.is_empty() && !is_named(stem(sources.path(*id))) {
            continue;
        }
        let (catalogue, _, _) = parse(sources, *id);
        outcomes.push(Outcome {
            path: path.clone(),
            shown: sources.path(*id).to_owned(),
            new: update(&catalogue, sources, &texts, &select),
            old: Some((sources.text(*id).to_owned(), catalogue)),
        });
    }
    let exists =
        |tag: &str| loaded.catalogues.iter().any(|id| stem(sources.path(*id)).eq_ignore_ascii_case(tag));
    for tag in args.languages.iter().map(String::as_str).collect::<BTreeSet<_>>() {
        if !exists(tag) {
            let all = || texts.iter().map(|text| text.unit.clone()).collect();
            let select = if args.select.is_empty() { all() } else { select.clone() };
            let path = path_of(tag, plan)?;
            let shown = terminal::path(&path);
            outcomes.push(Outcome {
                path,
                shown,
                old: None,
                new: update(&new_catalogue(tag), sources, &texts, &select),
            });
        }
    }
    if outcomes.is_empty() {
        return Err(
            Failure::new("no catalogue exists").with_hint("give a language to create one: `translate uk`")
        );
    }
    Ok(outcomes)
}

/// The units selected with `--select`. A package name selects all units of the package.
fn selected(names: &[String], texts: &[Text<'_>]) -> Result<BTreeSet<String>, Failure> {
    let units: BTreeSet<&str> = texts.iter().map(|text| text.unit.as_str()).collect();
    let mut selected = BTreeSet::new();
    for name in names {
        let is_selected = |unit: &&&str| {
            *unit == name || unit.strip_prefix(name.as_str()).is_some_and(|rest| rest.starts_with('/'))
        };
        let mut matching = units.iter().filter(is_selected).map(|unit| (*unit).to_owned()).peekable();
        if matching.peek().is_none() {
            let hint = similar(name, units.iter().copied()).map_or_else(
                || "write, for example, `px4/FailsafeFlags`, `flockwave/error-codes` or `px4`".to_owned(),
                |unit| format!("did you mean `{unit}`?"),
            );
            return Err(Failure::new(format!("`{name}` does not match any message, error codes or package"))
                .with_hint(hint));
        }
        selected.extend(matching);
    }
    Ok(selected)
}

/// The path of a new catalogue, derived from the first pattern in the configuration.
fn path_of(tag: &str, plan: &Plan) -> Result<PathBuf, Failure> {
    if !is_tag(tag) || tag == SOURCE_LANGUAGE {
        return Err(Failure::new(format!("`{tag}` is not a valid language tag for a translation"))
            .with_hint(
                "write a BCP 47 tag such as `uk` or `pt-BR`, but not `en`: the definitions are in English",
            ));
    }
    let (folder, patterns) = &plan.catalogues;
    let Some(pattern) = patterns.first() else {
        return Err(Failure::new("uavspec.toml has no `translations.include`")
            .with_hint("add `[translations]` with `include = [\"i18n/*.po\"]`"));
    };
    let (base, rest) = literal_base(pattern);
    if !matches!(rest.as_str(), "*.po" | "**/*.po") {
        return Err(Failure::new(format!(
            "cannot derive the path of the catalogue for `{tag}` from the pattern `{pattern}`"
        ))
        .with_hint("start `translations.include` with \"i18n/*.po\" or a similar pattern"));
    }
    Ok(normalise(&folder.join(base)).join(format!("{tag}.po")))
}

/// Updates all outdated catalogues atomically, then creates the new catalogues.
fn write(outcomes: &[Outcome]) -> Result<(), Failure> {
    let outdated = || outcomes.iter().filter(|outcome| outcome.is_changed());
    let mut changes = Vec::new();
    for outcome in outdated() {
        let Some((old, _)) = &outcome.old else { continue };
        // Write to the target of a symbolic link.
        let path = fs::canonicalize(&outcome.path).map_err(|error| unwritable(&outcome.path, &error))?;
        let (shown, old, new) = (outcome.shown.clone(), old.clone(), print(&outcome.new));
        changes.push(Change { path, shown, old, new });
    }
    rewrite::write(&changes)?;
    for outcome in outdated().filter(|outcome| outcome.old.is_none()) {
        create(&outcome.path, &print(&outcome.new)).map_err(|error| unwritable(&outcome.path, &error))?;
    }
    Ok(())
}

fn create(path: &Path, text: &str) -> io::Result<()> {
    fs::create_dir_all(path.parent().unwrap_or(Path::new("")))?;
    // Don't overwrite a file that was not read.
    File::create_new(path)?.write_all(text.as_bytes())
}

fn unwritable(path: &Path, error: &io::Error) -> Failure {
    Failure::new(format!("{}: {error}", terminal::path(path)))
        .with_hint("check that the folder is writable and contains no other file with this name")
}
