//! `repeated-white-space`: single blanks within declarations.

use super::rule::{Check, Levels, Measured, Rule, Sink};
use super::subject::Subject;
use crate::diagnostic::Level;
use crate::example::Example;

pub(super) const RULE: Rule = Rule {
    id: "repeated-white-space",
    purpose: "Between type, name, `=` and value there is one blank each: PX4's documentation checker asks \
              for that. Columns within a declaration have to be set anew with each longer name.",
    levels: Levels::both(Level::Note),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               float32   sink  # [m/s] Sink rate\n",
    },
    good: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
               float32 sink  # [m/s] Sink rate\n",
    },
    measured: Some(Measured {
        findings: 191,
        sample: 30,
        right: 30,
        remark: "most are columns set by hand, which PX4's checker reports too",
    }),
    check: Check::Message(check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    if !subject.is_px4() {
        return;
    }
    for (_, text, place) in subject.declarations() {
        let runs = runs(text);
        let (Some(first), Some(last)) = (runs.first(), runs.last()) else { continue };
        let finding = sink.report(
            place.part(first.start..last.end),
            "more than one blank within a declaration",
            "leave one",
        );
        for run in runs {
            finding.edit(place.part(run), " ");
        }
    }
}

/// Where in a declaration more stands between two words than a blank.
fn runs(text: &str) -> Vec<std::ops::Range<usize>> {
    let is_blank = |c: char| matches!(c, ' ' | '\t');
    let end = text.trim_end_matches(is_blank).len();
    let mut runs = Vec::new();
    let mut at = text.len() - text.trim_start_matches(is_blank).len();
    while let Some(start) = text[at..end].find(is_blank).map(|found| at + found) {
        let rest = &text[start..end];
        at = start + rest.len() - rest.trim_start_matches(is_blank).len();
        if &text[start..at] != " " {
            runs.push(start..at);
        }
    }
    runs
}
