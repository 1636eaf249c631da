//! Test cases for events: the bytes of the arguments, their values, and the texts for each profile.

use uavspec_dynamic::event::{DecodedEvent, EventValue, Events};
use uavspec_runtime::Scalar;
use uavspec_runtime::event::{MAX_ARGUMENTS_SIZE, Profile};
use uavspec_schema::{Event, EventArgument, EventComponent, Package};

use super::case::Case;
use super::print::quote;

/// The cases of a component: for each event, arguments with different bit patterns.
pub(super) fn cases(package: &Package, component: &EventComponent) -> Vec<Case> {
    let events = Events::new(package.components.as_slice());
    let of_event = |event| KINDS.iter().filter_map(|kind| case(&events, event, kind)).collect::<Vec<_>>();
    component.events.iter().flat_map(of_event).collect()
}

/// A kind of case.
struct Kind {
    name: &'static str,
    description: &'static str,
    /// The bits of an argument with this index.
    bits: fn(usize, &EventArgument, &Events) -> u64,
}

const KINDS: [Kind; 3] = [
    Kind { name: "zero", description: "all arguments are zero", bits: |_, _, _| 0 },
    Kind { name: "typical", description: "the arguments differ", bits: typical },
    Kind { name: "ones", description: "all bits of the integers are set", bits: ones },
];

/// Sets all bits of an integer. A `float` gets the lowest value, because JSON has no NaN.
fn ones(_: usize, argument: &EventArgument, _: &Events) -> u64 {
    if argument.scalar == Scalar::Float32 { f32::MIN.to_bits().into() } else { u64::MAX }
}

/// A value that differs from the other arguments. An enum argument has the last entry of its enum.
fn typical(index: usize, argument: &EventArgument, events: &Events) -> u64 {
    let number = index as u64 + 1;
    match events.enumeration(argument) {
        Some(found) => {
            found.entries.last().and_then(|entry| u64::try_from(entry.value).ok()).unwrap_or(number)
        }
        #[allow(clippy::cast_precision_loss)] // a small number
        None if argument.scalar == Scalar::Float32 => u64::from((number as f32 + 0.25).to_bits()),
        None => number,
    }
}

/// A case. An event without arguments has only the first kind of case.
fn case(events: &Events, event: &Event, kind: &Kind) -> Option<Case> {
    if event.arguments.is_empty() && kind.name != KINDS[0].name {
        return None;
    }
    let mut bytes = [0; MAX_ARGUMENTS_SIZE];
    for (index, argument) in event.arguments.iter().enumerate() {
        let bits = (kind.bits)(index, argument, events).to_le_bytes();
        let size = argument.scalar.size();
        bytes[argument.offset..argument.offset + size].copy_from_slice(&bits[..size]);
    }
    let decoded = events.decode(event.id, &bytes).ok()?;
    let texts = |profile: Profile| (profile.name(), [decoded.message(profile), decoded.description(profile)]);
    Some(Case {
        id: format!("{}-{}", event.name, kind.name),
        description: kind.description.to_owned(),
        json: Some(json(&decoded)),
        arguments: Some(bytes.to_vec()),
        texts: Profile::ALL.map(texts).into(),
        schema_verdict: Some(true),
        ..Case::default()
    })
}

/// A decoded event as JSON.
fn json(event: &DecodedEvent<'_>) -> String {
    let argument = |(argument, value): (&EventArgument, &EventValue)| {
        let value = match value {
            EventValue::Integer(value) => value.to_string(),
            EventValue::Float(value) if value.is_finite() => format!("{value:?}"),
            EventValue::Float(_) => "null".to_owned(),
        };
        format!("{}: {value}", quote(&argument.name))
    };
    let arguments: Vec<String> = event.event.arguments.iter().zip(&event.values).map(argument).collect();
    let (id, name) = (event.event.id, quote(&event.event.name));
    format!("{{\"id\": {id}, \"name\": {name}, \"arguments\": {{{}}}}}", arguments.join(", "))
}
