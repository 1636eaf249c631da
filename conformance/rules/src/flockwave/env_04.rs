//! `FW-ENV-04`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-04",
    name: "Unique message ids",
    level: Level::Must,
    status: Status::Normative,
    statement: "No two responses or notifications on a connection have the same id.",
    source: source::GENERAL,
    applies_to: "all messages from the server on a connection",
    why: "Clients that detect duplicates by id drop the second message, so a response or a state change \
          is lost.",
    example: r#"← {"$fw.version":"1.0","id":"s1","body":{"type":"OBJ-DEL","ids":["uav-1"]}}
← {"$fw.version":"1.0","id":"s1","body":{"type":"OBJ-DEL","ids":["uav-2"]}}"#,
    fix: "Create a new id for every message: a UUID, or a counter that is never reset on the connection.",
})
.checks(&[Check::Exchange(check), Check::StatusReport(check_status_report)])
.bug(Bug::message("All messages have the same id.", |out| out.message()["id"] = json!("s1")))
.mutants(&[Mutant::reply_message(
    "a response with the id of the previous response",
    "ACK-ACK",
    |message| message["id"] = "say-1".into(),
)]);

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let has_id = matches!(exchange.role, Role::Response | Role::Notification) && exchange.is_from_server();
    if !has_id || !exchange.record.connection.is_ordered {
        return;
    }
    let Some(id) = exchange.id else { return };
    context.covered();
    if exchange.is_id_in_use {
        exchange.violates(context, || in_use(id));
    }
}

fn check_status_report(report: &StatusReport<'_>, context: &mut RuleContext<'_>) {
    let Some(id) = report.id().filter(|_| report.connection().is_ordered) else { return };
    context.covered();
    if report.is_id_in_use() {
        report.violates(context, || in_use(id));
    }
}

fn in_use(id: &str) -> Detail {
    Detail::new(format!("an earlier message has the id {}", body::quoted(id))).at("/id")
}
