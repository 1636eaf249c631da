//! `FW-ASY-10`.
//!
//! That an operation isn't at its end when a recording ends says nothing, and how long one may take isn't laid down. So
//! its coming to an end is judged where someone tries it, with what takes no time ([`MAX_SECONDS`]).

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
        statement: "Each receipt ends in one ASYNC-RESP or ASYNC-TIMEOUT, and no more.",
        source: source::ASYNC,
        applies_to: "ASYNC-* over time",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Session(|| Box::new(Ends::default()))],
    covers: &[],
    bug: Bug::message("Nothing is heard of the end of operations.", |out| {
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
            name: "no end of what takes no time",
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

/// How long a server may tell nothing of an operation that takes no time, in seconds, while it speaks of other things.
const MAX_SECONDS: f64 = 18.0;

/// Of how many operations of a connection the end is waited for at the same time.
const MAX_OPEN: usize = 1_000;

/// Operations that try the rule: where they begin and when something was told of them last, by receipt.
type Open = BTreeMap<String, (Location, f64)>;

/// The operations that try the rule, connection by connection.
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
            once(exchange, context);
        }
        let open = self.0.get(exchange);
        let Some(now) = exchange.time else { return open.clear() };
        for named in &exchange.operations {
            let goes_on = exchange.type_name == Some("ASYNC-ST")
                && !matches!(exchange.field("suspended"), Some(Tree::Bool(true)));
            match open.get_mut(&named.receipt).filter(|_| goes_on) {
                Some((_, received)) => *received = now,
                // It ends, or waits for the client.
                None => _ = open.remove(&named.receipt),
            }
        }
        if served::tried(exchange, context) {
            for named in exchange.opened.iter().take(MAX_OPEN.saturating_sub(open.len())) {
                open.insert(named.receipt.clone(), (exchange.record.location, now));
            }
        }
        pass(open, now, context);
    }

    fn status_report(&mut self, report: &StatusReport<'_>, context: &mut RuleContext<'_>) {
        if !report.connection().is_ordered {
            return;
        }
        let open = self.0.at(report.connection_id());
        match report.time() {
            Some(now) => pass(open, now, context),
            None => open.clear(),
        }
    }

    fn corruption(&mut self, _: Location) {
        self.0.clear();
    }
}

/// No end is told twice.
fn once(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    for named in &exchange.operations {
        context.covered();
        if named.stage() == Some(Stage::Ended) {
            exchange.violates(context, || {
                Detail::new(format!("the end of {} was told already", body::quoted(&named.receipt)))
                    .at("/body")
            });
        }
    }
}

/// Reports the operations of which nothing was told for long.
fn pass(open: &mut Open, now: f64, context: &mut RuleContext<'_>) {
    open.retain(|receipt, (location, received)| {
        let waited = now - *received;
        if waited > MAX_SECONDS {
            context.violation("operation", *location, || {
                let receipt = body::quoted(receipt);
                Detail::new(format!(
                    "for {waited:.0} s nothing was told of {receipt}, nor of its end, though the server spoke"
                ))
                .expected("ASYNC-RESP or ASYNC-TIMEOUT")
                .actual("none")
            });
        }
        waited <= MAX_SECONDS
    });
}
