//! `FW-ASY-12`.

use serde_json::json;

use super::{
    Attribution, Bug, Check, ExpectedValue, Fault, FlockwaveRule, Level, Message, Mutant, Rule, RuleContext,
    Status, attribution, body, mutant, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ASY-12",
        level: Level::Must,
        status: Status::Disputed(
            "The percentage may be null by the text, but not by the published schema; here it may.",
        ),
        statement: "ASYNC-ST has `id` and `progress`; its percentage is an integer from 0 to 100, and `suspended` true or false.",
        source: source::ASYNC,
        applies_to: "ASYNC-ST",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Message(check)],
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
            make: || mutant::notice("ASYNC-ST", |body| body["progress"]["percentage"] = 110.into()),
            also: &[],
        },
        Mutant {
            name: "no progress",
            make: || mutant::notice("ASYNC-ST", |body| mutant::remove(body, "progress")),
            also: &[],
        },
        Mutant {
            name: "`suspended` is a word",
            make: || mutant::notice("ASYNC-ST", |body| body["suspended"] = "no".into()),
            also: &[],
        },
    ],
};

const PERCENTAGE: ExpectedValue = ExpectedValue::Nullable(&ExpectedValue::Integer(0, 100));

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    if message.body_of("ASYNC-ST").is_none() {
        return;
    }
    body::field(message, context, "id", true, &ExpectedValue::Text);
    body::field(message, context, "progress", true, &ExpectedValue::Object);
    body::field(message, context, "suspended", false, &ExpectedValue::Nullable(&ExpectedValue::Bool));
    let keys = ["body", "progress"];
    body::member(message, context, message.field("progress"), &keys, ("percentage", false), &PERCENTAGE);
}
