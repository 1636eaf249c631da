//! Failsafe flags, and the modes that they block.

use std::collections::BTreeMap;
use std::sync::Arc;

use uavspec_check::timeline::{
    Item, Label, Part, Severity, Value, flags, number, required_flags, state_value,
};
use uavspec_dynamic::DynamicView;
use uavspec_rules::px4::REQUIREMENT;

use super::Meaning;

/// The prefix of the flags of the failure detector.
const FAILURE: &str = "fd_";

/// Requirements without a flag.
const OTHER: &str = "mode_req_other";
const PREVENT_ARMING: &str = "mode_req_prevent_arming";

/// The number of modes that a mask can contain.
const NUM_MODES: i128 = 32;

/// The failsafe flags.
#[derive(Clone, Debug, Default)]
pub struct Flags {
    known: Option<Arc<[Known]>>,
    /// The names of the modes, by number.
    modes: Arc<BTreeMap<i128, Part>>,
    states: Vec<State>,
}

/// The constant part of a flag.
#[derive(Clone, Debug)]
pub(crate) struct Known {
    /// The name of the field.
    pub name: String,
    /// The label.
    pub label: Option<Label>,
    /// The heading of its group.
    pub group: Option<Label>,
    /// The index of the field.
    index: usize,
    /// The indices of its requirements.
    masks: Vec<usize>,
}

/// The value of a flag.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct State {
    number: i128,
    /// The value, if the field has constants.
    value: Option<Value>,
    /// The modes that require the flag to be clear.
    modes: i128,
}

/// A flag with its value.
#[derive(Clone, Debug)]
pub(crate) struct Flag<'f> {
    /// The constant part.
    pub known: &'f Known,
    /// The value, if the field has constants.
    pub value: Option<&'f Value>,
    /// The severity. Flags that aren't set are normal.
    pub severity: Severity,
    /// The number of modes that the flag blocks.
    pub num_modes: u32,
}

/// Modes that can't run, for the same reasons.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Blocked {
    /// The numbers of the modes.
    pub modes: Vec<i128>,
    /// The indices of the flags.
    flags: Vec<usize>,
}

impl Flags {
    /// Takes a message. Returns true if a flag or a requirement changes.
    pub(super) fn message(&mut self, values: DynamicView<'_>, meaning: Meaning<'_>) -> bool {
        if self.known.is_none() {
            self.known = Some(known(values, meaning).into());
            self.modes = Arc::new(modes(meaning));
        }
        let known = self.known.as_deref().unwrap_or_default();
        let states: Vec<State> = known.iter().map(|flag| flag.state(values, meaning)).collect();
        let is_changed = states != self.states;
        self.states = states;
        is_changed
    }

    /// True if no message has been received yet.
    pub(crate) fn is_empty(&self) -> bool {
        self.states.is_empty()
    }

    /// All flags. In a mode, the flags that it requires to be clear are errors.
    pub(crate) fn all(&self, mode: Option<i128>) -> impl Iterator<Item = Flag<'_>> {
        let known = self.known.as_deref().unwrap_or_default();
        known.iter().zip(&self.states).map(move |(known, state)| Flag {
            known,
            value: state.value.as_ref(),
            severity: state.severity(known, mode),
            num_modes: if state.number == 0 { 0 } else { state.modes.count_ones() },
        })
    }

    /// The flags by group, in the order of the definition.
    fn groups(&self, mode: Option<i128>) -> Vec<Vec<Flag<'_>>> {
        let mut groups: Vec<Vec<Flag<'_>>> = Vec::new();
        for flag in self.all(mode) {
            match groups.iter_mut().find(|group| group[0].known.group == flag.known.group) {
                Some(group) => group.push(flag),
                None => groups.push(vec![flag]),
            }
        }
        groups
    }

    /// The flags that are set, by group. The most severe come first.
    pub(crate) fn set(&self, mode: Option<i128>) -> Vec<Vec<Flag<'_>>> {
        let rank = |flag: &Flag<'_>| std::cmp::Reverse((flag.severity, flag.num_modes));
        let mut groups = self.groups(mode);
        for group in &mut groups {
            group.retain(|flag| flag.severity > Severity::Normal);
            group.sort_by_key(rank);
        }
        groups.retain(|group| !group.is_empty());
        groups.sort_by_key(|group| group.first().map(rank));
        groups
    }

    /// The flags that aren't set, by group. The requirements without a flag are left out.
    pub(crate) fn clear(&self, mode: Option<i128>) -> Vec<Vec<Flag<'_>>> {
        let mut groups = self.groups(mode);
        for group in &mut groups {
            group.retain(|flag| {
                flag.severity == Severity::Normal && !flag.known.name.starts_with(REQUIREMENT)
            });
        }
        groups.retain(|group| !group.is_empty());
        groups
    }

    /// The modes whose requirements aren't met. Modes with the same reasons are together.
    pub(crate) fn blocked(&self) -> Vec<Blocked> {
        let known = self.known.as_deref().unwrap_or_default();
        let mut found: Vec<Blocked> = Vec::new();
        for mode in 0..NUM_MODES {
            // Modes such as Land can't be armed in, but they can run.
            let is_blocking = |at: &usize| {
                let state = &self.states[*at];
                state.number != 0 && state.modes & (1 << mode) != 0 && known[*at].name != PREVENT_ARMING
            };
            let flags: Vec<usize> = (0..self.states.len()).filter(is_blocking).collect();
            match found.iter_mut().find(|blocked| blocked.flags == flags) {
                _ if flags.is_empty() => {}
                Some(blocked) => blocked.modes.push(mode),
                None => found.push(Blocked { modes: vec![mode], flags }),
            }
        }
        found
    }

    /// The reasons for which modes can't run.
    pub(crate) fn reasons(&self, blocked: &Blocked) -> impl Iterator<Item = &Known> {
        let known = self.known.as_deref().unwrap_or_default();
        blocked.flags.iter().filter_map(|at| known.get(*at))
    }

    /// The name of a mode, if it is known.
    pub(crate) fn mode(&self, mode: i128) -> Option<&Part> {
        self.modes.get(&mode)
    }
}

impl Known {
    fn state(&self, values: DynamicView<'_>, meaning: Meaning<'_>) -> State {
        let Meaning { id, definitions, texts } = meaning;
        let at = |index: usize| {
            let (name, _) = values.fields().nth(index)?;
            number(values, name)
        };
        let number = at(self.index).unwrap_or_default();
        let value = || state_value(("failsafe_flags", &self.name), id, number, definitions, texts);
        let value = if number == 0 || self.name.starts_with(REQUIREMENT) { None } else { value() };
        let masks = self.masks.iter().filter_map(|mask| at(*mask));
        State { number, value, modes: masks.fold(0, |all, mask| all | mask) }
    }
}

impl State {
    /// The severity. Flags that the mode requires to be clear prevent arming.
    fn severity(&self, known: &Known, mode: Option<i128>) -> Severity {
        let mode = mode.filter(|mode| (0..NUM_MODES).contains(mode));
        let is_required = mode.is_some_and(|mode| self.modes & (1 << mode) != 0);
        match &self.value {
            _ if self.number == 0 => Severity::Normal,
            _ if is_required => Severity::Error,
            // Requirements without a flag matter only in their modes.
            _ if known.name.starts_with(REQUIREMENT) => Severity::Normal,
            Some(value) => value.severity.max(Severity::Warning),
            None if known.name.starts_with(FAILURE) => Severity::Error,
            None => Severity::Warning,
        }
    }
}

/// The flags of a message, and its requirements without a flag.
fn known(values: DynamicView<'_>, meaning: Meaning<'_>) -> Vec<Known> {
    let Meaning { id, definitions, texts } = meaning;
    let required = required_flags(values);
    let flags = flags(id, values, definitions).into_iter().map(|(index, name)| Known {
        label: texts.label(id, Item::Field(&name), definitions),
        group: texts.label(id, Item::Group(&name), definitions),
        name,
        index,
        masks: required.iter().filter(|(flag, _)| *flag == index).map(|(_, mask)| *mask).collect(),
    });
    let others = values.fields().enumerate().filter(|(_, (name, _))| [OTHER, PREVENT_ARMING].contains(name));
    let others = others.map(|(index, (name, _))| Known {
        name: name.to_owned(),
        label: None,
        group: texts.label(id, Item::Group(name), definitions),
        index,
        masks: vec![index],
    });
    flags.chain(others).collect()
}

/// The names of the modes.
fn modes(meaning: Meaning<'_>) -> BTreeMap<i128, Part> {
    let Meaning { definitions, texts, .. } = meaning;
    let Some(id) = definitions.message_of_topic("vehicle_status") else { return BTreeMap::new() };
    let name = |mode: i128| {
        let value = state_value(("vehicle_status", "nav_state"), id, mode, definitions, texts)?;
        let part = value.parts.into_iter().next()?;
        // Undefined modes have their number as a name.
        (part.name != mode.to_string()).then_some((mode, part))
    };
    (0..NUM_MODES).filter_map(name).collect()
}
