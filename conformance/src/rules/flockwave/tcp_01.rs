//! `FW-TCP-01`.
//!
//! Lines that are no messages, but make up one together, are one that holds line breaks. What they make up no message
//! with is no JSON at all, of which another rule tells.

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Lines, Location, Mutant, Rule, RuleContext,
    SessionCheck, Status, StatusReport, lines, mutant, source,
};

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-TCP-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "Over TCP each message ends with a line break, and holds none.",
        source: source::TRANSPORT,
        applies_to: "messages of the server on connections whose name begins with `tcp`",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Session(|| Box::new(SplitMessages::default()))],
    covers: &[],
    bug: Bug::behaviour("Over TCP, notifications are written in several lines."),
    trial: None,
    mutants: &[
        Mutant {
            name: "a message in several lines",
            make: || {
                mutant::over("tcp#9", |session| {
                    for line in [
                        "{",
                        "\"$fw.version\": \"1.0\", \"id\": \"{\\\"\",",
                        "\"body\": { \"type\": \"OBJ-DEL\", \"ids\": [",
                        "\"vane\"",
                        "] } }",
                    ] {
                        session.send_raw(line);
                    }
                })
            },
            also: &[],
        },
        Mutant {
            name: "three messages in a line",
            make: || {
                let message = |id: &str| {
                    format!(r#"{{"$fw.version":"1.0","id":"{id}","body":{{"type":"OBJ-DEL","ids":[]}}}}"#)
                };
                mutant::over("tcp#9", |session| session.send_raw(&["a", "b", "c"].map(message).join(" ")))
            },
            also: &[],
        },
    ],
};

/// Messages that are broken into lines.
#[derive(Default)]
struct SplitMessages(Lines);

impl SessionCheck for SplitMessages {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        if exchange.is_from_server() && lines::is_called(exchange.record.connection, "tcp") {
            context.covered();
        }
        if lines::are_several(exchange, "tcp") {
            exchange.violates(context, || {
                Detail::new("several messages in a line").expected("one").actual("more than one")
            });
        } else {
            self.0.follow(exchange);
        }
        self.0.other.clear();
        for (line, count) in self.0.whole.drain(..) {
            context.violation("message", line.location, || {
                Detail::new(format!("a message in {count} lines"))
                    .expected("one line")
                    .actual(format!("{count} lines"))
                    .excerpt(line.excerpt)
            });
        }
    }

    fn status_report(&mut self, report: &StatusReport<'_>, context: &mut RuleContext<'_>) {
        if lines::is_called(report.connection(), "tcp") {
            context.covered();
        }
        self.0.end_of(report.connection().index);
        self.0.other.clear();
    }

    fn corruption(&mut self, _: Location) {
        self.0.part_all();
    }
}
