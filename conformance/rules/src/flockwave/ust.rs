//! Parts shared by the `FW-UST-…` rules. Each rule checks that one field of a UAV state matches its definition.

use super::prelude::*;

/// The common fields of the `FW-UST-…` rules.
pub(super) const RULE: Rule = Rule {
    id: "",
    name: "",
    level: Level::Must,
    status: Status::Normative,
    statement: "",
    source: source::TYPES,
    applies_to: "states of UAV-INF",
    why: "",
    example: "",
    fix: "",
};

/// Counts the states that have the field of the rule, and reports the body schema violations that the rule covers.
pub(super) fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    let Some(type_name) = message.type_name.filter(|name| *name == "UAV-INF") else { return };
    let Some(rule) = super::rule(context.rule.id) else { return };
    let field = rule.covers.first().and_then(Attribution::state_field);
    for (_, state) in body::states(message, type_name) {
        if field.is_some_and(|field| state.get(field).is_some()) {
            context.covered();
        }
    }
    for deviation in message.deviations.into_iter().flatten().filter(|found| rule.reports(type_name, found)) {
        message.deviates(context, "", deviation);
    }
}
