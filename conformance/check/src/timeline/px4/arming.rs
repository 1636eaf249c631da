//! Arming checks: requests, the replies of external components, and the registrations of these components.

use std::collections::BTreeMap;

use uavspec_dynamic::{DynamicView, Value as FieldValue};
use uavspec_px4::event::{EventMetadata, RawEvent};
use uavspec_schema::MessageId;

use super::{Defined, defined, events, number, rank_of};
use crate::limits::MAX_COMPONENTS;
use crate::timeline::context::Context;
use crate::timeline::label::{Item, Label, Texts};
use crate::timeline::lane::{LaneKind, Part, Severity, Value};

const REQUEST: &str = "arming_check_request";
/// The topic of the replies of external components.
pub(crate) const REPLY: &str = "arming_check_reply";

/// The verdict of a reply.
const VERDICT: &str = "can_arm_and_run";

/// Follows the external components.
#[derive(Default)]
pub(super) struct Arming {
    /// The current names of the components, by registration id. PX4 reuses the ids of removed components.
    names: BTreeMap<i128, String>,
}

impl Arming {
    /// Records the registrations that a request addresses. PX4 sends requests continuously, so requests aren't events.
    pub(super) fn request(&mut self, values: DynamicView<'_>, context: &mut Context<'_>) {
        let mask = number(values, "valid_registrations_mask");
        let name = if mask.is_some() { "valid_registrations_mask" } else { REQUEST };
        let lane = context.lane((REQUEST, "", name), rank_of(REQUEST), LaneKind::State);
        let Some(lane) = lane else { return };
        let parts = mask.map_or_else(|| vec![Part::new("sent", None)], |mask| self.registrations(mask));
        context.lanes.set(lane, context.time, Value::new(parts, Severity::Normal));
    }

    /// The registrations in a mask, each with the name of its component.
    fn registrations(&self, mask: i128) -> Vec<Part> {
        let is_valid = |bit: &u32| mask & (1 << bit) != 0;
        let part = |bit: u32| {
            let name = self.names.get(&bit.into());
            Part::new(format!("registration {bit}"), name.and_then(|name| Label::plain(name)))
        };
        (0..u32::BITS).filter(is_valid).map(part).collect()
    }

    /// Records a reply of a component.
    pub(super) fn reply(&self, id: MessageId, values: DynamicView<'_>, context: &mut Context<'_>) {
        let Some(registration) = number(values, "registration_id") else { return };
        let subject = component(registration, self.names.get(&registration));
        let lane = context.lane((REPLY, &subject, VERDICT), rank_of(REPLY), LaneKind::State);
        let Some(lane) = lane else { return };
        let can_run = number(values, VERDICT) != Some(0);
        let mut parts = vec![Part::new(if can_run { "true" } else { "false" }, None)];
        parts.extend(reply_events(values, context.metadata, context.texts));
        // The requirements of the mode, and the problems of the health component.
        for Defined { name, value, .. } in defined(id, values, context.definitions) {
            if matches!(value, FieldValue::Bool(true)) && name != VERDICT {
                let label = context.texts.label(id, Item::Field(name), context.definitions);
                parts.push(Part::new(name, label));
            }
        }
        let severity = if can_run { Severity::Normal } else { Severity::Warning };
        context.lanes.set(lane, context.time, Value::new(parts, severity));
    }

    /// Records a message that registers or removes a component.
    pub(super) fn registration(
        &mut self,
        topic: &str,
        definition: MessageId,
        values: DynamicView<'_>,
        context: &mut Context<'_>,
    ) {
        let lane = context.lane((topic, "", topic), rank_of(topic), LaneKind::Event);
        let is_refused = number(values, "success") == Some(0);
        let registration = number(values, "arming_check_id").filter(|id| *id >= 0 && !is_refused);
        if let (Some(id), Some(name)) = (registration, values.get("name").and_then(text)) {
            self.set_name(id, name, context);
        }
        let fields = defined(definition, values, context.definitions).into_iter();
        let fields = fields.filter(|field| field.name != "timestamp");
        let parts = fields.filter_map(|Defined { name, value, .. }| {
            let shown = match value {
                FieldValue::Bool(is_set) => return is_set.then(|| Part::new(name, None)),
                FieldValue::Int(value) => value.to_string(),
                FieldValue::UInt(value) => value.to_string(),
                other => text(other)?,
            };
            Some(Part::new(format!("{name} {shown}"), None))
        });
        if let Some(lane) = lane {
            let severity = if is_refused { Severity::Warning } else { Severity::Info };
            context.lanes.event(lane, context.time, Value::new(parts.collect(), severity));
        }
    }

    /// Sets the name of a component. The first component with a name also owns the earlier replies with this id. If
    /// another component gets the id, the replies of the previous component end.
    fn set_name(&mut self, registration: i128, name: String, context: &mut Context<'_>) {
        if self.names.len() >= MAX_COMPONENTS && !self.names.contains_key(&registration) {
            return;
        }
        let named = component(registration, Some(&name));
        match self.names.insert(registration, name) {
            None => context.lanes.rename((REPLY, &component(registration, None), VERDICT), &named),
            Some(before) => {
                let before = component(registration, Some(&before));
                if before != named {
                    context.lanes.end((REPLY, &before, VERDICT), context.time);
                }
            }
        }
    }
}

/// True if a message of a topic of the timeline contains events.
pub(crate) fn contains_events(topic: &str, values: Option<DynamicView<'_>>) -> bool {
    let has_event = |values| number(values, "num_events").is_some_and(|count| count > 0);
    topic == events::TOPIC || topic == REPLY && values.is_some_and(has_event)
}

/// The events in a reply.
pub fn reply_events(values: DynamicView<'_>, metadata: &EventMetadata, texts: &Texts) -> Vec<Part> {
    RawEvent::of_reply(values).iter().map(|event| events::part(event, metadata, texts)).collect()
}

/// The subject of a component's replies.
fn component(registration: i128, name: Option<&String>) -> String {
    let name = name.filter(|name| !name.is_empty()).map(|name| format!(", {name}"));
    format!("registration {registration}{}", name.unwrap_or_default())
}

/// The value of a text field.
pub fn text(value: FieldValue<'_>) -> Option<String> {
    match value {
        FieldValue::Text(bytes) | FieldValue::String(bytes) => {
            Some(String::from_utf8_lossy(bytes).into_owned())
        }
        _ => None,
    }
}
