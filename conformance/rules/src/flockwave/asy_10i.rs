//! `FW-ASY-10I`.
//!
//! The specification sets no time limit, and a recording may end before the operation does. A missing end is therefore
//! reported only for short operations that a probe starts in order to test `FW-ASY-10`.

use std::collections::BTreeMap;

use super::prelude::*;
use super::{asy_10, asy_17};
use crate::limits::MAX_OPEN;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ASY-10I",
    name: "Short operations end in time",
    level: Level::Info,
    status: Status::Advisory,
    statement: "A short operation ends with ASYNC-RESP or ASYNC-TIMEOUT within 18 s of the latest message \
                about it.",
    source: source::DERIVED,
    applies_to: "probe requests that test this rule or FW-ASY-10",
    why: "Without a final message, the client waits forever.",
    example: r#"→ {"type":"UAV-TEST","ids":["uav-1"],"component":"led"}
← {"type":"UAV-TEST","receipt":{"uav-1":"r2"}}
(20 s later)
← {"type":"OBJ-DEL","ids":["uav-2"]}"#,
    fix: "Send one ASYNC-RESP or ASYNC-TIMEOUT for each receipt. If the UAV doesn't answer, send \
          ASYNC-TIMEOUT.",
})
.checks(&[Check::Session(|| Box::new(Ends::default()))])
.bug(
    Bug::message("ASYNC-RESP is never sent.", |out| {
        if out.kind() == "ASYNC-RESP" {
            out.message = None;
        }
    })
    .needs(Needs::Patience)
    .also(&[&asy_17::RULE.rule]),
)
.mutants(&[Mutant::connection("a short operation that does not end", "tcp#9", |session| {
    let test = json!({ "type": "UAV-TEST", "ids": ["kite"], "component": "lamp" });
    let id = session.tries(&asy_10::RULE.rule, "", test);
    let body = json!({ "type": "UAV-TEST", "receipt": { "kite": "rcpt-50" } });
    session.answers(&id, json!({ "body": body }));
    session.wait(20.0);
    session.notify(json!({ "type": "CONN-DEL", "ids": ["winch"] }));
})]);

/// The maximum allowed gap between messages about a short operation, in seconds, if the server sends other messages.
const MAX_SECONDS: f64 = 18.0;

/// The operations that test the rule. Maps each receipt to the location of the response and the time of the operation's
/// latest message.
type Open = BTreeMap<String, (Location, f64)>;

/// The operations that test the rule, by connection.
#[derive(Default)]
struct Ends(PerConnection<Open>);

impl SessionCheck for Ends {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        if !exchange.is_from_server() || !exchange.record.connection.is_ordered {
            return;
        }
        let open = self.0.get(exchange);
        let Some(now) = exchange.time else { return open.clear() };
        for named in &exchange.operations {
            let is_running = exchange.type_name == Some("ASYNC-ST")
                && !matches!(exchange.field("suspended"), Some(Tree::Bool(true)));
            match open.get_mut(&named.receipt).filter(|_| is_running) {
                Some((_, last_news)) => *last_news = now,
                // The operation has ended, or is waiting for the client.
                None => _ = open.remove(&named.receipt),
            }
        }
        let is_trial = [&asy_10::RULE.rule, &RULE.rule].iter().any(|rule| exchange.tried(rule).is_some());
        if exchange.role == Role::Response && is_trial {
            context.covered();
            let running = exchange.opened.iter().filter(|named| !named.has_ended_early());
            for named in running.take(MAX_OPEN.saturating_sub(open.len())) {
                open.insert(named.receipt.clone(), (exchange.record.location, now));
            }
        }
        report_overdue(open, now, context);
    }

    fn status_report(&mut self, report: &StatusReport<'_>, context: &mut RuleContext<'_>) {
        if !report.connection().is_ordered {
            return;
        }
        let open = self.0.at(report.connection_id());
        match report.time() {
            Some(now) => report_overdue(open, now, context),
            None => open.clear(),
        }
    }

    fn corruption(&mut self, _: Location) {
        self.0.clear();
    }
}

/// Reports and removes operations that have had no message for too long.
fn report_overdue(open: &mut Open, now: f64, context: &mut RuleContext<'_>) {
    open.retain(|receipt, (location, last_news)| {
        let waited = now - *last_news;
        if waited > MAX_SECONDS {
            context.violation("operation", *location, || {
                let receipt = body::quoted(receipt);
                Detail::new(format!(
                    "{receipt} did not end: the latest message about it is {waited:.0} s old, but the server sent other messages"
                ))
                .expected("ASYNC-RESP or ASYNC-TIMEOUT")
                .actual("none")
            });
        }
        waited <= MAX_SECONDS
    });
}
