//! `PX-EXT-03`.
//!
//! That an answer isn't in a recording doesn't yet say that none was sent: a logger may take only some of them. So
//! a component is judged once it answered some requests in a row ([`MAX_MISSES`]), which also gives it time to start.
//! It has to answer a request if its bit is set in the mask of this one and still in that of the next, since it may
//! leave at any time, and a flight controller doesn't wait for those that were slow too often. Releases without
//! masks leave what was said of registrations.
//!
//! A request is judged with the second one after it, so that answers may stand late in the file. Where an answer has no
//! time, as those of ROS 2 nodes often have none, only the order of arrival says whether it came late. One that stands
//! behind the next request may have been in time all the same, but not several in a row.

use std::collections::VecDeque;

use super::ext::{Ids, Listener, Reply, Request, Requests, Talk, Waiting, is_later};
use super::{Change, Check, Detail, Level, Mutant, Px4Rule, Rule, RuleContext, Status};
use crate::rules::sample::Flight;

pub(super) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-EXT-03",
        level: Level::Should,
        status: Status::Normative,
        statement: "Each registered component replies to each ArmingCheckRequest before the next one.",
        source: "ArmingCheckRequest",
        applies_to: "messages over time",
        why: "",
        example: "",
        fix: "",
    },
    check: Check::State(|| Box::new(Talk::<Silence>::default())),
    mutants: &[Mutant { name: "a reply is missing", change: Change::Flight(silent), also: &[] }],
};

/// How many requests in a row a component answers until its answers are known to be in the recording; and how many
/// answers without a time stand behind the next request until they are known to be late.
const MAX_MISSES: u8 = 3;

/// A request that was sent, and what came of it.
struct SentRequest {
    request: Request,
    /// Those of which it asks an answer.
    who: Ids,
    answered: Ids,
    /// Those that answered when the next request was there already.
    late: Ids,
    /// Those whose answer stands behind the next request, and it isn't known when they gave it.
    behind: Ids,
}

struct Silence {
    requests: Requests,
    /// The latest requests, none of which is missing; at most two between messages.
    requests_sent: VecDeque<SentRequest>,
    /// Replies to what isn't known, or not yet.
    waiting: Waiting,
    /// By what was said of registrations.
    registered: Ids,
    /// How many requests in a row each id answered.
    in_a_row: [u8; 256],
    /// How many requests in a row each id answered only behind the next one.
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
    fn request(&mut self, topic: &str, request: Request, context: &mut RuleContext<'_>) {
        if !self.requests.push(request) {
            self.requests_sent.clear();
        }
        let who = request.mask.map_or(self.registered, Ids::from_mask);
        let [answered, late, behind] = [Ids::default(); 3];
        let mut sent = SentRequest { request, who, answered, late, behind };
        for reply in self.waiting.take() {
            // It stands before the request only in the file.
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

    /// Who comes isn't the one that had this id before; who goes needn't have answered.
    fn registered(&mut self, id: u8, _: Option<u64>) {
        self.registered.insert(id);
        self.begin_anew(id);
    }

    fn unregistered(&mut self, id: u8, _: Option<u64>) {
        self.registered.remove(id);
        self.begin_anew(id);
    }

    fn forget(&mut self) {
        *self = Self::default();
    }
}

impl Silence {
    fn begin_anew(&mut self, id: u8) {
        self.in_a_row[usize::from(id)] = 0;
        self.behind_in_a_row[usize::from(id)] = 0;
    }

    /// Judges the oldest request: two more have come.
    fn check_oldest(&mut self, topic: &str, context: &mut RuleContext<'_>) {
        let Some(oldest) = self.requests_sent.pop_front() else { return };
        let Some(next) = self.requests_sent.front() else { return };
        for id in oldest.who.iter().filter(|id| next.who.contains(*id)) {
            let in_a_row = &mut self.in_a_row[usize::from(id)];
            let behind = &mut self.behind_in_a_row[usize::from(id)];
            *behind = if oldest.behind.contains(id) { behind.saturating_add(1) } else { 0 };
            if *behind >= MAX_MISSES {
                report_violation(topic, &oldest, id, context);
            }
            if oldest.answered.contains(id) {
                *in_a_row = in_a_row.saturating_add(1);
            } else if *in_a_row < MAX_MISSES {
                *in_a_row = 0;
            } else {
                report_violation(topic, &oldest, id, context);
            }
            context.covered();
        }
    }
}

fn report_violation(topic: &str, sent: &SentRequest, id: u8, context: &mut RuleContext<'_>) {
    let definition = context.defined(sent.request.definition);
    context.violation_of(topic, sent.request.location, definition, || {
        let request = sent.request.id;
        let (when, found) = if sent.late.contains(id) || sent.behind.contains(id) {
            ("answers it only after the next one", "a reply after the next request")
        } else {
            ("doesn't answer it", "none")
        };
        Detail::new(format!("request {request}: registration {id} {when}"))
            .expected(format!("a reply of registration {id} before the next request"))
            .actual(found)
    });
}

/// A reply in the middle of the flight is gone.
fn silent<'d>(flight: &Flight<'d>) -> Option<Flight<'d>> {
    let at = flight.late_reply()?;
    let mut flight = flight.clone();
    flight.messages.remove(at);
    Some(flight)
}
