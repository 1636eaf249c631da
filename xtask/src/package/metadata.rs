//! Metadata for both registries.

/// The name of the packages.
pub(super) const NAME: &str = "uavspec";

/// The version of the workspace.
pub(super) const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The licence, as an SPDX expression.
pub(super) const LICENSE: &str = env!("CARGO_PKG_LICENSE");

/// The URL of the repository; empty if the workspace has none.
pub(super) const REPOSITORY: &str = env!("CARGO_PKG_REPOSITORY");

/// The description, in one line.
pub(super) const DESCRIPTION: &str =
    "Types, JSON Schemas, test vectors and error codes of PX4 messages and the Flockwave protocol";

/// The keywords.
pub(super) const KEYWORDS: [&str; 9] =
    ["drone", "uav", "px4", "uorb", "ros2", "flockwave", "skybrush", "json-schema", "test-vectors"];
