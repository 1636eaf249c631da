//! `PX-EXT-03`.
//!
//! That an answer isn't in a recording doesn't yet say that none was sent: a logger may take only some of them. So
//! a component is judged once it answered some requests in a row ([`IN_A_ROW`]), which also gives it time to start.
//! It has to answer a request if its bit is set in the mask of this one and still in that of the next, since it may
//! leave at any time, and a flight controller doesn't wait for those that were slow too often. Releases without
//! masks leave what was said of registrations.
//!
//! A request is judged with the second one after it, so that answers may stand late in the file.

use std::collections::VecDeque;

use super::px_ext::{Ids, Listener, Reply, Request, Requests, Talk, Waiting, is_later};
use super::{Check, Detail, Judged, Level, Mutant, Rule, Status};
use crate::sample::Flight;

pub(super) static RULE: Rule = Rule {
    id: "PX-EXT-03",
    level: Level::Should,
    status: Status::Normative,
    statement: "Each registered component replies to each ArmingCheckRequest before the next one.",
    source: "ArmingCheckRequest",
    applies_to: "messages over time",
    check: Check::State(|| Box::new(Talk::<Silence>::default())),
    mutants: &[
        Mutant {
            name: "a reply is missing, in a log",
            make: |flight| Some(silent(flight)?.log().to_bytes()),
            also: &[],
        },
        Mutant {
            name: "a reply is missing, as JSON",
            make: |flight| Some(silent(flight)?.lines().to_bytes()),
            also: &[],
        },
    ],
};

/// How many requests in a row a component answers until its answers are known to be in the recording.
const IN_A_ROW: u8 = 3;

/// A request that was sent, and what came of it.
struct Asked {
    request: Request,
    /// Those of which it asks an answer.
    who: Ids,
    answered: Ids,
    /// Those that answered when the next request was there already.
    late: Ids,
}

struct Silence {
    requests: Requests,
    /// The latest requests, none of which is missing; at most two between messages.
    asked: VecDeque<Asked>,
    /// Replies to what isn't known, or not yet.
    waiting: Waiting,
    /// By what was said of registrations.
    registered: Ids,
    /// How many requests in a row each id answered.
    in_a_row: [u8; 256],
}

impl Default for Silence {
    fn default() -> Self {
        Self {
            requests: Requests::default(),
            asked: VecDeque::new(),
            waiting: Waiting::default(),
            registered: Ids::default(),
            in_a_row: [0; 256],
        }
    }
}

impl Listener for Silence {
    fn request(&mut self, topic: &str, request: Request, judged: &mut Judged<'_>) {
        if !self.requests.push(request) {
            self.asked.clear();
        }
        let who = request.mask.map_or(self.registered, Ids::of_mask);
        let mut asked = Asked { request, who, answered: Ids::default(), late: Ids::default() };
        for reply in self.waiting.take() {
            // It stands before the request only in the file.
            if reply.request_id == request.id && !is_later(request.time, reply.time) {
                asked.answered.insert(reply.registration_id);
            }
        }
        self.asked.push_back(asked);
        if self.asked.len() > 2 {
            self.judge(topic, judged);
        }
    }

    fn reply(&mut self, reply: Reply, _: &mut Judged<'_>) {
        let Some(at) = self.asked.iter().rposition(|asked| asked.request.id == reply.request_id) else {
            return self.waiting.push(reply);
        };
        let next = self.asked.get(at + 1).and_then(|next| next.request.time);
        let asked = &mut self.asked[at];
        let answers = if is_later(reply.time, next) { &mut asked.late } else { &mut asked.answered };
        answers.insert(reply.registration_id);
    }

    /// Who comes isn't the one that had this id before; who goes needn't have answered.
    fn registered(&mut self, id: u8, _: Option<u64>) {
        self.registered.insert(id);
        self.in_a_row[usize::from(id)] = 0;
    }

    fn unregistered(&mut self, id: u8, _: Option<u64>) {
        self.registered.remove(id);
        self.in_a_row[usize::from(id)] = 0;
    }

    fn forget(&mut self) {
        *self = Self::default();
    }
}

impl Silence {
    /// Judges the oldest request: two more have come.
    fn judge(&mut self, topic: &str, judged: &mut Judged<'_>) {
        let Some(oldest) = self.asked.pop_front() else { return };
        let Some(next) = self.asked.front() else { return };
        for id in oldest.who.iter().filter(|id| next.who.contains(*id)) {
            let in_a_row = &mut self.in_a_row[usize::from(id)];
            if oldest.answered.contains(id) {
                *in_a_row = in_a_row.saturating_add(1);
            } else if *in_a_row < IN_A_ROW {
                *in_a_row = 0;
            } else {
                tell(topic, &oldest, id, judged);
            }
            judged.exercise();
        }
    }
}

fn tell(topic: &str, asked: &Asked, id: u8, judged: &mut Judged<'_>) {
    judged.report(topic, asked.request.place, || {
        let request = asked.request.id;
        let is_late = asked.late.contains(id);
        let when = if is_late { "answers it only after the next one" } else { "doesn't answer it" };
        Detail::new(format!("request {request}: registration {id} {when}"))
            .expected(format!("a reply of registration {id}"))
    });
}

/// A reply in the middle of the flight is gone.
fn silent<'d>(flight: &Flight<'d>) -> Option<Flight<'d>> {
    let at = flight.late_reply()?;
    let mut flight = flight.clone();
    flight.messages.remove(at);
    Some(flight)
}
