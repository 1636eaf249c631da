//! `FW-ENV-13`.
//!
//! Only a probe shows how a server treats unknown keys in requests.

use super::prelude::*;

pub(crate) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-13",
    name: "Additional keys of the envelope",
    level: Level::Must,
    status: Status::Normative,
    statement: "The only key of the envelope that starts with `$` is `$fw.version`. In requests, the \
                server accepts all additional keys that do not start with `$`.",
    source: source::GENERAL,
    applies_to: "messages from the server, and probe requests that test this rule",
    why: "Later versions of the protocol may give a reserved key a meaning. If a server rejects \
          additional keys, it excludes all clients that send such keys.",
    example: r#"{"$fw.version":"1.0","$node":"a","id":"s1","body":{"type":"OBJ-DEL","ids":["uav-1"]}}"#,
    fix: "Rename keys that start with `$`. When you parse a request, ignore unknown keys in the envelope.",
})
.checks(&[Check::Message(check), Check::Exchange(served::check)])
.bug(Bug::message("Messages have a custom key that starts with `$`.", |out| {
    out.message()["$wind"] = json!("fair");
}))
.trial(Trial::Requests(|_| requests()))
.mutants(&[
    Mutant::reply_message("a reserved key", "SYS-VER", |message| message["$wind"] = 7.into()),
    Mutant::refused("a request with an unknown key is refused", "tcp#9"),
]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    let Tree::Object(members) = message.value else { return };
    context.covered();
    let reserved = members.iter().find(|(key, _)| key.starts_with('$') && key != "$fw.version");
    if let Some((key, _)) = reserved {
        message.violates(context, || Detail::new(format!("the key {} is reserved", body::quoted(key))));
    }
}

fn requests() -> Vec<Request> {
    let request = Request::new("an unknown key", json!({ "type": "SYS-VER" }));
    vec![Request { member: Some(("wind", "west".into())), ..request }]
}
