//! `PX-EXT-02`.
//!
//! An id may have been assigned before the capture started. An unknown id is therefore wrong only if the capture
//! contains all registrations. A flight controller sends requests at regular intervals while at least one component is
//! registered. All registrations are therefore known under two conditions: a registration precedes the first request by
//! at most [`STARTUP_TIME`], and the request's mask contains only ids whose registration is in the capture. The mask
//! alone proves nothing, because it omits slow components. An old registration proves nothing either, because a log
//! starts with the latest message of each topic.
//!
//! If a request was sent after the release of an id, replies to the request must not contain that id. A reply to an
//! earlier request may have been sent before the release. If the mask of a later request contains the id, the id was
//! assigned again. Without masks, a component that continues to reply is assumed to be registered again
//! ([`REQUESTS_TO_WAIT`]).

use uavspec_types::px4::ArmingCheckReply;

use super::ext::{Ids, Listener, Reply, Request, TOLERANCE, Talk, Waiting, is_later};
use super::prelude::*;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-EXT-02",
    name: "Registered component",
    level: Level::Must,
    status: Status::Normative,
    statement: "The `registration_id` of an ArmingCheckReply was assigned by a successful \
                RegisterExtComponentReply and has not been unregistered since.",
    source: "`registration_id` of ArmingCheckReply, `arming_check_id` of RegisterExtComponentReply and \
             UnregisterExtComponent",
    applies_to: "message sequences",
    why: "The flight controller identifies the component by this id. If the id is wrong, the flight \
          controller ignores the reply or attributes the reply to another component.",
    example: "→ RegisterExtComponentReply {\"success\": true, \"arming_check_id\": 3, …}\n\
              → ArmingCheckRequest        {\"request_id\": 42, …}\n\
              ← ArmingCheckReply          {\"request_id\": 42, \"registration_id\": 9, …}",
    fix: "Check `success` in the RegisterExtComponentReply, and copy its `arming_check_id`. Send no \
          replies after UnregisterExtComponent.",
})
.check(Check::State(|| Box::new(Talk::<Registrations>::default())))
.bug(Bug::message(
    Side::Component,
    "After every fifth ArmingCheckReply, the component sends another one with `registration_id` 255.",
    |out| {
        out.follow(5, |reply: &mut ArmingCheckReply| reply.registration_id = u8::MAX);
    },
))
.mutants(&[
    Mutant::flight("a reply with an id that was never assigned", |flight| stranger(flight, 9)),
    Mutant::flight("a reply with an id that is never valid", |flight| stranger(flight, 255)),
    Mutant::flight("a reply with a released id", ghost),
]);

/// The maximum id, since `arming_check_id` is an int8. A component whose registration failed has the id -1, but may
/// send it as 255.
const MAX_REGISTRATION_ID: u8 = 127;

/// The maximum time from the first registration to the first request, in µs: twice PX4's request interval.
const STARTUP_TIME: u64 = 600_000;

/// The number of requests after which a component whose id was released counts as gone, if it sends no further reply.
const REQUESTS_TO_WAIT: u8 = 3;

/// The state of an id.
#[derive(Clone, Copy, Default)]
enum Known {
    #[default]
    Unknown,
    /// Assigned at this time.
    Assigned(Option<u64>),
    Released {
        when: Option<u64>,
        /// True if the latest request was sent after the release.
        is_past: bool,
    },
}

/// Indicates whether the capture contains all registrations.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
enum Whole {
    /// No message has been received yet.
    #[default]
    Open,
    /// The first message was a registration. Contains the time of the registration.
    Likely(u64),
    Yes,
    No,
}

struct Registrations {
    known: [Known; 256],
    whole: Whole,
    /// The start time of the capture; 0 if unknown.
    start: u64,
    /// The id of the latest request.
    request_id: Option<u8>,
    /// True if the latest request has a mask.
    is_masked: bool,
    waiting: Waiting,
    /// One reply from each component whose id appears to have been released. Only used if requests have no masks.
    suspects: Vec<Reply>,
}

impl Default for Registrations {
    fn default() -> Self {
        let known = [Known::Unknown; 256];
        Self {
            known,
            whole: Whole::Open,
            start: 0,
            request_id: None,
            is_masked: false,
            waiting: Waiting::default(),
            suspects: Vec::new(),
        }
    }
}

impl Listener for Registrations {
    fn started(&mut self, time: u64) {
        self.start = time;
    }

    fn request(&mut self, _: SubjectName<'_>, request: Request, context: &mut RuleContext<'_>) {
        self.check_suspects(request.id, context);
        self.request_id = Some(request.id);
        self.is_masked = request.mask.is_some();
        self.find_start(&request);
        self.learn(&request);
        for reply in self.waiting.take().into_iter().filter(|_| self.whole == Whole::Yes) {
            context.covered();
            if matches!(self.known[usize::from(reply.registration_id)], Known::Unknown) {
                report_violation(&reply, "was never assigned", context);
            }
        }
    }

    fn reply(&mut self, reply: Reply, context: &mut RuleContext<'_>) {
        if self.whole == Whole::Open {
            self.whole = Whole::No;
        }
        if reply.registration_id > MAX_REGISTRATION_ID {
            return report_violation(&reply, "is never valid", context);
        }
        match self.known[usize::from(reply.registration_id)] {
            Known::Assigned(_) => context.covered(),
            // The component's registration may be later in the file.
            Known::Unknown => self.waiting.push(reply),
            Known::Released { is_past, .. } => {
                if !is_past || self.request_id != Some(reply.request_id) {
                    return;
                }
                if self.is_masked {
                    report_violation(&reply, RELEASED, context);
                } else {
                    self.suspect(reply);
                }
            }
        }
    }

    fn registered(&mut self, id: u8, time: Option<u64>) {
        if self.whole == Whole::Open {
            let first = time.filter(|time| *time >= self.start);
            self.whole = first.map_or(Whole::No, Whole::Likely);
        }
        self.suspects.retain(|reply| reply.registration_id != id);
        let known = &mut self.known[usize::from(id)];
        match known {
            Known::Released { when, .. } if is_later(*when, time) => {}
            _ => *known = Known::Assigned(time),
        }
    }

    fn unregistered(&mut self, id: u8, time: Option<u64>) {
        if self.whole == Whole::Open {
            self.whole = Whole::No;
        }
        let known = &mut self.known[usize::from(id)];
        // A log starts with the latest message of each topic, and the order of the topics varies. This message may be
        // older than the registration.
        if let Known::Assigned(when) = known
            && when.zip(time).is_none_or(|(when, time)| when <= time)
        {
            *known = Known::Released { when: time, is_past: false };
        }
    }

    /// Resets everything. Registrations may be among the lost messages, so unknown ids are no longer reported.
    fn forget(&mut self) {
        *self = Self { whole: Whole::No, ..Self::default() };
    }
}

impl Registrations {
    /// Uses the first request to decide whether components were registered before the capture started.
    fn find_start(&mut self, request: &Request) {
        let is_assigned = |id: u8| matches!(self.known[usize::from(id)], Known::Assigned(_));
        self.whole = match (self.whole, request.mask, request.time) {
            (Whole::Yes, ..) => Whole::Yes,
            (Whole::Likely(first), Some(mask), Some(time))
                if first <= time.saturating_add(TOLERANCE)
                    && time <= first.saturating_add(STARTUP_TIME)
                    && Ids::from_mask(mask).iter().all(is_assigned) =>
            {
                Whole::Yes
            }
            _ => Whole::No,
        };
    }

    /// Updates the state of each id from a request's mask.
    fn learn(&mut self, request: &Request) {
        let mask = Ids::from_mask(request.mask.unwrap_or_default());
        for id in 0..=u8::MAX {
            let known = &mut self.known[usize::from(id)];
            let is_new = match known {
                Known::Unknown => mask.contains(id),
                Known::Assigned(_) => false,
                Known::Released { when, is_past } => {
                    // Without times, the order in the file decides.
                    *is_past = when.zip(request.time).is_none() || is_later(request.time, *when);
                    *is_past && mask.contains(id)
                }
            };
            if is_new {
                // The component was registered, but the capture doesn't contain the registration.
                *known = Known::Assigned(request.time);
                self.whole = Whole::No;
            }
        }
    }

    /// Handles a reply from a component that appears to be released.
    fn suspect(&mut self, reply: Reply) {
        let id = reply.registration_id;
        match self.suspects.iter().position(|known| known.registration_id == id) {
            None => self.suspects.push(reply),
            Some(at) if self.suspects[at].request_id == reply.request_id => {}
            // The component continues to reply, so it was registered again, but the capture doesn't contain that
            // registration.
            Some(at) => {
                self.suspects.remove(at);
                self.known[usize::from(id)] = Known::Assigned(None);
            }
        }
    }

    /// Reports the suspected components that have not replied again during the latest [`REQUESTS_TO_WAIT`] requests.
    fn check_suspects(&mut self, request_id: u8, context: &mut RuleContext<'_>) {
        let is_next = self.request_id.is_some_and(|latest| latest.wrapping_add(1) == request_id);
        if !is_next {
            self.suspects.clear();
        }
        self.suspects.retain(|reply| {
            let is_open = request_id.wrapping_sub(reply.request_id) < REQUESTS_TO_WAIT;
            if !is_open {
                report_violation(reply, RELEASED, context);
            }
            is_open
        });
    }
}

/// The error message for a reply from a released component.
const RELEASED: &str = "was released before the request";

fn report_violation(reply: &Reply, what: &str, context: &mut RuleContext<'_>) {
    reply.violation("registration_id", context, || {
        let id = reply.registration_id;
        Detail::new(format!("registration id {id} {what}"))
            .expected("an id from a RegisterExtComponentReply")
            .actual(id.to_string())
    });
}

/// Adds a reply with a different id.
fn stranger<'d>(flight: &Flight<'d>, id: u8) -> Option<Flight<'d>> {
    flight.with_reply(|reply| reply["registration_id"] = id.into())
}

/// Adds a reply from an unregistered component.
fn ghost<'d>(flight: &Flight<'d>) -> Option<Flight<'d>> {
    let left =
        flight.messages.iter().find(|sent| Some(sent.topic) == flight.topic("UnregisterExtComponent"))?;
    let id = left.value["arming_check_id"].clone();
    flight.with_reply(|reply| reply["registration_id"] = id)
}
