//! `PX-EXT-02`.
//!
//! What a recording doesn't show may have been before it, so an id that it never saw given out is wrong only where
//! it shows the beginning: flight controllers ask only while something is registered, and then steadily. Where a
//! registration comes shortly before the first request ([`STARTUP_TIME`]), and the mask of that request has no other bits, there
//! was none before. That the mask lacks a bit proves nothing alone, as it is clear for those that were slow, too. Nor
//! does a registration of long ago, as logs begin with the latest message of each topic.
//!
//! An id that was given back is wrong in a reply to a request that came after that. The reply to one before may be
//! under way. Where the mask of a later request has its bit, it was given out again. Where there are no masks, who goes
//! on to answer was registered again for all that is known ([`REQUESTS_TO_WAIT`]).

use super::ext::{Ids, Listener, Reply, Request, TOLERANCE, Talk, Waiting, is_later};
use super::{Change, Check, Detail, Level, Mutant, Px4Rule, Rule, RuleContext, Status};
use crate::rules::sample::Flight;

pub(super) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-EXT-02",
        level: Level::Must,
        status: Status::Normative,
        statement: "The `registration_id` of an ArmingCheckReply was given out by a RegisterExtComponentReply that succeeded, \
                and wasn't given back.",
        source: "`registration_id` of ArmingCheckReply, `arming_check_id` of RegisterExtComponentReply and \
             UnregisterExtComponent",
        applies_to: "messages over time",
        why: "",
        example: "",
        fix: "",
    },
    check: Check::State(|| Box::new(Talk::<Registrations>::default())),
    mutants: &[
        Mutant {
            name: "a reply with an id that was never given out",
            change: Change::Flight(|flight| stranger(flight, 9)),
            also: &[],
        },
        Mutant {
            name: "a reply with an id that nobody can have",
            change: Change::Flight(|flight| stranger(flight, 255)),
            also: &[],
        },
        Mutant { name: "a reply with an id that was given back", change: Change::Flight(ghost), also: &[] },
    ],
};

/// The greatest id that can be given out: `arming_check_id` is an int8. A component whose registration failed
/// may take its -1 for 255.
const MAX_REGISTRATION_ID: u8 = 127;

/// How long after the first registration of all the first request comes at the latest, in µs: twice the period in which
/// PX4 asks.
const STARTUP_TIME: u64 = 600_000;

/// With so many requests more it is clear whether who was held to have left goes on to answer.
const REQUESTS_TO_WAIT: u8 = 3;

/// What is known of an id.
#[derive(Clone, Copy, Default)]
enum Known {
    #[default]
    Nothing,
    Given(Option<u64>),
    GivenBack {
        when: Option<u64>,
        /// Whether the latest request came after that.
        is_past: bool,
    },
}

/// Whether all registrations are in the recording.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
enum Whole {
    /// Nothing was said yet.
    #[default]
    Open,
    /// A registration came first, at this time.
    Likely(u64),
    Yes,
    No,
}

struct Registrations {
    known: [Known; 256],
    whole: Whole,
    /// When the recording was begun, where it says so.
    start: u64,
    /// The latest request.
    request_id: Option<u8>,
    /// Whether that had a mask.
    is_masked: bool,
    waiting: Waiting,
    /// Replies of who seems to have left, one of each, where there are no masks.
    suspects: Vec<Reply>,
}

impl Default for Registrations {
    fn default() -> Self {
        let known = [Known::Nothing; 256];
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

    fn request(&mut self, _: &str, request: Request, context: &mut RuleContext<'_>) {
        self.check_suspects(request.id, context);
        self.request_id = Some(request.id);
        self.is_masked = request.mask.is_some();
        self.look_for_the_beginning(&request);
        self.learn(&request);
        for reply in self.waiting.take().into_iter().filter(|_| self.whole == Whole::Yes) {
            context.covered();
            if matches!(self.known[usize::from(reply.registration_id)], Known::Nothing) {
                report_violation(&reply, "was never given out", context);
            }
        }
    }

    fn reply(&mut self, reply: Reply, context: &mut RuleContext<'_>) {
        if self.whole == Whole::Open {
            self.whole = Whole::No;
        }
        if reply.registration_id > MAX_REGISTRATION_ID {
            return report_violation(&reply, "can't be given out", context);
        }
        match self.known[usize::from(reply.registration_id)] {
            Known::Given(_) => context.covered(),
            // Its registration may stand behind it in the file.
            Known::Nothing => self.waiting.push(reply),
            Known::GivenBack { is_past, .. } => {
                if !is_past || self.request_id != Some(reply.request_id) {
                    return;
                }
                if self.is_masked {
                    report_violation(&reply, LEFT, context);
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
            Known::GivenBack { when, .. } if is_later(*when, time) => {}
            _ => *known = Known::Given(time),
        }
    }

    fn unregistered(&mut self, id: u8, time: Option<u64>) {
        if self.whole == Whole::Open {
            self.whole = Whole::No;
        }
        let known = &mut self.known[usize::from(id)];
        // Logs begin with the latest message of each topic, and topics aren't in order among each other: it may be older
        // than what it seems to end.
        if let Known::Given(when) = known
            && when.zip(time).is_none_or(|(when, time)| when <= time)
        {
            *known = Known::GivenBack { when: time, is_past: false };
        }
    }

    /// A registration may be among what isn't known.
    fn forget(&mut self) {
        *self = Self { whole: Whole::No, ..Self::default() };
    }
}

impl Registrations {
    /// The first request says whether there were registrations before the recording.
    fn look_for_the_beginning(&mut self, request: &Request) {
        let is_given = |id: u8| matches!(self.known[usize::from(id)], Known::Given(_));
        self.whole = match (self.whole, request.mask, request.time) {
            (Whole::Yes, ..) => Whole::Yes,
            (Whole::Likely(first), Some(mask), Some(time))
                if first <= time.saturating_add(TOLERANCE)
                    && time <= first.saturating_add(STARTUP_TIME)
                    && Ids::from_mask(mask).iter().all(is_given) =>
            {
                Whole::Yes
            }
            _ => Whole::No,
        };
    }

    /// The mask of a request says who is registered.
    fn learn(&mut self, request: &Request) {
        let mask = Ids::from_mask(request.mask.unwrap_or_default());
        for id in 0..=u8::MAX {
            let known = &mut self.known[usize::from(id)];
            let is_news = match known {
                Known::Nothing => mask.contains(id),
                Known::Given(_) => false,
                Known::GivenBack { when, is_past } => {
                    // Without times the order of arrival has to do.
                    *is_past = when.zip(request.time).is_none() || is_later(request.time, *when);
                    *is_past && mask.contains(id)
                }
            };
            if is_news {
                // It was registered, and the recording didn't show it.
                *known = Known::Given(request.time);
                self.whole = Whole::No;
            }
        }
    }

    /// Somebody answers who seems to have left.
    fn suspect(&mut self, reply: Reply) {
        let id = reply.registration_id;
        match self.suspects.iter().position(|known| known.registration_id == id) {
            None => self.suspects.push(reply),
            Some(at) if self.suspects[at].request_id == reply.request_id => {}
            // It goes on: it was registered again, and the recording didn't show it.
            Some(at) => {
                self.suspects.remove(at);
                self.known[usize::from(id)] = Known::Given(None);
            }
        }
    }

    /// Tells of those that didn't go on to answer until this request.
    fn check_suspects(&mut self, request_id: u8, context: &mut RuleContext<'_>) {
        let is_next = self.request_id.is_some_and(|latest| latest.wrapping_add(1) == request_id);
        if !is_next {
            self.suspects.clear();
        }
        self.suspects.retain(|reply| {
            let is_open = request_id.wrapping_sub(reply.request_id) < REQUESTS_TO_WAIT;
            if !is_open {
                report_violation(reply, LEFT, context);
            }
            is_open
        });
    }
}

/// What is said of a reply of who has left.
const LEFT: &str = "was given back before this was asked";

fn report_violation(reply: &Reply, what: &str, context: &mut RuleContext<'_>) {
    let definition = context.field(reply.definition, "registration_id");
    context.violation_of(&format!("{}.registration_id", reply.topic), reply.location, definition, || {
        let id = reply.registration_id;
        Detail::new(format!("{id} as the id of who answers, which {what}"))
            .expected("an id from RegisterExtComponentReply")
            .actual(id.to_string())
    });
}

/// A reply more, of somebody else.
fn stranger<'d>(flight: &Flight<'d>, id: u8) -> Option<Flight<'d>> {
    flight.with_reply(|reply| reply["registration_id"] = id.into())
}

/// A reply of a component that has left.
fn ghost<'d>(flight: &Flight<'d>) -> Option<Flight<'d>> {
    let left =
        flight.messages.iter().find(|sent| Some(sent.topic) == flight.topic("UnregisterExtComponent"))?;
    let id = left.value["arming_check_id"].clone();
    flight.with_reply(|reply| reply["registration_id"] = id)
}
