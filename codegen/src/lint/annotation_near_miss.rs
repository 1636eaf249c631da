//! `annotation-near-miss`: what comes close to an annotation is read as one.

use super::rule::{Check, Levels, Measured, Rule};
use crate::diagnostic::{Diagnostic, Level, Problem};
use crate::example::Example;
use crate::finding::Edit;
use crate::msg::annotation::is_bracketed;
use crate::source::SourceMap;

pub(super) const RULE: Rule = Rule {
    id: "annotation-near-miss",
    purpose: "Annotations are written as the standard has them: `[@enum PREFIX]`, `[@range low, high]`, \
              `[@frame NED]`. What comes close is read as meant here; other tools take it for text, or for a unit.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               float32 flaps     # [-] (@range 0, 1) How far the flaps are out\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               float32 flaps     # [-] [@range 0, 1] How far the flaps are out\n",
    },
    measured: Some(Measured { findings: 6, sample: 6, right: 6, remark: "" }),
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
