//! `FW-ASY-11`.

use serde_json::json;

use super::fw::{self, Stage, Turn};
use super::{Check, Detail, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

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
    mutants: &[Mutant {
        name: "progress after the end",
        make: || {
            let late = json!({ "type": "ASYNC-ST", "id": "rcpt-1", "progress": { "percentage": 80 } });
            fw::then(|talk| talk.tells(late))
        },
        also: &[],
    }],
};

fn judge(turn: &Turn<'_>, context: &mut RuleContext<'_>) {
    if turn.notification("ASYNC-ST").is_none() {
        return;
    }
    for named in turn.operations.iter().filter(|_| turn.exchange.connection.is_told) {
        context.covered();
        if named.stage() == Some(Stage::Ended) {
            turn.breaks(context, || {
                Detail::new(format!("the end of {} was told already", fw::quoted(&named.receipt)))
                    .at("/body/id")
            });
        }
    }
}
