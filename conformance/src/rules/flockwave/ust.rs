//! The parts that the rules on the state of a UAV share (`FW-UST-…`): each field has the shape that the definitions give it.

use serde_json::Value;

use super::{FlockwaveRule, Level, Message, Rule, RuleContext, Status, body, mutant, source};

/// What the specification says of null.
pub(super) const NULL: Status = Status::Disputed(
    "The published schemas don't let a field be null that isn't required; the advice to the authors of the specification \
     does. Here null is a deviation.",
);

/// The statement that these rules have in common.
pub(super) const RULE: Rule = Rule {
    id: "",
    level: Level::Must,
    status: Status::Normative,
    statement: "",
    source: source::TYPES,
    applies_to: "states of UAV-INF",
    why: "",
    example: "",
    fix: "",
};

/// The session in which a field of a state has another value.
pub(super) fn with(field: &str, value: Value) -> Option<Vec<u8>> {
    mutant::state(|kite| kite[field] = value)
}

/// Counts the states that have a field, and reports the violations of its body schema that the rule covers.
pub(super) fn check(message: &Message<'_>, context: &mut RuleContext<'_>, of: &FlockwaveRule, field: &str) {
    for (_, state) in body::states(message, "UAV-INF") {
        if state.get(field).is_some() {
            context.covered();
        }
    }
    let Some(type_name) = message.type_name else { return };
    for deviation in message.deviations.into_iter().flatten().filter(|found| of.covers(type_name, found)) {
        message.deviates(context, "", deviation);
    }
}
