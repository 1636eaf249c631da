//! `FW-ASY-20`.

use super::{
    Attribution, Bug, Check, ExpectedValue, FlockwaveRule, Level, Message, Mutant, Rule, RuleContext, Status,
    attribution, body, mutant, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ASY-20",
        level: Level::Must,
        status: Status::Normative,
        statement: "ASYNC-TIMEOUT has `ids`, a list of strings.",
        source: source::ASYNC,
        applies_to: "ASYNC-TIMEOUT",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Message(check)],
    covers: &[
        Attribution::new(&["ASYNC-TIMEOUT"], "ids", attribution::MISSING),
        Attribution::new(&["ASYNC-TIMEOUT"], "ids.*", attribution::MISSING),
    ],
    bug: Bug::message("ASYNC-TIMEOUT has its receipt as a text.", |out| {
        if let Some(body) = out.body_of("ASYNC-TIMEOUT") {
            body["ids"] = body["ids"][0].take();
        }
    }),
    trial: None,
    mutants: &[Mutant {
        name: "one id without a list",
        make: || mutant::notice("ASYNC-TIMEOUT", |body| body["ids"] = "rcpt-2".into()),
        also: &[],
    }],
};

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    if message.body_of("ASYNC-TIMEOUT").is_some() {
        body::field(message, context, "ids", true, &ExpectedValue::List(&ExpectedValue::Text));
    }
}
