//! `FW-TCP-01`.
//!
//! If lines form a message only when joined, this rule reports them as a single message with line breaks. `FW-ENV-01`
//! reports all other lines that are not messages.

use super::lines::Lines;
use super::prelude::*;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-TCP-01",
    name: "One message per line over TCP",
    level: Level::Must,
    status: Status::Normative,
    statement: "Over TCP, each message is a single line: it ends with a line break and contains no other \
                line breaks.",
    source: source::TRANSPORT,
    applies_to: "messages from the server on connections whose name begins with `tcp`",
    why: "Clients split the stream at line breaks. A message that spans several lines becomes several \
          invalid messages. Two messages on one line become one invalid message.",
    example: r#"← {"$fw.version":"1.0","id":"s1",
←  "body":{"type":"OBJ-DEL","ids":["uav-1"]}}"#,
    fix: "Serialize without indentation or line breaks, and write one `\\n` after each message.",
})
.checks(&[Check::Session(|| Box::new(SplitMessages::default()))])
.bug(Bug::behaviour("Over TCP, notifications are split into several lines.").needs(Needs::Tcp))
.mutants(&[
    Mutant::connection("a message on several lines", "tcp#9", |session| {
        for line in [
            "{",
            "\"$fw.version\": \"1.0\", \"id\": \"{\\\"\",",
            "\"body\": { \"type\": \"OBJ-DEL\", \"ids\": [",
            "\"vane\"",
            "] } }",
        ] {
            session.send_raw(line);
        }
    }),
    Mutant::connection("three messages on one line", "tcp#9", |session| {
        let message =
            |id: &str| format!(r#"{{"$fw.version":"1.0","id":"{id}","body":{{"type":"OBJ-DEL","ids":[]}}}}"#);
        session.send_raw(&["a", "b", "c"].map(message).join(" "));
    }),
]);

/// Messages that are split into lines.
#[derive(Default)]
struct SplitMessages(Lines);

impl SessionCheck for SplitMessages {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        if exchange.is_from_server() && lines::name_starts_with(exchange.record.connection, "tcp") {
            context.covered();
        }
        if lines::has_several_messages(exchange, "tcp") {
            exchange.violates(context, || {
                Detail::new("several messages on one line").expected("one").actual("more than one")
            });
        } else {
            self.0.follow(exchange);
        }
        self.0.other.clear();
        for (line, count) in self.0.split.drain(..) {
            context.violation("message", line.location, || {
                Detail::new(format!("a message split into {count} lines"))
                    .expected("one line")
                    .actual(format!("{count} lines"))
                    .excerpt(line.excerpt)
            });
        }
    }

    fn status_report(&mut self, report: &StatusReport<'_>, context: &mut RuleContext<'_>) {
        if lines::name_starts_with(report.connection(), "tcp") {
            context.covered();
        }
        self.0.end_of(report.connection().index);
        self.0.other.clear();
    }

    fn corruption(&mut self, _: Location) {
        self.0.discard_open();
    }
}
