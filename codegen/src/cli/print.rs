//! Output to the terminal: results to standard output, messages to standard error.

use std::io;
use std::path::Path;

use uavspec_schema::diagnostic::{Diagnostic, Level};
use uavspec_schema::failure::Failure;
use uavspec_schema::identity::Identity;
use uavspec_schema::render;
use uavspec_schema::terminal;
use uavspec_schema::wording::plural;

use crate::load::Loaded;

/// Prints a text to standard output, with colours if enabled.
pub(super) fn print_results(render: impl FnOnce(bool) -> String) {
    let is_plain = anstream::AutoStream::choice(&io::stdout()) == anstream::ColorChoice::Never;
    terminal::print(format_args!("{}", render(!is_plain)));
}

/// Prints a machine-readable report, whose format escapes all text.
pub(super) fn print_report(text: &str) {
    terminal::print_unguarded(text);
}

/// Fails if standard output is redirected to an input.
pub(super) fn protect_inputs<'i>(mut inputs: impl Iterator<Item = &'i Path>) -> Result<(), Failure> {
    let Some(output) = Identity::standard_output() else { return Ok(()) };
    let changed = inputs.find(|input| Identity::of(input).is_some_and(|input| input.is_same(&output)));
    changed.map_or(Ok(()), |input| {
        let message = format!("standard output would overwrite the input {}", terminal::path(input));
        Err(Failure::new(message).with_hint("redirect standard output to another file"))
    })
}

/// Prints a text to standard error, with colours if enabled. `render` receives true if colours are enabled, because
/// removing colours from its text would take longer.
pub(super) fn print_rendered(render: impl FnOnce(bool) -> String) {
    let is_plain = anstream::AutoStream::choice(&io::stderr()) == anstream::ColorChoice::Never;
    terminal::print_error(format_args!("{}", render(!is_plain)));
}

/// Prints all diagnostics, and the number of errors and warnings.
pub(super) fn report(command: &str, loaded: &Loaded, diagnostics: &[Diagnostic], consequence: &str) {
    if diagnostics.is_empty() {
        return;
    }
    print_rendered(|styled| render::render(diagnostics, &loaded.sources, styled));
    let count = |level| diagnostics.iter().filter(|diagnostic| diagnostic.level() == level).count();
    let (errors, warnings) = (count(Level::Error), count(Level::Warning));
    let mut files: Vec<_> =
        diagnostics.iter().map(|diagnostic| loaded.sources.source_of(diagnostic.span)).collect();
    files.sort_unstable();
    files.dedup();
    let counts: Vec<String> = [(errors, "error"), (warnings, "warning")]
        .into_iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, what)| plural(count, what))
        .collect();
    let consequence = if errors > 0 { format!("; {consequence}") } else { String::new() };
    let place = format!("{} of {}", files.len(), plural(loaded.files.len(), "file"));
    terminal::eprintln!("{command}: {} in {place}{consequence}", counts.join(", "));
}
