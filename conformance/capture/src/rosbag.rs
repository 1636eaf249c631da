//! Reads and writes the bags of rosbag2 that are not MCAP files: `SQLite` files, and the `metadata.yaml` of a bag's folder.

pub mod metadata;
pub mod sqlite;
mod writer;

pub use self::writer::{BagContent, FileContent, Writer, portable_qos};

/// The column of topics in `SQLite` files, and the metadata key of channels in MCAP files, for the quality of service.
pub const QOS: &str = "offered_qos_profiles";

/// The first bytes of `SQLite` files.
pub const SQLITE_MAGIC: [u8; 16] = *b"SQLite format 3\0";

/// The reason why a ROS 1 bag isn't checked, and the way to convert it.
pub const CONVERT_ROS1: &str =
    "a ROS 1 bag: convert it first, for example with `rosbags-convert --src a.bag --dst a`";

/// The first bytes of ROS 1 bags.
pub const ROS1_MAGIC: [u8; 13] = *b"#ROSBAG V2.0\n";
