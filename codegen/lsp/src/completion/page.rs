//! Completion in the tables of Markdown pages.

use lsp_types::CompletionItemKind;

use super::item::{Item, annotations_of_pages, open_bracket, units, word_start};
use crate::snapshot::Document;

/// The built-in types of pages and the words of type expressions.
const TYPES: [&str; 9] =
    ["any", "boolean", "integer", "list of", "map of", "null", "number", "one of", "string"];

/// The words before the number of an error code.
const CODE_WORDS: [&str; 4] = ["code ", "codes ", "or ", "and "];

/// The items in a cell, and the start of the text that they replace.
pub(super) fn items(document: &Document<'_>, line: usize, before: &str) -> (usize, Vec<Item>) {
    let nothing = (before.len(), Vec::new());
    let Some(column) = before.matches('|').count().checked_sub(1) else { return nothing };
    let header = header(document, line);
    let Some(name) = header.get(column) else { return nothing };
    let cell = before.rfind('|').map_or(0, |at| at + 1);
    match name.to_lowercase().as_str() {
        "type" => (word_from(before, cell), types(document)),
        "required" => {
            let words = ["yes", "no"].map(|word| Item::new(word, CompletionItemKind::Value, ""));
            (word_from(before, cell), words.into())
        }
        "description" => description(document, &before[cell..], cell),
        _ => nothing,
    }
}

/// The items in a description (annotations, or the codes after `code`), and the start of the text that they replace.
fn description(document: &Document<'_>, text: &str, cell: usize) -> (usize, Vec<Item>) {
    if let Some(open) = open_bracket(text) {
        return (cell + open, units().chain(annotations_of_pages()).collect());
    }
    let from = word_start(text);
    let is_code = CODE_WORDS.iter().any(|word| text[..from].ends_with(word));
    (cell + from, if is_code { codes(document) } else { Vec::new() })
}

/// The start of the last word of a cell.
fn word_from(before: &str, cell: usize) -> usize {
    cell + word_start(&before[cell..])
}

/// The names of the columns of the table that contains a line.
fn header<'d>(document: &'d Document<'_>, line: usize) -> Vec<&'d str> {
    let is_row = |line: &usize| document.lines.line(*line).trim_start().starts_with('|');
    let first = (0..line).rev().take_while(is_row).last().unwrap_or(line);
    document.lines.line(first).trim().trim_matches('|').split('|').map(str::trim).collect()
}

fn types(document: &Document<'_>) -> Vec<Item> {
    let schema = &document.snapshot.schema;
    let built_in = TYPES.map(|name| Item::new(name, CompletionItemKind::Keyword, "built-in type"));
    let own = document.package_index().map_or(&[][..], |at| &schema.packages[at].json_types);
    let own = own.iter().map(|id| schema.json_type(*id));
    built_in
        .into_iter()
        .chain(own.map(|ty| Item::new(&ty.name, CompletionItemKind::Class, &ty.docs.summary)))
        .collect()
}

/// The error codes of the package.
fn codes(document: &Document<'_>) -> Vec<Item> {
    let schema = &document.snapshot.schema;
    let tables = document.package_index().map_or(&[][..], |at| &schema.packages[at].error_tables);
    let codes = tables.iter().flat_map(|table| &table.codes);
    codes
        .map(|code| {
            let name = code.abbreviation.as_deref().unwrap_or(&code.description);
            Item::new(code.code.to_string(), CompletionItemKind::EnumMember, name)
        })
        .collect()
}
