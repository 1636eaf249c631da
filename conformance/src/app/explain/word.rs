//! Explains words by the definitions of all releases.

use uavspec_model::text::terminal;
use uavspec_report::explain::{Unknown, explain, to_text};
use uavspec_rules::definitions::{Library, ReleaseId};
use uavspec_schema::json_text;

use crate::app::report::print_result;
use crate::app::{Format, Status};

/// Explains a word, by all releases or by one. Errors are printed.
pub(super) fn explain_word(word: &str, release: Option<&str>, format: Format) -> Status {
    let library = Library::built_in();
    let release = match release.map(|label| find(&library, label)).transpose() {
        Ok(release) => release,
        Err(unknown) => return fail(&unknown),
    };
    let explanation = match explain(&library, word, release) {
        Ok(explanation) => explanation,
        Err(unknown) => return fail(&unknown),
    };
    let text = match format {
        Format::Text => to_text(&explanation),
        Format::Json => json_text::pretty(&explanation),
    };
    print_result(&text).err().unwrap_or(Status::Conforms)
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
