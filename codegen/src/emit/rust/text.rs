//! Sentences of documentation that several kinds of types share.

use std::fmt::Write as _;

use crate::prose;
use crate::schema::{Constant, Special};
use crate::unit;
use crate::value::Value;

/// The documentation of a constant, with the parameters that a command takes.
pub(super) fn constant_text(constant: &Constant) -> String {
    let mut text = match constant.name.as_str() {
        _ if !constant.description.is_empty() => prose::block(&constant.description),
        "MESSAGE_VERSION" => "Version of the message, raised when its fields change.".to_owned(),
        "ORB_QUEUE_LENGTH" => "How many messages a topic holds before the oldest is lost.".to_owned(),
        name => format!("The constant `{name}`, which its definition says no more of."),
    };
    if constant.parameters.iter().any(|parameter| !is_unused(&parameter.description)) {
        text += "\n\n| parameter | unit | meaning |\n|---|---|---|";
        for (index, parameter) in constant.parameters.iter().enumerate() {
            let unit = parameter
                .unit
                .as_deref()
                .filter(|unit| *unit != unit::NONE)
                .map(prose::inline)
                .unwrap_or_default();
            let range = parameter
                .range
                .as_ref()
                .and_then(|range| range_text(range.low.as_ref(), range.high.as_ref()));
            let range = range.map(|range| format!(" ({range})")).unwrap_or_default();
            let _ = write!(
                text,
                "\n| {} | {unit} | {}{range} |",
                index + 1,
                prose::inline(&parameter.description)
            );
        }
    }
    text
}

fn is_unused(description: &str) -> bool {
    matches!(description, "" | "Unused" | "Empty")
}

pub(super) fn range_text(low: Option<&Value>, high: Option<&Value>) -> Option<String> {
    match (low, high) {
        (Some(low), Some(high)) => Some(format!("{low} to {high}")),
        (Some(low), None) => Some(format!("{low} or more")),
        (None, Some(high)) => Some(format!("at most {high}")),
        (None, None) => None,
    }
}

pub(super) fn special_text(special: &Special) -> String {
    let value =
        special.value.as_ref().map_or_else(|| "empty".to_owned(), |value| prose::code(&value.to_string()));
    if special.text.is_empty() { value } else { format!("{value} ({})", prose::inline(&special.text)) }
}
