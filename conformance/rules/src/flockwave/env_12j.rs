//! `FW-ENV-12J`.

use uavspec_flockwave::body_schema::INTEGER;

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-12J",
    name: "Types in an error",
    level: Level::Should,
    status: Status::Advisory,
    statement: "In the `error` of a message, `code` is an integer and `message` is a string.",
    source: source::SCHEMA,
    applies_to: "messages from the server",
    why: "Clients that validate messages cannot decode the error, so the operator does not learn the reason.",
    example: r#"{"$fw.version":"1.0","id":"s1","refs":"c1","error":{"code":"three"}}"#,
    fix: "Send a human-readable `message` as a string. Send `code` only if it is an integer.",
})
.checks(&[Check::Message(check)])
.bug(Bug::message(
    "The `error` after a request of an unknown type has a `message` that is a number.",
    |out| {
        if out.refuses_unknown_type()
            && let Some(message) = out.message().as_object_mut()
        {
            message.remove("body");
            message.insert("error".to_owned(), json!({ "message": 7 }));
        }
    },
))
.mutants(&[
    Mutant::session("a code that is a string", |session| {
        fails(session, &json!({ "code": "three", "message": "No" }));
    }),
    Mutant::session("a message that is a number", |session| {
        fails(session, &json!({ "code": 3, "message": 4 }));
    }),
]);

/// Adds a request that fails with this error.
fn fails(session: &mut Session, error: &Value) {
    let id = session.sends(json!({ "type": "LCN-INF" }));
    session.answers(&id, json!({ "error": error }));
}

const CODE: ExpectedValue = ExpectedValue::Nullable(&INTEGER);
const MESSAGE: ExpectedValue = ExpectedValue::Nullable(&ExpectedValue::Text);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    let error = message.value.get("error");
    for (name, schema) in [("code", &CODE), ("message", &MESSAGE)] {
        body::member(message, context, error, &["error"], (name, false), schema);
    }
}
