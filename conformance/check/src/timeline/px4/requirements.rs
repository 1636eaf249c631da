//! The requirements of the current mode that aren't met.

use uavspec_dynamic::DynamicView;
use uavspec_model::Channel;
use uavspec_rules::px4::{REQUIREMENT, belongs_to};
use uavspec_schema::MessageId;

use super::{number, rank_of, whole};
use crate::timeline::context::Context;
use crate::timeline::label::{Item, Label};
use crate::timeline::lane::{Lane, LaneKind, Part, Severity, Value};

const TOPIC: &str = "failsafe_flags";

/// The name of the lane, after the masks from which it is derived.
const NAME: &str = "mode_req_*";

/// Evaluates the mode requirements. Bit N of a mask belongs to mode N, so the masks are useful only if the current mode
/// is known.
#[derive(Default)]
pub(super) struct Requirements {
    /// The channel that contains the mode, and the latest mode.
    mode: Option<(usize, i128)>,
    /// The channel that contains the flags.
    channel: Option<usize>,
    /// True if there are several vehicles, whose messages can't be distinguished.
    is_ambiguous: bool,
    /// The flags that have a mask. Set when the first message arrives.
    pairs: Option<Vec<Pair>>,
    /// The indices of the latest unmet requirements.
    unmet: Option<Vec<usize>>,
}

/// A flag, and the mask of the modes that require it to be clear.
struct Pair {
    flag: usize,
    mask: usize,
    name: String,
    label: Option<Label>,
    /// The latest values.
    is_set: bool,
    modes: i128,
}

impl Requirements {
    /// Takes the mode from a message of `vehicle_status`.
    pub(super) fn status(
        &mut self,
        channel: &Channel<'_>,
        values: DynamicView<'_>,
        context: &mut Context<'_>,
    ) {
        let Some(mode) = number(values, "nav_state") else { return };
        self.is_ambiguous |= self.mode.is_some_and(|(known, _)| known != channel.index);
        if self.mode.replace((channel.index, mode)) != Some((channel.index, mode)) {
            self.evaluate(context);
        }
    }

    /// Takes the flags and masks from a message.
    pub(super) fn flags(
        &mut self,
        channel: &Channel<'_>,
        definition: MessageId,
        values: DynamicView<'_>,
        context: &mut Context<'_>,
    ) {
        self.is_ambiguous |= self.channel.is_some_and(|known| known != channel.index);
        self.channel = Some(channel.index);
        let pairs = self.pairs.get_or_insert_with(|| pairs(definition, values, context));
        for pair in pairs {
            let at = |index| values.field(index).and_then(whole).unwrap_or_default();
            (pair.is_set, pair.modes) = (at(pair.flag) != 0, at(pair.mask));
        }
        self.evaluate(context);
    }

    fn evaluate(&mut self, context: &mut Context<'_>) {
        let (Some((_, mode)), Some(pairs), false) = (self.mode, &self.pairs, self.is_ambiguous) else {
            return;
        };
        let mask = u32::try_from(mode).ok().and_then(|mode| 1_i128.checked_shl(mode)).unwrap_or_default();
        let is_unmet = |pair: &Pair| pair.is_set && pair.modes & mask != 0;
        let unmet: Vec<usize> = (0..pairs.len()).filter(|at| is_unmet(&pairs[*at])).collect();
        if self.unmet.as_ref() == Some(&unmet) {
            return;
        }
        let lane = context.lanes.get((TOPIC, "", NAME), || Lane {
            label: Label::plain("Requirements of the current mode that aren't met"),
            rank: rank_of(TOPIC),
            ..Lane::new(TOPIC, NAME, LaneKind::State)
        });
        if let Some(lane) = lane {
            let parts = unmet.iter().map(|at| Part::new(&*pairs[*at].name, pairs[*at].label.clone()));
            let severity = if unmet.is_empty() { Severity::Normal } else { Severity::Error };
            context.lanes.set(lane, context.time, Value::new(parts.collect(), severity));
        }
        self.unmet = Some(unmet);
    }
}

/// The flags of a message that have a mask.
fn pairs(definition: MessageId, values: DynamicView<'_>, context: &Context<'_>) -> Vec<Pair> {
    let pair = |(flag, mask)| {
        let (name, _) = values.fields().nth(flag)?;
        let label = context.texts.label(definition, Item::Field(name), context.definitions);
        Some(Pair { flag, mask, name: name.to_owned(), label, is_set: false, modes: 0 })
    };
    required_flags(values).into_iter().filter_map(pair).collect()
}

/// The flags of a message that have a mask: the index of each flag, and the index of its mask.
pub fn required_flags(values: DynamicView<'_>) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    for (mask, (requirement, _)) in values.fields().enumerate() {
        let Some(required) = requirement.strip_prefix(REQUIREMENT) else { continue };
        let flags = values.fields().enumerate().filter(|(_, (name, _))| belongs_to(name, required));
        found.extend(flags.map(|(flag, _)| (flag, mask)));
    }
    found
}
