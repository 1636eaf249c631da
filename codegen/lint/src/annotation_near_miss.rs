//! `annotation-near-miss`: text that resembles an annotation.

use uavspec_schema::diagnostic::Problem;
use uavspec_schema::msg::annotation::is_bracketed;

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "annotation-near-miss",
    statement: "Text that resembles an annotation but deviates from the standard form.",
    why: "uavspec treats this text as the annotation that it resembles. Other tools treat it as plain text or as \
        a unit.",
    fix: "Write the annotation in its standard form, such as `[@enum PREFIX]`, `[@range low, high]` \
        or `[@frame NED]`.",
    levels: Levels::both(Level::Warning),
    bad: glider!["float32 flaps     # [-] (@range 0, 1) Flap deflection"],
    good: glider!["float32 flaps     # [-] [@range 0, 1] Flap deflection"],
    measured: Some(Measured { findings: 6, sample: 6, right: 6 }),
    check: Check::Reader(fix),
};

fn fix(diagnostic: &Diagnostic, _: &SourceMap) -> Vec<Edit> {
    match &diagnostic.problem {
        Problem::AnnotationNearMiss { expected, .. } if is_bracketed(expected) => {
            vec![Edit { span: diagnostic.span, text: expected.clone() }]
        }
        _ => Vec::new(),
    }
}
