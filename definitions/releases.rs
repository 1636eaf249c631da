//! The definitions of releases, as facts without comments.
//!
//! ```
//! use uavspec_definitions::releases::RELEASES;
//!
//! let release = RELEASES.iter().find(|release| release.name == "1.16").unwrap();
//! assert!(release.text().contains("MSG: px4_msgs/msg/BatteryStatus\n"));
//! ```

use alloc::string::String;

use miniz_oxide::inflate::decompress_to_vec;

/// The definitions of a release.
#[derive(Clone, Copy, Debug)]
pub struct Release {
    /// The family: `px4` or `ros2`.
    pub family: &'static str,
    /// The name, such as `1.16` or `jazzy`.
    pub name: &'static str,
    packed: &'static [u8],
}

impl Release {
    /// The definitions. Each one follows a line of `=` characters, and a line with its name.
    pub fn text(&self) -> String {
        unpacked(self.packed)
    }
}

include!(concat!(env!("OUT_DIR"), "/releases.rs"));

/// The fingerprints of the definitions in all releases: a table with tabs between its columns, and a heading.
pub fn fingerprints() -> String {
    unpacked(FINGERPRINTS)
}

fn unpacked(packed: &[u8]) -> String {
    // The build script compressed a text.
    decompress_to_vec(packed).ok().and_then(|bytes| String::from_utf8(bytes).ok()).unwrap_or_default()
}
