//! `PX-EXT-02`.
//!
//! What a recording doesn't show may have been before it, so an id that it never saw given out is wrong only where
//! it shows the beginning: flight controllers ask only while something is registered, and then steadily. Where a
//! registration comes before the first request, and the mask of that request has no other bits, there was none
//! before. That the mask lacks a bit proves nothing alone, as it is clear for those that were slow, too.
//!
//! An id that was given back is wrong in a reply to a request that came after that. The reply to one before may be
//! under way.

use super::px_ext::{Ids, Listener, Reply, Request, Talk, Waiting, is_later};
use super::{Check, Detail, Judged, Level, Mutant, Rule, Status};
use crate::sample::Flight;

pub(super) static RULE: Rule = Rule {
    id: "PX-EXT-02",
    level: Level::Must,
    status: Status::Normative,
    statement: "The `registration_id` of an ArmingCheckReply was given out by a RegisterExtComponentReply that succeeded, \
                and wasn't given back.",
    source: "`registration_id` of ArmingCheckReply, `arming_check_id` of RegisterExtComponentReply and \
             UnregisterExtComponent",
    applies_to: "messages over time",
    check: Check::State(|| Box::new(Talk::<Registrations>::default())),
    mutants: &[
        Mutant {
            name: "a reply with an id that was never given out, in a log",
            make: |flight| Some(stranger(flight, 9)?.log().to_bytes()),
            also: &[],
        },
        Mutant {
            name: "a reply with an id that nobody can have, as JSON",
            make: |flight| Some(stranger(flight, 255)?.lines().to_bytes()),
            also: &[],
        },
        Mutant {
            name: "a reply with an id that was given back, in a log",
            make: |flight| Some(ghost(flight)?.log().to_bytes()),
            also: &[],
        },
        Mutant {
            name: "a reply with an id that was given back, as JSON",
            make: |flight| Some(ghost(flight)?.rosbridge().to_bytes()),
            also: &[],
        },
    ],
};

/// The greatest id that can be given out: `arming_check_id` is an int8. A component whose registration failed
/// may take its -1 for 255.
const GREATEST: u8 = 127;

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
    /// A registration came first.
    Likely,
    Yes,
    No,
}

struct Registrations {
    known: [Known; 256],
    whole: Whole,
    /// The latest request.
    request_id: Option<u8>,
    waiting: Waiting,
}

impl Default for Registrations {
    fn default() -> Self {
        let known = [Known::Nothing; 256];
        Self { known, whole: Whole::Open, request_id: None, waiting: Waiting::default() }
    }
}

impl Listener for Registrations {
    fn request(&mut self, _: &str, request: Request, judged: &mut Judged<'_>) {
        self.request_id = Some(request.id);
        self.look_for_the_beginning(request.mask);
        let mask = Ids::of_mask(request.mask.unwrap_or_default());
        for id in 0..=u8::MAX {
            match &mut self.known[usize::from(id)] {
                Known::GivenBack { when, is_past } => {
                    // Without times the order of arrival has to do.
                    let is_after = when.zip(request.time).is_none() || is_later(request.time, *when);
                    *is_past = is_after && !mask.contains(id);
                }
                Known::Nothing if mask.contains(id) => {
                    // It was registered, and the recording didn't show it.
                    self.known[usize::from(id)] = Known::Given(request.time);
                    self.whole = Whole::No;
                }
                _ => {}
            }
        }
        for reply in self.waiting.take().into_iter().filter(|_| self.whole == Whole::Yes) {
            judged.exercise();
            if matches!(self.known[usize::from(reply.registration_id)], Known::Nothing) {
                tell(&reply, "was never given out", judged);
            }
        }
    }

    fn reply(&mut self, reply: Reply, judged: &mut Judged<'_>) {
        if self.whole == Whole::Open {
            self.whole = Whole::No;
        }
        if reply.registration_id > GREATEST {
            return tell(&reply, "can't be given out", judged);
        }
        match self.known[usize::from(reply.registration_id)] {
            Known::Given(_) => judged.exercise(),
            // Its registration may stand behind it in the file.
            Known::Nothing => self.waiting.push(reply),
            Known::GivenBack { is_past, .. } => {
                if is_past && self.request_id == Some(reply.request_id) {
                    tell(&reply, "was given back before this was asked", judged);
                }
            }
        }
    }

    fn registered(&mut self, id: u8, time: Option<u64>) {
        if self.whole == Whole::Open {
            self.whole = Whole::Likely;
        }
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
        // Logs begin with the latest message of each topic, and that may be older than what it seems to end.
        if let Known::Given(when) = known
            && !is_later(*when, time)
        {
            *known = Known::GivenBack { when: time, is_past: false };
        }
    }

    fn forget(&mut self) {
        *self = Self::default();
    }
}

impl Registrations {
    /// The first request says whether there were registrations before the recording.
    fn look_for_the_beginning(&mut self, mask: Option<u32>) {
        let is_given = |id: u8| matches!(self.known[usize::from(id)], Known::Given(_));
        self.whole = match (self.whole, mask) {
            (Whole::Likely, Some(mask)) if Ids::of_mask(mask).iter().all(is_given) => Whole::Yes,
            (Whole::Yes, _) => Whole::Yes,
            _ => Whole::No,
        };
    }
}

fn tell(reply: &Reply, what: &str, judged: &mut Judged<'_>) {
    judged.report(&format!("{}.registration_id", reply.topic), reply.place, || {
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
