//! `FW-ENV-09`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-09",
    name: "No references to notifications",
    level: Level::Must,
    status: Status::Normative,
    statement: "`refs` never contains the id of a notification.",
    source: source::GENERAL,
    applies_to: "responses over time",
    why: "Notifications are never answered. A client that looks up `refs` among its requests finds \
          nothing and reports an error.",
    example: r#"← {"$fw.version":"1.0","id":"s1","body":{"type":"OBJ-DEL","ids":["uav-1"]}}
← {"$fw.version":"1.0","id":"s2","refs":"s1","body":{"type":"ACK-ACK"}}"#,
    fix: "Set `refs` only in responses, and set it to the `id` of the request. Do not refer to your own \
          notifications.",
})
.checks(&[Check::Exchange(check)])
.bug(Bug::message("Each UAV-INF notification is followed by an ACK-ACK that refers to it.", |out| {
    if out.notification_of("UAV-INF").is_some() {
        let refs = out.message()["id"].as_str().unwrap_or_default().to_owned();
        out.follow(Some(&refs), json!({ "type": "ACK-ACK" }));
    }
}))
.mutants(&[Mutant::new("a response to a notification", || {
    let mut session = Session::opened();
    session.notify(json!({ "type": "SYS-MSG", "items": [{ "message": "Wind from the west" }] }));
    session.answers("say-1", json!({ "body": { "type": "ACK-ACK" } }));
    Some(session.to_bytes())
})]);

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if !reply::refers(exchange) {
        return;
    }
    context.covered();
    if exchange.reference == Reference::Notification {
        exchange.violates(context, || {
            let refs = exchange.refs.map(body::quoted).unwrap_or_default();
            Detail::new(format!("{refs} is the id of a notification, not of a request")).at("/refs")
        });
    }
}
