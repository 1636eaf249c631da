//! `FW-SYS-CLOSE-02`.
//!
//! Every request gets a response, so the responses to earlier requests may follow SYS-CLOSE. A response whose request is
//! unknown may answer an earlier request, so the rule doesn't report it.

use uavspec_flockwave::session::remembered::Remembered;

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-SYS-CLOSE-02",
    name: "Nothing follows SYS-CLOSE",
    level: Level::Info,
    status: Status::Advisory,
    statement: "After SYS-CLOSE, the server sends only responses to earlier requests, and closes the \
                connection.",
    source: source::DERIVED,
    applies_to: "SYS-CLOSE over time",
    why: "Clients close the connection or stop reading when SYS-CLOSE arrives, so they lose all later \
          messages.",
    example: r#"← {"type":"SYS-CLOSE","reason":"Restart"}
← {"type":"OBJ-DEL","ids":["uav-1"]}"#,
    fix: "Send SYS-CLOSE as the last message, then close the connection.",
})
.checks(&[Check::Session(|| Box::new(Closing::default()))])
.bug(Bug::message("SYS-CLOSE follows each SYS-VER response, and the connection stays open.", |out| {
    if out.kind() == "SYS-VER" {
        out.follow(None, json!({ "type": "SYS-CLOSE" }));
    }
}))
.mutants(&[Mutant::new("a message after SYS-CLOSE", || {
    let mut session = Session::new();
    let closed = session.lines.pop()?;
    session.notify(json!({ "type": "SYS-MSG", "items": [{ "message": "One more thing" }] }));
    session.lines.push(closed);
    Some(session.to_bytes())
})]);

/// The memory limit, in bytes.
const MEMORY_LIMIT: usize = 1 << 20;

/// The connections on which SYS-CLOSE was sent, each with the location of SYS-CLOSE.
struct Closing(Remembered<u64, Location>);

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
        let may_be_earlier = |closing: Location| {
            let request = exchange.request.as_ref();
            exchange.role == Role::Response && request.is_none_or(|request| request.location < closing)
        };
        match self.0.remove(&exchange.serial) {
            Some(closing) if may_be_earlier(closing) => self.0.insert(exchange.serial, closing, 0),
            Some(_) => exchange.violates(context, still_sends),
            None => {}
        }
        if exchange.body_of("SYS-CLOSE").is_some() {
            context.covered();
            self.0.insert(exchange.serial, exchange.record.location, 0);
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
