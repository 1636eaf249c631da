//! `translate`: catalogues of translations, brought up to date with the definitions.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;

use super::print::{plural, report};
use crate::diagnostic::Level;
use crate::failure::Failure;
use crate::load::read_translated;
use crate::load::{Config, Plan};
use crate::load::{Loaded, literal_base};
use crate::path::normalise;
use crate::rewrite::{self, Change};
use crate::schema::Schema;
use crate::source::stem;
use crate::translation::catalogue::{Catalogue, parse, print};
use crate::translation::{self, SOURCE_LANGUAGE, Text, is_tag, new_catalogue, update};

/// Arguments of `translate`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  cargo xtask translate                   bring all catalogues up to date with the definitions
  cargo xtask translate --check           write nothing; fail where one is not
  cargo xtask translate uk                begin to translate everything into Ukrainian
  cargo xtask translate uk --select px4/FailsafeFlags,flockwave/error-codes

A catalogue is a file of gettext's PO form, which is called after its language; uavspec.toml names them under
`translations.include`. What has no translation yet gets an entry with an empty one. Where the text has changed, the entry
is marked as fuzzy and keeps the text that was translated. What is gone from the definitions is kept as obsolete.")]
pub struct TranslateArgs {
    /// The language of a catalogue as BCP 47 writes it, which is begun where there is none; all that there are, where
    /// absent.
    #[arg(value_name = "LANGUAGE")]
    languages: Vec<String>,
    /// What is to be translated, beside what has been begun: messages, services (`harbour/Tow.srv`), actions, the error
    /// codes of a package (`flockwave/error-codes`), or whole packages. Of a catalogue that is begun all, where absent.
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    select: Vec<String>,
    /// Write nothing; list what is not up to date and fail if anything is not.
    #[arg(long)]
    check: bool,
    /// The configuration file, where it is not found by itself.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
}

pub(super) fn run(args: &TranslateArgs) -> Result<bool, Failure> {
    let started = Instant::now();
    let plan = Config::find(args.config.as_deref())?.plan()?;
    let (loaded, schema, _, mut diagnostics) = read_translated(&plan)?;
    // Whatever else there is to be said of catalogues is what this command is for.
    diagnostics.retain(|diagnostic| diagnostic.level() == Level::Error);
    report("translate", &loaded, &diagnostics, "nothing written");
    if !diagnostics.is_empty() {
        return Ok(false);
    }
    let outcomes = outcomes(args, &plan, &loaded, &schema)?;
    if !args.check {
        write(&outcomes)?;
    }
    let mut is_fine = true;
    for outcome in &outcomes {
        is_fine &= !args.check || !outcome.is_changed();
        anstream::eprintln!("{}: {}", outcome.shown, outcome.summary(args.check));
    }
    let read = plural(loaded.files.len(), "file");
    let advice = if is_fine { "" } else { "; run `cargo xtask translate`" };
    let elapsed = started.elapsed().as_millis();
    anstream::eprintln!(
        "translate: {read} read, {}{advice} ({elapsed} ms)",
        plural(outcomes.len(), "catalogue")
    );
    Ok(is_fine)
}

/// A catalogue, and what becomes of it.
struct Outcome {
    path: PathBuf,
    shown: String,
    /// What the file holds, as text and as entries; none, where it isn't there yet.
    old: Option<(String, Catalogue)>,
    new: Catalogue,
}

impl Outcome {
    /// Whether the entries differ: lines that a tool has broken otherwise are let stand.
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
            (true, true) => "not up to date",
            (true, false) => "brought up to date",
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
    let is_there =
        |tag: &str| loaded.catalogues.iter().any(|id| stem(sources.path(*id)).eq_ignore_ascii_case(tag));
    for tag in args.languages.iter().collect::<BTreeSet<_>>() {
        if !is_there(tag) {
            let all = || texts.iter().map(|text| text.unit.clone()).collect();
            let select = if args.select.is_empty() { all() } else { select.clone() };
            let path = path_of(tag, plan)?;
            let shown = path.display().to_string();
            outcomes.push(Outcome {
                path,
                shown,
                old: None,
                new: update(&new_catalogue(tag), sources, &texts, &select),
            });
        }
    }
    if outcomes.is_empty() {
        return Err(Failure::new("there is no catalogue yet")
            .with_hint("name a language to begin one: `cargo xtask translate uk`"));
    }
    Ok(outcomes)
}

/// What `--select` names: units, and all units of packages.
fn selected(names: &[String], texts: &[Text<'_>]) -> Result<BTreeSet<String>, Failure> {
    let units: BTreeSet<&str> = texts.iter().map(|text| text.unit.as_str()).collect();
    let mut selected = BTreeSet::new();
    for name in names {
        let is_meant = |unit: &&&str| {
            *unit == name || unit.strip_prefix(name.as_str()).is_some_and(|rest| rest.starts_with('/'))
        };
        let mut meant = units.iter().filter(is_meant).map(|unit| (*unit).to_owned()).peekable();
        if meant.peek().is_none() {
            // Names are short, and comparing takes the product of the lengths.
            let close = units
                .iter()
                .map(|unit| (strsim::damerau_levenshtein(unit, name), unit))
                .filter(|(distance, unit)| name.len() < 100 && *distance <= 1 + unit.len() / 5)
                .min();
            let hint = close.map_or_else(
                || "name a message as `px4/FailsafeFlags`, error codes as `flockwave/error-codes`, or a package".to_owned(),
                |(_, unit)| format!("did you mean `{unit}`?"),
            );
            return Err(Failure::new(format!("`{name}` names nothing that has texts")).with_hint(hint));
        }
        selected.extend(meant);
    }
    Ok(selected)
}

/// Where a new catalogue belongs: where the first pattern looks for it.
fn path_of(tag: &str, plan: &Plan) -> Result<PathBuf, Failure> {
    if !is_tag(tag) || tag == SOURCE_LANGUAGE {
        return Err(Failure::new(format!("`{tag}` is no tag of another language"))
            .with_hint("write it as BCP 47 does: `uk`, `pt-BR`; definitions are in English"));
    }
    let (folder, patterns) = &plan.catalogues;
    let Some(pattern) = patterns.first() else {
        return Err(Failure::new("uavspec.toml doesn't say where catalogues are")
            .with_hint("add `[translations]` with `include = [\"i18n/*.po\"]`"));
    };
    let (base, rest) = literal_base(pattern);
    if !matches!(rest.as_str(), "*.po" | "**/*.po") {
        return Err(Failure::new(format!(
            "the pattern `{pattern}` doesn't say where a catalogue for `{tag}` belongs"
        ))
        .with_hint("write a pattern such as \"i18n/*.po\" first"));
    }
    Ok(normalise(&folder.join(base)).join(format!("{tag}.po")))
}

/// Writes what has changed: all or nothing of those that are there, then the new ones.
fn write(outcomes: &[Outcome]) -> Result<(), Failure> {
    let wanted = || outcomes.iter().filter(|outcome| outcome.is_changed());
    let mut changes = Vec::new();
    for outcome in wanted() {
        let Some((old, _)) = &outcome.old else { continue };
        // Behind a link stands the file that is meant.
        let path = fs::canonicalize(&outcome.path).map_err(|error| unwritable(&outcome.path, &error))?;
        let (shown, old, new) = (outcome.shown.clone(), old.clone(), print(&outcome.new));
        changes.push(Change { path, shown, old, new });
    }
    rewrite::write(&changes)?;
    for outcome in wanted().filter(|outcome| outcome.old.is_none()) {
        create(&outcome.path, &print(&outcome.new)).map_err(|error| unwritable(&outcome.path, &error))?;
    }
    Ok(())
}

fn create(path: &Path, text: &str) -> io::Result<()> {
    fs::create_dir_all(path.parent().unwrap_or(Path::new("")))?;
    // What is there already is nothing that was read.
    File::create_new(path)?.write_all(text.as_bytes())
}

fn unwritable(path: &Path, error: &io::Error) -> Failure {
    Failure::new(format!("{}: {error}", path.display()))
        .with_hint("check that the folder can be written, and that no other file is there")
}
