//! `PX-EXT-01`.
//!
//! A capture may lack requests: a logger may record only some of them, and a file may be truncated. A reply that
//! matches no known request therefore waits for the next request. If the ids of the requests are consecutive, no
//! request is missing. In that case, the reply is wrong, unless it answers the new request and was only recorded before
//! that request. A reply that is older than all known requests is not checked, because a log starts with the latest
//! message of each topic.

use uavspec_types::px4::ArmingCheckReply;

use super::ext::{Listener, Reply, Request, Requests, Talk, Waiting};
use super::prelude::*;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-EXT-01",
    name: "Request id of an arming check reply",
    level: Level::Must,
    status: Status::Normative,
    statement: "The `request_id` of an ArmingCheckReply is the id of one of the two latest \
                ArmingCheckRequests.",
    source: "`request_id` of ArmingCheckReply and ArmingCheckRequest",
    applies_to: "message sequences",
    why: "The flight controller matches replies to requests by this id. A reply with a different id is \
          useless, so the flight controller may consider the component unresponsive.",
    example: "→ ArmingCheckRequest {\"request_id\": 41, …}\n\
              → ArmingCheckRequest {\"request_id\": 42, …}\n\
              ← ArmingCheckReply   {\"request_id\": 35, \"registration_id\": 3, …}",
    fix: "Copy `request_id` from the request that the reply answers. Send the reply before the next \
          request arrives.",
})
.check(Check::State(|| Box::new(Talk::<Answers>::default())))
.bug(Bug::message(
    Side::Component,
    "After every fifth ArmingCheckReply, the component replies again to the request seven requests earlier.",
    |out| {
        out.follow(5, |reply: &mut ArmingCheckReply| reply.request_id = reply.request_id.wrapping_sub(7));
    },
))
.mutants(&[
    Mutant::flight("a reply to an old request", |flight| stray(flight, 7)),
    Mutant::flight("a reply to a request that was never sent", |flight| stray(flight, 255)),
]);

#[derive(Default)]
struct Answers {
    requests: Requests,
    waiting: Waiting,
}

impl Listener for Answers {
    fn request(&mut self, _: SubjectName<'_>, request: Request, context: &mut RuleContext<'_>) {
        let is_next = self.requests.push(request);
        for reply in self.waiting.take().into_iter().filter(|_| is_next) {
            context.covered();
            if !is_answer(&reply, self.requests.latest_at(reply.time)) {
                // The reply is older than this request.
                report_violation(&reply, request.id.wrapping_sub(1), context);
            }
        }
    }

    fn reply(&mut self, reply: Reply, context: &mut RuleContext<'_>) {
        let latest_then = self.requests.latest_at(reply.time);
        if [self.requests.latest(), latest_then].iter().any(|request| is_answer(&reply, *request)) {
            context.covered();
        } else if latest_then.is_some() {
            self.waiting.push(reply);
        }
    }

    fn forget(&mut self) {
        *self = Self::default();
    }

    /// Reports the waiting replies to old requests. Other replies may answer the next request, which may be missing
    /// from the capture.
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

/// True if a reply answers this request or the previous one.
fn is_answer(reply: &Reply, request: Option<&Request>) -> bool {
    request.is_some_and(|request| request.id.wrapping_sub(reply.request_id) < 2)
}

fn report_violation(reply: &Reply, latest: u8, context: &mut RuleContext<'_>) {
    let before = latest.wrapping_sub(1);
    reply.violation("request_id", context, || {
        let Reply { request_id, registration_id, .. } = reply;
        let text = format!(
            "registration {registration_id} answers request {request_id}, but the latest request is {latest}"
        );
        Detail::new(text).expected(format!("{latest} or {before}")).actual(request_id.to_string())
    });
}

/// Changes a reply so that it answers the request whose id is `behind` lower.
fn stray<'d>(flight: &Flight<'d>, behind: u8) -> Option<Flight<'d>> {
    flight.with_reply(|reply| {
        let id = reply["request_id"].as_u64().and_then(|id| u8::try_from(id).ok());
        reply["request_id"] = id.unwrap_or_default().wrapping_sub(behind).into();
    })
}
