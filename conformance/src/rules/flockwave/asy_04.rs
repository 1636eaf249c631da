//! `FW-ASY-04`.

use serde_json::json;

use super::{
    Attribution, Bug, Check, Exchange, Fault, FlockwaveRule, Level, Mutant, OPERATIONS, Role, Rule,
    RuleContext, Shape, Status, Tree, attribution, env_18, fw,
};

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ASY-04",
        level: Level::Should,
        status: Status::Advisory,
        statement: "A receipt is a string of 1 to 64 characters.",
        source: fw::SCHEMA,
        applies_to: "replies with `receipt`",
    },
    check: Check::Exchange(judge),
    covers: &[
        Attribution::new(&OPERATIONS, "receipt", &[Fault::Kind]),
        Attribution::new(&OPERATIONS, "receipt.*", attribution::UNFIT),
        Attribution::new(&["LOG-DATA"], "receipt", attribution::WRONG),
    ],
    bug: Bug::behaviour("Receipts are 70 characters long.").with(&[&env_18::RULE.rule]),
    trial: None,
    mutants: &[
        Mutant {
            name: "a number",
            make: || {
                fw::then(|session| {
                    session.asks(
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
                fw::then(|session| {
                    session.asks(
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

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if exchange.role != Role::Response
        || !exchange.is_of_server()
        || !exchange.type_name.is_some_and(fw::gives_receipts)
    {
        return;
    }
    let of_many = Shape::Map(&RECEIPT);
    let shape = if exchange.type_name == Some("LOG-DATA") { &RECEIPT } else { &of_many };
    match exchange.field("receipt") {
        None | Some(Tree::Null) => {}
        Some(_) => fw::field(exchange, context, "receipt", true, shape),
    }
}
