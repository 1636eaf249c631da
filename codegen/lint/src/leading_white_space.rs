//! `leading-white-space`: white space before a declaration.

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "leading-white-space",
    statement: "White space before a declaration.",
    why: "An indented declaration looks like part of the previous declaration, but messages have no such \
        structure.",
    fix: "Start the declaration in the first column.",
    levels: Levels::both(Level::Note),
    bad: glider!["  float32 sink  # [m/s] Sink rate"],
    good: glider!["float32 sink  # [m/s] Sink rate"],
    measured: Some(Measured { findings: 0, sample: 0, right: 0 }),
    check: Check::Message(Scope::Px4, check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    for (_, text, place) in subject.declarations() {
        let width = text.len() - text.trim_start_matches([' ', '\t']).len();
        if width > 0 {
            let place = place.part(0..width);
            sink.report(place, "white space before a declaration", "remove it").edit(place, "");
        }
    }
}
