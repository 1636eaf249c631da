//! `FW-AUTH-01`.

use serde_json::json;

use super::{
    Bug, Check, Detail, FlockwaveRule, Level, Message, Mutant, Needs, Rule, RuleContext, Status, Tree, body,
    mutant, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-AUTH-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "AUTH-RESP has exactly one of `result` and `data`, and `user` exactly where `result` is true.",
        source: source::MESSAGES,
        applies_to: "AUTH-RESP",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Message(check)],
    covers: &[],
    bug: Bug::message("A failed login has a user.", |out| {
        if let Some(body) = out.body_of("AUTH-RESP") {
            body["result"] = json!(false);
            body["user"] = json!("nobody");
        }
    })
    .needs(Needs::Login),
    trial: None,
    mutants: &[
        Mutant {
            name: "both",
            make: || mutant::reply("AUTH-RESP", |body| body["data"] = "more".into()),
            also: &[],
        },
        Mutant {
            name: "nobody",
            make: || mutant::reply("AUTH-RESP", |body| mutant::remove(body, "user")),
            also: &[],
        },
        Mutant {
            name: "a user who isn't logged in",
            make: || mutant::reply("AUTH-RESP", |body| body["result"] = false.into()),
            also: &[],
        },
    ],
};

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    let Some(body) = message.body_of("AUTH-RESP") else { return };
    body::exactly_one(message, context, &["result", "data"], "");
    let is_logged_in = body.get("result") == Some(&Tree::Bool(true));
    if is_logged_in != body::is_there(body.get("user")) {
        message.violates(context, || {
            let (what, path) = if is_logged_in {
                ("`result` is true, and there is no `user`", "/body")
            } else {
                ("there is a `user`, and `result` isn't true", "/body/user")
            };
            Detail::new(what).at(path)
        });
    }
}
