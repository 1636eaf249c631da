//! Translations of the text in definitions.
//!
//! ```text
//!  definitions ──▶ Schema ──text──▶ texts with keys ─┐
//!  uk.po ──catalogue──▶ entries ─────────────────────┴──resolve──▶ Translations ──▶ emit
//!                               └─────────────────────────update──▶ uk.po, brought up to date
//! ```
//!
//! Each language has one catalogue, a gettext PO file named after the language (`uk.po`). All translation tools support
//! this format. An entry contains the source text next to its translation, so a changed definition is detected by
//! comparison, without hashes. `msgctxt` is the [key](Text::key) of the text. The key ties an entry to its text even
//! when the text changes.
//!
//! Existing PO crates report no positions, discard previous text and obsolete entries, and panic on some inputs. This
//! module therefore has a separate parser, which supports only the small subset of the format that is needed.

pub mod catalogue;
mod language;
mod resolve;
mod text;
mod translations;
mod update;

pub use self::language::{SOURCE_LANGUAGE, is_right_to_left, is_tag, name as language_name, shorter};
pub use self::resolve::resolve;
pub use self::text::{
    MessageKeys, MessageText, Text, error_code_key, error_codes_unit, error_table_key, event_key,
    events_unit, in_language, interface_unit, message_unit, texts,
};
pub use self::translations::{Language, Translations};
pub use self::update::{new_catalogue, update};
