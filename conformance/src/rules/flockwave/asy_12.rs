//! `FW-ASY-12`.

use serde_json::json;

use super::{
    Attribution, Bug, Check, Exchange, Fault, FlockwaveRule, Level, Mutant, Rule, RuleContext, Shape, Status,
    attribution, fw,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ASY-12",
        level: Level::Must,
        status: Status::Disputed(
            "The percentage may be null by the text, but not by the published schema; here it may.",
        ),
        statement: "ASYNC-ST has `id` and `progress`; its percentage is an integer from 0 to 100, and `suspended` true or false.",
        source: fw::ASYNC,
        applies_to: "ASYNC-ST",
    },
    check: Check::Exchange(judge),
    covers: &[
        Attribution::new(&["ASYNC-ST"], "id", attribution::MISSING),
        Attribution::new(&["ASYNC-ST"], "progress", attribution::MISSING),
        Attribution::new(&["ASYNC-ST"], "progress.percentage", attribution::WRONG),
        Attribution::new(&["ASYNC-ST"], "suspended", &[Fault::Kind]),
    ],
    bug: Bug::message("More than all is done.", |out| {
        if let Some(body) = out.body_of("ASYNC-ST") {
            body["progress"]["percentage"] = json!(140);
        }
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "110 percent",
            make: || fw::notice("ASYNC-ST", |body| body["progress"]["percentage"] = 110.into()),
            also: &[],
        },
        Mutant {
            name: "no progress",
            make: || fw::notice("ASYNC-ST", |body| fw::remove(body, "progress")),
            also: &[],
        },
        Mutant {
            name: "`suspended` is a word",
            make: || fw::notice("ASYNC-ST", |body| body["suspended"] = "no".into()),
            also: &[],
        },
    ],
};

const PERCENTAGE: Shape = Shape::Nullable(&Shape::Integer(0, 100));

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if exchange.body_of("ASYNC-ST").is_none() {
        return;
    }
    fw::field(exchange, context, "id", true, &Shape::Text);
    fw::field(exchange, context, "progress", true, &Shape::Object);
    fw::field(exchange, context, "suspended", false, &Shape::Nullable(&Shape::Bool));
    let keys = ["body", "progress"];
    fw::member(exchange, context, exchange.field("progress"), &keys, ("percentage", false), &PERCENTAGE);
}
