//! `PX-HASH-02`.
//!
//! A recording contains the types with which an application was built, if the user named them. These types are compared
//! with the flight controller's responses.
//!
//! PX4's message translation node offers the topics of older versions. A difference is not reported if the application's
//! version of a topic exists in addition to another version. Endpoints appear at any time, so this is decided at the end.

use std::collections::{BTreeSet, HashMap};

use uavspec_dynamic::{DynamicView, Value};
use uavspec_model::{ApplicationType, Endpoint, EndpointKind};
use uavspec_px4::comparison::compare_texts;
use uavspec_types::px4::MessageFormatResponse;

use super::ext::{number, px4_message};
use super::prelude::*;
use crate::definitions::{ReleasedType, released_type, unversioned, versioned};
use crate::limits::MAX_ITEMS;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-HASH-02",
    name: "Definitions of an application",
    level: Level::Must,
    status: Status::Normative,
    statement: "An application uses the flight controller's definition of each topic: PX4's hash of the \
                application's definition equals the `message_hash` of the MessageFormatResponse.",
    source: "`message_hash` of MessageFormatResponse; px4_ros2 compares it before it registers a mode",
    applies_to: "a vehicle and the application that the user names",
    why: "PX4 doesn't send the definitions of its messages. If an application has different definitions, \
          it and the flight controller decode each other's messages as garbage.",
    example: "→ MessageFormatRequest  {\"topic_name\": \"/fmu/out/vehicle_status\", …}\n\
              ← MessageFormatResponse {\"topic_name\": \"/fmu/out/vehicle_status\", \
              \"message_hash\": 2777220878, …}\n\
              application: VehicleStatus has the hash 3050114935",
    fix: "Build the application with the message definitions of the vehicle's release, or run PX4's \
          message translation node.",
})
.check(Check::State(|| Box::new(Application::default())))
.bug(Bug::message(
    Side::Autopilot,
    "The `message_hash` of each MessageFormatResponse belongs to a different definition.",
    |out| out.edit(1, |response: &mut MessageFormatResponse| response.message_hash ^= 1),
))
.mutants(&[Mutant::mcap("an application with a different definition", |flight, mut bag| {
    flight.topic("MessageFormatResponse")?;
    bag.application.first_mut()?.hash ^= 1;
    Some(bag)
})]);

#[derive(Default)]
struct Application {
    /// The types of the application, by topic.
    types: HashMap<String, ApplicationType>,
    /// The topics that a vehicle or a translation node offers.
    topics: BTreeSet<String>,
    differences: Vec<Difference>,
}

/// A response whose hash differs from the hash of the application's type.
struct Difference {
    /// The topic without a version.
    topic: String,
    ty: ApplicationType,
    /// The hash in the response.
    hash: u32,
    location: Location,
}

impl Checker for Application {
    fn opened(&mut self, channel: &Channel<'_>, context: &mut RuleContext<'_>) -> Interest {
        match px4_message(channel, context) {
            Some("MessageFormatResponse") => Interest::Values,
            _ => Interest::Nothing,
        }
    }

    fn application(&mut self, ty: &ApplicationType) {
        for topic in &ty.topics {
            if self.types.len() < MAX_ITEMS {
                self.types.insert(topic.clone(), ty.clone());
            }
        }
    }

    fn endpoint(&mut self, endpoint: &Endpoint, _: Location, _: &mut RuleContext<'_>) {
        let offers = match endpoint.kind {
            EndpointKind::Publisher => endpoint.topic.contains("/fmu/out/"),
            EndpointKind::Subscriber => endpoint.topic.contains("/fmu/in/"),
        };
        if offers && self.topics.len() < MAX_ITEMS {
            self.topics.insert(endpoint.topic.clone());
        }
    }

    fn message(&mut self, _: &Channel<'_>, message: &Message<'_>, context: &mut RuleContext<'_>) {
        let Some((name, hash)) = message.values.and_then(response) else { return };
        let (folder, topic) = name.rsplit_once('/').unwrap_or(("", name));
        let Some(ty) = self.types.get(topic) else { return };
        context.covered();
        let topic = format!("/{}/{topic}", folder.trim_start_matches('/'));
        let is_new = !self.differences.iter().any(|known| known.topic == topic && known.hash == hash);
        if hash != ty.hash && is_new && self.differences.len() < MAX_ITEMS {
            let (ty, location) = (ty.clone(), message.location);
            self.differences.push(Difference { topic, ty, hash, location });
        }
    }

    fn end(&mut self, context: &mut RuleContext<'_>) {
        for difference in std::mem::take(&mut self.differences) {
            let own_topic = difference.own_topic();
            let offered = || self.versions(&difference.topic);
            // A vehicle may have a namespace.
            let is_offered = offered().any(|topic| topic.ends_with(&own_topic));
            let other = offered().find(|topic| !topic.ends_with(&own_topic));
            if is_offered && other.is_some() {
                continue;
            }
            let topic = difference.topic.escape_debug().to_string();
            let other = other.filter(|_| !is_offered);
            context.violation(&topic, difference.location, || difference.detail(other));
        }
    }
}

impl Application {
    /// The topics with this name that a vehicle or a translation node offers, with and without versions.
    fn versions(&self, topic: &str) -> impl Iterator<Item = &String> {
        self.topics.iter().filter(move |known| unversioned(known).unwrap_or(known).ends_with(topic))
    }
}

impl Difference {
    /// The topic that the application uses.
    fn own_topic(&self) -> String {
        versioned(&self.topic, self.ty.version)
    }

    /// Describes the difference. `other` is the vehicle's topic, if the application's topic doesn't exist.
    fn detail(&self, other: Option<&String>) -> Detail {
        let Self { ty, hash, .. } = self;
        let [own, vehicle] = [ty.hash, *hash].map(|hash| released_type(&ty.name, hash));
        let name = ty.name.rsplit('/').next().unwrap_or_default();
        let origins = [&own, &vehicle].map(|ty| origin(ty.as_ref()));
        let differences = vehicle.as_ref().map(|vehicle| {
            let differences = compare_texts(&ty.fields, &vehicle.fields);
            format!(": {differences}. {}", effect(&ty.fields, &vehicle.fields))
        });
        let other = other.map(|other| format!(". There is no topic {}, only {other}", self.own_topic()));
        let text = format!(
            "{name}: the application uses {}, but the vehicle uses {}{}{}",
            origins[0],
            origins[1],
            differences.unwrap_or_default(),
            other.unwrap_or_default()
        );
        let [expected, actual] = [*hash, ty.hash].map(|hash| format!("0x{hash:08x}"));
        Detail::new(text.escape_debug().to_string()).expected(expected).actual(actual)
    }
}

fn origin(ty: Option<&ReleasedType>) -> String {
    ty.map_or("a definition that matches no known release".to_owned(), |ty| {
        format!("the definition of {}", ty.releases())
    })
}

/// The effect of the differences between two texts that PX4's hash covers. CDR contains the values in the order of
/// these texts.
fn effect(own: &str, vehicle: &str) -> String {
    let types =
        |text: &str| text.lines().filter_map(|line| line.split(' ').next()).map(str::to_owned).collect();
    let [own_types, other_types]: [Vec<String>; 2] = [types(own), types(vehicle)];
    let place = own_types.iter().zip(&other_types).position(|(own, other)| own != other);
    let name = place.and_then(|at| own.lines().nth(at)?.split(' ').nth(1));
    match name {
        Some(name) => format!("The values from `{name}` on are garbage"),
        None => "All other values are at the same positions".to_owned(),
    }
}

/// The topic and the hash of a successful response.
fn response(values: DynamicView<'_>) -> Option<(&str, u32)> {
    let Value::Text(topic) = values.get("topic_name")? else { return None };
    let is_success = number::<u8>(values, "success")? != 0;
    let topic = std::str::from_utf8(topic).ok().filter(|_| is_success)?;
    Some((topic, number(values, "message_hash")?))
}
