//! `FW-UAV-INF-04`.

use serde_json::json;

use super::{
    Attribution, Bug, Check, ExpectedValue, Fault, FlockwaveRule, Level, Message, Mutant, Rule, RuleContext,
    Status, attribution, body, mutant, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UAV-INF-04",
        level: Level::Should,
        status: Status::Advisory,
        statement: "`error` maps ids to strings.",
        source: source::SCHEMA,
        applies_to: "UAV-INF",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Message(check)],
    covers: &[
        Attribution::new(&["UAV-INF"], "error", &[Fault::Kind]),
        Attribution::new(&["UAV-INF"], "error.*", attribution::MISSING),
    ],
    bug: Bug::message("Errors are objects.", |out| {
        let Some(body) = out.body_of("UAV-INF") else { return };
        for error in body["error"].as_object_mut().into_iter().flat_map(|errors| errors.values_mut()) {
            *error = json!({ "reason": error.take() });
        }
        // Reading a field that isn't there makes it one that is null.
        if body["error"].is_null()
            && let Some(body) = body.as_object_mut()
        {
            body.remove("error");
        }
    }),
    trial: None,
    mutants: &[Mutant {
        name: "a number for the reason",
        make: || mutant::reply("UAV-INF", |body| body["error"]["owl"] = 7.into()),
        also: &[],
    }],
};

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    if message.body_of("UAV-INF").is_some() {
        body::field(
            message,
            context,
            "error",
            false,
            &ExpectedValue::Nullable(&ExpectedValue::Map(&ExpectedValue::Text)),
        );
    }
}
