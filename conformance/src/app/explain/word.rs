//! Explains words by the definitions of all releases.

use std::path::PathBuf;

use uavspec_codegen::json_text;

use crate::app::report::print;
use crate::app::{Format, Status};
use crate::definitions::{Library, ReleaseId};
use crate::explain::{Unknown, explain, to_text};
use crate::text::terminal;

/// Explains words. Words that are unknown are errors, which are printed after the other answers.
pub(super) fn explain_words(words: &[PathBuf], release: Option<&str>, format: Format) -> Status {
    let library = Library::built_in();
    let release = match release.map(|label| find(&library, label)).transpose() {
        Ok(release) => release,
        Err(unknown) => return fail(&unknown),
    };
    let (mut explanations, mut unknown) = (Vec::new(), Vec::new());
    for word in words {
        match explain(&library, &word.to_string_lossy(), release) {
            Ok(explanation) => explanations.push(explanation),
            Err(problem) => unknown.push(problem),
        }
    }
    let text = match format {
        Format::Text => explanations.iter().map(to_text).collect::<Vec<_>>().join("\n"),
        Format::Json => json_text::pretty(&explanations),
    };
    if let Err(error) = print(&text) {
        terminal::error(format_args!("standard output: {error}"), None);
        return Status::Unreadable;
    }
    unknown.iter().map(fail).max().unwrap_or(Status::Conforms)
}

/// Prints an error.
fn fail(unknown: &Unknown) -> Status {
    terminal::error(&unknown.problem, Some(&unknown.help));
    Status::Usage
}

/// The release with a name such as `px4@1.16`.
fn find(library: &Library, label: &str) -> Result<ReleaseId, Unknown> {
    let index = library.index();
    index.find(label).ok_or_else(|| {
        let known: Vec<String> = index.releases().map(|release| index.label(release)).collect();
        Unknown {
            problem: format!("--release {label}: unknown release"),
            help: format!("the releases are {}", known.join(", ")),
        }
    })
}
