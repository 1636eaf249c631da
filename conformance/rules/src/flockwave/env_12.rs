//! `FW-ENV-12`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-12",
    name: "Content of an error",
    level: Level::Must,
    status: Status::Normative,
    statement: "The `error` of a message is an object with a `code`, a `message`, or both.",
    source: source::GENERAL,
    applies_to: "messages from the server",
    why: "Without `code` and `message`, the client has no error to show, so the operator learns only that \
          something failed.",
    example: r#"{"$fw.version":"1.0","id":"s1","refs":"c1","error":{}}"#,
    fix: "Send at least a human-readable `message`.",
})
.checks(&[Check::Message(check)])
.bug(Bug::message("Requests of unknown types are answered with an empty `error`.", |out| {
    if out.refuses_unknown_type()
        && let Some(message) = out.message().as_object_mut()
    {
        message.remove("body");
        message.insert("error".to_owned(), json!({}));
    }
}))
.mutants(&[
    Mutant::session("an empty error", |session| {
        let id = session.sends(json!({ "type": "LCN-INF" }));
        session.answers(&id, json!({ "error": {} }));
    }),
    Mutant::session("an error that is a string", |session| {
        let id = session.sends(json!({ "type": "LCN-INF" }));
        session.answers(&id, json!({ "error": "No" }));
    }),
]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    let Some(error) = message.value.get("error") else { return };
    if *error == Tree::Null {
        return;
    }
    context.covered();
    if !["code", "message"].iter().any(|name| body::is_present(error.get(name))) {
        message
            .violates(context, || Detail::differs("an object with `code` or `message`", error).at("/error"));
    }
}
