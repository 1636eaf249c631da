//! `FW-ASY-11`.

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Stage, Status, bug, fw,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ASY-11",
        level: Level::Info,
        status: Status::Advisory,
        statement: "Nothing is told of a receipt after its end.",
        source: fw::DERIVED,
        applies_to: "ASYNC-ST over time",
    },
    check: Check::Exchange(judge),
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
            fw::then(|session| session.tells(late))
        },
        also: &[],
    }],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if exchange.notification("ASYNC-ST").is_none() {
        return;
    }
    for named in exchange.operations.iter().filter(|_| exchange.record.connection.is_told) {
        context.covered();
        if named.stage() == Some(Stage::Ended) {
            exchange.breaks(context, || {
                Detail::new(format!("the end of {} was told already", fw::quoted(&named.receipt)))
                    .at("/body/id")
            });
        }
    }
}
