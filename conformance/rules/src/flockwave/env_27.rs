//! `FW-ENV-27`.
//!
//! After a trial or a request without a response, the probe sends a request on another open connection and on a new
//! connection. These requests belong to this rule. The messages since the latest answered request are the suspects: one
//! of them ended the service. Without a suspect, the server stopped by itself, which violates nothing.
//!
//! If there are several suspects, and the server serves again, the probe sends each of them alone. The finding then
//! names the message that ends the service even if it is sent alone.

use uavspec_flockwave::record::Direction;
use uavspec_flockwave::session::message_excerpt;

use super::env_22;
use super::prelude::*;
use super::trial::SENT_ALONE;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
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
    fix: "Handle the errors of each connection separately. An error must end at most the connection that \
          caused it.",
})
.checks(&[Check::Session(|| Box::new(Suspects::default()))])
.bug(
    Bug::behaviour("After the message `{}`, no request is answered on any connection.")
        .also(&[&env_22::RULE.rule]),
)
.mutants(&[
    Mutant::connection(served::UNANSWERED, "tcp#9", |session| {
        session.sends_raw(KILLER);
        session.tries(&RULE.rule, "after a trial", json!({ "type": "SYS-PING" }));
    }),
    Mutant::connection(served::NO_CONNECTION, "tcp#9", |session| {
        session.sends_raw(KILLER);
        session.refused(&RULE.rule, "after a trial", "Connection refused");
    }),
    Mutant::connection("no connection over UDP", "udp#9", |session| {
        session.sends_raw(KILLER);
        session.refused(&RULE.rule, "after a trial", "no server listens");
    }),
]);

/// Text that ends the service in the mutants.
const KILLER: &str = "wind";

/// The maximum number of suspects.
const MAX_SUSPECTS: usize = 16;

/// The messages that may have ended the service.
#[derive(Default)]
struct Suspects {
    /// The messages since the latest answered request.
    sent: Vec<Suspect>,
    /// The description of the latest control request, and the suspects at that time.
    blamed: (String, Vec<Suspect>),
    /// The suspects at the time when the server closed a connection. The probe may find out later that no other cause
    /// explains this end.
    ended: PerConnection<Vec<Suspect>>,
    /// True if the server closed a connection. It may be shutting down, so further messages aren't suspects until the
    /// next response.
    is_doubtful: bool,
    /// The latest finding with several suspects.
    unclear: Option<Unclear>,
}

/// A finding with several suspects.
struct Unclear {
    subject: String,
    location: Location,
    /// The suspects that were not sent again.
    left: Vec<String>,
    /// True if the server still served requests after the latest suspect was sent again.
    is_served: bool,
}

/// A message that may have ended the service.
#[derive(Clone)]
struct Suspect {
    excerpt: String,
    location: Location,
    /// True for a request that shows only whether the server still serves.
    is_control: bool,
}

impl SessionCheck for Suspects {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        self.follow(exchange);
        if self.blamed.1.is_empty() && exchange.role != Role::Response {
            return;
        }
        let how = exchange.tried(&RULE.rule).unwrap_or_default();
        let is_ended = served::problem(exchange, &RULE.rule).is_some();
        if how.ends_with(SENT_ALONE) && is_ended {
            // The new finding replaces it.
            if let Some(Unclear { subject, location, .. }) = self.unclear.take() {
                context.findings.remove(context.rule, (&*subject).into(), None, (1, &[location]));
            }
        } else if how.ends_with(SENT_ALONE) && exchange.role == Role::Response {
            self.unclear.iter_mut().for_each(|unclear| unclear.is_served = true);
        }
        let suspects = &self.blamed.1;
        served::tried_as(&RULE.rule, exchange, context, |detail| blame(suspects, detail));
        if is_ended && likely(suspects).count() > 1 {
            let left = likely(suspects).map(|suspect| suspect.excerpt.clone()).collect();
            self.settle(context);
            let subject = how.split(": ").next().unwrap_or_default().to_owned();
            let location = exchange.record.location;
            self.unclear = Some(Unclear { subject, location, left, is_served: false });
        }
    }

    fn end(&mut self, context: &mut RuleContext<'_>) {
        self.settle(context);
    }
}

impl Suspects {
    /// Completes the finding with several suspects if none of them ended the service when it was sent alone.
    fn settle(&mut self, context: &mut RuleContext<'_>) {
        let unclear = self.unclear.take().filter(|unclear| unclear.left.is_empty() && unclear.is_served);
        if let Some(Unclear { subject, location, .. }) = unclear {
            context.findings.amend(context.rule, &subject, location, |detail| {
                detail.message.push_str("; sent alone, none of them ended the service");
            });
        }
    }

    fn follow(&mut self, exchange: &Exchange<'_>) {
        let record = exchange.record;
        let tried = record.trial.filter(|trial| trial.rule.id == RULE.rule.id);
        match exchange.role {
            Role::Unanswered => {}
            Role::Response if exchange.is_from_server() => {
                // A server on an ordered connection has not necessarily read the messages after the request.
                let answered = exchange.request.as_ref().filter(|_| exchange.record.connection.is_ordered);
                self.sent
                    .retain(|suspect| answered.is_some_and(|request| suspect.location > request.location));
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
        let record = exchange.record;
        let excerpt =
            record.value.map_or_else(|| exchange.excerpt(), |value| message_excerpt(value, "/body"));
        if let Some(unclear) = self.unclear.as_mut().filter(|unclear| unclear.left.contains(&excerpt)) {
            unclear.left.retain(|left| *left != excerpt);
            unclear.is_served = false;
        }
        let is_control = exchange.is_sound() && exchange.type_name == Some("SYS-VER");
        self.sent.push(Suspect { excerpt, location: record.location, is_control });
    }
}

/// The suspects, except for requests that only show whether the server still serves.
fn likely(suspects: &[Suspect]) -> impl Iterator<Item = &Suspect> {
    suspects.iter().filter(|suspect| !suspect.is_control)
}

/// Adds the suspects to the details of a finding.
fn blame(suspects: &[Suspect], detail: Detail) -> Detail {
    let mut likely = likely(suspects);
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
