//! Builds the conversion of one message.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use uavspec_runtime::Number;
use uavspec_schema::{Element, Field};

use super::constants::changed;
use super::direction::{Direction, Side};
use super::field::FieldBuilder;
use super::{Builder, nested};
use crate::breaking::Pair;
use crate::conversion::plan::{Conversion, Copy, CountLimit, Elements, Loss, LossKind, Neutral, Step};

impl<'a> Builder<'_, 'a> {
    pub(super) fn build(&mut self, pair: &'a Pair<'a>) -> Conversion {
        let direction = Direction::new(pair, self.pairs, self.is_forward);
        let (from, to) = direction.old_and_new(pair.ids.0, pair.ids.1);
        let mut mistakes = Vec::new();
        let decisions = self.decisions(pair);
        let mut used = BTreeSet::new();
        let mut conversion = Conversion {
            from,
            to,
            steps: Vec::new(),
            losses: Vec::new(),
            unchecked: Vec::new(),
            undecided: Vec::new(),
            blocked_by: None,
            uses_hints: !decisions.is_empty(),
        };
        let mut steps = Vec::new();
        for target in 0..direction.to.message.fields.len() {
            let mut field = FieldBuilder {
                direction: &direction,
                decisions: &decisions,
                target,
                conversion: &mut conversion,
                used: &mut used,
                mistakes: &mut mistakes,
            };
            steps.push(field.step());
        }
        conversion.undecided.extend(changed(&direction, &used, &decisions));
        self.found.mistakes.append(&mut mistakes);
        conversion.steps = steps;
        self.resolve_nested(&direction, &mut conversion);
        limit_counts(&direction, &mut conversion);
        add_losses(&direction, &mut conversion);
        conversion.unchecked = unchecked(&direction, &conversion);
        conversion
    }

    /// Replaces the placeholders of nested conversions.
    fn resolve_nested(&mut self, direction: &Direction<'a>, conversion: &mut Conversion) {
        for (target, step) in conversion.steps.iter_mut().enumerate() {
            let Step::Copy(copy) = step else { continue };
            let element = |fields: &[Field], at: usize| match fields[at].ty.element {
                Element::Message(id) => Some(id),
                Element::Scalar(_) | Element::Text(_) | Element::String { .. } => None,
            };
            let source = element(&direction.from.message.fields, copy.source);
            let (Some(from), Some(to)) = (source, element(&direction.to.message.fields, target)) else {
                continue;
            };
            let ids = direction.old_and_new(from, to);
            if let Some(found) = self.conversion(ids) {
                if !found.is_decided() {
                    conversion.blocked_by.get_or_insert(to);
                }
                conversion.uses_hints |= found.uses_hints;
                copy.elements = Elements::Message(found);
            }
        }
    }
}

/// Limits the fields that count the elements of a truncated array. Flags are not limited.
fn limit_counts(direction: &Direction<'_>, conversion: &mut Conversion) {
    for (target, step) in conversion.steps.iter_mut().enumerate() {
        let Step::Copy(copy) = step else { continue };
        if matches!(copy.elements, Elements::Flags(_)) {
            continue;
        }
        let counted = |fields: &[Field], field: usize| fields.get(fields[field].counts?)?.ty.max_length();
        let fields = &direction.to.message.fields;
        let Some(max) = counted(fields, target) else { continue };
        let before = counted(&direction.from.message.fields, copy.source);
        if before.is_none_or(|before| before > max) {
            let special = special_counts(direction, copy, &fields[target], (before, max));
            copy.limit = Some(CountLimit { max, special });
        }
    }
}

/// Special values of a count, with their values in the target; counts up to `max` are excluded. A value is special if
/// either definition annotates or names it, because annotations are often added or removed without a change in meaning.
/// A value up to `before`, the length of the array in the source, may be a count. Such a value is special only if the
/// source annotates it.
///
/// The neutral value replaces special values that the target type lacks. The nearest number would have another meaning.
fn special_counts(
    direction: &Direction<'_>,
    copy: &Copy,
    target: &Field,
    (before, max): (Option<u32>, u32),
) -> BTreeMap<i128, i128> {
    let source = &direction.from.message.fields[copy.source];
    let has = |field: &Field, value: i128| match field.ty.element {
        Element::Scalar(scalar) => {
            scalar.integer_bounds().is_some_and(|(low, high)| (low..=high).contains(&value))
        }
        Element::Text(_) | Element::String { .. } | Element::Message(_) => false,
    };
    let neutral = match copy.rest {
        Neutral::Int(value) => value,
        Neutral::Default | Neutral::Float(_) => 0,
    };
    let is_no_count = |value: &i128| before.is_some_and(|before| *value > i128::from(before));
    let named = named_values(direction.from, source).chain(named_values(direction.to, target));
    let others = annotated_values(target).chain(named).filter(is_no_count);
    let all = annotated_values(source).chain(others);
    let all = all.filter(|value| has(source, *value) && (*value > i128::from(max) || !has(target, *value)));
    let mut special: BTreeMap<i128, i128> =
        all.map(|value| (value, if has(target, value) { value } else { neutral })).collect();
    if let Elements::Values(pairs) = &copy.elements {
        special.extend(pairs.iter().copied().filter(|(from, to)| from != to && has(source, *from)));
    }
    special
}

/// The integers that the definition of a field annotates as special.
fn annotated_values(field: &Field) -> impl Iterator<Item = i128> {
    field.special_values().into_iter().map(|value| match value {
        Number::Int(value) => value,
        #[allow(clippy::cast_possible_truncation)] // the float is an integer, such as 255.0
        Number::Float(value) => value as i128,
    })
}

/// The integers that the enum of a field names.
fn named_values<'s>(side: Side<'s>, field: &Field) -> impl Iterator<Item = i128> + use<'s> {
    let enumeration = field.enumeration.map(|reference| side.schema.enumeration(reference));
    enumeration.into_iter().flat_map(|found| &found.members).map(|member| member.value)
}

/// Lists the source fields that no step copies, and the losses of nested messages.
fn add_losses(direction: &Direction<'_>, conversion: &mut Conversion) {
    let mut copied = BTreeSet::new();
    let mut read = BTreeSet::new();
    let mut inner = Vec::new();
    for step in &conversion.steps {
        match step {
            Step::Copy(copy) => {
                copied.insert(copy.source);
                let name = &direction.from.message.fields[copy.source].name;
                for loss in nested(step).map(Arc::as_ref).into_iter().flat_map(|nested| &nested.losses) {
                    let text = format!("in `{name}`, {}", loss.text);
                    inner.push(Loss { source: Some(copy.source), kind: LossKind::Nested, text });
                }
            }
            Step::Compute(expression) => expression.fields(&mut |field| {
                read.insert(field);
            }),
            Step::Fill(_) => {}
        }
    }
    conversion.losses.append(&mut inner);
    for (at, field) in direction.from.message.fields.iter().enumerate() {
        let name = &field.name;
        let (kind, text) = match (copied.contains(&at), read.contains(&at)) {
            (true, _) => continue,
            (_, true) => (LossKind::Computed, format!("`{name}` is only used to compute other values")),
            _ => (LossKind::Dropped, format!("`{name}` is dropped")),
        };
        conversion.losses.push(Loss { source: Some(at), kind, text });
    }
    conversion.losses.sort_by_key(|loss| loss.source);
}

/// The fields of the target whose valid values differ from the valid values of the source field.
fn unchecked(direction: &Direction<'_>, conversion: &Conversion) -> Vec<usize> {
    let (from, to) = (direction.from, direction.to);
    let is_unchecked = |(target, step): &(usize, &Step)| {
        let restriction = to.schema.restriction(to.message, &to.message.fields[*target]);
        match step {
            Step::Fill(_) => false,
            Step::Compute(_) => restriction.is_some(),
            Step::Copy(copy) => {
                let source = from.schema.restriction(from.message, &from.message.fields[copy.source]);
                nested(step).is_some_and(|nested| !nested.unchecked.is_empty())
                    || restriction.is_some() && restriction != source
            }
        }
    };
    conversion.steps.iter().enumerate().filter(is_unchecked).map(|(target, _)| target).collect()
}
