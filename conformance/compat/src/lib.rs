//! Compares a ROS 2 application with versions of PX4, from the sources of the application.
//!
//! PX4 and an application exchange messages on topics such as `/fmu/out/vehicle_status`. They work together if both use
//! the same name and the same definition. Since PX4 1.16, the definitions of some messages have versions. The name of the
//! topic then ends with the version, and PX4's message translation node converts messages between versions.
//!
//! Source of these facts: <https://docs.px4.io/main/en/ros2/px4_ros2_msg_translation_node>.

mod application;
mod dds;
mod lexer;
pub mod limits;
mod report;
mod source;
mod verdict;

pub use self::application::{Application, Hints, Unread, Use, definitions_in};
pub use self::dds::DdsTopics;
pub use self::report::{CompatReport, Place, TopicReport, UnreadReport};
pub use self::source::{Direction, Topic, Version};
pub use self::verdict::{History, Kind, Side, Verdict, compare};
