//! `constant-without-enum`: a constant that no field claims.

use std::collections::BTreeSet;

use super::rule::{Check, Levels, Measured, Rule, Sink};
use super::subject::Subject;
use crate::diagnostic::Level;
use crate::example::Example;
use crate::schema::{Message, enumeration};

pub(super) const RULE: Rule = Rule {
    id: "constant-without-enum",
    purpose: "A constant is a value of some field, which says so with `[@enum PREFIX]`. Of one that no field \
              claims, nobody can tell where it may stand, and a value outside the list isn't noticed. Limits \
              and counts need no field.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               uint8 GEAR_UP = 0    # Retracted\nuint8 GEAR_DOWN = 1  # Extended\n\n\
               uint8 gear  # Landing gear\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               uint8 GEAR_UP = 0    # Retracted\nuint8 GEAR_DOWN = 1  # Extended\n\n\
               uint8 gear  # [@enum GEAR] Landing gear\n",
    },
    measured: Some(Measured { findings: 728, sample: 30, right: 29, remark: "the other is a default" }),
    check: Check::Message(check),
};

/// Constants that PX4 knows by name.
pub(super) const KNOWN_BY_NAME: [&str; 2] = ["MESSAGE_VERSION", "ORB_QUEUE_LENGTH"];

/// First and last words of constants that bound, count or date something: they are none of a set of values.
const LIMIT_STARTS: [&str; 4] = ["MAX_", "MIN_", "NUM_", "LATEST_"];
const LIMIT_ENDS: [&str; 6] = ["_MIN", "_MAX", "_LENGTH", "_SIZE", "_DIM", "_VERSION"];

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    if !subject.is_px4() {
        return;
    }
    let message = subject.message;
    let claimed = claimed(message);
    let names = names(message);
    for constant in &message.constants {
        let name = constant.name.as_str();
        if !is_plain(name, &names) && enumeration::longest_prefix(name, &claimed).is_none() {
            sink.report(
                constant.span,
                format!("no field claims `{name}`"),
                "name its prefix where it is a value: `[@enum PREFIX]` in the comment of the field",
            );
        }
    }
}

/// The prefixes that fields and parameters claim, those of other messages too where they name this one.
fn claimed(message: &Message) -> BTreeSet<String> {
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

/// Whether the name says that the constant is no value of a field.
fn is_plain(name: &str, names: &BTreeSet<&str>) -> bool {
    KNOWN_BY_NAME.contains(&name)
        || enumeration::is_sentinel_among(name, names)
        || LIMIT_STARTS.iter().any(|start| name.starts_with(start))
        || LIMIT_ENDS.iter().any(|end| name.ends_with(end))
}
