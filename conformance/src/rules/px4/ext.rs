//! What the rules on external components (`PX-EXT-…`) have in common: who says what, and which requests were sent.
//!
//! A flight controller asks all registered components again and again whether they agree to arming, and each
//! answers. A recording shows that talk from outside, and rarely all of it, so the rules keep to what is certain:
//!
//! - After a dropout, damage, or a message that can't be trusted, all is forgotten; so it is where time goes back,
//!   as when the flight controller starts again.
//! - Requests count up. Where the number after one isn't the next, a request isn't in the recording.
//! - Topics needn't be in order among each other. So nothing counts as wrong that is right by the order of arrival
//!   or by time, and the clocks of both sides may differ a little ([`TOLERANCE`]).
//! - Where two topics bring requests, as of two vehicles, nobody knows who is asked, and nothing is said.

use std::collections::VecDeque;

use uavspec_codegen::dynamic::DynamicView;
use uavspec_codegen::msg::Dialect;
use uavspec_codegen::schema::{Form, MessageId};
use uavspec_runtime::Number;

use super::{Channel, Checker, Interest, Location, Message, RuleContext};

/// How much two times may differ and yet be the same, in µs: messages of a component have the time of its
/// computer, which follows that of the flight controller within some milliseconds.
pub(super) const TOLERANCE: u64 = 10_000;

/// How many requests are kept: a reply that stands late in a file is looked up among them.
const REQUESTS: usize = 8;

/// How many replies wait for the next request; a flight controller registers far fewer components.
const WAITING: usize = 64;

/// What a message of the talk is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    Request,
    Reply,
    Registration,
    Unregistration,
}

/// Names of messages, in the order of the roles.
const ROLES: [(&str, Role); 4] = [
    ("ArmingCheckRequest", Role::Request),
    ("ArmingCheckReply", Role::Reply),
    ("RegisterExtComponentReply", Role::Registration),
    ("UnregisterExtComponent", Role::Unregistration),
];

/// All registered components are asked.
#[derive(Clone, Copy, Debug)]
pub(super) struct Request {
    pub(super) id: u8,
    /// When, where that is known, as all times here.
    pub(super) time: Option<u64>,
    /// A bit for each registration that exists and answers; none where the release has no such field.
    pub(super) mask: Option<u32>,
    pub(super) definition: Option<MessageId>,
    pub(super) location: Location,
}

/// A component answers.
#[derive(Clone, Debug)]
pub(super) struct Reply {
    pub(super) topic: String,
    pub(super) request_id: u8,
    pub(super) registration_id: u8,
    pub(super) time: Option<u64>,
    pub(super) definition: Option<MessageId>,
    pub(super) location: Location,
}

/// A rule that listens to the talk.
pub(super) trait Listener: Default {
    /// When the recording was begun.
    fn started(&mut self, _time: u64) {}

    /// All registered components are asked, on this topic.
    fn request(&mut self, _topic: &str, _request: Request, _context: &mut RuleContext<'_>) {}

    /// A component answers.
    fn reply(&mut self, _reply: Reply, _context: &mut RuleContext<'_>) {}

    /// A component is given an id.
    fn registered(&mut self, _id: u8, _time: Option<u64>) {}

    /// A component gives its id back.
    fn unregistered(&mut self, _id: u8, _time: Option<u64>) {}

    /// Something isn't known that may have been said.
    fn forget(&mut self);

    /// The recording ends.
    fn end(&mut self, _context: &mut RuleContext<'_>) {}
}

/// Tells a listener who says what.
#[derive(Default)]
pub(super) struct Talk<L> {
    listener: L,
    /// The first channel of each role that had a message.
    channels: [Option<usize>; ROLES.len()],
    /// Whether there are several talks, which can't be told apart.
    is_unclear: bool,
    latest: Option<(u8, Option<u64>)>,
}

impl<L: Listener> Checker for Talk<L> {
    fn opened(&mut self, channel: &Channel<'_>, context: &mut RuleContext<'_>) -> Interest {
        if role(channel, context).is_some() { Interest::Values } else { Interest::Nothing }
    }

    fn closed(&mut self, channel: &Channel<'_>) {
        let is_closed = |known: &&mut Option<usize>| **known == Some(channel.index);
        self.channels.iter_mut().filter(is_closed).for_each(|known| *known = None);
    }

    fn started(&mut self, time: u64) {
        self.listener.started(time);
    }

    fn message(&mut self, channel: &Channel<'_>, message: &Message<'_>, context: &mut RuleContext<'_>) {
        let Some(role) = role(channel, context) else { return };
        // Loggers subscribe to instances that nobody publishes, so it counts who says something.
        let first = *self.channels[role as usize].get_or_insert(channel.index);
        // Components may share a topic by instances, but there is one who asks.
        let is_instance = channel.multi_id.is_some() && role != Role::Request;
        self.is_unclear |= first != channel.index && !is_instance;
        if !self.is_unclear && self.dispatch(role, channel, message, context).is_none() {
            self.forget();
        }
    }

    fn dropout(&mut self, _: u16, _: Location) {
        self.forget();
    }

    fn corruption(&mut self, _: Location) {
        self.forget();
    }

    fn end(&mut self, context: &mut RuleContext<'_>) {
        if !self.is_unclear {
            self.listener.end(context);
        }
    }
}

impl<L: Listener> Talk<L> {
    /// Tells what a message says; none where it can't be read.
    fn dispatch(
        &mut self,
        role: Role,
        channel: &Channel<'_>,
        message: &Message<'_>,
        context: &mut RuleContext<'_>,
    ) -> Option<()> {
        let values = message.values?;
        // 0 is the time of what didn't know any.
        let time = message.timestamp.filter(|time| *time > 0);
        let (definition, location) = (channel.definition, message.location);
        match role {
            Role::Request => {
                let id = number(values, "request_id")?;
                let mask = number(values, "valid_registrations_mask");
                self.request(channel.topic, Request { id, time, mask, definition, location }, context);
            }
            Role::Reply => {
                let request_id = number(values, "request_id")?;
                let registration_id = number(values, "registration_id")?;
                let topic = channel.topic.to_owned();
                let reply = Reply { topic, request_id, registration_id, time, definition, location };
                self.listener.reply(reply, context);
            }
            Role::Registration => {
                let is_success = number::<u8>(values, "success")? != 0;
                let id: i128 = number(values, "arming_check_id")?;
                // A component that takes no part in arming checks gets -1.
                if let Some(id) = u8::try_from(id).ok().filter(|_| is_success) {
                    self.listener.registered(id, time);
                }
            }
            Role::Unregistration => {
                let id: i128 = number(values, "arming_check_id")?;
                if let Ok(id) = u8::try_from(id) {
                    self.listener.unregistered(id, time);
                }
            }
        }
        Some(())
    }

    fn request(&mut self, topic: &str, request: Request, context: &mut RuleContext<'_>) {
        let before = self.latest.replace((request.id, request.time));
        // The same message may be recorded twice.
        if before == self.latest {
            return;
        }
        if before.is_some_and(|(_, time)| time.zip(request.time).is_some_and(|(before, now)| now < before)) {
            self.listener.forget();
        }
        self.listener.request(topic, request, context);
    }

    fn forget(&mut self) {
        self.latest = None;
        self.listener.forget();
    }
}

/// What the messages of a channel are, where they belong to the talk.
fn role(channel: &Channel<'_>, context: &RuleContext<'_>) -> Option<Role> {
    let name = px4_message(channel, context)?;
    ROLES.iter().find(|(known, _)| *known == name).map(|(_, role)| *role)
}

/// The name of the messages of a channel, where they are of PX4.
pub(super) fn px4_message<'j>(channel: &Channel<'_>, context: &RuleContext<'j>) -> Option<&'j str> {
    let schema = &context.definitions.schema;
    let message = schema.message(channel.definition?);
    (schema.package_of(message).form == Form::Msg(Dialect::Px4)).then_some(message.name.as_str())
}

/// Whether a channel brings answers of components.
pub(super) fn is_reply(channel: &Channel<'_>, context: &RuleContext<'_>) -> bool {
    role(channel, context) == Some(Role::Reply)
}

/// A field as an integer, or a bool as 0 or 1; none where there is no such field, or it doesn't fit.
pub(super) fn number<T: TryFrom<i128>>(values: DynamicView<'_>, path: &str) -> Option<T> {
    match values.get(path)?.number()? {
        Number::Int(value) => T::try_from(value).ok(),
        Number::Float(_) => None,
    }
}

/// Whether something came later for certain.
pub(super) fn is_later(time: Option<u64>, than: Option<u64>) -> bool {
    time.zip(than).is_some_and(|(time, than)| time > than.saturating_add(TOLERANCE))
}

/// The latest requests, of which none is missing in between.
#[derive(Default)]
pub(super) struct Requests(VecDeque<Request>);

impl Requests {
    /// Adds one, and says whether it is the next one. Otherwise those before are forgotten.
    pub(super) fn push(&mut self, request: Request) -> bool {
        let is_next = self.latest().is_some_and(|latest| latest.id.wrapping_add(1) == request.id);
        if !is_next {
            self.0.clear();
        } else if self.0.len() == REQUESTS {
            self.0.pop_front();
        }
        self.0.push_back(request);
        is_next
    }

    /// The latest by order of arrival.
    pub(super) fn latest(&self) -> Option<&Request> {
        self.0.back()
    }

    /// The latest at this time.
    pub(super) fn latest_at(&self, time: Option<u64>) -> Option<&Request> {
        self.0.iter().rfind(|request| !is_later(request.time, time))
    }

    /// How many are known.
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }
}

/// Replies about which the next request decides. Of too many the oldest are let go.
#[derive(Default)]
pub(super) struct Waiting(VecDeque<Reply>);

impl Waiting {
    pub(super) fn push(&mut self, reply: Reply) {
        if self.0.len() == WAITING {
            self.0.pop_front();
        }
        self.0.push_back(reply);
    }

    /// All of them, which then wait no more.
    pub(super) fn take(&mut self) -> VecDeque<Reply> {
        std::mem::take(&mut self.0)
    }
}

/// A set of ids of registrations.
#[derive(Clone, Copy, Default)]
pub(super) struct Ids([u64; 4]);

impl Ids {
    /// Those of which a mask has a bit.
    pub(super) fn from_mask(mask: u32) -> Self {
        Self([mask.into(), 0, 0, 0])
    }

    pub(super) fn insert(&mut self, id: u8) {
        self.0[usize::from(id / 64)] |= 1 << (id % 64);
    }

    pub(super) fn remove(&mut self, id: u8) {
        self.0[usize::from(id / 64)] &= !(1 << (id % 64));
    }

    pub(super) fn contains(self, id: u8) -> bool {
        self.0[usize::from(id / 64)] >> (id % 64) & 1 == 1
    }

    /// All of them, in order.
    pub(super) fn iter(self) -> impl Iterator<Item = u8> {
        (0..=u8::MAX).filter(move |id| self.contains(*id))
    }
}
