//! `FW-ASY-13`.
//!
//! A recording shows it where an operation is resumed that nobody said to be suspended.

use serde_json::Value;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Session, Stage, Status,
    asy_19, body, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ASY-13",
        level: Level::Must,
        status: Status::Normative,
        statement: "That an operation is suspended is told by ASYNC-ST with `suspended` true.",
        source: source::ASYNC,
        applies_to: "ASYNC-RESUME over time",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Exchange(check)],
    covers: &[],
    bug: Bug::message("Nobody is told that an operation is suspended.", |out| {
        if let Some(body) = out.body_of("ASYNC-ST").and_then(Value::as_object_mut) {
            body.remove("suspended");
        }
    }),
    trial: None,
    mutants: &[Mutant {
        name: "it isn't told",
        make: || {
            let mut session = Session::new();
            for line in session.lines.iter_mut().filter(|line| line["msg"]["body"]["suspended"] == true) {
                line["msg"]["body"]["suspended"] = false.into();
            }
            Some(session.to_bytes())
        },
        also: &[],
    }],
};

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    // An operation that isn't suspended, and is to be resumed for a trial, is another rule's matter.
    if exchange.response("ASYNC-RESUME").is_none() || exchange.tried(&asy_19::RULE.rule).is_some() {
        return;
    }
    for named in exchange.operations.iter().filter(|named| named.is_known) {
        let Some(operation) = named.before.as_ref().filter(|known| known.stage != Stage::Early) else {
            continue;
        };
        context.covered();
        if !operation.was_suspended {
            exchange.violates(context, || {
                Detail::new(format!(
                    "{} was resumed, and nothing has told that it was suspended",
                    body::quoted(&named.receipt)
                ))
                .at("/body/success")
            });
        }
    }
}
