//! Prints cases, one per line, so that diffs are readable.

use std::fmt::Write as _;

use super::case::Case;
use super::form::FORM;
use crate::file::notice;
use crate::json_schema::DRAFT;

/// The header of a vector file.
#[derive(Debug)]
pub(super) struct Head {
    /// Facts about the type, as names and JSON values.
    pub(super) facts: Vec<(&'static str, String)>,
    /// Package and name of the type.
    pub(super) title: String,
    /// URL of the schema.
    pub(super) schema: String,
}

/// Prints cases in this crate's own format.
pub(super) fn vectors(head: &Head, cases: &[Case]) -> String {
    let mut text = String::with_capacity(cases.len() * 1_024);
    let _ = write!(
        text,
        "{{\n  \"$comment\": {},\n  \"form\": {FORM},\n  \"type\": {},\n",
        quote(&notice(&head.title)),
        quote(&head.title)
    );
    for (name, value) in &head.facts {
        let _ = writeln!(text, "  \"{name}\": {value},");
    }
    let _ = write!(text, "  \"schema\": {},\n  \"cases\": [", quote(&head.schema));
    for (index, case) in cases.iter().enumerate() {
        text.push_str(if index == 0 { "\n    " } else { ",\n    " });
        print(case, &mut text);
    }
    text.push_str("\n  ]\n}\n");
    text
}

fn print(case: &Case, text: &mut String) {
    let _ = write!(
        text,
        "{{\"id\": {}, \"description\": {}, \"valid\": {}",
        quote(&case.id),
        quote(&case.description),
        case.rule.is_none()
    );
    if let Some(rule) = case.rule {
        let _ = write!(text, ", \"rule\": \"{rule}\"");
    }
    if let Some((class, severity)) = case.class {
        let _ = write!(text, ", \"class\": \"{class}\", \"severity\": \"{severity}\"");
    }
    for (name, json) in [("json", &case.json), ("decoded", &case.decoded)] {
        if let Some(json) = json {
            text.extend([", \"", name, "\": ", json]);
        }
    }
    for (name, bytes) in [("uorb", &case.uorb), ("cdr", &case.cdr), ("arguments", &case.arguments)] {
        if let Some(bytes) = bytes {
            text.extend([", \"", name, "\": \""]);
            hex(bytes, text);
            text.push('"');
        }
    }
    for (index, (profile, [message, description])) in case.texts.iter().enumerate() {
        let _ = write!(
            text,
            "{}\"{profile}\": {{\"message\": {}, \"description\": {}}}",
            if index == 0 { ", \"texts\": {" } else { ", " },
            quote(message),
            quote(description)
        );
    }
    text.push_str(if case.texts.is_empty() { "}" } else { "}}" });
}

/// Prints cases in the format of the JSON Schema Test Suite. Returns `None` if there are no tests.
pub(super) fn suite(head: &Head, cases: &[Case]) -> Option<String> {
    let tests: Vec<(&Case, &str, bool)> =
        cases.iter().filter_map(|case| Some((case, case.json.as_deref()?, case.schema_verdict?))).collect();
    if tests.is_empty() {
        return None;
    }
    let mut text = String::with_capacity(tests.len() * 1_024);
    let _ = write!(
        text,
        "[\n  {{\n    \"description\": {},\n    \"comment\": {},\n    \"schema\": {{\"$schema\": \"{DRAFT}\", \"$ref\": {}}},\n    \
         \"tests\": [",
        quote(&head.title),
        quote(&notice(&head.title)),
        quote(&head.schema),
    );
    for (index, (case, json, is_valid)) in tests.into_iter().enumerate() {
        let description = quote(&format!("{}: {}", case.id, case.description));
        let comma = if index == 0 { "" } else { "," };
        let _ = write!(
            text,
            "{comma}\n      {{\"description\": {description}, \"data\": {json}, \"valid\": {is_valid}}}"
        );
    }
    text.push_str("\n    ]\n  }\n]\n");
    Some(text)
}

fn hex(bytes: &[u8], text: &mut String) {
    let digit = |value: u8| char::from_digit(value.into(), 16).unwrap_or('0');
    text.extend(bytes.iter().flat_map(|byte| [digit(byte >> 4), digit(byte & 0xf)]));
}

/// Quotes a JSON string.
pub(super) fn quote(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}
