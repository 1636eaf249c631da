//! `trailing-white-space`: white space at the end of a line.

use uavspec_schema::Form;

use super::prelude::*;
use super::subject::SourceText;

pub(super) const RULE: Rule = Rule {
    id: "trailing-white-space",
    statement: "White space at the end of a line.",
    why: "Many editors remove such white space automatically, which adds unrelated lines to a commit.",
    fix: "Remove the white space.",
    levels: Levels::both(Level::Note),
    bad: Example {
        path: "Glider.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start \n",
    },
    good: glider![],
    measured: Some(Measured { findings: 0, sample: 0, right: 0 }),
    check: Check::Text(check),
};

fn check(text: &SourceText<'_>, sink: &mut Sink<'_>) {
    // In Markdown, two spaces at the end are a line break. Event metadata is written by programs.
    if !matches!(text.form, Form::Msg(_)) {
        return;
    }
    for (line, span) in text.lines() {
        let kept = line.trim_end_matches([' ', '\t']).len();
        if kept < line.len() {
            let place = span.part(kept..line.len());
            sink.report(place, "white space at the end of the line", "remove it").edit(place, "");
        }
    }
}
