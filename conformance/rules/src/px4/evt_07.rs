//! `PX-EVT-07`.

use uavspec_px4::checks::{Report, Reports, Step};

use super::evt::Follow;
use super::prelude::*;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-EVT-07",
    name: "Reasons in a health and arming report",
    level: Level::Info,
    status: Status::Advisory,
    statement: "A report has an event for each health component with an error, and for each named group \
                of modes in which the vehicle can't arm.",
    source: "derived: the summaries and the events state the same problems",
    applies_to: "message sequences",
    why: "Without an event, the operator sees that the vehicle can't arm, but not why.",
    example: "commander_arming_check_summary: error \"GPS\", can_arm nothing\n\
              commander_health_summary                (no event about the GPS)",
    fix: "Send an event wherever the code sets an error bit or clears a `can_arm` bit. PX4 also drops \
          events if the buffer of a report is full.",
})
.check(Check::State(|| Box::new(Follow::new(reasons))))
.mutants(&[
    Mutant::flight_in("a component with an error, but no event", &[Encoding::Ulog], |flight| {
        // The component with bit 1.
        flight.with_event(0, |event| event["arguments"][1] = 2.into())
    }),
    Mutant::flight_in("a mode without a reason", &[Encoding::Ulog], |flight| {
        flight.with_event(1, |event| event["arguments"][0] = 0xf8.into())
    }),
]);

fn reasons(step: &Step, reports: &Reports, context: &mut RuleContext<'_>) -> Option<Detail> {
    let report = reports.known().filter(|_| *step == Step::Complete)?;
    context.covered();
    let text = unexplained(report)?;
    Some(Detail::new(text).expected("an event that gives the reason"))
}

/// The components and modes whose problems no event reports. `None` if there are none.
fn unexplained(report: &Report) -> Option<String> {
    let components = report.components.iter().filter(|(bit, component)| {
        component.has_error && !report.problems.iter().any(|problem| problem.component == **bit)
    });
    let modes = report.modes.iter().filter(|(bit, mode)| {
        let affects = |mask: u64| mask.checked_shr(**bit).is_some_and(|rest| rest & 1 == 1);
        !mode.can_arm && !report.problems.iter().any(|problem| affects(problem.modes))
    });
    let names = components
        .map(|(_, component)| &component.name)
        .chain(modes.map(|(_, mode)| &mode.name))
        .map(String::as_str)
        .collect::<Vec<_>>();
    (!names.is_empty()).then(|| format!("the report has no event about {}", names.join(", ")))
}
