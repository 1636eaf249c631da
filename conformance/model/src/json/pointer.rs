//! JSON pointers.

use std::fmt::Write as _;

/// The maximum length of a key, in characters.
const MAX_KEY: usize = 64;

/// A JSON pointer (RFC 6901). Very long keys are shortened.
pub fn pointer(keys: &[&str]) -> String {
    let mut pointer = String::new();
    for key in keys {
        let escaped = key.chars().take(MAX_KEY).collect::<String>().replace('~', "~0").replace('/', "~1");
        let more = if key.chars().nth(MAX_KEY).is_some() { "…" } else { "" };
        // Writing to a string can't fail.
        let _ = write!(pointer, "/{escaped}{more}");
    }
    pointer
}
