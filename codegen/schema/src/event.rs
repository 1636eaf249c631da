//! Events: the components, enums and events of event metadata.
//!
//! Event metadata is the JSON file that PX4's build writes as `all_events.json`, and that PX4 embeds in its logs. The
//! format is defined by libevents (<https://github.com/mavlink/libevents>).

mod compressed;
pub(crate) mod file;
mod json;

pub use self::compressed::{decompress, is_compressed};
pub(crate) use self::json::Located;
pub use self::json::syntax;

use std::borrow::Cow;

use uavspec_runtime::Scalar;
use uavspec_runtime::event::Labels;

use crate::span::Span;

/// The name of the component whose events several components share.
pub const COMMON: &str = "common";

/// The group of events that report reasons against arming.
pub const ARMING_CHECK: &str = "arming_check";

/// The group of events that report problems of the vehicle.
pub const HEALTH: &str = "health";

/// The groups of events that make up reports.
pub const CHECK_GROUPS: [&str; 2] = [ARMING_CHECK, HEALTH];

/// The events of a component.
#[derive(Clone, Debug, PartialEq)]
pub struct EventComponent {
    /// The id: the highest byte of the ids of its events.
    pub id: u8,
    /// The name.
    pub namespace: String,
    /// The enums, by name.
    pub enums: Vec<EventEnum>,
    /// The events, by name.
    pub events: Vec<Event>,
    /// The groups of navigation modes: for each group, its bit and its modes (`custom_mode` of
    /// `MAVLink`).
    pub mode_groups: Vec<(u8, Vec<u32>)>,
    /// The protocols that the component supports.
    pub protocols: Vec<String>,
    /// The id in the file.
    pub span: Span,
}

/// An enum or a bit field of event metadata.
#[derive(Clone, Debug, PartialEq)]
pub struct EventEnum {
    /// The name, which ends in `_t`.
    pub name: String,
    /// The type of the values.
    pub scalar: Scalar,
    /// The description.
    pub description: String,
    /// The text between the descriptions of several bits. `None` if a value isn't a bit field.
    pub separator: Option<String>,
    /// The entries, by value.
    pub entries: Vec<EventEntry>,
    /// The name in the file.
    pub span: Span,
}

/// An entry of an enum.
#[derive(Clone, Debug, PartialEq)]
pub struct EventEntry {
    /// The value, or the mask of a bit.
    pub value: i128,
    /// The name.
    pub name: String,
    /// The text for users.
    pub description: String,
    /// The value in the file.
    pub span: Span,
}

impl EventEnum {
    /// The entry of a value.
    pub fn entry(&self, value: i128) -> Option<&EventEntry> {
        self.entries.binary_search_by_key(&value, |entry| entry.value).ok().map(|at| &self.entries[at])
    }
}

impl Labels for EventEnum {
    fn bits(&self) -> Option<(usize, &str)> {
        Some((8 * self.scalar.size(), self.separator.as_deref()?))
    }

    fn label(&self, value: i128) -> Option<&str> {
        self.entry(value).map(|entry| entry.description.as_str())
    }
}

/// An event.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// The id, which includes the id of the component.
    pub id: u32,
    /// The name.
    pub name: String,
    /// The group.
    pub group: String,
    /// The type.
    pub kind: EventKind,
    /// The message, with tags and placeholders.
    pub message: String,
    /// The description, with tags and placeholders. May be empty.
    pub description: String,
    /// The arguments, in the order of their bytes.
    pub arguments: Vec<EventArgument>,
    /// The index of the argument that numbers the instances of a sensor.
    pub instance_argument: Option<usize>,
    /// The id in the file.
    pub span: Span,
}

impl Event {
    /// The size of the arguments, in bytes.
    pub fn size(&self) -> usize {
        self.arguments.last().map_or(0, |last| last.offset + last.scalar.size())
    }

    /// True if the event is about a problem that a health or arming report lists.
    pub fn is_check(&self) -> bool {
        self.kind == EventKind::Plain && CHECK_GROUPS.contains(&self.group.as_str())
    }
}

/// The type of an event, which depends on its group.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EventKind {
    /// An event without a type.
    Plain,
    /// The summary of a health or arming report.
    Summary,
    /// An event to which user interfaces append the reasons why a mode isn't available.
    AppendChecks,
}

impl EventKind {
    /// The name in a file; empty for an event without a type.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Plain => "",
            Self::Summary => "summary",
            Self::AppendChecks => "append_health_and_arming_messages",
        }
    }
}

/// An argument of an event.
#[derive(Clone, Debug, PartialEq)]
pub struct EventArgument {
    /// The name.
    pub name: String,
    /// The type of the value.
    pub scalar: Scalar,
    /// The enum.
    pub enumeration: Option<EventEnumRef>,
    /// The description. May be empty.
    pub description: String,
    /// The number of bytes before the argument.
    pub offset: usize,
    /// The name in the file.
    pub span: Span,
}

/// A reference to an enum of a package.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct EventEnumRef {
    /// The index of the component in the package.
    pub component: usize,
    /// The index in [`EventComponent::enums`].
    pub index: usize,
}

/// The type with this name in event metadata: a C type, or `float`.
pub fn scalar(name: &str) -> Option<Scalar> {
    match name {
        "float" => Some(Scalar::Float32),
        // Reject `byte` and `char`, which only `.msg` files have.
        _ => Scalar::from_name(name.strip_suffix("_t")?).filter(|scalar| {
            scalar.integer_bounds().is_some() && !matches!(scalar, Scalar::Byte | Scalar::Char)
        }),
    }
}

/// The name of a type in event metadata.
pub fn scalar_name(scalar: Scalar) -> Cow<'static, str> {
    match scalar {
        Scalar::Float32 => Cow::Borrowed("float"),
        integer => Cow::Owned(format!("{}_t", integer.name())),
    }
}
