//! Properties of formatted files.

use serde_json::Value as Json;
use uavspec_emit::inspect;
use uavspec_lint::format::{Formatted, format};
use uavspec_schema::diagnostic::Level;
use uavspec_schema::msg::annotation::Note;
use uavspec_schema::msg::{Dialect, Kind, parse as parse_definition};
use uavspec_schema::table::parse as parse_page;
use uavspec_schema::{Diagnostic, Form, SourceMap, read};

/// Formats a file, or returns its errors.
pub(crate) fn laid_out(path: &str, text: &str, form: Form) -> Result<Formatted, Vec<Diagnostic>> {
    let mut sources = SourceMap::default();
    let id = sources.add(path, text.as_bytes().to_vec()).map_err(|diagnostic| vec![diagnostic])?;
    format(&sources, id, form)
}

/// The model of files, and the sorted codes of their errors.
fn model(form: Form, files: &[(String, String)]) -> (Json, Vec<&'static str>) {
    let mut sources = SourceMap::default();
    let mut package = uavspec_test_definitions::package("demo", form);
    for (path, text) in files {
        package.sources.extend(sources.add(path.as_str(), text.as_bytes().to_vec()));
    }
    let (schema, diagnostics) = read(&sources, &[package]);
    let errors = diagnostics.iter().filter(|diagnostic| diagnostic.level() == Level::Error);
    let mut errors: Vec<&str> = errors.map(|diagnostic| diagnostic.problem.code()).collect();
    errors.sort_unstable();
    (inspect::schema(&schema), errors)
}

/// The comments, each with its text, the number of its annotations, and its parameters.
fn comments(path: &str, text: &str, dialect: Dialect) -> Vec<String> {
    fn words(note: &Note<'_>) -> String {
        let parameters: Vec<String> = note.parameters.iter().map(words).collect();
        format!("{} {} {parameters:?}", note.annotations.len(), note.text)
    }
    let mut sources = SourceMap::default();
    let id = sources.add(path, text.as_bytes().to_vec()).expect("a text");
    let kind = Kind::of(path).expect("a definition");
    let (definition, _) = parse_definition(&sources, id, kind, dialect);
    let lines = definition.parts.iter().flat_map(|part| &part.lines);
    let comments = lines.filter_map(|line| line.comment.as_deref());
    let normalised = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    comments.map(|found| found.note.as_ref().map_or_else(|| normalised(found.text), words)).collect()
}

/// All cells of a page.
fn cells(path: &str, text: &str) -> Vec<Vec<String>> {
    let mut sources = SourceMap::default();
    let id = sources.add(path, text.as_bytes().to_vec()).expect("a text");
    let (page, _) = parse_page(&sources, id);
    let rows =
        page.tables.iter().flat_map(|table| table.rows.iter().map(|row| &row.cells).chain([&table.header]));
    rows.map(|row| row.iter().map(|cell| cell.text.as_str().to_owned()).collect()).collect()
}

/// Formats a file and checks the result. Returns `None` for a file with errors.
fn check_layout(path: &str, text: &str, form: Form) -> Result<Option<String>, String> {
    let Ok(first) = laid_out(path, text, form) else { return Ok(None) };
    let problem = |what: &str| Err(format!("{path}: {what}\n{text:?}\n{:?}", first.text));
    if first.is_kept {
        return problem("formatting changes the meaning");
    }
    match laid_out(path, &first.text, form) {
        Ok(second) if second.text == first.text && !second.is_kept => {}
        Ok(second) => return problem(&format!("a second run changes the formatted text: {:?}", second.text)),
        Err(diagnostics) => return problem(&format!("the formatted text has errors: {diagnostics:?}")),
    }
    let is_same = match form {
        Form::Msg(dialect) => comments(path, text, dialect) == comments(path, &first.text, dialect),
        Form::Table => cells(path, text) == cells(path, &first.text),
        Form::Events => text == first.text,
    };
    if !is_same {
        return problem("a comment or cell is lost");
    }
    let is_tidy = |line: &str| !line.ends_with([' ', '\t', '\r']);
    if let (Form::Msg(_), Some(line)) = (form, first.text.split('\n').find(|line| !is_tidy(line))) {
        return problem(&format!("trailing white space in {line:?}"));
    }
    // A page is not formatted if a carriage return in it may end a line.
    let is_formatted = !text.replace("\r\n", "\n").contains('\r');
    if is_formatted && !first.text.is_empty() && (!first.text.ends_with('\n') || first.text.ends_with("\n\n"))
    {
        return problem("the text must end with a single newline");
    }
    Ok(Some(first.text))
}

/// Formats the files of a package, and checks that their model is unchanged.
pub(crate) fn check_files(form: Form, files: &[(String, String)]) -> Result<usize, String> {
    let mut laid_out = files.to_vec();
    let mut count = 0;
    for (path, text) in &mut laid_out {
        if let Some(new) = check_layout(path, text, form)? {
            *text = new;
            count += 1;
        }
    }
    let [before, after] = [files, &laid_out].map(|files| model(form, files));
    if before == after { Ok(count) } else { Err(format!("the model differs: {files:?}\n{laid_out:?}")) }
}
