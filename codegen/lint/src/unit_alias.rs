//! `unit-alias`: a unit in a nonstandard spelling.

use uavspec_schema::msg::statement::Statement;
use uavspec_schema::unit;

use super::prelude::*;
use super::subject::annotations;

pub(super) const RULE: Rule = Rule {
    id: "unit-alias",
    statement: "A unit in a nonstandard spelling.",
    why: "Other tools know only the standard spelling, and PX4's documentation reports the unit as unknown.",
    fix: "Write the standard spelling, such as `m/s` or `degC`.",
    levels: Levels::both(Level::Note),
    bad: glider!["float32 sink  # [meters/second] Sink rate"],
    good: glider!["float32 sink  # [m/s] Sink rate"],
    measured: Some(Measured { findings: 16, sample: 16, right: 16 }),
    check: Check::Message(Scope::Px4, check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    for annotation in subject.part.lines.iter().flat_map(annotations) {
        let Statement::Unit(symbol) = annotation.statement else { continue };
        let written = subject.sources.slice(annotation.span).trim_matches(['[', ']']).trim();
        if written != symbol && unit::lookup(symbol).is_some() {
            sink.report(
                annotation.span,
                format!("`{written}` is a nonstandard spelling of `{symbol}`"),
                format!("write `[{symbol}]`"),
            )
            .edit(annotation.span, format!("[{symbol}]"));
        }
    }
}
