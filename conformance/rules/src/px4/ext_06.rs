//! `PX-EXT-06`.
//!
//! A capture may contain a message twice, for example because two routers forwarded it. Two replies therefore count as
//! different messages only if they differ in a value. The timestamp doesn't count, because PX4 sets it on reception.
//! Replies on different topics are not compared, because PX4's message translation node publishes each reply in several
//! versions.
//!
//! Request ids repeat after 256 requests, so only replies to the two latest requests in the file are compared. Their
//! times must differ by at most [`MAX_DISTANCE`]. If a reply answers neither request, requests may be missing from the
//! capture, and all replies so far are forgotten.

use std::collections::VecDeque;

use uavspec_types::px4::ArmingCheckReply;

use super::ext::{Listener, Reply, Request, Requests, Talk};
use super::prelude::*;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-EXT-06",
    name: "One reply to each request",
    level: Level::Must,
    status: Status::Normative,
    statement: "A component replies to an ArmingCheckRequest at most once.",
    source: "ArmingCheckRequest: each registered component answers with one ArmingCheckReply",
    applies_to: "message sequences",
    why: "The flight controller uses the last reply that it receives. If two replies differ, the result \
          of the arming check depends on their order. The replies also fill the queue of the topic, so \
          replies from other components may be lost.",
    example: "→ ArmingCheckRequest {\"request_id\": 42, …}\n\
              ← ArmingCheckReply   {\"request_id\": 42, \"registration_id\": 3, \
              \"can_arm_and_run\": true, …}\n\
              ← ArmingCheckReply   {\"request_id\": 42, \"registration_id\": 3, \
              \"can_arm_and_run\": false, …}",
    fix: "Send one reply when a request arrives. Report changes in the reply to the next request. Check \
          that only one instance of the component runs.",
})
.check(Check::State(|| Box::new(Talk::<Repetitions>::default())))
.bug(Bug::message(
    Side::Component,
    "The component changes every fifth ArmingCheckReply immediately.",
    |out| {
        out.follow(5, |reply: &mut ArmingCheckReply| reply.mode_req_mission = !reply.mode_req_mission);
    },
))
.mutants(&[Mutant::flight("a second reply with different values", |flight| {
    flight.with_reply(|reply| reply["can_arm_and_run"] = true.into())
})]);

/// The maximum time between two replies to the same request, in µs. Request ids repeat after a longer time.
const MAX_DISTANCE: u64 = 10_000_000;

/// The maximum number of stored replies. A flight controller registers far fewer components.
const REPLIES: usize = 64;

#[derive(Default)]
struct Repetitions {
    requests: Requests,
    /// The first reply of each component to each of the two latest requests.
    replies: VecDeque<Reply>,
}

impl Listener for Repetitions {
    const COMPARES_REPLIES: bool = true;

    fn request(&mut self, _: SubjectName<'_>, request: Request, _: &mut RuleContext<'_>) {
        if !self.requests.push(request) {
            self.replies.clear();
        }
        let requests = &self.requests;
        self.replies.retain(|reply| requests.recent(reply.request_id).is_some());
    }

    fn reply(&mut self, reply: Reply, context: &mut RuleContext<'_>) {
        if self.requests.recent(reply.request_id).is_none() {
            return self.replies.clear();
        }
        context.covered();
        let first = self.replies.iter().find(|first| is_to_same_request(first, &reply));
        match first {
            Some(first) if first.digest != reply.digest => report_violation(&reply, context),
            Some(_) => {}
            None => self.store(reply),
        }
    }

    /// Removes the replies with a newly registered id, because the id may have belonged to another component before.
    fn registered(&mut self, id: u8, _: Option<u64>) {
        self.replies.retain(|reply| reply.registration_id != id);
    }

    fn forget(&mut self) {
        *self = Self::default();
    }
}

impl Repetitions {
    fn store(&mut self, reply: Reply) {
        if self.replies.len() == REPLIES {
            self.replies.pop_front();
        }
        self.replies.push_back(reply);
    }
}

/// True if a component sent both replies to the same request.
fn is_to_same_request(first: &Reply, second: &Reply) -> bool {
    let is_near = first.time.zip(second.time).is_none_or(|(one, other)| one.abs_diff(other) <= MAX_DISTANCE);
    let key = |reply: &Reply| (reply.request_id, reply.registration_id);
    key(first) == key(second) && first.topic == second.topic && is_near
}

fn report_violation(reply: &Reply, context: &mut RuleContext<'_>) {
    reply.violation("request_id", context, || {
        let Reply { request_id, registration_id, .. } = reply;
        let text = format!(
            "registration {registration_id} answers request {request_id} twice, with different values"
        );
        Detail::new(text).expected("one reply").actual("two replies")
    });
}
