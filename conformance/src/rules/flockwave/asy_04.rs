//! `FW-ASY-04`.

use serde_json::json;

use super::fw::{self, Role, Shape, Tree, Turn};
use super::{Check, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ASY-04",
        level: Level::Should,
        status: Status::Advisory,
        statement: "A receipt is a string of 1 to 64 characters.",
        source: fw::SCHEMA,
        applies_to: "replies with `receipt`",
    },
    check: Check::Exchange(judge),
    mutants: &[
        Mutant {
            name: "a number",
            make: || {
                fw::then(|talk| {
                    talk.asks(
                        json!({ "type": "UAV-RTH", "ids": ["kite"] }),
                        json!({ "receipt": { "kite": 7 } }),
                    );
                })
            },
            also: &[],
        },
        Mutant {
            name: "an empty one",
            make: || {
                fw::then(|talk| {
                    talk.asks(
                        json!({ "type": "UAV-RTH", "ids": ["kite"] }),
                        json!({ "receipt": { "kite": "" } }),
                    );
                })
            },
            also: &[],
        },
    ],
};

const RECEIPT: Shape = Shape::Length(1, 64);

fn judge(turn: &Turn<'_>, context: &mut RuleContext<'_>) {
    if turn.role != Role::Response || !turn.is_of_server() || !turn.type_name.is_some_and(fw::gives_receipts)
    {
        return;
    }
    let of_many = Shape::Map(&RECEIPT);
    let shape = if turn.type_name == Some("LOG-DATA") { &RECEIPT } else { &of_many };
    match turn.field("receipt") {
        None | Some(Tree::Null) => {}
        Some(_) => fw::field(turn, context, "receipt", true, shape),
    }
}
