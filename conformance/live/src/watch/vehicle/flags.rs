//! Failsafe flags, and the modes that they prevent.

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

/// The name of the requirements that have no flag.
const OTHER: &str = "mode_req_other";
const PREVENT_ARMING: &str = "mode_req_prevent_arming";

/// The number of modes that a mask can contain.
const NUM_MODES: i128 = 32;

/// The failsafe flags.
#[derive(Clone, Debug, Default)]
pub struct Flags {
    known: Option<Arc<[Known]>>,
    /// The names of the modes, by mode number.
    modes: Arc<BTreeMap<i128, Part>>,
    states: Vec<State>,
}

/// The constant part of a flag.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Known {
    /// The name of the field.
    pub name: String,
    /// The label.
    pub label: Option<Label>,
    /// The heading of its group.
    pub group: Option<Label>,
    /// The index of the field.
    index: usize,
    /// The indices of the mode requirements that refer to the flag.
    masks: Vec<usize>,
}

/// The current value of a flag.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct State {
    number: i128,
    /// The value, if the field has constants.
    pub value: Option<Value>,
    /// The modes that require the flag to be clear.
    modes: i128,
}

/// A flag with its value.
#[derive(Clone, Debug)]
pub(crate) struct Flag<'f> {
    /// The constant part.
    pub known: &'f Known,
    /// The value.
    pub state: &'f State,
    /// The severity. A flag that isn't set has the severity "normal".
    pub severity: Severity,
}

/// Flags by group.
pub(crate) type Groups<'f> = Vec<Vec<Flag<'f>>>;

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

    /// All flags with their values.
    fn all(&self) -> impl Iterator<Item = (&Known, &State)> {
        self.known.as_deref().unwrap_or_default().iter().zip(&self.states)
    }

    /// The flags by group, in the order of the definition. Flags that `mode` requires to be clear are errors.
    fn groups(&self, mode: Option<i128>) -> Groups<'_> {
        let mut groups: Groups<'_> = Vec::new();
        for (known, state) in self.all() {
            let flag = Flag { known, state, severity: state.severity(known, mode) };
            match groups.iter_mut().find(|group| group[0].known.group == known.group) {
                Some(group) => group.push(flag),
                None => groups.push(vec![flag]),
            }
        }
        groups
    }

    /// The flags that are set, by group. The most severe flags come first.
    pub(crate) fn set(&self, mode: Option<i128>) -> Groups<'_> {
        let rank = |flag: &Flag<'_>| std::cmp::Reverse((flag.severity, flag.num_modes()));
        let mut groups = filtered(self.groups(mode), |flag| flag.severity > Severity::Normal);
        for group in &mut groups {
            group.sort_by_key(rank);
        }
        groups.sort_by_key(|group| group.first().map(rank));
        groups
    }

    /// The flags that aren't set, by group. Requirements without a flag are left out.
    pub(crate) fn clear(&self, mode: Option<i128>) -> Groups<'_> {
        filtered(self.groups(mode), |flag| {
            flag.severity == Severity::Normal && !flag.known.name.starts_with(REQUIREMENT)
        })
    }

    /// The modes whose requirements aren't met, with the reasons. Modes with the same reasons share an entry.
    pub(crate) fn blocked(&self) -> Vec<(Vec<i128>, Vec<&Known>)> {
        let mut found: Vec<(Vec<i128>, Vec<&Known>)> = Vec::new();
        for mode in 0..NUM_MODES {
            // The vehicle can't arm in modes such as Land, but it can switch to them in flight.
            let is_blocking = |(known, state): &(&Known, &State)| {
                state.number != 0 && state.modes & (1 << mode) != 0 && known.name != PREVENT_ARMING
            };
            let reasons: Vec<&Known> = self.all().filter(is_blocking).map(|(known, _)| known).collect();
            match found.iter_mut().find(|(_, known)| *known == reasons) {
                _ if reasons.is_empty() => {}
                Some((modes, _)) => modes.push(mode),
                None => found.push((vec![mode], reasons)),
            }
        }
        found
    }

    /// The name of a mode, if it is known.
    pub(crate) fn mode(&self, mode: i128) -> Option<&Part> {
        self.modes.get(&mode)
    }
}

/// The flags for which `is_kept` returns true. Groups without flags are left out.
pub(crate) fn filtered(groups: Groups<'_>, is_kept: impl Fn(&Flag<'_>) -> bool) -> Groups<'_> {
    let kept = groups.into_iter().map(|group| group.into_iter().filter(&is_kept).collect::<Vec<_>>());
    kept.filter(|group| !group.is_empty()).collect()
}

impl Flag<'_> {
    /// The number of modes that the flag blocks.
    pub(crate) fn num_modes(&self) -> u32 {
        if self.state.number == 0 { 0 } else { self.state.modes.count_ones() }
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
    /// The severity. A flag that `mode` requires to be clear prevents arming.
    fn severity(&self, known: &Known, mode: Option<i128>) -> Severity {
        let mode = mode.filter(|mode| (0..NUM_MODES).contains(mode));
        let is_required = mode.is_some_and(|mode| self.modes & (1 << mode) != 0);
        match &self.value {
            _ if self.number == 0 => Severity::Normal,
            _ if is_required => Severity::Error,
            // A requirement without a flag matters only in its modes.
            _ if known.name.starts_with(REQUIREMENT) => Severity::Normal,
            Some(value) => value.severity.max(Severity::Warning),
            None if known.name.starts_with(FAILURE) => Severity::Error,
            None => Severity::Warning,
        }
    }
}

/// The flags in a message, and the requirements without a flag.
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
        // For undefined modes, the name is the number.
        (part.name != mode.to_string()).then_some((mode, part))
    };
    (0..NUM_MODES).filter_map(name).collect()
}
