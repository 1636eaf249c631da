//! `FW-ASY-17`.
//!
//! The end may come before the answer to the request that brings it about, and then may still be the operation's own.
//! Progress that is told afterwards needn't mean that it goes on for long. So this is judged by what ends the operation
//! after that answer, and by its coming at all in good time ([`MAX_SECONDS`]) while the server speaks of other things.

use std::collections::{BTreeMap, VecDeque};

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Location, Mutant, PerConnection, Rule, RuleContext,
    Session, SessionCheck, Stage, Status, StatusReport, body, mutant, source,
};

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ASY-17",
        level: Level::Must,
        status: Status::Normative,
        statement: "An operation that a client has cancelled still ends in an ASYNC-RESP, with an error.",
        source: source::ASYNC,
        applies_to: "ASYNC-CANCEL over time",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Session(|| Box::new(Cancelled::default()))],
    covers: &[],
    bug: Bug::behaviour("Operations that were cancelled go on."),
    trial: None,
    mutants: &[
        Mutant {
            name: "nothing is told of its end",
            make: || {
                mutant::over("tcp#9", |session| {
                    cancel(session, "rcpt-40");
                    session.wait(2.0 * MAX_SECONDS);
                    session.notify(json!({ "type": "CONN-DEL", "ids": ["winch"] }));
                })
            },
            also: &[],
        },
        Mutant {
            name: "it has a result",
            make: || {
                mutant::over("tcp#9", |session| {
                    cancel(session, "rcpt-40");
                    session.notify(json!({ "type": "ASYNC-RESP", "id": "rcpt-40", "result": "Flaps out" }));
                })
            },
            also: &[],
        },
        Mutant {
            name: "it is timed out",
            make: || {
                mutant::over("tcp#9", |session| {
                    cancel(session, "rcpt-40");
                    session.notify(json!({ "type": "ASYNC-TIMEOUT", "ids": ["rcpt-40"] }));
                })
            },
            also: &[],
        },
    ],
};

/// How long a server may take to end what it has cancelled, in seconds.
const MAX_SECONDS: f64 = 10.0;

/// Of how many operations of a connection the end is waited for at the same time.
const MAX_CANCELLED: usize = 1_000;

/// An operation is begun, and cancelled.
fn cancel(session: &mut Session, receipt: &str) {
    session.command(receipt);
    session.exchange(json!({ "type": "ASYNC-CANCEL", "ids": [receipt] }), json!({ "success": [receipt] }));
}

/// What was cancelled, connection by connection.
#[derive(Default)]
struct Cancelled(PerConnection<Waiting>);

/// Operations whose end is waited for.
#[derive(Default)]
struct Waiting {
    /// Where the answer stands that says that it is cancelled, by receipt.
    receipts: BTreeMap<String, Location>,
    /// When those answers came, in that order; some operations have ended already.
    times: VecDeque<(f64, String, Location)>,
}

impl SessionCheck for Cancelled {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        if exchange.message().is_none() || !exchange.record.connection.is_ordered {
            return;
        }
        let waiting = self.0.get(exchange);
        waiting.end(exchange, context);
        waiting.pass(exchange.time, context);
        if exchange.response("ASYNC-CANCEL").is_some() {
            waiting.begin(exchange);
        }
    }

    fn status_report(&mut self, report: &StatusReport<'_>, context: &mut RuleContext<'_>) {
        if report.connection().is_ordered {
            self.0.at(report.connection_id()).pass(report.time(), context);
        }
    }

    fn corruption(&mut self, _: Location) {
        self.0.clear();
    }
}

impl Waiting {
    /// Operations are cancelled.
    fn begin(&mut self, exchange: &Exchange<'_>) {
        for named in &exchange.operations {
            let is_open = matches!(named.stage(), Some(Stage::Open | Stage::Suspended | Stage::Released));
            let has_room = self.receipts.len() < MAX_CANCELLED && self.times.len() < MAX_CANCELLED;
            if !is_open || !has_room || self.receipts.contains_key(&named.receipt) {
                continue;
            }
            let location = exchange.record.location;
            self.receipts.insert(named.receipt.clone(), location);
            self.times.extend(exchange.time.map(|time| (time, named.receipt.clone(), location)));
        }
    }

    /// Something is told of the end of operations.
    fn end(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        // Another operation has the same receipt.
        for named in &exchange.opened {
            self.receipts.remove(&named.receipt);
        }
        let actual = match exchange.type_name {
            Some("ASYNC-TIMEOUT") => Some("ASYNC-TIMEOUT"),
            Some("ASYNC-RESP") if body::is_there(exchange.field("error")) => None,
            // With neither it isn't known what it wants to say.
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
                    Detail::new(format!("{receipt} was cancelled, and ends in {actual}"))
                        .expected("ASYNC-RESP with an error")
                        .actual(actual)
                });
            }
        }
    }

    /// Time passes.
    fn pass(&mut self, time: Option<f64>, context: &mut RuleContext<'_>) {
        let Some(now) = time else { return };
        while self.times.front().is_some_and(|(time, ..)| now - time > MAX_SECONDS) {
            let Some((time, receipt, location)) = self.times.pop_front() else { break };
            // It may have ended since, and another may have its receipt.
            if self.receipts.get(&receipt) != Some(&location) {
                continue;
            }
            self.receipts.remove(&receipt);
            context.covered();
            context.violation("ASYNC-CANCEL", location, || {
                let receipt = body::quoted(&receipt);
                let waited = now - time;
                Detail::new(format!(
                    "{receipt} was cancelled, and for {waited:.0} s nothing was told of its end, though the server spoke"
                ))
                .expected("ASYNC-RESP with an error")
                .actual("none")
            });
        }
    }
}
