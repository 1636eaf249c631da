//! `conversion-undecided`: a difference between two packages that neither the definitions nor hints resolve.

use uavspec_dynamic::conversion::Conversions;

use super::prelude::*;
use super::rule::Converted;

pub(super) const RULE: Rule = Rule {
    id: "conversion-undecided",
    statement: "A difference between two packages that neither the definitions nor hints resolve.",
    why: "No conversion is generated for the message, because the meaning of its data could change.",
    fix: "Add a hint to the file that the key `hints` in the table `[[conversion]]` specifies.",
    levels: Levels::both(Level::Warning),
    bad: Example { path: "hints.toml", text: "# Nothing is decided yet.\n" },
    good: Example {
        path: "hints.toml",
        text: "# The sink rate needs no more than seven digits.\n[[hint]]\nmessage = \"Glider\"\nnarrow = { sink = \"nearest\" }\n",
    },
    measured: None,
    check: Check::Conversion(check),
};

fn check(subject: &Converted<'_>, sink: &mut Sink<'_>) {
    for found in subject.answer.conversions.iter().flat_map(Conversions::undecided) {
        let finding = sink.report(found.span, found.message.clone(), found.help.clone());
        if let Some(old) = found.old {
            finding.relate(old, "the old definition");
        }
    }
}
