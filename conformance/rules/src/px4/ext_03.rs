//! `PX-EXT-03`.
//!
//! A capture may lack replies that were sent, because a logger may record only some of them. A component is therefore
//! checked only after it has answered several requests in a row ([`STREAK`]), which also gives it time to start. The
//! component must answer a request if the component's bit is set in the masks of this request and the next. The next
//! mask is needed because a component may be unregistered at any time, and because the flight controller doesn't wait
//! for slow components. Without masks, the registrations in the capture decide.
//!
//! Each request is checked only after two more requests, because its replies may appear late in the file. Many ROS 2
//! nodes send replies without a time. For such replies, only the order in the file shows whether a reply was late. A
//! single reply after the next request may still have been on time. If several consecutive replies come after the next
//! request, they count as late.

use std::collections::VecDeque;

use uavspec_types::px4::ArmingCheckReply;

use super::ext::{Ids, Listener, Reply, Request, Requests, Talk, Waiting, is_later};
use super::prelude::*;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-EXT-03",
    name: "Timely arming check replies",
    level: Level::Should,
    status: Status::Normative,
    statement: "Each registered component replies to each ArmingCheckRequest before the next request \
                arrives.",
    source: "ArmingCheckRequest",
    applies_to: "message sequences",
    why: "The flight controller needs the replies to know which external modes can run. A component that \
          does not reply is treated as unresponsive.",
    example: "→ ArmingCheckRequest {\"request_id\": 42, \"valid_registrations_mask\": 8, …}\n\
              \x20                    (no reply from registration 3)\n\
              → ArmingCheckRequest {\"request_id\": 43, \"valid_registrations_mask\": 8, …}",
    fix: "Reply to each request, even while the vehicle is armed. If the component can be busy for longer \
          than the request interval, handle requests in a separate thread.",
})
.check(Check::State(|| Box::new(Talk::<Silence>::default())))
.bug(Bug::message(Side::Component, "The component does not answer every sixth ArmingCheckRequest.", |out| {
    out.drop::<ArmingCheckReply>(6);
}))
.mutants(&[Mutant::flight("a missing reply", silent)]);

/// The number of consecutive replies after which a component is checked. Replies without a time count as late only if
/// this many in a row follow the next request.
const STREAK: u8 = 3;

/// A request with the components that answered it.
struct SentRequest {
    request: Request,
    /// The components that must answer.
    required: Ids,
    answered: Ids,
    /// The components that answered after the next request.
    late: Ids,
    /// The components whose reply has no time and follows the next request in the file.
    behind: Ids,
}

struct Silence {
    requests: Requests,
    /// The latest consecutive requests. At most two remain after each message.
    requests_sent: VecDeque<SentRequest>,
    /// Replies to unknown requests.
    waiting: Waiting,
    /// The components that are registered according to the capture.
    registered: Ids,
    /// For each id, the number of consecutive requests that the component answered.
    in_a_row: [u8; 256],
    /// For each id, the number of consecutive requests whose reply follows the next request in the file.
    behind_in_a_row: [u8; 256],
}

impl Default for Silence {
    fn default() -> Self {
        Self {
            requests: Requests::default(),
            requests_sent: VecDeque::new(),
            waiting: Waiting::default(),
            registered: Ids::default(),
            in_a_row: [0; 256],
            behind_in_a_row: [0; 256],
        }
    }
}

impl Listener for Silence {
    fn request(&mut self, topic: SubjectName<'_>, request: Request, context: &mut RuleContext<'_>) {
        if !self.requests.push(request) {
            self.requests_sent.clear();
        }
        let required = request.mask.map_or(self.registered, Ids::from_mask);
        let [answered, late, behind] = [Ids::default(); 3];
        let mut sent = SentRequest { request, required, answered, late, behind };
        for reply in self.waiting.take() {
            // The reply precedes the request in the file, but its timestamp is not earlier.
            if reply.request_id == request.id && !is_later(request.time, reply.time) {
                sent.answered.insert(reply.registration_id);
            }
        }
        self.requests_sent.push_back(sent);
        if self.requests_sent.len() > 2 {
            self.check_oldest(topic, context);
        }
    }

    fn reply(&mut self, reply: Reply, _: &mut RuleContext<'_>) {
        let Some(at) = self.requests_sent.iter().rposition(|sent| sent.request.id == reply.request_id) else {
            return self.waiting.push(reply);
        };
        let next = self.requests_sent.get(at + 1).map(|next| next.request.time);
        let id = reply.registration_id;
        let sent = &mut self.requests_sent[at];
        match next {
            Some(next) if is_later(reply.time, next) => return sent.late.insert(id),
            Some(next) if reply.time.zip(next).is_none() && !sent.answered.contains(id) => {
                sent.behind.insert(id);
            }
            _ => {}
        }
        sent.answered.insert(id);
    }

    /// Marks an id as registered, and restarts its counts, because the id may have belonged to another component
    /// before.
    fn registered(&mut self, id: u8, _: Option<u64>) {
        self.registered.insert(id);
        self.restart(id);
    }

    fn unregistered(&mut self, id: u8, _: Option<u64>) {
        self.registered.remove(id);
        self.restart(id);
    }

    fn forget(&mut self) {
        *self = Self::default();
    }
}

impl Silence {
    fn restart(&mut self, id: u8) {
        self.in_a_row[usize::from(id)] = 0;
        self.behind_in_a_row[usize::from(id)] = 0;
    }

    /// Checks the oldest request, once two more requests have arrived.
    fn check_oldest(&mut self, topic: SubjectName<'_>, context: &mut RuleContext<'_>) {
        let Some(oldest) = self.requests_sent.pop_front() else { return };
        let Some(next) = self.requests_sent.front() else { return };
        for id in oldest.required.iter().filter(|id| next.required.contains(*id)) {
            let in_a_row = &mut self.in_a_row[usize::from(id)];
            let behind = &mut self.behind_in_a_row[usize::from(id)];
            *behind = if oldest.behind.contains(id) { behind.saturating_add(1) } else { 0 };
            if *behind >= STREAK {
                report_violation(topic, &oldest, id, context);
            }
            if oldest.answered.contains(id) {
                *in_a_row = in_a_row.saturating_add(1);
            } else if *in_a_row < STREAK {
                *in_a_row = 0;
            } else {
                report_violation(topic, &oldest, id, context);
            }
            context.covered();
        }
    }
}

fn report_violation(topic: SubjectName<'_>, sent: &SentRequest, id: u8, context: &mut RuleContext<'_>) {
    let definition = context.defined(sent.request.definition);
    context.violation_of(topic, sent.request.location, definition, || {
        let request = sent.request.id;
        let (when, found) = if sent.late.contains(id) || sent.behind.contains(id) {
            ("replies after the next request", "a reply after the next request")
        } else {
            ("does not reply", "none")
        };
        Detail::new(format!("request {request}: registration {id} {when}"))
            .expected(format!("a reply from registration {id} before the next request"))
            .actual(found)
    });
}

/// Removes a reply in the middle of the flight.
fn silent<'d>(flight: &Flight<'d>) -> Option<Flight<'d>> {
    let at = flight.late_reply()?;
    let mut flight = flight.clone();
    flight.messages.remove(at);
    Some(flight)
}
