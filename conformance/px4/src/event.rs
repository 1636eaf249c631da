//! Events in PX4 messages, and the event metadata that explains them.

use std::borrow::Cow;
use std::fmt;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::sync::OnceLock;

use uavspec_dynamic::event::{DecodedEvent, EventError, Events};
use uavspec_dynamic::{DynamicView, Value};
use uavspec_runtime::Number;
use uavspec_runtime::event::{LogLevel, MAX_ARGUMENTS_SIZE};
use uavspec_schema::diagnostic::{Level, Problem};
use uavspec_schema::event::{decompress, is_compressed};
use uavspec_schema::limits::MAX_EVENTS_LEN;
use uavspec_schema::{Failure, terminal};

/// The event metadata for a capture, which is read when it is first used. The metadata of another build may decode
/// events wrongly, so reports name the origin.
#[derive(Debug, Default)]
pub struct EventMetadata {
    /// The origin.
    pub origin: EventOrigin,
    source: Cow<'static, [u8]>,
    events: OnceLock<Events>,
}

impl EventMetadata {
    /// The event metadata of uavspec, as JSON.
    pub fn built_in(json: &'static [u8]) -> Self {
        Self { origin: EventOrigin::BuiltIn, source: Cow::Borrowed(json), events: OnceLock::new() }
    }

    /// Reads a file with event metadata: JSON, which may be compressed with xz. Fails if the file is longer than 1 MiB, or if
    /// it has mistakes.
    pub fn load(path: &Path) -> Result<Self, Failure> {
        let shown = path.to_string_lossy().into_owned();
        let failed =
            |problem: &dyn fmt::Display| Failure::new(format!("{}: {problem}", terminal::path(path)));
        let mut bytes = Vec::new();
        let start = File::open(path).map(|file| file.take(MAX_EVENTS_LEN as u64 + 1));
        start.and_then(|mut start| start.read_to_end(&mut bytes)).map_err(|error| failed(&error))?;
        if bytes.len() > MAX_EVENTS_LEN {
            return Err(failed(&format!("longer than {MAX_EVENTS_LEN} bytes")));
        }
        let (events, mistake) = read(&bytes).map_err(|error| failed(&error))?;
        if let Some(error) = mistake {
            let path = terminal::path(path);
            let hint =
                format!("`uavspec lint --package events --dialect events --input {path}` lists all mistakes");
            return Err(failed(&error).with_hint(hint));
        }
        Ok(Self { origin: EventOrigin::File(shown), source: Cow::Owned(bytes), events: events.into() })
    }

    /// Reads the event metadata in a capture: JSON, which may be compressed with xz. Also returns the first reason why not
    /// all events can be decoded. Fails if no event can be decoded.
    pub fn of_capture(bytes: &[u8]) -> io::Result<(Self, Option<Problem>)> {
        let (events, mistake) = read(bytes)?;
        match mistake {
            Some(mistake) if events.is_empty() => Err(io::Error::other(mistake.to_string())),
            mistake => {
                let events = events.into();
                Ok((Self { origin: EventOrigin::Capture, source: Cow::default(), events }, mistake))
            }
        }
    }

    /// The content of the file that the user gave.
    pub fn file(&self) -> Option<&[u8]> {
        matches!(self.origin, EventOrigin::File(_)).then_some(&self.source)
    }

    /// The events that can be decoded.
    pub fn events(&self) -> &Events {
        self.events.get_or_init(|| read(&self.source).map(|(events, _)| events).unwrap_or_default())
    }
}

/// Reads event metadata. Also returns the first error in it.
fn read(bytes: &[u8]) -> io::Result<(Events, Option<Problem>)> {
    let json = if is_compressed(bytes) { decompress(bytes)? } else { bytes.to_vec() };
    let (events, mistakes) = Events::read(json);
    Ok((events, mistakes.into_iter().find(|mistake| mistake.level() == Level::Error)))
}

/// The events about arming and disarming, each with the field of `vehicle_status` that contains the reason.
pub const ARMING_EVENTS: [(&str, &str); 2] =
    [("commander_armed_by", "latest_arming_reason"), ("commander_disarmed_by", "latest_disarming_reason")];

/// `vehicle_status.arming_state` of an armed vehicle, in all releases.
pub const ARMED: u8 = 2;

/// The origin of event metadata.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum EventOrigin {
    /// The capture contains the metadata of its firmware.
    Capture,
    /// The user gave a file.
    File(String),
    /// The definitions of uavspec.
    #[default]
    BuiltIn,
}

impl fmt::Display for EventOrigin {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Capture => formatter.write_str("its own event metadata"),
            Self::File(path) => formatter.write_str(path),
            Self::BuiltIn => formatter.write_str("uavspec's built-in events (PX4 1.15)"),
        }
    }
}

/// An event in a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RawEvent {
    /// The id, which isn't 0.
    pub id: u32,
    /// The number of the event, which increases by one with each event.
    pub sequence: Option<u16>,
    /// The levels for logs and ground stations.
    pub levels: u8,
    /// The arguments.
    pub arguments: [u8; MAX_ARGUMENTS_SIZE],
}

impl RawEvent {
    /// Reads an event from a message of type `Event`. `None` if a field is missing, or if the message contains no event.
    pub fn read(values: DynamicView<'_>) -> Option<Self> {
        let Value::Array(bytes) = values.get("arguments")? else { return None };
        let mut arguments = [0; MAX_ARGUMENTS_SIZE];
        for (argument, byte) in arguments.iter_mut().zip(bytes.iter()) {
            *argument = integer(byte)?;
        }
        Some(Self {
            id: integer(values.get("id")?).filter(|id| *id != 0)?,
            sequence: values.get("event_sequence").and_then(integer),
            levels: integer(values.get("log_levels")?)?,
            arguments,
        })
    }

    /// The events in a message of type `ArmingCheckReply`. Empty if it claims more events than there is room for.
    pub fn of_reply(values: DynamicView<'_>) -> Vec<Self> {
        let Some(Value::Array(events)) = values.get("events") else { return Vec::new() };
        let used = values.get("num_events").and_then(integer::<usize>);
        let Some(used) = used.filter(|used| *used <= events.len()) else { return Vec::new() };
        let event = |event| match event {
            Value::Message(event) => Self::read(event),
            _ => None,
        };
        events.iter().take(used).filter_map(event).collect()
    }

    /// The level for ground stations. `None` if the value has no meaning.
    pub fn level(&self) -> Option<LogLevel> {
        LogLevel::external(self.levels)
    }

    /// Decodes the event.
    pub fn decode<'e>(&self, events: &'e Events) -> Result<DecodedEvent<'e>, EventError> {
        events.decode(self.id, &self.arguments)
    }

    /// Describes an event without metadata by its id and its bytes.
    pub fn undecoded(&self) -> String {
        let Self { id, levels, .. } = *self;
        let arguments: Vec<String> = self.used().iter().map(|byte| format!("{byte:02x}")).collect();
        let arguments =
            if arguments.is_empty() { String::new() } else { format!(", arguments {}", arguments.join(" ")) };
        format!(
            "event {id} (component {}, number {}), log levels {} and {}{arguments}",
            id >> 24,
            id & 0x00ff_ffff,
            levels >> 4,
            levels & 0xf
        )
    }

    /// The arguments without the zeros at the end.
    pub fn used(&self) -> &[u8] {
        let used = self.arguments.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
        &self.arguments[..used]
    }
}

fn integer<T: TryFrom<i128>>(value: Value<'_>) -> Option<T> {
    match value.number()? {
        Number::Int(value) => value.try_into().ok(),
        Number::Float(_) => None,
    }
}
