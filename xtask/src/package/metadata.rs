//! Metadata for both registries.

/// The name of the packages.
pub(super) const NAME: &str = "uavspec";

/// The version of the workspace.
pub(super) const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The licence, as an SPDX expression.
pub(super) const LICENSE: &str = env!("CARGO_PKG_LICENSE");

/// The URL of the repository; empty if the workspace has none.
pub(super) const REPOSITORY: &str = env!("CARGO_PKG_REPOSITORY");

/// The modification time of all files in tar archives for registries: 26 October 1985, 08:15, as in npm's archives.
/// Archives with times after 1980 can be converted to formats that don't support earlier times.
pub(super) const TIME: u64 = 499_162_500;

/// The description, in one line.
pub(super) const DESCRIPTION: &str =
    "Types, JSON Schemas, test vectors and error codes of PX4 messages and the Flockwave protocol";

/// The keywords.
pub(super) const KEYWORDS: [&str; 9] =
    ["drone", "uav", "px4", "uorb", "ros2", "flockwave", "skybrush", "json-schema", "test-vectors"];
