//! `FW-ENV-27`.
//!
//! After a trial or a request without a response, the probe sends a request on another open connection and on a new
//! connection. These requests belong to this rule. The messages since the latest response are the suspects: one of them
//! ended the service. Without a suspect, the server stopped by itself, which violates nothing.

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, PerConnection, Role, Rule, RuleContext,
    SessionCheck, Status, body, env_22, mutant, served, source,
};
use crate::flockwave::record::Direction;
use crate::flockwave::session::message_excerpt;

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-27",
        name: "Clients do not affect each other",
        level: Level::Must,
        status: Status::Normative,
        statement: "No message ends the service: requests get a response, whatever another client has sent.",
        source: source::GENERAL,
        applies_to: "probe requests after a request or trial without a response",
        why: "If one message stops the service for all clients, a single faulty client grounds the whole fleet.",
        example: r#"(connection 1)
→ this is not JSON
(connection 2)
→ {"type":"SYS-VER"}
(no response)"#,
        fix: "Handle the errors of each connection separately. An error must end at most the connection that caused \
              it.",
    },
    checks: &[Check::Session(|| Box::new(Suspects::default()))],
    covers: &[],
    bug: Bug::behaviour("After the message `{}`, no request is answered on any connection.")
        .with(&[&env_22::RULE.rule]),
    trial: None,
    mutants: &[
        Mutant { name: served::UNANSWERED, make: unanswered, also: &[] },
        Mutant { name: served::NO_CONNECTION, make: no_connection, also: &[] },
        Mutant { name: "no connection over UDP", make: no_datagrams, also: &[] },
    ],
};

/// Text that ends the service in the mutants.
const KILLER: &str = "wind";

fn unanswered() -> Option<Vec<u8>> {
    mutant::over("tcp#9", |session| {
        session.sends_raw(KILLER);
        session.tries(&RULE.rule, "after a trial", json!({ "type": "SYS-PING" }));
    })
}

fn no_connection() -> Option<Vec<u8>> {
    mutant::over("tcp#9", |session| {
        session.sends_raw(KILLER);
        session.refused(&RULE.rule, "after a trial", "Connection refused");
    })
}

fn no_datagrams() -> Option<Vec<u8>> {
    mutant::over("udp#9", |session| {
        session.sends_raw(KILLER);
        session.refused(&RULE.rule, "after a trial", "no server listens");
    })
}

/// The maximum number of suspects.
const MAX_SUSPECTS: usize = 16;

/// The messages that may have ended the service.
#[derive(Default)]
struct Suspects {
    /// The messages since the latest response.
    sent: Vec<Suspect>,
    /// The suspects of the trial with this description.
    blamed: (String, Vec<Suspect>),
    /// The suspects at the time when the server closed a connection. The probe may find out later that no other cause
    /// explains this end.
    ended: PerConnection<Vec<Suspect>>,
    /// True if the server closed a connection. It may be shutting down, so further messages are no suspects until the
    /// next response.
    is_doubtful: bool,
}

/// A message that may have ended the service.
#[derive(Clone)]
struct Suspect {
    excerpt: String,
    /// True for a request that shows only whether the server still serves.
    is_control: bool,
}

impl SessionCheck for Suspects {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        self.follow(exchange);
        match &self.blamed.1[..] {
            [] if exchange.role != Role::Response => {}
            suspects => {
                served::tried_as(&RULE.rule, exchange, context, |detail| blame(suspects, detail));
            }
        }
    }
}

impl Suspects {
    fn follow(&mut self, exchange: &Exchange<'_>) {
        let record = exchange.record;
        let tried = record.trial.filter(|trial| trial.rule.id == RULE.rule.id);
        match exchange.role {
            Role::Unanswered => {}
            Role::Response if exchange.is_from_server() => {
                self.sent.clear();
                self.is_doubtful = false;
            }
            _ if tried.is_some() => {
                let how = tried.map_or("", |trial| trial.how);
                let ended = std::mem::take(self.ended.get(exchange));
                let suspects = if ended.is_empty() { self.sent.clone() } else { ended };
                if !suspects.is_empty() || self.blamed.0 != how {
                    self.blamed = (how.to_owned(), suspects);
                }
            }
            Role::Event if record.text == "closed" && record.note.is_some_and(|note| note != "client") => {
                self.is_doubtful = true;
                self.ended.get(exchange).clone_from(&self.sent);
            }
            Role::Event => {}
            _ if record.direction == Direction::Out => self.add(exchange),
            _ => {}
        }
    }

    /// Adds a message from the client.
    fn add(&mut self, exchange: &Exchange<'_>) {
        if self.is_doubtful || self.sent.len() >= MAX_SUSPECTS {
            return;
        }
        let value = exchange.record.value;
        let excerpt = value.map_or_else(|| exchange.excerpt(), |value| message_excerpt(value, "/body"));
        let is_control = exchange.is_sound() && exchange.type_name == Some("SYS-VER");
        self.sent.push(Suspect { excerpt, is_control });
    }
}

/// Adds the suspects to the details of a finding.
fn blame(suspects: &[Suspect], detail: Detail) -> Detail {
    let mut likely = suspects.iter().filter(|suspect| !suspect.is_control);
    let Some(first) = likely.next().or(suspects.first()) else { return detail };
    let others = likely.count();
    let more = match others {
        0 => String::new(),
        1 => " or the message after it".to_owned(),
        count => format!(" or one of the {count} messages after it"),
    };
    let message =
        format!("{}; the service ended after {}{more}", detail.message, body::quoted(&first.excerpt));
    Detail { message, request: first.excerpt.clone(), ..detail }
}
