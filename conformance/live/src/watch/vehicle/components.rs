//! External components: their registrations, and their replies to arming checks.

use std::collections::BTreeMap;

use uavspec_check::timeline::{Part, Texts, number, reply_events, text};
use uavspec_dynamic::DynamicView;
use uavspec_rules::definitions::EventMetadata;

use crate::limits::MAX_COMPONENTS;

/// The number of consecutive unanswered requests after which PX4 regards a component as unresponsive.
pub(crate) const LATE: u32 = 3;

/// The external components.
#[derive(Clone, Debug, Default)]
pub struct Components {
    /// The components by registration id.
    pub all: BTreeMap<i128, Component>,
    /// The name of the component whose registration was last refused.
    pub refused: Option<String>,
    /// True if the vehicle has sent a request.
    pub has_request: bool,
}

/// An external component.
#[derive(Clone, Debug, Default)]
pub struct Component {
    /// The name of the component, if its registration was received.
    pub name: Option<String>,
    /// The number of the mode that the component adds.
    pub mode: Option<i128>,
    /// The time of the latest reply, in µs.
    pub replied: Option<u64>,
    /// True if the component allows arming.
    pub can_run: Option<bool>,
    /// The reasons in the last reply: its events.
    pub reasons: Vec<Part>,
    /// The number of consecutive unanswered requests.
    pub unanswered: u32,
    /// True if the vehicle states that the registration is valid.
    pub is_valid: Option<bool>,
    /// True if the last request hasn't been answered yet.
    is_awaited: bool,
}

/// The readiness of a component, from worst to best.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Readiness {
    /// The component doesn't reply.
    Late,
    /// The component doesn't allow arming.
    NotReady,
    /// There has been no reply yet.
    Unknown,
    /// The component allows arming.
    Ready,
}

impl Component {
    /// The readiness.
    pub(crate) fn readiness(&self) -> Readiness {
        match self.can_run {
            _ if self.unanswered >= LATE => Readiness::Late,
            Some(true) => Readiness::Ready,
            Some(false) => Readiness::NotReady,
            None => Readiness::Unknown,
        }
    }
}

impl Components {
    /// Takes a request from the vehicle. Returns true if it changes the displayed state.
    pub(super) fn request(&mut self, values: DynamicView<'_>) -> bool {
        let mut is_changed = !std::mem::replace(&mut self.has_request, true);
        let mask = number(values, "valid_registrations_mask");
        for id in (0..32).filter(|id| mask.is_some_and(|mask| mask & (1 << id) != 0)) {
            is_changed |= !self.all.contains_key(&id);
            self.component(id);
        }
        for (id, component) in &mut self.all {
            let before = (component.readiness(), component.is_valid);
            if component.is_awaited {
                component.unanswered = component.unanswered.saturating_add(1);
            }
            component.is_awaited = true;
            component.is_valid = mask.filter(|_| *id < 32).map(|mask| mask & (1 << *id) != 0);
            is_changed |= before != (component.readiness(), component.is_valid);
        }
        is_changed
    }

    /// Takes a reply. Returns true if it changes the displayed state.
    pub(super) fn reply(
        &mut self,
        values: DynamicView<'_>,
        time: u64,
        (metadata, texts): (&EventMetadata, &Texts),
    ) -> bool {
        let Some(id) = number(values, "registration_id") else { return false };
        let Some(component) = self.component(id) else { return false };
        let can_run = number(values, "can_arm_and_run").map(|value| value != 0);
        let reasons = reply_events(values, metadata, texts);
        let is_changed =
            component.can_run != can_run || component.reasons != reasons || component.unanswered >= LATE;
        component.replied = Some(time);
        (component.unanswered, component.is_awaited) = (0, false);
        (component.can_run, component.reasons) = (can_run, reasons);
        is_changed
    }

    /// Takes the vehicle's answer to a registration. Returns true if it changes the displayed state.
    pub(super) fn registered(&mut self, values: DynamicView<'_>) -> bool {
        let name = values.get("name").and_then(text);
        if number(values, "success") == Some(0) {
            self.refused = Some(name.unwrap_or_default());
            return true;
        }
        let Some(id) = number(values, "arming_check_id").filter(|id| *id >= 0) else { return false };
        let mode = number(values, "mode_id").filter(|mode| *mode >= 0);
        // A new registration with the same id replaces the old one.
        self.all.remove(&id);
        if let Some(component) = self.component(id) {
            (component.name, component.mode) = (name, mode);
        }
        true
    }

    /// Takes the end of a registration. Returns true if it changes the displayed state.
    pub(super) fn unregistered(&mut self, values: DynamicView<'_>) -> bool {
        number(values, "arming_check_id").is_some_and(|id| self.all.remove(&id).is_some())
    }

    /// Returns the component with this id, which is added if necessary. `None` if there are too many components.
    fn component(&mut self, id: i128) -> Option<&mut Component> {
        let is_full = self.all.len() >= MAX_COMPONENTS && !self.all.contains_key(&id);
        (!is_full).then(|| self.all.entry(id).or_default())
    }

    /// The name of the component that adds a mode.
    pub(crate) fn name_of_mode(&self, mode: i128) -> Option<&str> {
        let mut all = self.all.values();
        all.find(|component| component.mode == Some(mode)).and_then(|component| component.name.as_deref())
    }
}
