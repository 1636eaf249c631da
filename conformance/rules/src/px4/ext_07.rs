//! `PX-EXT-07`.
//!
//! A capture may lack requests, and components may choose ids that aren't random. A reply with a known id may therefore
//! belong to a request that the capture lacks. A finding requires that no reply with the id has the name of a request
//! with the id, so it is reported at the end of the capture. Replies with unknown ids are not checked. Names that
//! aren't UTF-8 violate PX-STR-01, and are not compared. Dropouts and unreadable data may have contained other
//! requests, so all requests so far are forgotten.

use std::collections::HashMap;

use uavspec_dynamic::{DynamicView, Value};
use uavspec_runtime::Text;
use uavspec_schema::MessageId;
use uavspec_types::px4::RegisterExtComponentReply;

use super::ext::{number, px4_message};
use super::prelude::*;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-EXT-07",
    name: "Reply to a registration",
    level: Level::Must,
    status: Status::Normative,
    statement: "A RegisterExtComponentReply repeats the `request_id` and the `name` of a \
                RegisterExtComponentRequest.",
    source: "`request_id` and `name` of RegisterExtComponentReply",
    applies_to: "message sequences",
    why: "All components receive all replies. A component recognizes the reply to its request by the id \
          and the name. If the name differs, the component ignores the reply and never starts.",
    example: "← RegisterExtComponentRequest {\"request_id\": 81, \"name\": \"Precision landing\", …}\n\
              → RegisterExtComponentReply   {\"request_id\": 81, \"name\": \"Precision\", …}",
    fix: "Copy `request_id` and all bytes of `name` from the request.",
})
.check(Check::State(|| Box::new(Registrations::default())))
.bug(Bug::message(
    Side::Autopilot,
    "The `name` of each RegisterExtComponentReply except the first is empty.",
    |out| {
        if !out.is_first() {
            out.edit(1, |reply: &mut RegisterExtComponentReply| reply.name = Text::default());
        }
    },
))
.mutants(&[Mutant::flight("a reply with a different name", renamed)]);

/// The maximum number of stored requests. A flight controller registers far fewer components.
const REQUESTS: usize = 256;

/// The maximum number of different names that are stored for an id.
const NAMES: usize = 16;

#[derive(Default)]
struct Registrations {
    /// The requests, by id.
    requests: HashMap<u64, Registration>,
    /// For requests and replies, the first channel that had a message.
    channels: [Option<usize>; 2],
    /// True if several channels carry requests or replies, for example from several vehicles.
    is_ambiguous: bool,
}

/// The requests and replies with the same id.
#[derive(Default)]
struct Registration {
    names: Vec<Vec<u8>>,
    /// The first reply whose name differs.
    other: Option<OtherReply>,
    /// True if a reply has the name of a request, or if there are too many names.
    is_right: bool,
}

/// A reply whose name differs from the name in the request.
struct OtherReply {
    topic: String,
    /// The instance of the topic in a log.
    instance: Option<u8>,
    name: Vec<u8>,
    definition: Option<MessageId>,
    location: Location,
}

impl Checker for Registrations {
    fn opened(&mut self, channel: &Channel<'_>, context: &mut RuleContext<'_>) -> Interest {
        if is_reply(channel, context).is_some() { Interest::Values } else { Interest::Nothing }
    }

    fn closed(&mut self, channel: &Channel<'_>) {
        let is_closed = |known: &&mut Option<usize>| **known == Some(channel.index);
        self.channels.iter_mut().filter(is_closed).for_each(|known| *known = None);
    }

    fn message(&mut self, channel: &Channel<'_>, message: &Message<'_>, context: &mut RuleContext<'_>) {
        let Some(is_reply) = is_reply(channel, context) else { return };
        let first = *self.channels[usize::from(is_reply)].get_or_insert(channel.index);
        self.is_ambiguous |= first != channel.index && channel.multi_id.is_none();
        let Some((id, name)) = message.values.and_then(id_and_name) else {
            return self.requests.clear();
        };
        if is_reply {
            self.reply(id, name, channel, message, context);
        } else {
            self.request(id, name);
        }
    }

    fn dropout(&mut self, _: u16, _: Location) {
        self.requests.clear();
    }

    fn corruption(&mut self, _: Location) {
        self.requests.clear();
    }

    fn end(&mut self, context: &mut RuleContext<'_>) {
        let requests = self.requests.drain().filter(|(_, request)| !request.is_right && !self.is_ambiguous);
        let mut found: Vec<_> =
            requests.filter_map(|(id, request)| Some((id, request.names, request.other?))).collect();
        found.sort_by_key(|(_, _, reply)| reply.location);
        for (id, names, reply) in found {
            report_violation(id, &names, &reply, context);
        }
    }
}

impl Registrations {
    fn request(&mut self, id: u64, name: &[u8]) {
        if self.requests.len() >= REQUESTS && !self.requests.contains_key(&id) {
            return;
        }
        let request = self.requests.entry(id).or_default();
        if request.names.iter().any(|known| known == name) {
            return;
        }
        // The reply precedes the request in the file.
        request.is_right |= request.other.as_ref().is_some_and(|reply| reply.name == name);
        request.is_right |= request.names.len() >= NAMES;
        if request.names.len() < NAMES {
            request.names.push(name.to_owned());
        }
    }

    fn reply(
        &mut self,
        id: u64,
        name: &[u8],
        channel: &Channel<'_>,
        message: &Message<'_>,
        context: &mut RuleContext<'_>,
    ) {
        let Some(request) = self.requests.get_mut(&id) else { return };
        context.covered();
        if request.names.iter().any(|known| known == name) {
            request.is_right = true;
        } else if request.other.is_none() {
            request.other = Some(OtherReply {
                topic: channel.full_topic.to_owned(),
                instance: channel.multi_id,
                name: name.to_owned(),
                definition: channel.definition,
                location: message.location,
            });
        }
    }
}

/// True for a reply, false for a request. `None` for other messages.
fn is_reply(channel: &Channel<'_>, context: &RuleContext<'_>) -> Option<bool> {
    match px4_message(channel, context)? {
        "RegisterExtComponentRequest" => Some(false),
        "RegisterExtComponentReply" => Some(true),
        _ => None,
    }
}

fn id_and_name(values: DynamicView<'_>) -> Option<(u64, &[u8])> {
    match values.get("name")? {
        Value::Text(name) if std::str::from_utf8(name).is_ok() => Some((number(values, "request_id")?, name)),
        _ => None,
    }
}

fn report_violation(id: u64, names: &[Vec<u8>], reply: &OtherReply, context: &mut RuleContext<'_>) {
    let topic = SubjectName { name: &reply.topic, instance: reply.instance };
    context.violation_in(topic, (reply.definition, "name"), reply.location, || {
        let names: Vec<String> = names.iter().map(|name| quoted(name)).collect();
        let (expected, actual) = (names.join(" or "), quoted(&reply.name));
        Detail::new(format!(
            "the reply to request {id} has the name {actual}, but the request has {expected}"
        ))
        .expected(expected)
        .actual(actual)
    });
}

fn quoted(name: &[u8]) -> String {
    format!("\"{}\"", name.escape_ascii())
}

/// Changes the name in the last reply.
fn renamed<'d>(flight: &Flight<'d>) -> Option<Flight<'d>> {
    flight.with_last(flight.topic("RegisterExtComponentReply")?, |reply| reply["name"] = "other".into())
}
