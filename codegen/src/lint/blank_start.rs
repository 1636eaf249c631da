//! `blank-start`: files start with something.

use super::rule::{Check, Levels, Measured, Rule, Sink};
use super::subject::Subject;
use crate::diagnostic::Level;
use crate::example::Example;
use crate::msg::ast::Line;
use crate::source::Span;

pub(super) const RULE: Rule = Rule {
    id: "blank-start",
    purpose: "A file starts with its description, not with an empty line. A comment below an empty line \
              describes what follows it, no longer the message.",
    levels: Levels::both(Level::Note),
    bad: Example { path: "Glider.msg", text: "\nuint64 timestamp  # [us] Time since system start\n" },
    good: Example { path: "Glider.msg", text: "uint64 timestamp  # [us] Time since system start\n" },
    measured: Some(Measured { findings: 4, sample: 4, right: 4, remark: "" }),
    check: Check::Message(check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    // Other parts of services start below a `---`.
    let source = subject.sources.span(subject.sources.source_of(subject.message.span));
    let lines = &subject.part.lines;
    let blank = lines.iter().take_while(|line| line.is_blank()).count();
    let starts = lines.first().is_some_and(|line| line.span.start == source.start);
    let Some(first) = lines.get(blank).filter(|_| subject.is_px4() && blank > 0 && starts) else { return };
    let place = Span { start: source.start, end: source.start };
    let finding = sink.report(place, "an empty line at the start of the file", "remove it");
    let is_comment = |line: &Line<'_>| line.item.is_none();
    // A comment would become the description of the message.
    if !is_comment(first) {
        finding.edit(Span { start: source.start, end: first.span.start }, "");
    }
}
