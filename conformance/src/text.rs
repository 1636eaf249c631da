//! Formats text for people to read.

mod command_line;
mod secrets;
mod wrap;

use std::borrow::Cow;

pub(crate) use self::command_line::command_line;
#[cfg(feature = "stores")]
pub(crate) use self::secrets::without_secrets;
pub(crate) use self::secrets::{
    HIDDEN, is_object_url, shown_url, shown_value, shown_words, without_login, without_query,
};
pub(crate) use self::wrap::wrapped;
// All text from captures, servers, testees, files and arguments passes through this function before it is shown.
pub(crate) use uavspec_codegen::terminal::{self, shown};
pub(crate) use uavspec_codegen::wording::{plural, similar, thousands};

/// Bytes as text. The error says where the text isn't valid UTF-8.
pub(crate) fn utf8(bytes: &[u8]) -> Result<&str, String> {
    std::str::from_utf8(bytes).map_err(|error| format!("invalid UTF-8 at byte {}", error.valid_up_to()))
}

/// The text, or its first `limit` characters and an ellipsis if it is longer.
pub(crate) fn start_of(text: &str, limit: usize) -> Cow<'_, str> {
    match text.char_indices().nth(limit) {
        None => Cow::Borrowed(text),
        Some((end, _)) => Cow::Owned(format!("{}…", &text[..end])),
    }
}
