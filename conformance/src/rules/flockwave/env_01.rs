//! `FW-ENV-01`.
//!
//! Where a message goes over TCP in several lines, and where there are several in one line or datagram, other rules tell of
//! it. So a line that may be the beginning of one is told of only once it is seen to be none.

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Lines, Location, Mutant, Rule, RuleContext, Session,
    SessionCheck, Status, StatusReport, lines, mutant, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "A message is one JSON object.",
        source: source::GENERAL,
        applies_to: "messages of the server",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Session(|| Box::new(Unreadable::default()))],
    covers: &[],
    bug: Bug::message("Notifications of UAV-INF come in an array.", |out| {
        if out.notification_of("UAV-INF").is_some() {
            let message = out.message().take();
            *out.message() = json!([message]);
        }
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "what the server sends is no JSON",
            make: || {
                let mut session = Session::new();
                session
                    .lines
                    .push(json!({ "t": 1.8e9, "conn": "hill", "dir": "in", "raw": "{\"$fw.version\":" }));
                Some(session.to_bytes())
            },
            also: &[],
        },
        Mutant {
            name: "lines that make up no message",
            make: || {
                mutant::over("tcp#9", |session| {
                    session.send_raw("{");
                    session.send_raw("\"wind\":");
                    session.notify(json!({ "type": "CONN-DEL", "ids": ["winch"] }));
                })
            },
            also: &[],
        },
        Mutant {
            name: "a list",
            make: || {
                let mut session = Session::new();
                session.lines.push(json!({ "t": 1.8e9, "conn": "hill", "dir": "in", "msg": [1] }));
                Some(session.to_bytes())
            },
            also: &[],
        },
    ],
};

/// What isn't known to be part of a message.
#[derive(Default)]
struct Unreadable(Lines);

impl Unreadable {
    fn report(&mut self, context: &mut RuleContext<'_>) {
        self.0.whole.clear();
        for line in self.0.other.drain(..) {
            context.violation("message", line.location, || {
                match line.actual {
                    Some(actual) => Detail::differs("an object", actual),
                    None => Detail::new("no JSON").expected("an object"),
                }
                .excerpt(line.excerpt)
            });
        }
    }
}

impl SessionCheck for Unreadable {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        if exchange.is_from_server() {
            context.covered();
        }
        if !lines::are_several(exchange, "tcp") && !lines::are_several(exchange, "udp") {
            self.0.follow(exchange);
        }
        self.report(context);
    }

    fn status_report(&mut self, report: &StatusReport<'_>, context: &mut RuleContext<'_>) {
        context.covered();
        self.0.end_of(report.connection().index);
        self.report(context);
    }

    fn corruption(&mut self, _: Location) {
        self.0.part_all();
    }

    fn end(&mut self, context: &mut RuleContext<'_>) {
        self.0.part_all();
        self.report(context);
    }
}
