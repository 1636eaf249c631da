//! The definitions of uavspec, embedded in the binary as files.
//!
//! ```
//! use uavspec_definitions::PX4;
//!
//! let flags = PX4.get_file("FailsafeFlags.msg").and_then(|file| file.contents_utf8());
//! assert!(flags.is_some_and(|text| text.contains("bool geofence_breached")));
//! ```

#![no_std]

extern crate alloc;

pub mod releases;

use include_dir::include_dir;
pub use include_dir::{Dir, File};

/// PX4 messages, one `.msg` file per message.
pub static PX4: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/px4");

/// Event metadata of PX4, in JSON: facts of PX4's events, with the texts of uavspec.
pub static PX4_EVENTS: &[u8] = include_bytes!("px4_events/px4.json");

/// Hints for conversions between releases of PX4, in TOML.
pub static PX4_HINTS: &str = include_str!("hints/px4.toml");

/// Translations of the texts in the definitions, one gettext catalogue per language.
pub static I18N: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/i18n");

/// Markdown pages of the Flockwave protocol.
pub static FLOCKWAVE: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/flockwave");
