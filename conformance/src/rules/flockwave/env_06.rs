//! `FW-ENV-06`.
//!
//! Requests from before the recording aren't known, so this is judged only of connections whose beginning it shows.

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Reference, Rule, RuleContext, Status, body,
    mutant, reply, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-06",
        level: Level::Must,
        status: Status::Normative,
        statement: "`refs` of a response is the id of a request that was sent on the same connection.",
        source: source::GENERAL,
        applies_to: "responses over time",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Exchange(check)],
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
            mutant::then(|session| session.answers("nobody", answer()))
        },
        also: &[],
    }],
};

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if !reply::refers(exchange) {
        return;
    }
    context.covered();
    if exchange.reference == Reference::Unknown {
        exchange.violates(context, || {
            let refs = exchange.refs.map(body::quoted).unwrap_or_default();
            Detail::new(format!("no request on this connection has had the id {refs}")).at("/refs")
        });
    }
}
