//! `FW-AUTH-01`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-AUTH-01",
    name: "Result or challenge in AUTH-RESP",
    level: Level::Must,
    status: Status::Normative,
    statement: "AUTH-RESP has exactly one of `result` and `data`, and has `user` if and only if `result` \
                is true.",
    source: source::MESSAGES,
    applies_to: "AUTH-RESP",
    why: "The client does not know whether the login succeeded, failed or continues with another step. If \
          `user` is missing or unexpected, the client shows the wrong login state.",
    example: r#"{"type":"AUTH-RESP","result":false,"user":"alice"}"#,
    fix: "Send `data` if the login continues with another step, and `result` otherwise. Add `user` only \
          after a successful login.",
})
.checks(&[Check::Message(check)])
.bug(
    Bug::message("The response to a failed login has a `user`.", |out| {
        if let Some(body) = out.body_of("AUTH-RESP") {
            body["result"] = json!(false);
            body["user"] = json!("nobody");
        }
    })
    .needs(Needs::Login),
)
.mutants(&[
    Mutant::reply("both `result` and `data`", "AUTH-RESP", |body| body["data"] = "more".into()),
    Mutant::reply("a successful login without `user`", "AUTH-RESP", |body| mutant::remove(body, "user")),
    Mutant::reply("a failed login with `user`", "AUTH-RESP", |body| body["result"] = false.into()),
]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    let Some(body) = message.body_of("AUTH-RESP") else { return };
    body::exactly_one(message, context, &["result", "data"], "");
    let is_logged_in = body.get("result") == Some(&Tree::Bool(true));
    let user = body.get("user");
    // FW-ENV-26 reports null.
    if is_logged_in != body::is_present(user) && user != Some(&Tree::Null) {
        message.violates(context, || {
            let (what, path) = if is_logged_in {
                ("`result` is true, but `user` is missing", "/body")
            } else {
                ("`user` is present, but `result` is not true", "/body/user")
            };
            Detail::new(what).at(path)
        });
    }
}
