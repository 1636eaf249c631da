//! Reads hints from TOML, and reports all mistakes.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};
use uavspec_schema::source::{SourceId, SourceMap};
use uavspec_schema::span::Span;
use uavspec_schema::wording::similar;

use super::model::{Hint, HintValue, Hints, Key, Mistake};
use crate::conversion::expression::{Node, NodeKind, parse};
use crate::conversion::plan::Narrowing;

/// The keys of a hint.
const KEYS: [&str; 10] =
    ["message", "old_message", "new_message", "topic", "versions", "rename", "old", "new", "narrow", "same"];

/// Reads the hints in a source.
pub fn read(sources: &SourceMap, source: SourceId) -> Hints {
    let mut reader = Reader { whole: sources.span(source), mistakes: Vec::new() };
    let (table, errors) = DeTable::parse_recoverable(sources.text(source));
    for error in &errors {
        let span = reader.span(error.span().unwrap_or_default());
        reader.mistake(span, error.message().to_owned(), "correct the TOML syntax");
    }
    // Skip a partly parsed file, which would only cause further errors.
    let mut hints = if errors.is_empty() { reader.file(table.get_ref()) } else { Hints::default() };
    reader.mistakes.sort_by_key(|mistake| mistake.span);
    hints.mistakes = reader.mistakes;
    hints
}

struct Reader {
    whole: Span,
    mistakes: Vec<Mistake>,
}

type Value<'t> = Spanned<DeValue<'t>>;

impl Reader {
    fn span(&self, range: Range<usize>) -> Span {
        self.whole.part(range)
    }

    fn mistake(&mut self, span: Span, message: impl Into<String>, help: impl Into<String>) {
        self.mistakes.push(Mistake { span, message: message.into(), help: help.into() });
    }

    /// Reports a value of the wrong type.
    fn mistyped(&mut self, key: &str, expected: &str, value: &Value<'_>) {
        let found = value.get_ref().type_str();
        let message = format!("`{key}`: expected {expected}, found type {found}");
        let span = self.span(value.span());
        self.mistake(span, message, "the guide describes all keys in the chapter \"Generate conversions\"");
    }

    fn file(&mut self, table: &DeTable<'_>) -> Hints {
        let mut hints = Hints::default();
        for (key, value) in table {
            if key.get_ref() == "packages" {
                hints.packages = self.pairs("packages", value);
                continue;
            }
            let tables = value.get_ref().as_array().filter(|_| key.get_ref() == "hint");
            let Some(tables) = tables else {
                let message = format!("unknown key `{}`", key.get_ref());
                let span = self.span(key.span());
                self.mistake(span, message, "write `[[hint]]`, or `[packages]` for packages with a new name");
                continue;
            };
            for value in tables {
                match value.get_ref().as_table() {
                    Some(table) => hints.of_messages.extend(self.hint(self.span(value.span()), table)),
                    None => self.mistyped("hint", "a table", value),
                }
            }
        }
        hints
    }

    fn hint(&mut self, span: Span, table: &DeTable<'_>) -> Option<Hint> {
        let before = self.mistakes.len();
        let mut hint = Hint::default();
        let mut names: [Option<Key>; 3] = [None, None, None];
        for (key, value) in table {
            match key.get_ref().as_ref() {
                "message" => names[0] = self.text("message", value),
                "old_message" => names[1] = self.text("old_message", value),
                "new_message" => names[2] = self.text("new_message", value),
                "topic" => hint.topic = self.text("topic", value),
                "versions" => hint.versions = self.versions(value),
                "rename" => hint.rename = self.pairs("rename", value),
                "old" => hint.values[0] = self.values("old", value),
                "new" => hint.values[1] = self.values("new", value),
                "narrow" => hint.narrow = self.narrow(value),
                "same" => hint.same = self.list("same", value),
                unknown => {
                    let place = self.span(key.span());
                    self.mistake(place, format!("unknown key `{unknown}` in a hint"), suggestion(unknown));
                }
            }
        }
        hint.messages = match names {
            [Some(name), None, None] => [name.clone(), name],
            [None, Some(old), Some(new)] => [old, new],
            _ => {
                let help =
                    "write `message`, or `old_message` and `new_message` if a topic changed its message";
                if self.mistakes.len() == before {
                    self.mistake(span, "the hint doesn't name its message", help);
                }
                return None;
            }
        };
        let is_empty = hint.values.iter().all(Vec::is_empty)
            && hint.rename.is_empty()
            && hint.narrow.is_empty()
            && hint.same.is_empty()
            && hint.messages[0] == hint.messages[1];
        if is_empty && self.mistakes.len() == before {
            let help = "add `new.FIELD`, `old.FIELD`, `rename`, `narrow` or `same`";
            self.mistake(span, "the hint decides nothing", help);
        }
        (self.mistakes.len() == before).then_some(hint)
    }

    fn text(&mut self, key: &str, value: &Value<'_>) -> Option<Key> {
        let Some(text) = value.get_ref().as_str() else {
            self.mistyped(key, "a string", value);
            return None;
        };
        Some(Key { text: text.to_owned(), span: self.span(value.span()) })
    }

    fn versions(&mut self, value: &Value<'_>) -> Option<[u32; 2]> {
        let numbers = value.get_ref().as_array().and_then(|values| {
            let number =
                |value: &Value<'_>| integer(value.get_ref()).and_then(|number| number.try_into().ok());
            <[u32; 2]>::try_from(values.iter().filter_map(number).collect::<Vec<u32>>())
                .ok()
                .filter(|_| values.len() == 2)
        });
        if numbers.is_none() {
            self.mistyped("versions", "two numbers, such as [0, 1]", value);
        }
        numbers
    }

    fn table<'t, 'v>(&mut self, key: &str, value: &'v Value<'t>) -> Option<&'v DeTable<'t>> {
        let table = value.get_ref().as_table();
        if table.is_none() {
            self.mistyped(key, "a table", value);
        }
        table
    }

    fn pairs(&mut self, key: &str, value: &Value<'_>) -> Vec<[Key; 2]> {
        let Some(table) = self.table(key, value) else { return Vec::new() };
        let pair = |(name, value): (&Spanned<_>, &Value<'_>)| {
            let text: &toml::de::DeString<'_> = name.get_ref();
            let left = Key { text: text.to_string(), span: self.span(name.span()) };
            Some([left, self.text(key, value)?])
        };
        table.iter().filter_map(pair).collect()
    }

    fn list(&mut self, key: &str, value: &Value<'_>) -> Vec<Key> {
        let Some(values) = value.get_ref().as_array() else {
            self.mistyped(key, "an array of names", value);
            return Vec::new();
        };
        values.iter().filter_map(|value| self.text(key, value)).collect()
    }

    fn narrow(&mut self, value: &Value<'_>) -> Vec<(Key, Narrowing)> {
        let mut policies = Vec::new();
        for [field, policy] in self.pairs("narrow", value) {
            match policy.text.as_str() {
                "nearest" => policies.push((field, Narrowing::Nearest)),
                "neutral" => policies.push((field, Narrowing::Neutral)),
                unknown => self.mistake(
                    policy.span,
                    format!("unknown policy `{unknown}`"),
                    "write \"nearest\" for the nearest value, or \"neutral\" for the neutral value",
                ),
            }
        }
        policies
    }

    fn values(&mut self, key: &str, value: &Value<'_>) -> Vec<(Key, HintValue)> {
        let Some(table) = self.table(key, value) else { return Vec::new() };
        let mut values = Vec::new();
        for (name, value) in table {
            let field = Key { text: name.get_ref().to_string(), span: self.span(name.span()) };
            if let Some(value) = self.value(&field.text, value) {
                values.push((field, value));
            }
        }
        values
    }

    fn value(&mut self, field: &str, value: &Value<'_>) -> Option<HintValue> {
        let span = self.span(value.span());
        let kind = match value.get_ref() {
            DeValue::Boolean(value) => NodeKind::Bool(*value),
            DeValue::Integer(_) => match integer(value.get_ref()) {
                Some(number) => NodeKind::Int(number),
                None => return self.too_large(span),
            },
            DeValue::Float(value) => match value.as_str().replace('_', "").parse() {
                Ok(number) => NodeKind::Float(number),
                Err(_) => return self.too_large(span),
            },
            DeValue::Table(_) => return Some(HintValue::Constants(self.pairs(field, value))),
            DeValue::String(text) => return self.expression(text, span),
            DeValue::Array(_) | DeValue::Datetime(_) => {
                self.mistyped(
                    field,
                    "a number, true, false, an expression in quotes, or a table of constants",
                    value,
                );
                return None;
            }
        };
        Some(HintValue::Expression(Node { kind, span }))
    }

    fn too_large(&mut self, span: Span) -> Option<HintValue> {
        self.mistake(
            span,
            "the number can't be represented",
            "write a number that the field's type can represent",
        );
        None
    }

    fn expression(&mut self, text: &str, span: Span) -> Option<HintValue> {
        // The quotes are not part of the text.
        let inner = Span { start: span.start + 1, end: span.end.saturating_sub(1).max(span.start + 1) };
        match parse(text, inner) {
            Ok(node) => Some(HintValue::Expression(node)),
            Err((place, message)) => {
                self.mistake(
                    place,
                    message,
                    "the guide describes expressions in the chapter \"Generate conversions\"",
                );
                None
            }
        }
    }
}

fn integer(value: &DeValue<'_>) -> Option<i128> {
    let integer = value.as_integer()?;
    i128::from_str_radix(&integer.as_str().replace('_', ""), integer.radix()).ok()
}

/// Advice for an unknown key.
fn suggestion(key: &str) -> String {
    match similar(key, KEYS) {
        Some(known) => format!("did you mean `{known}`?"),
        None => format!("the keys are {}", KEYS.map(|key| format!("`{key}`")).join(", ")),
    }
}
