//! `FW-SYS-TIME-03`.
//!
//! It shows in the times that the server tells before and after. A clock that stands still or goes wrong moves against
//! that of the recording no faster than time passes, and is another rule's matter.

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, mutant, source,
    sys_time_02,
};
use crate::flockwave::session::ClockMove;

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-SYS-TIME-03",
        level: Level::Must,
        status: Status::Normative,
        statement: "An `adjustment` of 0 leaves the server's clock as it is.",
        source: source::MESSAGES,
        applies_to: "SYS-TIME over time",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Exchange(check)],
    covers: &[],
    bug: Bug::behaviour("An adjustment of 0 puts the clock forward by an hour."),
    trial: None,
    mutants: &[
        Mutant { name: "the clock is an hour ahead at once", make: || adjusted(1), also: &[] },
        Mutant { name: "the clock is an hour ahead afterwards", make: || adjusted(2), also: &[] },
    ],
};

/// The server's clock is an hour ahead from this answer on, of three.
fn adjusted(first: usize) -> Option<Vec<u8>> {
    mutant::over("tcp#9", |session| {
        let requests = [json!({}), json!({ "adjustment": 0 }), json!({})];
        for (at, mut request) in requests.into_iter().enumerate() {
            request["type"] = "SYS-TIME".into();
            let ahead = if at < first { 0 } else { 3_600_000 };
            let answer = json!({ "timestamp": session.now() + 40 + ahead });
            session.exchange(request, answer);
        }
    })
}

/// Whether a clock was adjusted by a request that should have left it as it is.
pub(super) fn is_adjusted(found: &ClockMove) -> bool {
    found.is_after_nothing && found.by > sys_time_02::TOLERANCE + found.since
}

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let Some(found) = exchange.clock_move.filter(|found| found.is_after_nothing) else { return };
    context.covered();
    if is_adjusted(&found) {
        exchange.violates(context, || {
            let by = found.by;
            Detail::new(format!(
                "the server's clock has moved by {by:.1} s, after it was to be adjusted by 0"
            ))
            .at("/body/timestamp")
        });
    }
}
