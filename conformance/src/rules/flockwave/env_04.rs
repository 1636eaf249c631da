//! `FW-ENV-04`.

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Role, Rule, RuleContext, Status, fw,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-04",
        level: Level::Must,
        status: Status::Normative,
        statement: "No two responses and notifications of a connection have the same id.",
        source: fw::GENERAL,
        applies_to: "messages of the server over time",
    },
    check: Check::Context(judge),
    covers: &[],
    bug: Bug::message("All messages have the same id.", |out| out.message()["id"] = json!("s1")),
    trial: None,
    mutants: &[Mutant {
        name: "a response has the id of the one before",
        make: || fw::reply_message("ACK-ACK", |message| message["id"] = "say-1".into()),
        also: &[],
    }],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let is_named = matches!(exchange.role, Role::Response | Role::Notification) && exchange.is_of_server();
    if !is_named || !exchange.record.connection.is_told {
        return;
    }
    let Some(id) = exchange.id else { return };
    context.covered();
    if exchange.is_id_in_use {
        exchange.breaks(context, || {
            Detail::new(format!("another message has had the id {}", fw::quoted(id))).at("/id")
        });
    }
}
