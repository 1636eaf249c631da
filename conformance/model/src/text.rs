//! Formats text for people to read.

pub mod command_line;
mod secrets;
mod wrap;

use std::borrow::Cow;

// All text from captures, servers, testees, files and arguments passes through this function before it is shown.
pub use uavspec_schema::terminal::{self, shown};
pub use uavspec_schema::wording::{plural, similar, thousands};

pub use self::command_line::command_line;
pub use self::secrets::{
    HIDDEN, is_object_url, shown_url, shown_value, shown_words, without_login, without_query, without_secrets,
};
pub use self::wrap::wrapped;

/// Bytes as text. The error contains the location of the invalid UTF-8.
pub fn utf8(bytes: &[u8]) -> Result<&str, String> {
    std::str::from_utf8(bytes).map_err(|error| format!("invalid UTF-8 at byte {}", error.valid_up_to()))
}

/// The text, or its first `limit` characters and an ellipsis if it is longer.
pub fn start_of(text: &str, limit: usize) -> Cow<'_, str> {
    match text.char_indices().nth(limit) {
        None => Cow::Borrowed(text),
        Some((end, _)) => Cow::Owned(format!("{}…", &text[..end])),
    }
}
