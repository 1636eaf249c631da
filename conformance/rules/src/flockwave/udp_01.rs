//! `FW-UDP-01`.

use super::prelude::*;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UDP-01",
    name: "One message per datagram",
    level: Level::Must,
    status: Status::Normative,
    statement: "Over UDP, each datagram contains one message.",
    source: source::TRANSPORT,
    applies_to: "messages from the server on connections whose name begins with `udp`",
    why: "Clients parse each datagram as one JSON value. If a datagram contains two messages, both are lost.",
    example: r#"(one datagram)
← {"$fw.version":"1.0","id":"s1","body":{"type":"OBJ-DEL","ids":["uav-1"]}}
  {"$fw.version":"1.0","id":"s2","body":{"type":"OBJ-DEL","ids":["uav-2"]}}"#,
    fix: "Send each message in its own datagram. Do not collect several messages into one datagram.",
})
.checks(&[Check::Exchange(check), Check::StatusReport(check_status_report)])
.bug(Bug::behaviour("Over UDP, each notification is sent twice in one datagram.").needs(Needs::Udp))
.mutants(&[Mutant::connection("two messages in a datagram", "udp#9", |session| {
    let message =
        |id: &str| format!(r#"{{"$fw.version":"1.0","id":"{id}","body":{{"type":"OBJ-DEL","ids":[]}}}}"#);
    session.send_raw(&["a", "b"].map(message).join("\n"));
})]);

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if !exchange.is_from_server() || !lines::name_starts_with(exchange.record.connection, "udp") {
        return;
    }
    context.covered();
    if lines::has_several_messages(exchange, "udp") {
        exchange.violates(context, || {
            Detail::new("several messages in one datagram").expected("one").actual("more than one")
        });
    }
}

fn check_status_report(report: &StatusReport<'_>, context: &mut RuleContext<'_>) {
    if lines::name_starts_with(report.connection(), "udp") {
        context.covered();
    }
}
