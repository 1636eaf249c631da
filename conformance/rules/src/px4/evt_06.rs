//! `PX-EVT-06`.

use uavspec_px4::checks::{Reports, Step};

use super::evt::Follow;
use super::prelude::*;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-EVT-06",
    name: "Order of a health and arming report",
    level: Level::Should,
    status: Status::Normative,
    statement: "A report starts with the summary of the group `arming_check`, continues with events \
                about problems, and ends with the summary of the group `health` for the same chunk.",
    source: "libevents (health and arming checks)",
    applies_to: "message sequences",
    why: "Ground stations drop incomplete reports and ignore problems outside of a report, so the \
          operator sees an older report, or no reason.",
    example: "commander_arming_check_summary\n\
              check_modes_local_pos\n\
              commander_arming_check_summary      (the first report has no end)",
    fix: "Send both summaries and the events between them without interruption by another report.",
})
.check(Check::State(|| Box::new(Follow::new(order))))
.mutants(&[Mutant::flight_in("a problem outside of a report", &[Encoding::Ulog], |flight| {
    let problem = &flight.messages[flight.last_event(1)?].value;
    flight.with_event(3, |event| {
        for field in ["id", "arguments"] {
            event[field] = problem[field].clone();
        }
    })
})]);

fn order(step: &Step, _: &Reports, context: &mut RuleContext<'_>) -> Option<Detail> {
    if *step != Step::Unrelated {
        context.covered();
    }
    let Step::Unexpected(why) = step else { return None };
    Some(Detail::new(*why).expected("the next part of the report"))
}
