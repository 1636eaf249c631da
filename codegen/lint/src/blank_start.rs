//! `blank-start`: an empty line at the start of a file.

use uavspec_schema::msg::ast::Line;
use uavspec_schema::source::Span;

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "blank-start",
    statement: "An empty line at the start of a file.",
    why: "If an empty line precedes the first comment, the comment describes the next declaration and not \
        the message.",
    fix: "Remove the empty line.",
    levels: Levels::both(Level::Note),
    bad: Example { path: "Glider.msg", text: "\nuint64 timestamp  # [us] Time since system start\n" },
    good: Example { path: "Glider.msg", text: "uint64 timestamp  # [us] Time since system start\n" },
    measured: Some(Measured { findings: 4, sample: 4, right: 4 }),
    check: Check::Message(Scope::Px4, check),
};

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    // Check only the first part. The other parts of a service start after `---`.
    let source = subject.sources.span(subject.sources.source_of(subject.message.span));
    let lines = &subject.part.lines;
    let empty = lines.iter().take_while(|line| line.is_blank()).count();
    let starts = lines.first().is_some_and(|line| line.span.start == source.start);
    let Some(first) = lines.get(empty).filter(|_| empty > 0 && starts) else { return };
    let place = Span { start: source.start, end: source.start };
    let finding = sink.report(place, "an empty line at the start of the file", "remove it");
    let is_comment = |line: &Line<'_>| line.item.is_none();
    // Keep the empty line before a comment, which would otherwise become the description of the message.
    if !is_comment(first) {
        finding.edit(Span { start: source.start, end: first.span.start }, "");
    }
}
