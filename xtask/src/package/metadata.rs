//! What both registries are told.

/// The name of the packages.
pub(super) const NAME: &str = "uavspec";

/// The version of the workspace.
pub(super) const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The licence, as an SPDX expression.
pub(super) const LICENSE: &str = env!("CARGO_PKG_LICENSE");

/// Where the sources are; empty where the workspace doesn't say.
pub(super) const REPOSITORY: &str = env!("CARGO_PKG_REPOSITORY");

/// What the packages are, in a line.
pub(super) const DESCRIPTION: &str =
    "Types, JSON Schemas, test vectors and error codes of PX4 messages and the Flockwave protocol";

/// What they are found by.
pub(super) const KEYWORDS: [&str; 9] =
    ["drone", "uav", "px4", "uorb", "ros2", "flockwave", "skybrush", "json-schema", "test-vectors"];
