//! Shared code of the fuzz targets. These functions read arbitrary bytes as a package, render the diagnostics and emit
//! output.

use uavspec_codegen::diagnostic::has_errors;
use uavspec_codegen::emit::{self, inspect};
use uavspec_codegen::format::{Formatted, format};
use uavspec_codegen::schema::Form;
use uavspec_codegen::source::Span;
use uavspec_codegen::translation::Translations;
use uavspec_codegen::{PackageInput, SourceMap, read, render};

/// The byte that separates the files of an input. It never occurs in UTF-8.
pub const FILE_SEPARATOR: u8 = 0xff;

/// The maximum number of rendered diagnostics for an input.
const SHOWN: usize = 20;

/// Reads `data` as files with `extension`, called `A`, `B` and so on.
///
/// # Panics
///
/// Panics if the location of a diagnostic is not within the sources. The fuzzer searches for such inputs.
pub fn check(form: Form, extension: &str, data: &[u8]) {
    let mut sources = SourceMap::default();
    let mut package = PackageInput::new("demo", form, Vec::new());
    let mut diagnostics = Vec::new();
    for (bytes, name) in data.split(|byte| *byte == FILE_SEPARATOR).zip('A'..='Z') {
        match sources.add(format!("{name}.{extension}"), bytes.to_vec()) {
            Ok(id) => package.sources.push(id),
            Err(diagnostic) => diagnostics.push(diagnostic),
        }
    }
    let (schema, mut found) = read(&sources, &[package]);
    diagnostics.append(&mut found);
    for diagnostic in &diagnostics {
        check_place(&sources, diagnostic.span);
        diagnostic.related.iter().for_each(|(span, _)| check_place(&sources, *span));
    }
    if !has_errors(&diagnostics) {
        inspect::schema(&schema);
        emit::docs::emit(&schema, &Translations::default(), &sources, &emit::docs::Options::default());
        emit::json_schema::emit(&schema, &emit::json_schema::Options::default());
    }
    // Rendering one diagnostic takes longer than finding hundreds of them.
    diagnostics.truncate(SHOWN);
    render::render(&diagnostics, &sources, false);
}

/// Formats a file. A file with errors is not formatted.
///
/// # Panics
///
/// Panics if formatting would change the meaning, or if a second run changes the formatted text.
pub fn check_layout(form: Form, path: &str, data: &[u8]) {
    let before = read_one(form, path, data.to_vec());
    let Some((formatted, model)) = before else { return };
    assert!(!formatted.is_kept, "formatting changes the meaning");
    let Some((again, same_model)) = read_one(form, path, formatted.text.clone().into_bytes()) else {
        panic!("the formatted text has errors");
    };
    assert_eq!(again, formatted, "a second run changes the formatted text");
    assert_eq!(same_model, model, "formatting changes the meaning");
}

/// The formatted file, and its model as JSON.
fn read_one(form: Form, path: &str, data: Vec<u8>) -> Option<(Formatted, String)> {
    let mut sources = SourceMap::default();
    let id = sources.add(path, data).ok()?;
    let formatted = format(&sources, id, form).ok()?;
    let (schema, _) = read(&sources, &[PackageInput::new("demo", form, vec![id])]);
    Some((formatted, inspect::schema(&schema).to_string()))
}

fn check_place(sources: &SourceMap, span: Span) {
    let id = sources.source_of(span);
    let whole = sources.span(id);
    assert!(
        whole.start <= span.start && span.start <= span.end && span.end <= whole.end,
        "{span:?} in {whole:?}"
    );
    let text = sources.text(id);
    for at in [span.start - whole.start, span.end - whole.start] {
        assert!(text.is_char_boundary(at as usize), "{span:?} splits a character");
    }
}
