//! `FW-ENV-06`.
//!
//! Requests from before the recording aren't known, so this is judged only of connections whose beginning it shows.

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Reference, Rule, RuleContext, Status, fw,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-06",
        level: Level::Must,
        status: Status::Normative,
        statement: "`refs` of a response is the id of a request that was sent on the same connection.",
        source: fw::GENERAL,
        applies_to: "responses over time",
    },
    check: Check::Exchange(judge),
    covers: &[],
    bug: Bug::message("An acknowledgment that refers to no request follows each SYS-VER.", |out| {
        if out.kind() == "SYS-VER" {
            out.follow(Some("nobody-sent-this"), json!({ "type": "ACK-ACK" }));
        }
    }),
    trial: None,
    mutants: &[Mutant {
        name: "a response to what nobody asked",
        make: || {
            let answer = || json!({ "body": { "type": "ACK-ACK" } });
            fw::then(|session| session.answers("nobody", answer()))
        },
        also: &[],
    }],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if !fw::refers(exchange) {
        return;
    }
    context.covered();
    if exchange.reference == Reference::Unknown {
        exchange.breaks(context, || {
            let refs = exchange.refs.map(fw::quoted).unwrap_or_default();
            Detail::new(format!("no request on this connection has had the id {refs}")).at("/refs")
        });
    }
}
