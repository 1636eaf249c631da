//! The known state of a PX4 vehicle, limited to the reasons why the vehicle can't arm. This module does no input or
//! output, so the same messages result in the same state.
//!
//! ```text
//!  bus, capture ──record──▶ checker ──message──▶ Watcher ──▶ Vehicle ──▶ view
//!                                                   ▲
//!                                                playback: pause, speed
//! ```
//!
//! Vehicles aren't trusted: all counts are limited, and all text is escaped before it is shown.

mod battery;
mod components;
mod flags;

pub mod playback;
pub mod source;
#[cfg(test)]
pub(crate) mod tests;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use uavspec_check::timeline::{
    Part, Refused, Texts, number, refused_modes, reported_modes, state_value, topic_name,
};
use uavspec_dynamic::DynamicView;
use uavspec_model::{Channel, Message};
use uavspec_px4::checks::{Reports, Step};
use uavspec_px4::event::RawEvent;
use uavspec_rules::definitions::{Definitions, EventMetadata};
use uavspec_rules::px4::Interest;
use uavspec_schema::MessageId;

pub(crate) use self::battery::Battery;
pub(crate) use self::components::{Component, Components, Readiness};
pub(crate) use self::flags::{Flag, Flags, Groups, Known, filtered};
use super::rate::Rate;
use crate::limits::MAX_CHANNELS;

/// The topics that the display needs.
pub(crate) const TOPICS: [&str; 8] = [
    "vehicle_status",
    "failsafe_flags",
    "battery_status",
    "arming_check_request",
    "arming_check_reply",
    "register_ext_component_reply",
    "unregister_ext_component",
    "event",
];

/// The definition of a message, and the texts that describe its values.
#[derive(Clone, Copy)]
pub(crate) struct Meaning<'m> {
    /// The definition of the message.
    pub id: MessageId,
    /// The definitions.
    pub definitions: &'m Definitions,
    /// The texts.
    pub texts: &'m Texts,
}

/// A vehicle.
#[derive(Clone, Debug, Default)]
pub struct Vehicle {
    /// The name of the definitions that explain the messages.
    pub release: Option<Arc<str>>,
    /// The state in `vehicle_status`.
    pub status: Status,
    /// The failsafe flags.
    pub flags: Flags,
    /// The batteries, by battery number or topic instance.
    pub batteries: BTreeMap<i128, Battery>,
    /// The external components.
    pub components: Components,
    /// The health and arming reports.
    reports: Reports,
    /// The modes in which the vehicle can't arm. `None` before the first report.
    pub refused: Option<Vec<Refused>>,
    /// The metadata of the events.
    pub(crate) metadata: Arc<EventMetadata>,
    /// The number of messages.
    pub messages: u64,
    /// The time of the latest message, in µs.
    pub latest: Option<u64>,
    /// A topic that several channels carry, if there is one. The messages then come from several vehicles, which can't
    /// be distinguished.
    pub ambiguous: Option<&'static str>,
    /// The topics of the display whose release is unknown.
    pub undecided: BTreeSet<&'static str>,
    /// The number of unreadable messages on the display's topics.
    pub unreadable: u64,
    rate: Rate,
    /// The time of the first message.
    first: Option<u64>,
    channels: Vec<Option<(&'static str, MessageId)>>,
}

/// The state that `vehicle_status` contains.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Status {
    /// The number of the mode.
    pub mode: Option<i128>,
    /// The mode.
    pub nav_state: Option<Part>,
    /// The arming state.
    pub arming_state: Option<Part>,
    /// True if a failsafe is active.
    pub is_failsafe: Option<bool>,
    /// True if the preflight checks have passed.
    pub has_passed_checks: Option<bool>,
}

impl Status {
    fn read(values: DynamicView<'_>, meaning: Meaning<'_>) -> Self {
        let part = |name: &str| {
            let Meaning { id, definitions, texts } = meaning;
            let value = state_value(("vehicle_status", name), id, number(values, name)?, definitions, texts)?;
            value.parts.into_iter().next()
        };
        let flag = |name: &str| number(values, name).map(|value| value != 0);
        Self {
            mode: number(values, "nav_state"),
            nav_state: part("nav_state"),
            arming_state: part("arming_state"),
            is_failsafe: flag("failsafe"),
            has_passed_checks: flag("pre_flight_checks_pass"),
        }
    }
}

impl Vehicle {
    /// Handles a channel whose release is unknown.
    pub(crate) fn undecided(&mut self, channel: &Channel<'_>, definitions: &Definitions) {
        self.undecided.extend(topic_name(channel, definitions).filter(|topic| TOPICS.contains(topic)));
    }

    /// Handles a new channel, and returns the display's interest in its messages.
    pub(crate) fn opened(&mut self, channel: &Channel<'_>, definitions: &Definitions) -> Interest {
        self.release = Some(definitions.name.as_str().into());
        if channel.index >= MAX_CHANNELS {
            return Interest::Nothing;
        }
        let topic = topic_name(channel, definitions).filter(|topic| TOPICS.contains(topic));
        let count = self.channels.len().max(channel.index + 1);
        self.channels.resize(count, None);
        self.channels[channel.index] = None;
        // Several instances of a topic belong to the same vehicle.
        if let Some(topic) = topic.filter(|_| channel.multi_id.is_none()) {
            let is_known = self.channels.iter().flatten().any(|(known, _)| *known == topic);
            self.ambiguous = self.ambiguous.or(is_known.then_some(topic));
        }
        if topic == Some("failsafe_flags") {
            self.flags = Flags::default();
        }
        self.channels[channel.index] = topic.zip(channel.definition);
        if topic.is_some() { Interest::Values } else { Interest::Nothing }
    }

    /// Forgets the channels of a connection that was lost. The known state remains.
    pub(crate) fn forget_channels(&mut self) {
        self.channels.clear();
        self.ambiguous = None;
    }

    /// Takes a message. Returns true if it changes the displayed state, apart from ages and rates.
    pub(crate) fn message(
        &mut self,
        channel: &Channel<'_>,
        message: &Message<'_>,
        time: Option<u64>,
        (definitions, texts): (&Definitions, &Texts),
    ) -> bool {
        let time = time.or(self.latest).unwrap_or_default();
        self.count(time);
        let Some((topic, id)) = self.channels.get(channel.index).copied().flatten() else { return false };
        let Some(values) = message.values else {
            self.unreadable = self.unreadable.saturating_add(1);
            return false;
        };
        let meaning = Meaning { id, definitions, texts };
        match topic {
            "vehicle_status" => {
                let status = Status::read(values, meaning);
                let is_changed = status != self.status;
                self.status = status;
                is_changed
            }
            "failsafe_flags" => self.flags.message(values, meaning),
            "battery_status" => battery::message(&mut self.batteries, channel.multi_id, values, meaning),
            "arming_check_request" => self.components.request(values),
            "arming_check_reply" => self.components.reply(values, time, (&self.metadata, texts)),
            "register_ext_component_reply" => self.components.registered(values),
            "unregister_ext_component" => self.components.unregistered(values),
            "event" => self.event(values, texts),
            _ => false,
        }
    }

    /// Takes an event. Returns true if it completes a report that changes the displayed state.
    fn event(&mut self, values: DynamicView<'_>, texts: &Texts) -> bool {
        let Some(raw) = RawEvent::read(values) else { return false };
        let event = raw.decode(self.metadata.events()).ok();
        if self.reports.follow(&raw, event.as_ref()) != Step::Complete {
            return false;
        }
        let refused = self.reports.latest().map(|report| refused_modes(report, &self.metadata, texts));
        let is_changed = refused != self.refused;
        self.refused = refused;
        is_changed
    }

    /// The modes in the latest report.
    pub fn modes(&self) -> Vec<Part> {
        self.reports.latest().map(reported_modes).unwrap_or_default()
    }

    fn count(&mut self, time: u64) {
        self.messages += 1;
        self.latest = Some(self.latest.map_or(time, |latest| latest.max(time)));
        self.first.get_or_insert(time);
        self.rate.count(self.elapsed(time));
    }

    /// True if a message has been received on one of the display's topics.
    pub fn has_state(&self) -> bool {
        let has_components = self.components.has_request || !self.components.all.is_empty();
        has_components
            || !self.flags.is_empty()
            || self.refused.is_some()
            || !self.batteries.is_empty()
            || self.status != Status::default()
    }

    /// The number of messages per second.
    pub(crate) fn rate(&self, now: u64) -> f64 {
        self.rate.per_second(self.elapsed(now))
    }

    /// The time from the first message to `now`.
    pub(crate) fn elapsed(&self, now: u64) -> Duration {
        self.first.map_or(Duration::ZERO, |first| age(first, now))
    }
}

/// The time from `time` to `now`. Both are in µs.
pub(crate) fn age(time: u64, now: u64) -> Duration {
    Duration::from_micros(now.saturating_sub(time))
}
