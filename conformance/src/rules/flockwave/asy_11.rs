//! `FW-ASY-11`.

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Stage, Status, body, bug,
    mutant, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ASY-11",
        level: Level::Info,
        status: Status::Advisory,
        statement: "Nothing is told of a receipt after its end.",
        source: source::DERIVED,
        applies_to: "ASYNC-ST over time",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Exchange(check)],
    covers: &[],
    bug: Bug::message("Progress comes after the end.", |out| {
        if let Some(body) = out.body_of("ASYNC-RESP") {
            let receipt = body["id"].clone();
            out.follow(None, bug::progress(&receipt));
        }
    }),
    trial: None,
    mutants: &[Mutant {
        name: "progress after the end",
        make: || {
            let late = json!({ "type": "ASYNC-ST", "id": "rcpt-1", "progress": { "percentage": 80 } });
            mutant::then(|session| session.notify(late))
        },
        also: &[],
    }],
};

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if exchange.notification("ASYNC-ST").is_none() {
        return;
    }
    for named in exchange.operations.iter().filter(|_| exchange.record.connection.is_ordered) {
        context.covered();
        if named.stage() == Some(Stage::Ended) {
            exchange.violates(context, || {
                Detail::new(format!("the end of {} was told already", body::quoted(&named.receipt)))
                    .at("/body/id")
            });
        }
    }
}
