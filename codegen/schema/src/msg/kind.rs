//! Kinds of definitions, and their names.

use std::fmt;

/// The dialect of `.msg` files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Dialect {
    /// PX4 uORB messages: fixed size, topics, versions, queue lengths.
    Px4,
    /// ROS 2 interfaces, which also have strings, sequences, defaults and references to other packages.
    Ros2,
}

impl Dialect {
    /// The name in `uavspec.toml`.
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

/// The kind of a definition, determined by the file extension.
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
    /// The kind of the file at `path`, or `None` for other extensions.
    pub fn of(path: &str) -> Option<Self> {
        match path.rsplit_once('.')?.1 {
            "msg" => Some(Self::Message),
            "srv" => Some(Self::Service),
            "action" => Some(Self::Action),
            _ => None,
        }
    }

    /// The file extension, which is also the name of the folder in ROS packages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Message => "msg",
            Self::Service => "srv",
            Self::Action => "action",
        }
    }

    /// The name suffixes of the parts, in order, as in ROS.
    pub fn part_suffixes(self) -> &'static [&'static str] {
        match self {
            Self::Message => &[""],
            Self::Service => &["_Request", "_Response"],
            Self::Action => &["_Goal", "_Result", "_Feedback"],
        }
    }
}
