//! `range-reversed`: a range that ends before it starts.

use super::rule::{Check, Levels, Measured, Rule};
use crate::diagnostic::{Diagnostic, Level};
use crate::example::Example;
use crate::finding::Edit;
use crate::msg::annotation::is_bracketed;
use crate::source::SourceMap;

pub(super) const RULE: Rule = Rule {
    id: "range-reversed",
    purpose: "A range gives its lower bound first. Tools that take the bounds in the order written find every \
              value outside.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               float32 flaps  # [-] [@range 1, 0] How far the flaps are out\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               float32 flaps  # [-] [@range 0, 1] How far the flaps are out\n",
    },
    measured: Some(Measured { findings: 1, sample: 1, right: 1, remark: "" }),
    check: Check::Reader(fix),
};

/// Swaps the bounds as they are written, labels and all. A near miss is mended by its own rule first.
fn fix(diagnostic: &Diagnostic, sources: &SourceMap) -> Vec<Edit> {
    let inner = |text: &str| -> Option<String> {
        let bounds = text.strip_prefix("[@range ")?.strip_suffix(']')?;
        let (high, low) = bounds.split_once(',').filter(|(_, low)| !low.contains(','))?;
        Some(format!("[@range {}, {}]", low.trim(), high.trim()))
    };
    let mended = inner(sources.slice(diagnostic.span)).filter(|text| is_bracketed(text));
    mended.map(|text| Edit { span: diagnostic.span, text }).into_iter().collect()
}
