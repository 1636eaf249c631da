//! `FW-ENV-13`.
//!
//! What servers do with other keys that they don't know is seen where someone tries it.

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Request, Rule, RuleContext, Status, Tree,
    Trial, fw,
};

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-13",
        level: Level::Must,
        status: Status::Normative,
        statement: "No key of the envelope begins with `$` but `$fw.version`: such keys are reserved. A client may send any other.",
        source: fw::GENERAL,
        applies_to: "messages of the server, and requests that try it",
    },
    check: Check::Exchange(judge),
    covers: &[],
    bug: Bug::message("Messages have a key of their own that starts with $.", |out| {
        out.message()["$wind"] = json!("fair");
    }),
    trial: Some(Trial::Requests(|_| requests())),
    mutants: &[
        Mutant {
            name: "another key that begins so",
            make: || fw::reply_message("SYS-VER", |message| message["$wind"] = 7.into()),
            also: &[],
        },
        Mutant {
            name: "a request with an unknown key is refused",
            make: || fw::refused("tcp#9", &RULE.rule),
            also: &[],
        },
    ],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    fw::served(exchange, context);
    let Some(Tree::Object(members)) = exchange.message() else { return };
    context.covered();
    let reserved = members.iter().find(|(key, _)| key.starts_with('$') && key != "$fw.version");
    if let Some((key, _)) = reserved {
        exchange.breaks(context, || Detail::new(format!("the key {} is reserved", fw::quoted(key))));
    }
}

fn requests() -> Vec<Request> {
    let request = Request::new("a key that nobody knows", json!({ "type": "SYS-VER" }));
    vec![Request { member: Some(("wind", "west".into())), ..request }]
}
