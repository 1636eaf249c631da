//! `FW-SYS-TIME-02`.
//!
//! A request that sets the clock gives another offset, and nothing is known of it then. Of one that sets it by nothing
//! another rule tells.

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Session, Status, mutant,
    source, sys_time_03, uav_inf_09,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-SYS-TIME-02",
        level: Level::Info,
        status: Status::Advisory,
        statement: "The time that a server tells lies between sending the request and receiving the answer, but for an offset that stays the same.",
        source: source::DERIVED,
        applies_to: "SYS-TIME over time",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Exchange(check)],
    covers: &[],
    bug: Bug::message("The clock of the server stands still.", |out| {
        out.set("SYS-TIME", "timestamp", json!(1_700_000_000_000_u64));
    })
    .with(&[&uav_inf_09::RULE.rule]),
    trial: None,
    mutants: &[
        Mutant {
            name: "the second answer is ahead",
            make: || {
                let later = |session: &mut Session| {
                    session.exchange(
                        json!({ "type": "SYS-TIME" }),
                        json!({ "timestamp": 1_800_000_000_000_u64 }),
                    );
                };
                mutant::then(later)
            },
            also: &[],
        },
        Mutant {
            name: "the time goes back",
            make: || {
                let before = |session: &mut Session| {
                    session.exchange(
                        json!({ "type": "SYS-TIME" }),
                        json!({ "timestamp": 1_780_000_000_000_u64 }),
                    );
                };
                mutant::then(before)
            },
            also: &[],
        },
    ],
};

/// How much clocks may drift apart from one answer to the next, in seconds.
pub(super) const TOLERANCE: f64 = 1.0;

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let Some(found) = exchange.clock_move else { return };
    context.covered();
    if found.by > TOLERANCE && !sys_time_03::is_adjusted(&found) {
        exchange.violates(context, || {
            let by = found.by;
            Detail::new(format!("the server's clock has moved by {by:.1} s against that of the recording"))
                .at("/body/timestamp")
        });
    }
}
