//! `constant-without-enum`: a constant that no field refers to.

use std::collections::BTreeSet;

use uavspec_schema::{Message, enumeration};

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "constant-without-enum",
    statement: "A constant that no field refers to with `[@enum PREFIX]`.",
    why: "Readers can't tell which field uses the constant, and values outside the list are not \
        detected. Limits and counts, such as `MAX_…`, are not reported.",
    fix: "Add `[@enum PREFIX]` to the comment of the field that holds the constant.",
    levels: Levels::both(Level::Warning),
    bad: glider![
        "uint8 GEAR_UP = 0    # Retracted",
        "uint8 GEAR_DOWN = 1  # Extended",
        "",
        "uint8 gear  # Landing gear"
    ],
    good: glider![
        "uint8 GEAR_UP = 0    # Retracted",
        "uint8 GEAR_DOWN = 1  # Extended",
        "",
        "uint8 gear  # [@enum GEAR] Landing gear"
    ],
    measured: Some(Measured { findings: 728, sample: 30, right: 29 }),
    check: Check::Message(Scope::Px4, check),
};

/// Constants with a special meaning in PX4.
pub(super) const KNOWN_BY_NAME: [&str; 2] = ["MESSAGE_VERSION", "ORB_QUEUE_LENGTH"];

/// First and last words in the names of constants that are limits, counts or versions rather than field values.
const LIMIT_STARTS: [&str; 4] = ["MAX_", "MIN_", "NUM_", "LATEST_"];
const LIMIT_ENDS: [&str; 6] = ["_MIN", "_MAX", "_LENGTH", "_SIZE", "_DIM", "_VERSION"];

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    let message = subject.message;
    let prefixes = prefixes(message);
    let names = names(message);
    for constant in &message.constants {
        let name = constant.name.as_str();
        if !is_plain(name, &names) && enumeration::longest_prefix(name, &prefixes).is_none() {
            sink.report(
                constant.span,
                format!("no field refers to `{name}`"),
                "write `[@enum PREFIX]` in the comment of the field that holds the constant",
            );
        }
    }
}

/// The enum prefixes that fields and parameters use, including fields of other messages that refer to `message`.
fn prefixes(message: &Message) -> BTreeSet<String> {
    let fields = message.fields.iter().flat_map(|field| &field.enum_prefixes);
    let parameters = message.constants.iter().flat_map(|constant| &constant.parameters);
    let parameters = parameters.flat_map(|parameter| &parameter.enum_prefixes);
    let elsewhere = message.enums.iter().flat_map(|found| &found.prefixes);
    fields.chain(parameters).chain(elsewhere).cloned().collect()
}

/// The names of all constants of a message.
pub(super) fn names(message: &Message) -> BTreeSet<&str> {
    message.constants.iter().map(|constant| constant.name.as_str()).collect()
}

/// True if the name shows that the constant is not a field value.
fn is_plain(name: &str, names: &BTreeSet<&str>) -> bool {
    KNOWN_BY_NAME.contains(&name)
        || enumeration::is_sentinel_among(name, names)
        || LIMIT_STARTS.iter().any(|start| name.starts_with(start))
        || LIMIT_ENDS.iter().any(|end| name.ends_with(end))
}
