//! `description-missing`: an error code without a description.

use uavspec_schema::Package;

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "description-missing",
    statement: "An error code without a description.",
    why: "An operator who sees the code doesn't know what happened or what to do.",
    fix: "Describe the condition and the remedy.",
    levels: Levels::both(Level::Warning),
    bad: winch![codes: "| 64 | ROPE | |"],
    good: winch![codes: "| 64 | ROPE | The rope is worn. |"],
    measured: None,
    check: Check::Package(check),
};

fn check(package: &Package, _: &SourceMap, sink: &mut Sink<'_>) {
    for code in package.error_tables.iter().flat_map(|table| &table.codes) {
        if code.description.trim_matches(['-', '–', '—', '.', ' ']).is_empty() {
            sink.report(
                code.span,
                format!("code {} has no description", code.code),
                "describe what happened and what to do",
            );
        }
    }
}
