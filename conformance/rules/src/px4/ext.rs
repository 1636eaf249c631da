//! Requests, replies and registrations of external components, for the `PX-EXT-…` rules.
//!
//! A flight controller regularly asks all registered components whether they allow arming, and each component replies.
//! A capture rarely contains all of these messages, so the rules report only violations that are beyond doubt:
//!
//! - The state is reset after a dropout, corrupt data, or an unreadable message. The state is also reset if time goes
//!   backwards, for example after a restart of the flight controller.
//! - Request ids are consecutive, so a gap means that the capture lacks a request.
//! - Messages on different topics may be out of order, and the clocks of both sides may differ slightly
//!   ([`TOLERANCE`]). A message passes if its position in the file or its timestamp is correct.
//! - If two topics carry requests, for example from two vehicles, nothing is reported, because the recipient of each
//!   reply is unknown.

use std::collections::VecDeque;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};

use uavspec_dynamic::DynamicView;
use uavspec_runtime::Number;
use uavspec_schema::msg::Dialect;
use uavspec_schema::{Form, MessageId};

use super::prelude::*;

/// The maximum difference between two times that count as equal, in µs. A component uses the clock of its computer,
/// which is synchronized with the flight controller to within a few milliseconds.
pub(super) const TOLERANCE: u64 = 10_000;

/// The number of stored requests, used to match late replies.
const REQUESTS: usize = 8;

/// The maximum number of replies that wait for the next request. A flight controller registers far fewer components.
const WAITING: usize = 64;

/// The role of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    Request,
    Reply,
    Registration,
    Unregistration,
}

/// Each message name with its role, in role order.
const ROLES: [(&str, Role); 4] = [
    ("ArmingCheckRequest", Role::Request),
    ("ArmingCheckReply", Role::Reply),
    ("RegisterExtComponentReply", Role::Registration),
    ("UnregisterExtComponent", Role::Unregistration),
];

/// A request to all registered components.
#[derive(Clone, Copy, Debug)]
pub(super) struct Request {
    pub(super) id: u8,
    /// The time in µs, if known.
    pub(super) time: Option<u64>,
    /// A bit mask: bit N is set if registration id N exists and its component responds. `None` if the PX4 release lacks
    /// this field.
    pub(super) mask: Option<u32>,
    pub(super) definition: Option<MessageId>,
    pub(super) location: Location,
}

/// A reply from a component.
#[derive(Clone, Debug)]
pub(super) struct Reply {
    pub(super) topic: String,
    /// The instance of the topic in a log.
    pub(super) instance: Option<u8>,
    pub(super) request_id: u8,
    pub(super) registration_id: u8,
    /// A hash of all values except the time. `None` if the rule doesn't compare replies.
    pub(super) digest: Option<u64>,
    pub(super) time: Option<u64>,
    pub(super) definition: Option<MessageId>,
    pub(super) location: Location,
}

impl Reply {
    /// Reports a violation in a field of the reply.
    pub(super) fn violation(
        &self,
        field: &str,
        context: &mut RuleContext<'_>,
        detail: impl FnOnce() -> Detail,
    ) {
        let topic = SubjectName { name: &self.topic, instance: self.instance };
        context.violation_in(topic, (self.definition, field), self.location, detail);
    }
}

/// A rule on requests, replies and registrations.
pub(super) trait Listener: Default {
    /// True if the rule compares the values of replies.
    const COMPARES_REPLIES: bool = false;

    /// Receives the start time of the capture.
    fn started(&mut self, _time: u64) {}

    /// Handles a request on this topic.
    fn request(&mut self, _topic: SubjectName<'_>, _request: Request, _context: &mut RuleContext<'_>) {}

    /// Handles a reply.
    fn reply(&mut self, _reply: Reply, _context: &mut RuleContext<'_>) {}

    /// Handles a successful registration.
    fn registered(&mut self, _id: u8, _time: Option<u64>) {}

    /// Handles the end of a registration.
    fn unregistered(&mut self, _id: u8, _time: Option<u64>) {}

    /// Resets the state, because messages may have been lost.
    fn forget(&mut self);

    /// Handles the end of the capture.
    fn end(&mut self, _context: &mut RuleContext<'_>) {}
}

/// Passes the messages to a listener.
#[derive(Default)]
pub(super) struct Talk<L> {
    listener: L,
    /// For each role, the first channel that had a message, with its full topic. A bag may contain several channels of a
    /// topic.
    channels: [Option<(usize, String)>; ROLES.len()],
    /// True if there are several flight controllers, whose messages can't be distinguished.
    is_ambiguous: bool,
    latest: Option<(u8, Option<u64>)>,
}

impl<L: Listener> Checker for Talk<L> {
    fn opened(&mut self, channel: &Channel<'_>, context: &mut RuleContext<'_>) -> Interest {
        if role(channel, context).is_some() { Interest::Values } else { Interest::Nothing }
    }

    fn closed(&mut self, channel: &Channel<'_>) {
        let is_closed = |known: &&mut Option<(usize, String)>| {
            known.as_ref().is_some_and(|(index, _)| *index == channel.index)
        };
        self.channels.iter_mut().filter(is_closed).for_each(|known| *known = None);
    }

    fn started(&mut self, time: u64) {
        self.listener.started(time);
    }

    fn message(&mut self, channel: &Channel<'_>, message: &Message<'_>, context: &mut RuleContext<'_>) {
        let Some(role) = role(channel, context) else { return };
        // Loggers subscribe to instances that are never published, so only channels with messages count.
        let first = self.channels[role as usize]
            .get_or_insert_with(|| (channel.index, channel.full_topic.to_owned()));
        // Components may use several instances of a topic, but only one flight controller sends requests.
        let is_same = match channel.multi_id {
            Some(_) => role != Role::Request,
            None => first.1 == channel.full_topic,
        };
        self.is_ambiguous |= first.0 != channel.index && !is_same;
        if !self.is_ambiguous && self.dispatch(role, channel, message, context).is_none() {
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
        if !self.is_ambiguous {
            self.listener.end(context);
        }
    }
}

impl<L: Listener> Talk<L> {
    /// Passes a message to the listener. Returns `None` if the message can't be read.
    fn dispatch(
        &mut self,
        role: Role,
        channel: &Channel<'_>,
        message: &Message<'_>,
        context: &mut RuleContext<'_>,
    ) -> Option<()> {
        let values = message.values?;
        // 0 means that the time is unknown.
        let time = message.timestamp.filter(|time| *time > 0);
        let (definition, location) = (channel.definition, message.location);
        match role {
            Role::Request => {
                let id = number(values, "request_id")?;
                let mask = number(values, "valid_registrations_mask");
                let request = Request { id, time, mask, definition, location };
                self.request(channel.subject(), request, context);
            }
            Role::Reply => {
                let request_id = number(values, "request_id")?;
                let registration_id = number(values, "registration_id")?;
                let digest = if L::COMPARES_REPLIES { Some(digest(values)?) } else { None };
                let reply = Reply {
                    topic: channel.full_topic.to_owned(),
                    instance: channel.multi_id,
                    request_id,
                    registration_id,
                    digest,
                    time,
                    definition,
                    location,
                };
                self.listener.reply(reply, context);
            }
            Role::Registration => {
                let is_success = number::<u8>(values, "success")? != 0;
                let id: i128 = number(values, "arming_check_id")?;
                // A component that takes no part in arming checks gets the id -1.
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

    fn request(&mut self, topic: SubjectName<'_>, request: Request, context: &mut RuleContext<'_>) {
        let before = self.latest.replace((request.id, request.time));
        // A message may be recorded twice.
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

/// The role of a channel's messages.
fn role(channel: &Channel<'_>, context: &RuleContext<'_>) -> Option<Role> {
    let name = px4_message(channel, context)?;
    ROLES.iter().find(|(known, _)| *known == name).map(|(_, role)| *role)
}

/// The name of a channel's message type, if it is a PX4 message.
pub(super) fn px4_message<'j>(channel: &Channel<'_>, context: &RuleContext<'j>) -> Option<&'j str> {
    let schema = &context.definitions.schema;
    let message = schema.message(channel.definition?);
    (schema.package_of(message).form == Form::Msg(Dialect::Px4)).then_some(message.name.as_str())
}

/// True if a channel belongs to PX4: it is in a log, or has PX4 messages.
pub(super) fn is_of_px4(channel: &Channel<'_>, context: &RuleContext<'_>) -> bool {
    channel.multi_id.is_some() || px4_message(channel, context).is_some()
}

/// True if a channel has `ArmingCheckReply` messages.
pub(super) fn is_reply(channel: &Channel<'_>, context: &RuleContext<'_>) -> bool {
    role(channel, context) == Some(Role::Reply)
}

/// The value of an integer field; a bool counts as 0 or 1. `None` if the field is missing or the value doesn't fit.
pub(super) fn number<T: TryFrom<i128>>(values: DynamicView<'_>, path: &str) -> Option<T> {
    match values.get(path)?.number()? {
        Number::Int(value) => T::try_from(value).ok(),
        Number::Float(_) => None,
    }
}

/// A hash of all values of a message, except its time.
fn digest(values: DynamicView<'_>) -> Option<u64> {
    let mut hasher = DefaultHasher::new();
    let mut message = values.to_json().ok()?;
    message.as_object_mut()?.remove("timestamp");
    message.to_string().hash(&mut hasher);
    Some(hasher.finish())
}

/// True if a time is later than another by more than the tolerance.
pub(super) fn is_later(time: Option<u64>, than: Option<u64>) -> bool {
    time.zip(than).is_some_and(|(time, than)| time > than.saturating_add(TOLERANCE))
}

/// The latest consecutive requests.
#[derive(Default)]
pub(super) struct Requests(VecDeque<Request>);

impl Requests {
    /// Adds a request. Returns true if the id of the request directly follows the latest id. Otherwise, removes the
    /// earlier requests.
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

    /// The latest request, in file order.
    pub(super) fn latest(&self) -> Option<&Request> {
        self.0.back()
    }

    /// The request with this id, if it is one of the two latest in file order.
    pub(super) fn recent(&self, id: u8) -> Option<&Request> {
        self.0.iter().rev().take(2).find(|request| request.id == id)
    }

    /// The latest request at this time.
    pub(super) fn latest_at(&self, time: Option<u64>) -> Option<&Request> {
        self.0.iter().rfind(|request| !is_later(request.time, time))
    }

    /// The number of requests.
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }
}

/// Replies waiting for the next request. If there are too many replies, the oldest are dropped.
#[derive(Default)]
pub(super) struct Waiting(VecDeque<Reply>);

impl Waiting {
    pub(super) fn push(&mut self, reply: Reply) {
        if self.0.len() == WAITING {
            self.0.pop_front();
        }
        self.0.push_back(reply);
    }

    /// Removes all replies and returns them.
    pub(super) fn take(&mut self) -> VecDeque<Reply> {
        std::mem::take(&mut self.0)
    }
}

/// A set of registration ids.
#[derive(Clone, Copy, Default)]
pub(super) struct Ids([u64; 4]);

impl Ids {
    /// The ids in a mask.
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

    /// The ids in ascending order.
    pub(super) fn iter(self) -> impl Iterator<Item = u8> {
        (0..=u8::MAX).filter(move |id| self.contains(*id))
    }
}
