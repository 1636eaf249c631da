//! Documentation text that several kinds of types share.

use std::fmt::Write as _;

use uavspec_schema::{Constant, Constraint, prose, unit};

/// The documentation of a constant, with the parameters of a command.
pub(super) fn constant_text(constant: &Constant) -> String {
    let mut text = match constant.name.as_str() {
        _ if !constant.description.is_empty() => prose::block(&constant.description),
        "MESSAGE_VERSION" => "Version of the message, incremented when its fields change.".to_owned(),
        "ORB_QUEUE_LENGTH" => "Number of messages queued per topic before the oldest is dropped.".to_owned(),
        name => format!("Constant `{name}`; the definition has no description."),
    };
    if constant.parameters.iter().any(|parameter| !parameter.is_unused()) {
        text += "\n\n| parameter | unit | meaning |\n|---|---|---|";
        for (index, parameter) in constant.parameters.iter().enumerate() {
            let unit = parameter
                .unit
                .as_deref()
                .filter(|unit| *unit != unit::NONE)
                .map(prose::inline)
                .unwrap_or_default();
            let constraints = parameter.constraints.iter().filter(|found| !found.is_special());
            let constraints: String =
                constraints.filter_map(Constraint::valid_values).map(|text| format!(" ({text})")).collect();
            let _ = write!(
                text,
                "\n| {} | {unit} | {}{constraints} |",
                index + 1,
                prose::inline(&parameter.description)
            );
        }
    }
    text
}
