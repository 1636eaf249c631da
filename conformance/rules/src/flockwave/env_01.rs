//! `FW-ENV-01`.
//!
//! Other rules report TCP messages that span several lines, and lines or datagrams that contain several messages. A
//! line that could be the start of a message is reported only after later lines show that it isn't.

use super::lines::Lines;
use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-01",
    name: "Messages are objects",
    level: Level::Must,
    status: Status::Normative,
    statement: "Each message is one JSON object.",
    source: source::GENERAL,
    applies_to: "messages from the server",
    why: "The client cannot decode any other form of data, so it drops the data or closes the connection.",
    example: r#"[{"$fw.version":"1.0","id":"s1","body":{"type":"OBJ-DEL","ids":["uav-1"]}}]"#,
    fix: "Serialize each message as one JSON object, with no wrapper and no other output on the connection.",
})
.checks(&[Check::Session(|| Box::new(Unreadable::default()))])
.bug(Bug::message("UAV-INF notifications are sent in an array.", |out| {
    if out.notification_of("UAV-INF").is_some() {
        let message = out.message().take();
        *out.message() = json!([message]);
    }
}))
.mutants(&[
    Mutant::new("data that is not JSON", || {
        let mut session = Session::new();
        session.lines.push(json!({ "t": 1.8e9, "conn": "hill", "dir": "in", "raw": "{\"$fw.version\":" }));
        Some(session.to_bytes())
    }),
    Mutant::connection("lines that do not form a message", "tcp#9", |session| {
        session.send_raw("{");
        session.send_raw("\"wind\":");
        session.notify(json!({ "type": "CONN-DEL", "ids": ["winch"] }));
    }),
    Mutant::new("a list", || {
        let mut session = Session::new();
        session.lines.push(json!({ "t": 1.8e9, "conn": "hill", "dir": "in", "msg": [1] }));
        Some(session.to_bytes())
    }),
]);

/// Lines that are not known to be part of a message.
#[derive(Default)]
struct Unreadable(Lines);

impl Unreadable {
    fn report(&mut self, context: &mut RuleContext<'_>) {
        self.0.split.clear();
        for line in self.0.other.drain(..) {
            context.violation("message", line.location, || {
                match line.actual {
                    Some(actual) => Detail::differs("an object", actual),
                    None => Detail::new("not JSON").expected("an object"),
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
        if !lines::has_several_messages(exchange, "tcp") && !lines::has_several_messages(exchange, "udp") {
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
        self.0.discard_open();
    }

    fn end(&mut self, context: &mut RuleContext<'_>) {
        self.0.discard_open();
        self.report(context);
    }
}
