//! Sentences of documentation that several kinds of types share.

use std::fmt::Write as _;

use crate::prose;
use crate::schema::{Constant, Constraint};
use crate::unit;

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
            let said = parameter.constraints.iter().filter(|found| !found.is_special());
            let said: String =
                said.filter_map(Constraint::valid_values).map(|said| format!(" ({said})")).collect();
            let _ = write!(
                text,
                "\n| {} | {unit} | {}{said} |",
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
