//! The source files of this crate, embedded in the binary. `uavspec init` writes copies of the crate, because generated
//! code requires it.
//!
//! ```
//! use uavspec_runtime::sources::SOURCES;
//!
//! assert!(SOURCES.get_file("lib.rs").is_some());
//! ```

pub use include_dir::{Dir, File};

use include_dir::include_dir;

/// The files in `src/`. The manifest is missing, because it refers to a workspace.
pub static SOURCES: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/src");

/// The names and texts of the licences, at the user's option.
pub static LICENCES: [(&str, &str); 2] =
    [("LICENSE-APACHE", include_str!("../LICENSE-APACHE")), ("LICENSE-MIT", include_str!("../LICENSE-MIT"))];
