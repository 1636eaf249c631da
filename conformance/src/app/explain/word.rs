//! Explains words based on the definitions of all releases.

use uavspec_report::explain::{Unknown, explain, to_text};
use uavspec_rules::definitions::{Library, ReleaseId};
use uavspec_schema::json_text;

use crate::app::report::print_result;
use crate::app::{Exit, Format, Status};

/// Explains a word, based on all releases or on a single one. Prints errors.
pub(super) fn explain_word(word: &str, release: Option<&str>, format: Format) -> Exit {
    let library = Library::built_in();
    let release = release.map(|label| find(&library, label)).transpose();
    let explanation = release.and_then(|release| explain(&library, word, release));
    let explanation =
        explanation.map_err(|Unknown { problem, help }| Status::Usage.with_help(problem, &help))?;
    let text = match format {
        Format::Text => to_text(&explanation),
        Format::Json => json_text::pretty(&explanation),
    };
    print_result(&text)
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
