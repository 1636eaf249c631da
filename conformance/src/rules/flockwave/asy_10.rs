//! `FW-ASY-10`.
//!
//! The specification sets no time limit, and a recording may end before the operation does. A missing end is therefore
//! reported only for short operations that a probe starts in order to test this rule ([`MAX_SECONDS`]).

use std::collections::BTreeMap;

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Location, Mutant, PerConnection, Role, Rule,
    RuleContext, SessionCheck, Stage, Status, StatusReport, Tree, asy_17, body, mutant, served, source,
};

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ASY-10",
        level: Level::Must,
        status: Status::Normative,
        statement: "Exactly one ASYNC-RESP or ASYNC-TIMEOUT is sent for each receipt.",
        source: source::ASYNC,
        applies_to: "ASYNC-* over time",
        why: "Without a final message, the client waits forever. After two final messages, the client and the server \
              may disagree about the result.",
        example: r#"→ {"type":"UAV-TAKEOFF","ids":["uav-1"]}
← {"type":"UAV-TAKEOFF","receipt":{"uav-1":"r2"}}
← {"type":"ASYNC-TIMEOUT","ids":["r2"]}
← {"type":"ASYNC-RESP","id":"r2","result":true}"#,
        fix: "Send one ASYNC-RESP or ASYNC-TIMEOUT for each receipt and then delete the receipt. Discard any later \
              result.",
    },
    checks: &[Check::Session(|| Box::new(Ends::default()))],
    covers: &[],
    bug: Bug::message("ASYNC-RESP is never sent.", |out| {
        if out.kind() == "ASYNC-RESP" {
            out.message = None;
        }
    })
    .with(&[&asy_17::RULE.rule]),
    trial: None,
    mutants: &[
        Mutant {
            name: "a result after the timeout",
            make: || {
                mutant::then(|session| {
                    session.notify(json!({ "type": "ASYNC-RESP", "id": "rcpt-2", "result": "Flaps out" }));
                })
            },
            also: &[],
        },
        Mutant {
            name: "a second result",
            make: || {
                mutant::then(|session| {
                    session.notify(json!({ "type": "ASYNC-RESP", "id": "rcpt-1", "result": true }));
                })
            },
            also: &[],
        },
        Mutant {
            name: "a short operation that does not end",
            make: || {
                mutant::over("tcp#9", |session| {
                    let test = json!({ "type": "UAV-TEST", "ids": ["kite"], "component": "lamp" });
                    let id = session.tries(&RULE.rule, "", test);
                    let body = json!({ "type": "UAV-TEST", "receipt": { "kite": "rcpt-50" } });
                    session.answers(&id, json!({ "body": body }));
                    session.wait(2.0 * MAX_SECONDS);
                    session.notify(json!({ "type": "CONN-DEL", "ids": ["winch"] }));
                })
            },
            also: &[],
        },
    ],
};

/// The maximum allowed gap between messages about a short operation, in seconds, if the server sends other messages.
const MAX_SECONDS: f64 = 18.0;

/// The maximum number of tracked operations per connection.
const MAX_OPEN: usize = 1_000;

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
        if matches!(exchange.type_name, Some("ASYNC-RESP" | "ASYNC-TIMEOUT"))
            && exchange.role == Role::Notification
        {
            check_single_end(exchange, context);
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
        if served::tried(exchange, context) {
            for named in exchange.opened.iter().take(MAX_OPEN.saturating_sub(open.len())) {
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

/// Reports an operation that ends a second time.
fn check_single_end(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    for named in &exchange.operations {
        context.covered();
        if named.stage() == Some(Stage::Ended) {
            exchange.violates(context, || {
                Detail::new(format!("{} has already ended", body::quoted(&named.receipt))).at("/body")
            });
        }
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
                    "{receipt} did not end: no message about it for {waited:.0} s while the server sent other messages"
                ))
                .expected("ASYNC-RESP or ASYNC-TIMEOUT")
                .actual("none")
            });
        }
        waited <= MAX_SECONDS
    });
}
