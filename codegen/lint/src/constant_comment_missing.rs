//! `constant-comment-missing`: a constant without a comment.

use uavspec_schema::enumeration;

use super::constant_without_enum;
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "constant-comment-missing",
    statement: "A constant without a comment.",
    why: "The name rarely says when the value is used, and the documentation shows only the name.",
    fix: "Add a comment that explains what the value means.",
    levels: Levels::strict(Level::Note),
    bad: glider!["uint8 GEAR_UP = 0", "uint8 GEAR_DOWN = 1", "", "uint8 gear  # [@enum GEAR] Landing gear"],
    good: glider![
        "uint8 GEAR_UP = 0    # Retracted",
        "uint8 GEAR_DOWN = 1  # Extended",
        "",
        "uint8 gear  # [@enum GEAR] Landing gear"
    ],
    measured: Some(Measured { findings: 430, sample: 30, right: 26 }),
    check: Check::Message(Scope::Px4, check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    let names = constant_without_enum::names(subject.message);
    for constant in subject.message.constants.iter().filter(|constant| constant.description.is_empty()) {
        let name = constant.name.as_str();
        let is_known = constant_without_enum::KNOWN_BY_NAME.contains(&name)
            || enumeration::is_sentinel_among(name, &names);
        if !is_known && constant.parameters.is_empty() {
            sink.report(
                constant.span,
                format!("`{name}` has no comment"),
                "add a comment that explains what it means",
            );
        }
    }
}
