//! The texts of errors.

use std::fmt::Display;

/// The text for a failed action. `key` names the object of the action.
pub(super) fn failure(action: &str, key: &str, error: &dyn Display) -> String {
    format!("can't {action} `{}`: {}", key.escape_debug(), reason(error))
}

/// The text of a Zenoh error, without the source location at its end.
pub(super) fn reason(error: &dyn Display) -> String {
    let text = error.to_string();
    text.split(" at /").next().unwrap_or_default().trim_end_matches('.').to_owned()
}
