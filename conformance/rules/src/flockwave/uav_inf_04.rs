//! `FW-UAV-INF-04`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UAV-INF-04",
    name: "Type of errors about UAVs",
    level: Level::Should,
    status: Status::Advisory,
    statement: "`error` maps ids to strings.",
    source: source::SCHEMA,
    applies_to: "UAV-INF",
    why: "Clients show the reason to the operator. If the reason is not a string, the message may fail to \
          decode, and its states are lost too.",
    example: r#"→ {"type":"UAV-INF","ids":["uav-9"]}
← {"type":"UAV-INF","error":{"uav-9":404}}"#,
    fix: "Send each reason as one human-readable string.",
})
.checks(&[Check::Message(check)])
.covers(&[
    Attribution::new(&["UAV-INF"], "error", &[Fault::Kind]),
    Attribution::new(&["UAV-INF"], "error.*", attribution::MISSING),
])
.bug(Bug::message("The values of `error` in UAV-INF are objects.", |out| {
    let Some(body) = out.body_of("UAV-INF") else { return };
    for error in body["error"].as_object_mut().into_iter().flat_map(|errors| errors.values_mut()) {
        *error = json!({ "reason": error.take() });
    }
    // Indexing an absent field inserts null.
    if body["error"].is_null()
        && let Some(body) = body.as_object_mut()
    {
        body.remove("error");
    }
}))
.mutants(&[Mutant::reply("a reason that is a number", "UAV-INF", |body| body["error"]["owl"] = 7.into())]);

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
