//! Prints the story of a capture.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use uavspec_codegen::emit::docs::markdown::plural;
use uavspec_codegen::load::read_definitions_translated;
use uavspec_codegen::translation::Translations;

use super::ExplainArgs;
use crate::app::outputs::{self, Inputs, Output};
use crate::app::progress::Progress;
use crate::app::report::{print, write_file};
use crate::app::{Format, Status};
use crate::model::Extent;
use crate::report::story::{to_html, to_json, to_text};
use crate::story::{Story, Texts, TopicStatus};
use crate::text::terminal;

/// The language of the definitions.
const ENGLISH: &str = "en";

/// The file for the page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Page(PathBuf);

impl FromStr for Page {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once('=') {
            Some(("html", path)) if !path.is_empty() => Ok(Self(path.into())),
            _ => Err("expected html=FILE, such as html=story.html".to_owned()),
        }
    }
}

/// Prints the story of a capture. Errors are printed.
pub(super) fn story(path: &Path, args: &ExplainArgs) -> Result<Status, Status> {
    let library = crate::app::library(args.definitions.as_deref(), None, &[])?;
    let texts = texts(args.definitions.as_deref())?;
    let language = language(args.language.as_deref(), &texts.languages())?;
    check_outputs(path, args)?;
    let progress = Progress::bytes(std::fs::metadata(path).map_or(0, |metadata| metadata.len()));
    let story = Story::read(path, &library, texts, &|input| progress.reading(input));
    drop(progress);
    let unreadable = |error: &str| {
        terminal::error(format_args!("{}: {error}", terminal::path(path)), None);
        Status::Unreadable
    };
    let story =
        story.map_err(|error| unreadable(&error.to_string()))?.map_err(|reason| unreadable(&reason))?;
    write(args, &story, &language)?;
    Ok(status(&story))
}

/// The exit status of a story.
fn status(story: &Story) -> Status {
    if story.extent != Extent::Whole {
        let count = plural(story.corruption.len() as u64, "part");
        terminal::error(format_args!("incomplete: {count} of the capture can't be read"), None);
        return Status::Incomplete;
    }
    if story.lanes.is_empty() {
        let undefined: Vec<&str> = story.topics(TopicStatus::Undefined).collect();
        let help = match (undefined.as_slice(), story.unreadable_messages) {
            ([], 0) => "the capture contains no topics of the story".to_owned(),
            ([], count) => format!(
                "{} can't be read or violate a rule: `uavspec check` names the reasons",
                plural(count, "message")
            ),
            _ => format!("name the definitions of {} with --definitions", undefined.join(", ")),
        };
        terminal::error("nothing to explain", Some(&help));
        return Status::Nothing;
    }
    Status::Conforms
}

/// Prints the story, and writes the page. Errors are printed.
fn write(args: &ExplainArgs, story: &Story, language: &str) -> Result<(), Status> {
    let text = match args.format {
        Format::Text => Ok(to_text(story, language)),
        Format::Json => to_json(story).map_err(std::io::Error::from),
    };
    let printed = text.and_then(|text| print(&text)).map_err(|error| format!("standard output: {error}"));
    let written = args.report.as_ref().map_or(Ok(()), |Page(path)| {
        let page = to_html(story, language, &crate::app::command());
        write_file(path, |file| file.write_all(page.as_bytes()))
            .map_err(|error| format!("{}: can't write the report: {error}", terminal::path(path)))
    });
    let failures = [printed, written].into_iter().filter_map(Result::err);
    let failures = failures.inspect(|failure| terminal::error(failure, None)).count();
    if failures == 0 { Ok(()) } else { Err(Status::Unreadable) }
}

/// Checks that the page doesn't replace an input. Errors are printed.
fn check_outputs(path: &Path, args: &ExplainArgs) -> Result<(), Status> {
    let inputs = Inputs { files: vec![path], definitions: args.definitions.as_deref(), ..Inputs::default() };
    let outputs: Vec<Output<'_>> =
        args.report.iter().map(|Page(path)| Output::new("--report html", path)).collect();
    outputs::check(&inputs, &outputs)
}

/// The texts of the definitions at a path, or of the built-in definitions. Errors are printed.
fn texts(path: Option<&Path>) -> Result<Texts, Status> {
    // A release has no translations.
    let Some(path) = path.filter(|path| path.exists()) else { return Ok(Texts::of(Translations::default())) };
    match read_definitions_translated(path) {
        Ok((_, _, translations)) => Ok(Texts::of(translations)),
        Err(failure) => {
            terminal::eprintln!("{failure}");
            Err(Status::Usage)
        }
    }
}

/// The tag of the labels' language. Errors are printed.
fn language(wanted: Option<&str>, languages: &BTreeMap<String, String>) -> Result<String, Status> {
    let wanted = wanted.unwrap_or(ENGLISH);
    let known = std::iter::once(ENGLISH).chain(languages.keys().map(String::as_str));
    if let Some(tag) = known.clone().find(|tag| tag.eq_ignore_ascii_case(wanted)) {
        return Ok(tag.to_owned());
    }
    let help = format!("expected one of {}", known.collect::<Vec<_>>().join(", "));
    terminal::error(format_args!("--language {}: no such language", terminal::shown(wanted)), Some(&help));
    Err(Status::Usage)
}
