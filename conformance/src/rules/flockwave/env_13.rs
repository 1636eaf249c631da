//! `FW-ENV-13`.
//!
//! What servers do with other keys that they don't know is seen where someone tries it.

use serde_json::json;

use super::{
    Bug, Check, Detail, FlockwaveRule, Level, Message, Mutant, Request, Rule, RuleContext, Status, Tree,
    Trial, body, mutant, served, source,
};

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-13",
        level: Level::Must,
        status: Status::Normative,
        statement: "No key of the envelope begins with `$` but `$fw.version`: such keys are reserved. A client may send any other.",
        source: source::GENERAL,
        applies_to: "messages of the server, and requests that try it",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Message(check), Check::Exchange(served::check)],
    covers: &[],
    bug: Bug::message("Messages have a key of their own that starts with $.", |out| {
        out.message()["$wind"] = json!("fair");
    }),
    trial: Some(Trial::Requests(|_| requests())),
    mutants: &[
        Mutant {
            name: "another key that begins so",
            make: || mutant::reply_message("SYS-VER", |message| message["$wind"] = 7.into()),
            also: &[],
        },
        Mutant {
            name: "a request with an unknown key is refused",
            make: || mutant::refused("tcp#9", &RULE.rule),
            also: &[],
        },
    ],
};

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    let Tree::Object(members) = message.value else { return };
    context.covered();
    let reserved = members.iter().find(|(key, _)| key.starts_with('$') && key != "$fw.version");
    if let Some((key, _)) = reserved {
        message.violates(context, || Detail::new(format!("the key {} is reserved", body::quoted(key))));
    }
}

fn requests() -> Vec<Request> {
    let request = Request::new("a key that nobody knows", json!({ "type": "SYS-VER" }));
    vec![Request { member: Some(("wind", "west".into())), ..request }]
}
