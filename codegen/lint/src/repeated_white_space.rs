//! `repeated-white-space`: more than one space within a declaration.

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "repeated-white-space",
    statement: "More than one space within a declaration.",
    why: "PX4's documentation checker requires a single space. Aligned columns must be realigned whenever a \
        longer name is added.",
    fix: "Write one space between type, name, `=` and value.",
    levels: Levels::both(Level::Note),
    bad: glider!["float32   sink  # [m/s] Sink rate"],
    good: glider!["float32 sink  # [m/s] Sink rate"],
    measured: Some(Measured { findings: 191, sample: 30, right: 30 }),
    check: Check::Message(Scope::Px4, check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    for (_, text, place) in subject.declarations() {
        let runs = runs(text);
        let (Some(first), Some(last)) = (runs.first(), runs.last()) else { continue };
        let finding = sink.report(
            place.part(first.start..last.end),
            "more than one space within a declaration",
            "write one space",
        );
        for run in runs {
            finding.edit(place.part(run), " ");
        }
    }
}

/// The ranges of repeated spaces between the words of a declaration.
fn runs(text: &str) -> Vec<std::ops::Range<usize>> {
    let is_space = |c: char| matches!(c, ' ' | '\t');
    let end = text.trim_end_matches(is_space).len();
    let mut runs = Vec::new();
    let mut at = text.len() - text.trim_start_matches(is_space).len();
    while let Some(start) = text[at..end].find(is_space).map(|found| at + found) {
        let rest = &text[start..end];
        at = start + rest.len() - rest.trim_start_matches(is_space).len();
        if &text[start..at] != " " {
            runs.push(start..at);
        }
    }
    runs
}
