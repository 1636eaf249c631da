//! Matches the constants that give names to the values of a field.

use std::collections::{BTreeSet, HashMap};

use uavspec_schema::enumeration::{is_sentinel, is_sentinel_among};
use uavspec_schema::{Constant, Field};

use super::direction::{Direction, Side};
use crate::breaking::ConstantChange;
use crate::conversion::hints::{Decisions, HintValue, constant};
use crate::conversion::plan::{Elements, Undecided};

/// The named values of a field.
struct Names<'a> {
    /// Constants and values, in declaration order. The values of flags are masks if the field has an enum.
    values: Vec<(&'a Constant, i128)>,
    /// The values by name.
    by_name: HashMap<&'a str, i128>,
    is_flags: Option<bool>,
}

/// The conversion of the values of a field.
pub(super) struct Mapped<'a> {
    /// `None` if no value changes.
    pub(super) elements: Option<Elements>,
    /// Source values that have the same counterpart.
    pub(super) merged: Vec<&'a str>,
    pub(super) undecided: Option<Undecided>,
    /// The constants that the fields use.
    pub(super) used: Vec<&'a str>,
}

/// Determines the conversion of a field's values by matching the names of their constants.
pub(super) fn map<'a>(
    direction: &Direction<'a>,
    (source, target): (&'a Field, &'a Field),
    decisions: &Decisions<'_>,
) -> Mapped<'a> {
    let mut mapped = Mapped { elements: None, merged: Vec::new(), undecided: None, used: Vec::new() };
    let from = names(direction.from, source, (direction.to, target));
    let to = names(direction.to, target, (direction.from, source));
    let (Some(from), Some(to)) = (from, to) else { return mapped };
    mapped.used = from.values.iter().chain(&to.values).map(|(constant, _)| constant.name.as_str()).collect();
    let hinted = match decisions.values.get(target.name.as_str()) {
        Some((_, HintValue::Constants(pairs))) => pairs.as_slice(),
        _ => &[],
    };
    // A side without constants doesn't contradict the other side.
    if to.values.is_empty() && hinted.is_empty() {
        return mapped;
    }
    if from.is_flags.zip(to.is_flags).is_some_and(|(one, other)| one != other) {
        mapped.undecided = Some(undecided(
            direction,
            (source, target),
            &[],
            "is an enum on one side and flags on the other",
        ));
        return mapped;
    }
    let renamed = renamed(direction);
    let hinted: HashMap<&str, &str> =
        hinted.iter().map(|[name, to]| (name.text.as_str(), to.text.as_str())).collect();
    let mut pairs = Vec::new();
    let mut absent = Vec::new();
    for (constant, value) in &from.values {
        let name = constant.name.as_str();
        let found = match hinted.get(name) {
            Some(name) => to.value(name).or_else(|| plain_value(direction.to, name)),
            None => to.value(name).or_else(|| to.value(renamed.get(name)?)),
        };
        match found {
            Some(found) => pairs.push((*value, found)),
            None if decisions.same.contains(&name) => pairs.push((*value, *value)),
            None => absent.push((name, *value)),
        }
    }
    // Ignore a constant if another name of the same value has a counterpart.
    let known: BTreeSet<i128> = pairs.iter().map(|(value, _)| *value).collect();
    let absent: Vec<&str> =
        absent.into_iter().filter(|(_, value)| !known.contains(value)).map(|(name, _)| name).collect();
    if !absent.is_empty() {
        mapped.undecided =
            Some(undecided(direction, (source, target), &absent, "has values without a counterpart"));
    }
    let is_flags = from.is_flags.or(to.is_flags).unwrap_or(false);
    mapped.merged = merged(&from, &pairs);
    mapped.elements = elements(pairs, is_flags);
    let is_bound = from.is_flags.is_some() && to.is_flags.is_some();
    if is_flags && !is_bound && mapped.elements.is_some() && mapped.undecided.is_none() {
        let problem =
            "has flags with other numbers, and only one definition annotates the field with its enum";
        mapped.undecided = Some(undecided(direction, (source, target), &[], problem));
    }
    mapped
}

/// The conversion for pairs of values, or `None` if all values stay the same.
fn elements(mut pairs: Vec<(i128, i128)>, is_flags: bool) -> Option<Elements> {
    if pairs.iter().all(|(from, to)| from == to) {
        return None;
    }
    // Aliases have the same value; the first name is used.
    let mut seen = BTreeSet::new();
    pairs.retain(|(from, _)| seen.insert(*from));
    Some(if is_flags { Elements::Flags(pairs) } else { Elements::Values(pairs) })
}

/// The constants whose converted values equal the converted value of another constant.
fn merged<'a>(from: &Names<'a>, pairs: &[(i128, i128)]) -> Vec<&'a str> {
    let mut sources: HashMap<i128, BTreeSet<i128>> = HashMap::new();
    for (value, target) in pairs {
        sources.entry(*target).or_default().insert(*value);
    }
    let values: BTreeSet<i128> = sources.into_values().filter(|values| values.len() > 1).flatten().collect();
    let named = from.values.iter().filter(|(_, value)| values.contains(value));
    named.map(|(constant, _)| constant.name.as_str()).collect()
}

impl<'a> Names<'a> {
    fn new(values: Vec<(&'a Constant, i128)>, is_flags: Option<bool>) -> Self {
        let by_name = values.iter().map(|(constant, value)| (constant.name.as_str(), *value)).collect();
        Self { values, by_name, is_flags }
    }

    fn value(&self, name: &str) -> Option<i128> {
        self.by_name.get(name).copied()
    }
}

fn plain_value(side: Side<'_>, name: &str) -> Option<i128> {
    constant((side.schema, side.message), name)?.value.as_int()
}

/// The new names of renamed constants, by their names in the source.
fn renamed<'a>(direction: &Direction<'a>) -> HashMap<&'a str, &'a str> {
    let changes = direction.pair.constants.iter().filter_map(|change| match change {
        ConstantChange::Renamed(old, new) if direction.is_forward => Some((old, new)),
        ConstantChange::Renamed(old, new) => Some((new, old)),
        _ => None,
    });
    changes.map(|(from, to)| (from.name.as_str(), to.name.as_str())).collect()
}

/// The named values of `field`. If only the field on the other side has an enum, returns the constants with the
/// prefixes of that enum. `None` if neither field has an enum.
fn names<'a>(side: Side<'a>, field: &'a Field, other: (Side<'a>, &'a Field)) -> Option<Names<'a>> {
    if let Some(reference) = field.enumeration {
        let (owner, found) = (side.schema.message(reference.message), side.schema.enumeration(reference));
        let is_bound = other.1.enumeration.is_some();
        let values = found.members.iter().filter_map(|member| {
            let constant = owner.constants.get(member.constant)?;
            // If the other side has no enum, only the written numbers can be compared.
            let value = if is_bound { Some(member.value) } else { constant.value.as_int() };
            Some((constant, value?))
        });
        return Some(Names::new(values.collect(), Some(found.is_flags)));
    }
    let reference = other.1.enumeration?;
    let found = other.0.schema.enumeration(reference);
    let owner_name = &other.0.schema.message(reference.message).name;
    let owner = if *owner_name == other.0.message.name {
        Some(side.message)
    } else {
        let package = &side.schema.packages[side.message.package];
        package.messages.iter().map(|id| side.schema.message(*id)).find(|message| message.name == *owner_name)
    };
    let constants = owner.into_iter().flat_map(|owner| &owner.constants).filter(|constant| {
        found.prefixes.iter().any(|prefix| {
            let rest = constant.name.strip_prefix(prefix.as_str()).and_then(|rest| rest.strip_prefix('_'));
            rest.is_some_and(|rest| !is_sentinel(rest))
        })
    });
    let values = constants.filter_map(|constant| Some((constant, constant.value.as_int()?)));
    Some(Names::new(values.collect(), None))
}

fn undecided(
    direction: &Direction<'_>,
    (source, target): (&Field, &Field),
    names: &[&str],
    problem: &str,
) -> Undecided {
    let (old, new) = direction.old_and_new(source, target);
    let side = if direction.is_forward { "new" } else { "old" };
    let message = if names.is_empty() {
        format!("`{}.{}` {problem}", direction.to.message.name, target.name)
    } else {
        let list: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
        format!(
            "`{}.{}`: the {side} definition has no counterpart of {}",
            direction.to.message.name,
            target.name,
            list.join(", ")
        )
    };
    let example = names.first().map_or_else(
        || format!("compute the value: {side}.{} = \"…\"", target.name),
        |name| {
            format!(
                "name a counterpart: {side}.{} = {{ {name} = \"…\" }}, or keep the numbers: same = [\"{name}\"]",
                target.name
            )
        },
    );
    Undecided { span: new.span, old: Some(old.span), message, help: example }
}

/// True if a constant is the length of an array in both definitions.
fn is_length(direction: &Direction<'_>, old: &Constant, new: &Constant) -> bool {
    let length = |field: &Field| field.ty.max_length().map(i128::from);
    let values = (old.value.as_int(), new.value.as_int());
    direction.sources.iter().any(|(target, source)| {
        let source = length(&direction.from.message.fields[*source]);
        let lengths = direction.old_and_new(source, length(&direction.to.message.fields[*target]));
        lengths.0.is_some() && lengths == values
    })
}

/// The constants outside enums whose number or meaning changed.
pub(super) fn changed(
    direction: &Direction<'_>,
    used: &BTreeSet<&str>,
    decisions: &Decisions<'_>,
) -> Vec<Undecided> {
    let sides = [direction.from, direction.to];
    let all: Vec<BTreeSet<&str>> = sides
        .iter()
        .map(|side| side.message.constants.iter().map(|constant| constant.name.as_str()).collect())
        .collect();
    let is_decided = |name: &str| {
        used.contains(name)
            || decisions.same.contains(&name)
            || decisions.mentioned.contains(&name)
            || all.iter().any(|names| is_sentinel_among(name, names))
    };
    let mut found = Vec::new();
    for change in &direction.pair.constants {
        let (old, new, message) = match change {
            // Compared as text, since NaN doesn't equal itself.
            ConstantChange::Same(old, new) if old.value.to_string() != new.value.to_string() => {
                (old, new, format!("`{}` is {} instead of {}", new.name, new.value, old.value))
            }
            ConstantChange::Reused(old, new) => {
                (old, new, format!("{} is `{}` instead of `{}`", new.value, new.name, old.name))
            }
            _ => continue,
        };
        if is_decided(&old.name) || is_decided(&new.name) || is_length(direction, old, new) {
            continue;
        }
        found.push(Undecided {
            span: new.span,
            old: Some(old.span),
            message: format!(
                "`{}`: {message}, and no field is annotated with its enum",
                direction.to.message.name
            ),
            help: format!(
                "compute the field that has these values, or accept the change: same = [\"{}\"]",
                new.name
            ),
        });
    }
    found
}
