//! The texts of errors.

use std::fmt::Display;

/// The text for an action that failed. `key` names the object.
pub(super) fn failure(action: &str, key: &str, error: &dyn Display) -> String {
    format!("can't {action} `{}`: {}", key.escape_debug(), reason(error))
}

/// The text of an error of Zenoh without the location in Zenoh's sources at its end.
pub(super) fn reason(error: &dyn Display) -> String {
    let text = error.to_string();
    text.split(" at /").next().unwrap_or_default().trim_end_matches('.').to_owned()
}
