//! `range-reversed`: a range with swapped bounds.

use uavspec_schema::msg::annotation::is_bracketed;

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "range-reversed",
    statement: "A range whose lower bound is higher than its upper bound.",
    why: "Tools that read the bounds in order treat every value as out of range.",
    fix: "Swap the bounds.",
    levels: Levels::both(Level::Warning),
    bad: glider!["float32 flaps  # [-] [@range 1, 0] Flap deflection"],
    good: glider!["float32 flaps  # [-] [@range 0, 1] Flap deflection"],
    measured: Some(Measured { findings: 1, sample: 1, right: 1 }),
    check: Check::Reader(fix),
};

/// Swaps the bounds, including their labels. Returns no edit if the annotation is malformed, because
/// `annotation-near-miss` fixes that first.
fn fix(diagnostic: &Diagnostic, sources: &SourceMap) -> Vec<Edit> {
    let inner = |text: &str| -> Option<String> {
        let bounds = text.strip_prefix("[@range ")?.strip_suffix(']')?;
        let (high, low) = bounds.split_once(',').filter(|(_, low)| !low.contains(','))?;
        Some(format!("[@range {}, {}]", low.trim(), high.trim()))
    };
    let fixed = inner(sources.slice(diagnostic.span)).filter(|text| is_bracketed(text));
    fixed.map(|text| Edit { span: diagnostic.span, text }).into_iter().collect()
}
