//! `FW-SYS-CLOSE-02`.

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Session, SessionCheck,
    Status, StatusReport, source,
};
use crate::flockwave::session::remembered::Remembered;

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-SYS-CLOSE-02",
        name: "Nothing follows SYS-CLOSE",
        level: Level::Info,
        status: Status::Advisory,
        statement: "After SYS-CLOSE, the server sends no more messages and closes the connection.",
        source: source::DERIVED,
        applies_to: "SYS-CLOSE over time",
        why: "Clients close the connection or stop reading when SYS-CLOSE arrives, so they lose all later messages.",
        example: r#"← {"type":"SYS-CLOSE","reason":"Restart"}
← {"type":"OBJ-DEL","ids":["uav-1"]}"#,
        fix: "Send SYS-CLOSE as the last message, then close the connection.",
    },
    checks: &[Check::Session(|| Box::new(Closing::default()))],
    covers: &[],
    bug: Bug::message("SYS-CLOSE follows each SYS-VER response, and the connection stays open.", |out| {
        if out.kind() == "SYS-VER" {
            out.follow(None, json!({ "type": "SYS-CLOSE" }));
        }
    }),
    trial: None,
    mutants: &[Mutant {
        name: "a message after SYS-CLOSE",
        make: || {
            let mut session = Session::new();
            let closed = session.lines.pop()?;
            session.notify(json!({ "type": "SYS-MSG", "items": [{ "message": "One more thing" }] }));
            session.lines.push(closed);
            Some(session.to_bytes())
        },
        also: &[],
    }],
};

/// The memory limit, in bytes.
const MEMORY_LIMIT: usize = 1 << 20;

/// The connections on which SYS-CLOSE was sent.
struct Closing(Remembered<u64, ()>);

impl Default for Closing {
    fn default() -> Self {
        Self(Remembered::new(MEMORY_LIMIT))
    }
}

impl SessionCheck for Closing {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        if !exchange.is_from_server() || !exchange.record.connection.is_ordered {
            return;
        }
        if self.0.remove(&exchange.serial).is_some() {
            exchange.violates(context, still_sends);
        }
        if exchange.body_of("SYS-CLOSE").is_some() {
            context.covered();
            self.0.insert(exchange.serial, (), 0);
        }
    }

    fn status_report(&mut self, report: &StatusReport<'_>, context: &mut RuleContext<'_>) {
        if report.connection().is_ordered && self.0.remove(&report.connection_id().serial).is_some() {
            report.violates(context, still_sends);
        }
    }
}

fn still_sends() -> Detail {
    Detail::new("the server sends a message after SYS-CLOSE")
}
