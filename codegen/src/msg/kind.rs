//! Kinds of definitions, and names in them.

use std::fmt;

/// Which of the two readings of `.msg` applies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Dialect {
    /// PX4's uORB messages: fixed size, topics, versions, queue lengths.
    Px4,
    /// ROS 2 interfaces: also strings, sequences, defaults, other packages.
    Ros2,
}

impl Dialect {
    /// Its name in `uavspec.toml`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Px4 => "px4",
            Self::Ros2 => "ros2",
        }
    }
}

impl fmt::Display for Dialect {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

/// What a file defines, by its extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// `.msg`: one part.
    Message,
    /// `.srv`: request and response.
    Service,
    /// `.action`: goal, result and feedback.
    Action,
}

impl Kind {
    /// The kind of the file at `path`, by its extension.
    pub fn of(path: &str) -> Option<Self> {
        match path.rsplit_once('.')?.1 {
            "msg" => Some(Self::Message),
            "srv" => Some(Self::Service),
            "action" => Some(Self::Action),
            _ => None,
        }
    }

    /// Name of the folder that ROS packages keep such files in, and their extension.
    pub fn name(self) -> &'static str {
        match self {
            Self::Message => "msg",
            Self::Service => "srv",
            Self::Action => "action",
        }
    }

    /// Suffixes of the names of its parts, in order, as ROS forms them.
    pub fn part_suffixes(self) -> &'static [&'static str] {
        match self {
            Self::Message => &[""],
            Self::Service => &["_Request", "_Response"],
            Self::Action => &["_Goal", "_Result", "_Feedback"],
        }
    }
}

/// Whether `text` can be the name of anything: letters, digits and `_`, with a letter first.
pub(crate) fn is_identifier(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_alphabetic())
        && text.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
}
