//! `PX-EXT-01`.
//!
//! A request may be missing in the recording: a logger may take only some, and a file may end too early. So a
//! reply that answers no known request waits for the next one. If that has the next number, none was missing, and
//! the reply is wrong unless it answers that very request and stands before it only in the file. Of a reply that is
//! older than all known requests nothing is said: a log begins with the latest message of each topic.

use super::ext::{Listener, Reply, Request, Requests, Talk, Waiting};
use super::{Change, Check, Detail, Level, Mutant, Px4Rule, Rule, RuleContext, Status};
use crate::rules::sample::Flight;

pub(super) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-EXT-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "An ArmingCheckReply answers a request that was sent: its `request_id` is that of the latest \
                ArmingCheckRequest, or of the one before.",
        source: "`request_id` of ArmingCheckReply and ArmingCheckRequest",
        applies_to: "messages over time",
        why: "",
        example: "",
        fix: "",
    },
    check: Check::State(|| Box::new(Talk::<Answers>::default())),
    mutants: &[
        Mutant {
            name: "a reply to a request of long ago",
            change: Change::Flight(|flight| stray(flight, 7)),
            also: &[],
        },
        Mutant {
            name: "a reply to a request that wasn't sent yet",
            change: Change::Flight(|flight| stray(flight, 255)),
            also: &[],
        },
    ],
};

#[derive(Default)]
struct Answers {
    requests: Requests,
    waiting: Waiting,
}

impl Listener for Answers {
    fn request(&mut self, _: &str, request: Request, context: &mut RuleContext<'_>) {
        let is_next = self.requests.push(request);
        for reply in self.waiting.take().into_iter().filter(|_| is_next) {
            context.covered();
            if !is_answer(&reply, self.requests.latest_at(reply.time)) {
                // When it came, this request wasn't there yet.
                report_violation(&reply, request.id.wrapping_sub(1), context);
            }
        }
    }

    fn reply(&mut self, reply: Reply, context: &mut RuleContext<'_>) {
        let then = self.requests.latest_at(reply.time);
        if [self.requests.latest(), then].iter().any(|request| is_answer(&reply, *request)) {
            context.covered();
        } else if then.is_some() {
            self.waiting.push(reply);
        }
    }

    fn forget(&mut self) {
        *self = Self::default();
    }

    /// The next request may be cut off. That of long ago isn't the next.
    fn end(&mut self, context: &mut RuleContext<'_>) {
        let Some(latest) = self.requests.latest().map(|request| request.id) else { return };
        for reply in self.waiting.take() {
            let is_behind = latest.wrapping_sub(reply.request_id) < 128;
            if is_behind && self.requests.len() > 1 {
                report_violation(&reply, latest, context);
            }
        }
    }
}

/// Whether a reply answers this request, or the one before it.
fn is_answer(reply: &Reply, request: Option<&Request>) -> bool {
    request.is_some_and(|request| request.id.wrapping_sub(reply.request_id) < 2)
}

fn report_violation(reply: &Reply, latest: u8, context: &mut RuleContext<'_>) {
    let before = latest.wrapping_sub(1);
    let definition = context.field(reply.definition, "request_id");
    context.violation_of(&format!("{}.request_id", reply.topic), reply.location, definition, || {
        let Reply { request_id, registration_id, .. } = reply;
        let text = format!(
            "registration {registration_id} answers request {request_id}, where {latest} is the latest"
        );
        Detail::new(text).expected(format!("{latest} or {before}")).actual(request_id.to_string())
    });
}

/// A reply more, which answers the request so many before the latest.
fn stray<'d>(flight: &Flight<'d>, behind: u8) -> Option<Flight<'d>> {
    flight.with_reply(|reply| {
        let id = reply["request_id"].as_u64().and_then(|id| u8::try_from(id).ok());
        reply["request_id"] = id.unwrap_or_default().wrapping_sub(behind).into();
    })
}
