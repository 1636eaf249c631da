//! The items of completion. Definitions and pages share some of them.

use lsp_types::CompletionItemKind;
use uavspec_schema::msg::attribute::ATTRIBUTES;
use uavspec_schema::msg::constraint::CONSTRAINTS;
use uavspec_schema::unit::UNITS;

/// An item: its label, its kind, a short text and the inserted text.
pub(crate) struct Item {
    pub(super) label: String,
    pub(super) kind: CompletionItemKind,
    pub(super) detail: String,
    /// The snippet, if it differs from the label.
    pub(super) snippet: Option<String>,
}

impl Item {
    pub(crate) fn new(label: impl Into<String>, kind: CompletionItemKind, detail: impl Into<String>) -> Self {
        Self { label: label.into(), kind, detail: detail.into(), snippet: None }
    }
}

/// The position after the last bracket that isn't closed.
pub(super) fn open_bracket(text: &str) -> Option<usize> {
    let open = text.rfind('[')?;
    (!text[open..].contains(']')).then_some(open + 1)
}

/// The start of the last word of a text.
pub(super) fn word_start(text: &str) -> usize {
    let word = text.rsplit(|c: char| c.is_whitespace() || c == ',').next().unwrap_or(text);
    text.len() - word.len()
}

/// The units.
pub(super) fn units() -> impl Iterator<Item = Item> {
    UNITS.iter().map(|unit| Item::new(unit.symbol, CompletionItemKind::Unit, unit.name))
}

/// The annotations, with placeholders for their arguments.
pub(super) fn annotations() -> Vec<Item> {
    let own = [
        ("enum", "${1:PREFIX}", "One of the constants with a prefix"),
        ("flags", "${1:PREFIX}", "A mask of the constants with a prefix"),
        ("count", "${1:array}", "The number of used elements of an array"),
    ];
    let constraints = CONSTRAINTS.iter().map(|kind| (kind.name, argument(kind.form), kind.form));
    let attributes = ATTRIBUTES.iter().map(|kind| (kind.name, argument(kind.form), kind.form));
    let own = own.into_iter().map(|(name, argument, words)| (name, argument.to_owned(), words));
    own.chain(constraints)
        .chain(attributes)
        .map(|(name, argument, words)| annotation(name, &argument, words))
        .collect()
}

/// The annotations in the descriptions of pages.
pub(super) fn annotations_of_pages() -> impl Iterator<Item = Item> {
    let items = [
        ("range", "${1:low}, ${2:high}", "The bounds of numbers"),
        ("length", "${1:least}, ${2:most}", "The length of a string or list"),
        ("unique", "", "The elements of a list are distinct"),
        ("pattern", "${1:REGEX}", "A regular expression that strings must match"),
        ("format", "${1:base64}", "The encoding of strings"),
    ];
    items.into_iter().map(|(name, argument, words)| annotation(name, argument, words))
}

fn annotation(name: &str, argument: &str, words: &str) -> Item {
    Item {
        snippet: Some(format!("@{name} {argument}").trim_end().to_owned()),
        ..Item::new(format!("@{name}"), CompletionItemKind::Keyword, words)
    }
}

/// The arguments in the form of an annotation, as placeholders: `[@range low, high]`.
fn argument(form: &str) -> String {
    let words = form.trim_matches(['[', ']']).split_once(' ').map_or("", |(_, words)| words);
    let placeholder = |(at, word): (usize, &str)| format!("${{{}:{word}}}", at + 1);
    words.split(", ").enumerate().map(placeholder).collect::<Vec<_>>().join(", ")
}
