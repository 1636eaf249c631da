//! Targets for definitions, pages with tables, and event metadata. They read arbitrary bytes as a package, render the diagnostics, emit
//! output and format the files.

use uavspec_emit::inspect;
use uavspec_lint::format::Formatted;
use uavspec_lint::{Preset, Settings, apply, lint, rule};
use uavspec_schema::diagnostic::has_errors;
use uavspec_schema::finding::Finding;
use uavspec_schema::msg::Dialect;
use uavspec_schema::translation::Translations;
use uavspec_schema::{Form, PackageInput, SourceMap, read, render};

/// The byte that separates the files of an input. It never occurs in UTF-8.
const FILE_SEPARATOR: u8 = 0xff;

/// The maximum number of rendered diagnostics for an input.
const SHOWN: usize = 20;

/// Reads `.msg`, `.srv` and `.action` files in both dialects. The first byte selects the kind of file.
pub(crate) fn definitions(data: &[u8]) {
    let Some((first, data)) = data.split_first() else { return };
    let extension = ["msg", "srv", "action"][usize::from(first % 3)];
    for dialect in [Dialect::Px4, Dialect::Ros2] {
        check(Form::Msg(dialect), extension, data);
    }
}

/// Reads pages with tables. The first byte selects the format of the page.
pub(crate) fn tables(data: &[u8]) {
    let Some((first, data)) = data.split_first() else { return };
    check(Form::Table, ["md", "adoc", "txt"][usize::from(first % 3)], data);
}

/// Reads event metadata.
pub(crate) fn events(data: &[u8]) {
    check(Form::Events, "json", data);
}

/// Formats a definition or page. The meaning must stay the same, and a second run must change nothing. The first byte
/// selects the kind of file.
pub(crate) fn format(data: &[u8]) {
    let Some((first, data)) = data.split_first() else { return };
    let (form, path) = form(*first);
    check_layout(form, path, data);
}

/// The form and the file name that a byte selects.
fn form(byte: u8) -> (Form, &'static str) {
    match byte % 9 {
        0 => (Form::Msg(Dialect::Px4), "A.msg"),
        1 => (Form::Msg(Dialect::Px4), "A.srv"),
        2 => (Form::Msg(Dialect::Px4), "A.action"),
        3 => (Form::Msg(Dialect::Ros2), "A.msg"),
        4 => (Form::Msg(Dialect::Ros2), "A.srv"),
        5 => (Form::Msg(Dialect::Ros2), "A.action"),
        6 => (Form::Table, "A.md"),
        7 => (Form::Table, "A.adoc"),
        _ => (Form::Table, "A.txt"),
    }
}

/// Applies the automatic fixes of `lint`, as an edit of the text. The fixed definition must have no new errors, and a
/// fresh run must have identical findings. The first byte selects the kind of file.
pub(crate) fn fixes(data: &[u8]) {
    let Some((first, data)) = data.split_first() else { return };
    let (form, path) = form(*first);
    let mut sources = SourceMap::default();
    let Ok(id) = sources.add(path, data.to_vec()) else { return };
    let package = PackageInput::new("demo", form, vec![id]);
    let settings = Settings { preset: Preset::Strict, ..Settings::default() };
    let findings = |sources: &SourceMap| lint(sources, std::slice::from_ref(&package), &[], &settings);
    let before = findings(&sources);
    let errors = |findings: &[Finding]| findings.iter().filter(|found| rule(found.rule).is_none()).count();
    let changed = apply(&before, &sources);
    let Some(text) = changed.get(&id) else { return };
    let edited = sources.with_texts(&changed);
    let after = findings(&edited);
    assert!(errors(&before) > 0 || errors(&after) == 0, "the fix causes an error: {text}");
    let mut fresh = SourceMap::default();
    assert_eq!(fresh.add(path, text.clone().into_bytes()).ok(), Some(id));
    assert_eq!(findings(&fresh), after, "an edited text is read differently");
}

/// Reads `data` as files with `extension`, called `A`, `B` and so on. The location of each
/// diagnostic must be within the sources.
fn check(form: Form, extension: &str, data: &[u8]) {
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
        let related = diagnostic.related.iter().map(|(span, _)| span);
        for span in related.chain([&diagnostic.span]) {
            assert!(sources.contains(*span), "{span:?}");
        }
    }
    if !has_errors(&diagnostics) {
        inspect::schema(&schema);
        uavspec_emit::docs::emit(
            &schema,
            &Translations::default(),
            &sources,
            &uavspec_emit::docs::Options::default(),
        );
        uavspec_emit::json_schema::emit(&schema, &uavspec_emit::json_schema::Options::default());
    }
    // Render only a few diagnostics, because rendering one takes longer than finding hundreds.
    diagnostics.truncate(SHOWN);
    render::render(&diagnostics, &sources, false);
}

/// Formats a file. A file with errors is not formatted.
fn check_layout(form: Form, path: &str, data: &[u8]) {
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
    let formatted = uavspec_lint::format::format(&sources, id, form).ok()?;
    let (schema, _) = read(&sources, &[PackageInput::new("demo", form, vec![id])]);
    Some((formatted, inspect::schema(&schema).to_string()))
}
