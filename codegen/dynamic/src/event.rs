//! Events whose metadata is known only at run time.
//!
//! ```
//! use uavspec_dynamic::event::Events;
//! use uavspec_runtime::event::{Profile, sub_id};
//!
//! let id = sub_id("door_open");
//! let json = format!(
//!     r#"{{"version": 2, "components": {{"7": {{"namespace": "door", "event_groups": {{"default": {{"events": {{
//!     "{id}": {{"name": "door_open", "message": "Door {{1}} open", "arguments": [{{"name": "door", "type": "uint8_t"}}]}}
//!     }}}}}}}}}}}}"#
//! );
//! let (events, mistakes) = Events::read(json.into_bytes());
//! assert!(mistakes.is_empty());
//! let event = events.decode(7 << 24 | id, &[3]).unwrap();
//! assert_eq!(event.message(Profile::Normal), "Door 3 open");
//! ```

use std::collections::HashMap;
use std::fmt::{self, Write};

use uavspec_runtime::Scalar;
use uavspec_runtime::event::{Argument, Profile, Text};
use uavspec_schema::diagnostic::Problem;
use uavspec_schema::{
    Event, EventArgument, EventComponent, EventEnum, Form, PackageInput, SourceMap, read_formats,
};

use crate::limits::MAX_EVENT_TEXT;

/// The index of the component and the index of the event within it, by event id.
#[derive(Debug, Default)]
pub struct Events {
    components: Vec<EventComponent>,
    /// The index of the component and of the event in it, by id.
    by_id: HashMap<u32, (usize, usize)>,
}

/// The reason why an event can't be decoded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum EventError {
    /// The metadata has no event with this id.
    Unknown,
    /// The event needs more bytes of arguments.
    TooShort {
        /// The required number of bytes.
        required: usize,
        /// The given number of bytes.
        found: usize,
    },
}

impl fmt::Display for EventError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown => formatter.write_str("the event metadata has no event with this id"),
            Self::TooShort { required, found } => {
                write!(formatter, "the event has {found} bytes of arguments, but needs {required}")
            }
        }
    }
}

impl std::error::Error for EventError {}

/// The value of an argument.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EventValue {
    /// An integer, or the number of an entry of an enum.
    Integer(i128),
    /// A `float`.
    Float(f32),
}

impl EventValue {
    /// The value, if it is an integer.
    pub fn integer(self) -> Option<i128> {
        match self {
            Self::Integer(value) => Some(value),
            Self::Float(_) => None,
        }
    }
}

impl Events {
    /// The events of the components of a package.
    pub fn new(components: impl Into<Vec<EventComponent>>) -> Self {
        let components = components.into();
        let mut by_id = HashMap::new();
        for (index, component) in components.iter().enumerate() {
            by_id.extend(component.events.iter().enumerate().map(|(at, event)| (event.id, (index, at))));
        }
        Self { components, by_id }
    }

    /// Reads event metadata, as JSON. Returns the events that can be decoded, and the mistakes.
    pub fn read(json: Vec<u8>) -> (Self, Vec<Problem>) {
        let mut sources = SourceMap::default();
        match sources.add("events.json", json) {
            Ok(id) => {
                let package = PackageInput::new("events", Form::Events, vec![id]);
                let (mut schema, mistakes) = read_formats(&sources, &[package]);
                let components = schema.packages.pop().map(|package| package.components);
                let events = components.map(Self::new).unwrap_or_default();
                (events, mistakes.into_iter().map(|mistake| mistake.problem).collect())
            }
            Err(error) => (Self::default(), vec![error.problem]),
        }
    }

    /// The components, by id.
    pub fn components(&self) -> &[EventComponent] {
        &self.components
    }

    /// The number of events.
    pub fn len(&self) -> usize {
        self.by_id.len()
    }

    /// True if there are no events.
    pub fn is_empty(&self) -> bool {
        self.by_id.is_empty()
    }

    /// The event with an id, and its component.
    pub fn get(&self, id: u32) -> Option<(&EventComponent, &Event)> {
        let (component, event) = *self.by_id.get(&id)?;
        let component = &self.components[component];
        Some((component, &component.events[event]))
    }

    /// The enum of an argument.
    pub fn enumeration(&self, argument: &EventArgument) -> Option<&EventEnum> {
        let reference = argument.enumeration?;
        Some(&self.components[reference.component].enums[reference.index])
    }

    /// Decodes the arguments of an event. Bytes after the arguments are ignored.
    pub fn decode(&self, id: u32, arguments: &[u8]) -> Result<DecodedEvent<'_>, EventError> {
        let (component, event) = self.get(id).ok_or(EventError::Unknown)?;
        let value = |argument: &EventArgument| {
            let end = argument.offset + argument.scalar.size();
            arguments.get(argument.offset..end).map(|bytes| value(argument.scalar, bytes))
        };
        let values: Option<Vec<EventValue>> = event.arguments.iter().map(value).collect();
        let values = values.ok_or(EventError::TooShort { required: event.size(), found: arguments.len() })?;
        Ok(DecodedEvent { events: self, component, event, values })
    }
}

/// The value of a scalar, little endian.
fn value(scalar: Scalar, bytes: &[u8]) -> EventValue {
    let mut padded = [0; 8];
    padded[..bytes.len()].copy_from_slice(bytes);
    let bits = u64::from_le_bytes(padded);
    if scalar.is_float() {
        #[allow(clippy::cast_possible_truncation)] // a float has four bytes
        return EventValue::Float(f32::from_bits(bits as u32));
    }
    let value = i128::from(bits);
    let (_, max) = scalar.integer_bounds().unwrap_or((0, i128::MAX));
    EventValue::Integer(if value > max { value - (1 << (8 * bytes.len())) } else { value })
}

/// An event with the values of its arguments.
#[derive(Clone, Debug)]
pub struct DecodedEvent<'e> {
    events: &'e Events,
    /// The component.
    pub component: &'e EventComponent,
    /// The event.
    pub event: &'e Event,
    /// The values of the arguments.
    pub values: Vec<EventValue>,
}

impl<'e> DecodedEvent<'e> {
    /// An event with the values of its arguments. `None` if there is no event with this id.
    pub fn new(events: &'e Events, id: u32, values: Vec<EventValue>) -> Option<Self> {
        let (component, event) = events.get(id)?;
        Some(Self { events, component, event, values })
    }

    /// The message for readers with this profile.
    pub fn message(&self, profile: Profile) -> String {
        self.text(&self.event.message, profile)
    }

    /// The description for readers with this profile; empty if there is none.
    pub fn description(&self, profile: Profile) -> String {
        self.text(&self.event.description, profile)
    }

    /// The text of an argument. The text of a bit field lists the bits.
    pub fn argument(&self, index: usize) -> Option<Argument<'e>> {
        let argument = self.event.arguments.get(index)?;
        Some(match (*self.values.get(index)?, self.events.enumeration(argument)) {
            (EventValue::Float(value), _) => Argument::Float(value),
            (EventValue::Integer(value), Some(enumeration)) => Argument::Enum(value, enumeration),
            (EventValue::Integer(value), None) => Argument::Integer(value),
        })
    }

    /// The enum of an argument.
    pub fn enumeration(&self, index: usize) -> Option<&'e EventEnum> {
        self.events.enumeration(self.event.arguments.get(index)?)
    }

    /// The integer value of the argument with this name.
    pub fn integer(&self, name: &str) -> Option<i128> {
        let index = self.event.arguments.iter().position(|argument| argument.name == name)?;
        self.values[index].integer()
    }

    fn text(&self, text: &str, profile: Profile) -> String {
        let mut shown = Limited(String::new());
        // An error means only that the text is too long.
        _ = write!(shown, "{}", Text::new(text).show(profile, &|index| self.argument(index)));
        shown.0
    }
}

/// Text that is truncated at a maximum length. A text of a few bytes may refer to the same long label many times.
struct Limited(String);

impl Write for Limited {
    fn write_str(&mut self, part: &str) -> fmt::Result {
        let room = MAX_EVENT_TEXT - self.0.len().min(MAX_EVENT_TEXT);
        if part.len() <= room {
            self.0.push_str(part);
            return Ok(());
        }
        self.0.push_str(&part[..(0..=room).rev().find(|at| part.is_char_boundary(*at)).unwrap_or(0)]);
        self.0.push('…');
        Err(fmt::Error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const METADATA: &str = r#"{"version": 2, "components": {
        "0": {"namespace": "common", "enums": {
            "side_t": {"type": "uint8_t", "is_bitfield": true, "entries": {
                "1": {"name": "left", "description": "Left"}, "128": {"name": "right", "description": "Right"}}}}},
        "3": {"namespace": "tank", "event_groups": {"default": {"events": {
            "6424053": {"name": "level", "message": "{1}: {3:.1}, {2}, {4}", "arguments": [
                {"name": "side", "type": "common::side_t"}, {"name": "low", "type": "int16_t"},
                {"name": "rest", "type": "float"}, {"name": "all", "type": "uint64_t"}]}}}}}}}"#;

    fn level() -> (Events, u32) {
        let (events, mistakes) = Events::read(METADATA.replace("6424053", &id().to_string()).into_bytes());
        assert_eq!(mistakes, []);
        (events, 3 << 24 | id())
    }

    fn id() -> u32 {
        uavspec_runtime::event::sub_id("level")
    }

    #[test]
    fn decodes_arguments_in_order_without_padding() {
        let (events, id) = level();
        let mut bytes = vec![0x81, 0xfe, 0xff];
        bytes.extend(0.25_f32.to_le_bytes());
        bytes.extend(u64::MAX.to_le_bytes());
        let event = events.decode(id, &bytes).expect("an event");
        assert_eq!(event.values[1], EventValue::Integer(-2));
        assert_eq!(event.message(Profile::Normal), "Left|Right: 0.2, -2, 18446744073709551615");
        assert_eq!((event.integer("low"), event.integer("rest")), (Some(-2), None));
        let required = event.event.size();
        bytes.pop();
        let error = events.decode(id, &bytes).expect_err("too short");
        assert_eq!(error, EventError::TooShort { required, found: required - 1 });
        assert_eq!(events.decode(id + 1, &bytes).expect_err("unknown"), EventError::Unknown);
    }

    #[test]
    fn a_text_stays_short_whatever_it_refers_to() {
        let json = METADATA.replace("{1}: ", &"{1}".repeat(30)).replace("Left", &"é".repeat(2_000));
        let (events, _) = Events::read(json.replace("6424053", &id().to_string()).into_bytes());
        let event = events.decode(3 << 24 | id(), &[1; 25]).expect("an event");
        let message = event.message(Profile::Dev);
        assert!(
            message.len() <= MAX_EVENT_TEXT + '…'.len_utf8() && message.ends_with("é…"),
            "{}",
            message.len()
        );
    }

    #[test]
    fn malformed_texts_are_shown_as_written() {
        for text in ["<a>", "<a><a>", "{", "{999999999999}", "{0}", "\u{7}", r#"<b><profile name=\"dev\">"#] {
            let json = METADATA.replace("{1}: {3:.1}, {2}, {4}", &text.replace('\u{7}', "\\u0007"));
            let (events, mistakes) = Events::read(json.replace("6424053", &id().to_string()).into_bytes());
            assert_eq!((events.len(), mistakes.is_empty()), (1, text == "\u{7}"), "{text}: {mistakes:?}");
            let event = events.decode(3 << 24 | id(), &[0; 25]).expect("an event");
            assert_eq!(event.message(Profile::Normal), text.replace('\\', ""), "{text}");
        }
    }

    #[test]
    fn what_cannot_be_decoded_is_omitted() {
        let (events, mistakes) = Events::read(METADATA.replace("int16_t", "int17_t").into_bytes());
        assert_eq!((events.len(), mistakes.len()), (0, 2));
        let (events, mistakes) = Events::read(vec![0xff]);
        assert_eq!((events.len(), mistakes.len()), (0, 1));
    }
}
