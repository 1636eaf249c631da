//! `FW-ASY-19`.
//!
//! An operation may be suspended by itself just before; what the server has said so of may be resumed.

use serde_json::json;

use super::{
    Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, mutant, served, source,
};

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ASY-19",
        level: Level::Info,
        status: Status::Advisory,
        statement: "An operation that isn't suspended has an entry in `error` where it is to be resumed.",
        source: source::DERIVED,
        applies_to: "ASYNC-RESUME that tries it",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Exchange(check)],
    covers: &[],
    bug: Bug::behaviour("Operations that aren't suspended can be resumed."),
    trial: None,
    mutants: &[
        Mutant {
            name: "it is resumed",
            make: || {
                let resume = json!({ "type": "ASYNC-RESUME", "ids": ["rcpt-30"] });
                let done = json!({ "type": "ASYNC-RESUME", "success": ["rcpt-30"] });
                mutant::over("tcp#9", |session| {
                    session.command("rcpt-30");
                    session.tries_and_receives(&RULE.rule, "", resume, done);
                })
            },
            also: &[],
        },
        Mutant { name: "the request is refused", make: || mutant::refused("tcp#9", &RULE.rule), also: &[] },
    ],
};

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let is_clear = exchange
        .operations
        .iter()
        .all(|named| named.before.as_ref().is_some_and(|operation| !operation.was_suspended));
    if is_clear {
        served::in_error(exchange, context, &["ASYNC-RESUME"]);
    }
}
