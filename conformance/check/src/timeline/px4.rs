//! Follows the PX4 topics of the timeline.

mod arming;
mod events;
mod flights;
mod requirements;

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use uavspec_dynamic::{DynamicView, Value as FieldValue};
use uavspec_model::{Channel, Message};
use uavspec_rules::definitions::{BATTERY_STATUS, Definitions, VEHICLE_STATUS};
use uavspec_rules::px4::REQUIREMENT;
use uavspec_runtime::Number;
use uavspec_schema::msg::Dialect;
use uavspec_schema::value::Value as ConstantValue;
use uavspec_schema::{Form, MessageId};

pub(crate) use self::arming::{REPLY, contains_events};
pub use self::arming::{reply_events, text};
pub use self::events::{SentEvent, full_name};
pub(super) use self::events::{logged_text, remove_repeated_texts};
use self::flights::Flights;
pub use self::flights::{Flight, Overview, Refusal, Refused, reasons_text, refused_modes, reported_modes};
use self::requirements::Requirements;
pub use self::requirements::required_flags;
use super::context::Context;
use super::label::{Item, Texts};
use super::lane::{Lane, LaneKind, Part, Severity, Value};

/// A topic of the timeline.
#[derive(Debug)]
pub(super) struct Topic {
    /// The name.
    pub(super) name: &'static str,
    kind: TopicKind,
}

/// The lanes that a topic produces.
#[derive(Debug)]
enum TopicKind {
    /// A lane for each of these fields, in this order.
    Fields(&'static [Field]),
    /// A lane for each flag, for each of these fields, and for the unmet mode requirements.
    Flags(&'static [Field]),
    /// A lane for each component that replies.
    Replies,
    /// A lane for the components that a request addresses, by their registrations.
    Requests,
    /// Each message is an event.
    Events,
    /// No lane. The messages report takeoffs and landings.
    Landed,
    /// Each message registers or removes a component.
    Registrations,
}

/// A field that produces a lane.
#[derive(Debug)]
struct Field {
    name: &'static str,
    /// The constants that denote the field's values, if the definition doesn't bind an enum to the field. Without
    /// constants or an enum, the field is a flag.
    constants: Option<Constants>,
}

/// The constants for the values of a field to which some PX4 releases don't bind them.
#[derive(Debug)]
struct Constants {
    /// The topic of the message with the constants.
    topic: &'static str,
    /// The prefixes of the constants in the releases of PX4.
    prefixes: &'static [&'static str],
    /// True if greater values are worse.
    is_scale: bool,
}

const fn flag(name: &'static str) -> Field {
    Field { name, constants: None }
}

const fn state(name: &'static str, prefixes: &'static [&'static str]) -> Field {
    Field { name, constants: Some(Constants { topic: VEHICLE_STATUS, prefixes, is_scale: false }) }
}

const fn battery(name: &'static str) -> Field {
    let prefixes = &["BATTERY_WARNING", "BATTERY_STATE", "WARNING", "STATE"];
    let constants = Constants { topic: BATTERY_STATUS, prefixes, is_scale: true };
    Field { name, constants: Some(constants) }
}

/// The topics of the timeline, in the order of their lanes.
pub(super) static TOPICS: [Topic; 10] = [
    Topic {
        name: "vehicle_status",
        kind: TopicKind::Fields(&[
            state("nav_state", &["NAVIGATION_STATE"]),
            state("nav_state_user_intention", &["NAVIGATION_STATE"]),
            state("arming_state", &["ARMING_STATE"]),
            state("latest_arming_reason", &["ARM_DISARM_REASON"]),
            state("latest_disarming_reason", &["ARM_DISARM_REASON"]),
            flag("failsafe"),
        ]),
    },
    Topic { name: "failsafe_flags", kind: TopicKind::Flags(&[battery("battery_warning")]) },
    Topic { name: "battery_status", kind: TopicKind::Fields(&[battery("warning")]) },
    Topic { name: "arming_check_request", kind: TopicKind::Requests },
    Topic { name: "arming_check_reply", kind: TopicKind::Replies },
    Topic { name: "register_ext_component_request", kind: TopicKind::Registrations },
    Topic { name: "register_ext_component_reply", kind: TopicKind::Registrations },
    Topic { name: "unregister_ext_component", kind: TopicKind::Registrations },
    Topic { name: "event", kind: TopicKind::Events },
    Topic { name: "vehicle_land_detected", kind: TopicKind::Landed },
];

/// The subject of the first instance of a topic in a log.
const FIRST_INSTANCE: &str = "instance 0";

/// The number of ranks that are reserved for a topic's lanes, which have one rank for each field.
const RANKS: usize = 1_000;

/// Finds the index of the timeline topic that a channel carries.
pub(super) fn topic_of(channel: &Channel<'_>, definitions: &Definitions) -> Option<usize> {
    let message = definitions.schema.message(channel.definition?);
    let is_px4 = definitions.schema.package_of(message).form == Form::Msg(Dialect::Px4);
    let is_published = |name: &str| message.topics.iter().any(|topic| topic == name);
    // The other topics of a message aren't part of the timeline.
    let is_other = |name: &str| channel.topic != name && is_published(channel.topic);
    TOPICS.iter().position(|topic| is_px4 && is_published(topic.name) && !is_other(topic.name))
}

/// The name of the timeline topic that a channel carries.
pub fn topic_name(channel: &Channel<'_>, definitions: &Definitions) -> Option<&'static str> {
    topic_of(channel, definitions).map(|topic| TOPICS[topic].name)
}

/// Follows all channels.
#[derive(Default)]
pub(super) struct Px4 {
    channels: Vec<Option<Open>>,
    /// The number of channels for each full topic name, outside of logs.
    carriers: HashMap<String, usize>,
    requirements: Requirements,
    arming: arming::Arming,
    pub(super) events: events::Events,
    pub(super) flights: Flights,
}

/// A channel of a topic.
struct Open {
    topic: usize,
    /// The instance in a log; otherwise, the topic with its namespace.
    subject: Arc<str>,
    definition: MessageId,
    /// The fields that produce lanes. Set when the first message arrives.
    watched: Option<Vec<Watched>>,
}

/// A field that produces a lane.
struct Watched {
    /// The index of the field in messages.
    index: usize,
    name: String,
    constants: Option<&'static Constants>,
    rank: usize,
    /// The lane, and its latest value.
    lane: Option<(usize, i128)>,
}

impl Px4 {
    /// Handles a new channel. Returns true if the timeline needs its messages.
    pub(super) fn opened(&mut self, channel: &Channel<'_>, definitions: &Definitions) -> bool {
        let count = self.channels.len().max(channel.index + 1);
        self.channels.resize_with(count, || None);
        let open = topic_of(channel, definitions).zip(channel.definition).map(|(topic, definition)| Open {
            topic,
            subject: self.subject(channel).into(),
            definition,
            watched: None,
        });
        let is_open = open.is_some();
        self.channels[channel.index] = open;
        is_open
    }

    /// The subject of a channel's lanes.
    fn subject(&mut self, channel: &Channel<'_>) -> String {
        if let Some(instance) = channel.multi_id {
            return format!("instance {instance}");
        }
        let count = self.carriers.entry(channel.full_topic.to_owned()).or_default();
        *count += 1;
        match *count {
            1 => channel.full_topic.to_owned(),
            number => format!("{}, channel {number}", channel.full_topic),
        }
    }

    /// Follows a message. Returns its topic if the message belongs to the timeline. If the message is unreadable, the
    /// topic is returned as an error.
    pub(super) fn message(
        &mut self,
        channel: &Channel<'_>,
        message: &Message<'_>,
        context: &mut Context<'_>,
    ) -> Option<Result<&'static str, &'static str>> {
        let open = self.channels.get_mut(channel.index)?.as_mut()?;
        let Topic { name, kind } = &TOPICS[open.topic];
        let Some(values) = message.values else { return Some(Err(name)) };
        match kind {
            TopicKind::Fields(fields) => {
                open.follow(fields, false, values, context);
                self.requirements.status(channel, values, context);
                if *name == VEHICLE_STATUS {
                    let stated = |field: &str| {
                        let value = number(values, field)?;
                        let (definitions, texts) = (context.definitions, context.texts);
                        let value = state_value((name, field), open.definition, value, definitions, texts)?;
                        value.parts.into_iter().next()
                    };
                    self.flights.status(channel, values, context.time, stated);
                }
            }
            TopicKind::Flags(fields) => {
                open.follow(fields, true, values, context);
                self.requirements.flags(channel, open.definition, values, context);
            }
            TopicKind::Replies => self.arming.reply(open.definition, values, context),
            TopicKind::Requests => self.arming.request(values, context),
            TopicKind::Registrations => self.arming.registration(name, open.definition, values, context),
            TopicKind::Events => self.events.event(values, &open.subject, &mut self.flights, context),
            TopicKind::Landed => self.flights.landed(values, context.time),
        }
        Some(Ok(name))
    }
}

/// Removes the subjects of topics that have only one channel, unless this channel isn't the first instance.
pub(super) fn hide_only_channels(lanes: &mut [Lane]) {
    for Topic { name, kind } in &TOPICS {
        if !matches!(kind, TopicKind::Fields(_) | TopicKind::Flags(_) | TopicKind::Events) {
            continue;
        }
        let of_topic: Vec<&mut Lane> = lanes.iter_mut().filter(|lane| lane.topic == *name).collect();
        let subjects: BTreeSet<&String> = of_topic.iter().filter_map(|lane| lane.subject.as_ref()).collect();
        let is_only = |subject: &&String| !subject.starts_with("instance ") || *subject == FIRST_INSTANCE;
        if subjects.len() == 1 && subjects.iter().all(is_only) {
            for lane in of_topic {
                lane.subject = None;
            }
        }
    }
}

/// The rank of the first lane of a topic.
fn rank_of(topic: &str) -> usize {
    TOPICS.iter().position(|known| known.name == topic).unwrap_or(TOPICS.len()) * RANKS
}

impl Open {
    /// Records the values of all watched fields.
    fn follow(
        &mut self,
        fields: &'static [Field],
        has_flags: bool,
        values: DynamicView<'_>,
        context: &mut Context<'_>,
    ) {
        let topic = TOPICS[self.topic].name;
        let id = self.definition;
        let watched = self.watched.get_or_insert_with(|| {
            let known = defined(id, values, context.definitions);
            watched(topic, fields, has_flags, known)
        });
        for field in watched {
            let Some(Number::Int(number)) = values.field(field.index).and_then(FieldValue::number) else {
                continue;
            };
            match field.lane {
                Some((lane, known)) if known == number => context.lanes.count(lane),
                _ => field.changed(topic, &self.subject, id, number, context),
            }
        }
    }
}

/// A field of a message that the definition also contains.
struct Defined<'v> {
    /// The index in the message.
    index: usize,
    name: &'v str,
    value: FieldValue<'v>,
}

/// The fields of a message that the definition contains, in the order of the definition. Logs have a different order.
fn defined<'v>(id: MessageId, values: DynamicView<'v>, definitions: &Definitions) -> Vec<Defined<'v>> {
    let fields = &definitions.schema.message(id).fields;
    let found = fields.iter().filter_map(|field| {
        let mut all = values.fields().enumerate();
        let (index, (name, value)) = all.find(|(_, (name, _))| *name == field.name)?;
        Some(Defined { index, name, value })
    });
    found.collect()
}

/// The fields of a message that produce lanes. `fields` are the fields in the list; `has_flags` adds all flags.
fn watched(topic: &str, fields: &'static [Field], has_flags: bool, values: Vec<Defined<'_>>) -> Vec<Watched> {
    let mut found = Vec::new();
    for (at, Defined { index, name, value }) in values.into_iter().enumerate() {
        let known = fields.iter().position(|field| field.name == name);
        let is_flag = has_flags && matches!(value, FieldValue::Bool(_)) && !name.starts_with(REQUIREMENT);
        if known.is_none() && !is_flag {
            continue;
        }
        found.push(Watched {
            index,
            name: name.to_owned(),
            constants: known.and_then(|at| fields[at].constants.as_ref()),
            // Flags are in the order of the definition.
            rank: rank_of(topic) + known.filter(|_| !has_flags).unwrap_or(at),
            lane: None,
        });
    }
    found
}

impl Watched {
    fn changed(
        &mut self,
        topic: &str,
        subject: &str,
        id: MessageId,
        number: i128,
        context: &mut Context<'_>,
    ) {
        let Context { definitions, texts, .. } = *context;
        let kind = if self.constants.is_some() { LaneKind::State } else { LaneKind::Flag };
        let lane = context.lanes.get((topic, subject, &self.name), || Lane {
            label: texts.label(id, Item::Field(&self.name), definitions),
            group: texts.label(id, Item::Group(&self.name), definitions),
            rank: self.rank,
            ..Lane::new(topic, &*self.name, kind)
        });
        let Some(lane) = lane else { return };
        self.lane = Some((lane, number));
        match self.constants {
            None => context.lanes.set_flag(lane, context.time, number != 0),
            Some(constants) => {
                let value = constants.value(id, &self.name, number, definitions, texts);
                context.lanes.set(lane, context.time, value);
            }
        }
    }
}

impl Constants {
    /// The value of a field, with its constant and severity.
    fn value(
        &self,
        id: MessageId,
        field: &str,
        number: i128,
        definitions: &Definitions,
        texts: &Texts,
    ) -> Value {
        let severity = match number {
            1 if self.is_scale => Severity::Warning,
            2.. if self.is_scale => Severity::Error,
            _ => Severity::Normal,
        };
        Value::new(vec![constant(id, field, self, number, definitions, texts)], severity)
    }
}

/// The value of a field, if the field has constants and belongs to a timeline topic. `None` for other fields.
pub fn state_value(
    (topic, field): (&str, &str),
    id: MessageId,
    number: i128,
    definitions: &Definitions,
    texts: &Texts,
) -> Option<Value> {
    let topic = TOPICS.iter().find(|known| known.name == topic)?;
    let (TopicKind::Fields(fields) | TopicKind::Flags(fields)) = topic.kind else { return None };
    let constants = fields.iter().find(|known| known.name == field)?.constants.as_ref()?;
    Some(constants.value(id, field, number, definitions, texts))
}

/// The indices and names of the flags in a message of `failsafe_flags`, in the order of the definition.
pub fn flags(id: MessageId, values: DynamicView<'_>, definitions: &Definitions) -> Vec<(usize, String)> {
    let topic = "failsafe_flags";
    let kinds = TOPICS.iter().filter(|known| known.name == topic).map(|known| &known.kind);
    let fields =
        kinds.filter_map(|kind| if let TopicKind::Flags(fields) = kind { Some(*fields) } else { None });
    let watched = fields.flat_map(|fields| watched(topic, fields, true, defined(id, values, definitions)));
    watched.map(|field| (field.index, field.name)).collect()
}

/// The constant for a value of a field.
fn constant(
    id: MessageId,
    field: &str,
    constants: &Constants,
    number: i128,
    definitions: &Definitions,
    texts: &Texts,
) -> Part {
    let schema = &definitions.schema;
    let message = schema.message(id);
    let bound = message.fields.iter().find(|known| known.name == field).and_then(|field| field.enumeration);
    let found = match bound {
        Some(reference) => {
            let members = &schema.enumeration(reference).members;
            let member = members.iter().find(|member| member.value == number);
            member.map(|member| (reference.message, &*member.name, member.constant))
        }
        None => by_prefix(id, constants, number, definitions),
    };
    let Some((id, name, at)) = found else { return Part::new(number.to_string(), None) };
    let constant = &schema.message(id).constants[at];
    let label = texts.label(id, Item::Constant(&constant.name), definitions);
    Part::new(name, label.or_else(|| texts.built_in_value(message, field, name)))
}

/// Finds the first constant that has this value and one of the prefixes. Returns its message, its name without the
/// prefix, and its index.
fn by_prefix<'d>(
    id: MessageId,
    constants: &Constants,
    number: i128,
    definitions: &'d Definitions,
) -> Option<(MessageId, &'d str, usize)> {
    let other = definitions.message_of_topic(constants.topic);
    [Some(id), other].into_iter().flatten().find_map(|id| {
        let all = definitions.schema.message(id).constants.iter().enumerate();
        let mut named = all.filter_map(|(at, constant)| {
            let mut prefixes = constants.prefixes.iter();
            let name = prefixes.find_map(|prefix| constant.name.strip_prefix(prefix)?.strip_prefix('_'))?;
            // A constant for the number of values isn't a value.
            (integer(&constant.value) == Some(number) && name != "MAX").then_some((id, name, at))
        });
        named.next()
    })
}

fn integer(value: &ConstantValue) -> Option<i128> {
    match value.number()? {
        Number::Int(value) => Some(value),
        Number::Float(_) => None,
    }
}

/// The value of an integer field.
pub fn number(values: DynamicView<'_>, name: &str) -> Option<i128> {
    whole(values.get(name)?)
}

fn whole(value: FieldValue<'_>) -> Option<i128> {
    match value.number()? {
        Number::Int(value) => Some(value),
        Number::Float(_) => None,
    }
}
