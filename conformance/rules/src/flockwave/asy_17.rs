//! `FW-ASY-17`.
//!
//! An operation that ends before the ASYNC-CANCEL response may have ended normally. A progress message that arrives
//! after that response does not prove that the operation is still running. The rule therefore checks only operations
//! that are still pending when the response arrives. Each of these operations must end with the correct message, and
//! within `MAX_SECONDS` if the server sends other messages.

use std::collections::{BTreeMap, VecDeque};

use super::prelude::*;
use crate::limits::MAX_CANCELLED;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ASY-17",
    name: "Cancelled operations end with an error",
    level: Level::Should,
    status: Status::Disputed(
        "The specification text requires an ASYNC-RESP with an error, but also allows a server to \
         continue a cancelled operation without informing the client. This rule requires the ASYNC-RESP.",
    ),
    statement: "A cancelled operation ends with an ASYNC-RESP that contains an error.",
    source: source::ASYNC,
    applies_to: "ASYNC-CANCEL over time",
    why: "The ASYNC-RESP confirms that the operation has stopped. Without confirmation, the UAV may still \
          be executing a command that the operator cancelled.",
    example: r#"→ {"type":"UAV-TAKEOFF","ids":["uav-1"]}
← {"type":"UAV-TAKEOFF","receipt":{"uav-1":"r1"}}
→ {"type":"ASYNC-CANCEL","ids":["r1"]}
← {"type":"ASYNC-CANCEL","success":["r1"]}
← {"type":"ASYNC-TIMEOUT","ids":["r1"]}"#,
    fix: "After you accept ASYNC-CANCEL, stop the operation and send ASYNC-RESP with an `error` such as \
          \"cancelled\".",
})
.checks(&[Check::Session(|| Box::new(Cancelled::default()))])
.bug(Bug::behaviour("Cancelled operations continue."))
.mutants(&[
    Mutant::connection("a cancelled operation that does not end", "tcp#9", |session| {
        cancel(session, "rcpt-40");
        session.wait(20.0);
        session.notify(json!({ "type": "CONN-DEL", "ids": ["winch"] }));
    }),
    Mutant::connection("a cancelled operation with a result", "tcp#9", |session| {
        cancel(session, "rcpt-40");
        session.notify(json!({ "type": "ASYNC-RESP", "id": "rcpt-40", "result": "Flaps out" }));
    }),
    Mutant::connection("a cancelled operation that times out", "tcp#9", |session| {
        cancel(session, "rcpt-40");
        session.notify(json!({ "type": "ASYNC-TIMEOUT", "ids": ["rcpt-40"] }));
    }),
]);

/// The maximum allowed time, in seconds, from the ASYNC-CANCEL response to the end of the operation.
const MAX_SECONDS: f64 = 10.0;

/// Adds an operation that the client cancels.
fn cancel(session: &mut Session, receipt: &str) {
    session.command(receipt);
    session.exchange(json!({ "type": "ASYNC-CANCEL", "ids": [receipt] }), json!({ "success": [receipt] }));
}

/// The cancelled operations, by connection.
#[derive(Default)]
struct Cancelled(PerConnection<Waiting>);

/// Cancelled operations that have not ended.
#[derive(Default)]
struct Waiting {
    /// The location of the ASYNC-CANCEL response, by receipt.
    receipts: BTreeMap<String, Location>,
    /// The times of the ASYNC-CANCEL responses, in order. Some of the cancelled operations may have ended.
    times: VecDeque<(f64, String, Location)>,
}

impl SessionCheck for Cancelled {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        if exchange.message().is_none() || !exchange.record.connection.is_ordered {
            return;
        }
        let waiting = self.0.get(exchange);
        waiting.end(exchange, context);
        waiting.report_overdue(exchange.time, context);
        if exchange.response("ASYNC-CANCEL").is_some() {
            waiting.begin(exchange);
        }
    }

    fn status_report(&mut self, report: &StatusReport<'_>, context: &mut RuleContext<'_>) {
        if report.connection().is_ordered {
            self.0.at(report.connection_id()).report_overdue(report.time(), context);
        }
    }

    fn corruption(&mut self, _: Location) {
        self.0.clear();
    }
}

impl Waiting {
    /// Adds the operations that a response reports as cancelled.
    fn begin(&mut self, exchange: &Exchange<'_>) {
        for named in &exchange.operations {
            let is_open = matches!(named.stage(), Some(Stage::Open | Stage::Suspended | Stage::Released));
            let has_room = self.receipts.len().max(self.times.len()) < MAX_CANCELLED;
            if !is_open || !has_room || self.receipts.contains_key(&named.receipt) {
                continue;
            }
            let location = exchange.record.location;
            self.receipts.insert(named.receipt.clone(), location);
            self.times.extend(exchange.time.map(|time| (time, named.receipt.clone(), location)));
        }
    }

    /// Removes the operations that this message ends. Reports operations that end with the wrong message.
    fn end(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        // A new operation reuses the receipt.
        for named in &exchange.opened {
            self.receipts.remove(&named.receipt);
        }
        let actual = match exchange.type_name {
            Some("ASYNC-TIMEOUT") => Some("ASYNC-TIMEOUT"),
            Some("ASYNC-RESP") if body::is_present(exchange.field("error")) => None,
            // If the message has neither a result nor an error, FW-ASY-07 reports it.
            Some("ASYNC-RESP") => exchange.field("result").map(|_| "a result"),
            _ => return,
        };
        for named in &exchange.operations {
            if self.receipts.remove(&named.receipt).is_none() {
                continue;
            }
            context.covered();
            if let Some(actual) = actual {
                exchange.violates(context, || {
                    let receipt = body::quoted(&named.receipt);
                    Detail::new(format!("{receipt} was cancelled but ended with {actual}"))
                        .expected("ASYNC-RESP with an error")
                        .actual(actual)
                });
            }
        }
    }

    /// Reports the operations that did not end in time.
    fn report_overdue(&mut self, time: Option<f64>, context: &mut RuleContext<'_>) {
        let Some(now) = time else { return };
        while self.times.front().is_some_and(|(time, ..)| now - time > MAX_SECONDS) {
            let Some((time, receipt, location)) = self.times.pop_front() else { break };
            // The operation may have ended, and another operation may reuse its receipt.
            if self.receipts.get(&receipt) != Some(&location) {
                continue;
            }
            self.receipts.remove(&receipt);
            context.covered();
            context.violation("ASYNC-CANCEL", location, || {
                let receipt = body::quoted(&receipt);
                let waited = now - time;
                Detail::new(format!(
                    "{receipt} was cancelled but did not end within {waited:.0} s, although the server sent other \
                     messages"
                ))
                .expected("ASYNC-RESP with an error")
                .actual("none")
            });
        }
    }
}
