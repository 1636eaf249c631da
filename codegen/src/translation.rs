//! Translations: what definitions say, in other languages.
//!
//! ```text
//!  definitions ──▶ Schema ──text──▶ texts with keys ─┐
//!  uk.po ──catalogue──▶ entries ─────────────────────┴──resolve──▶ Translations ──▶ emit
//!                               └─────────────────────────update──▶ uk.po, brought up to date
//! ```
//!
//! A language has one catalogue, a file of gettext's PO form that is called after the language (`uk.po`). That form,
//! since every translator's tool takes it, and since an entry holds the text that was translated beside its
//! translation: whether the definition has changed since is seen by comparing the two, and no hashes need be kept.
//! `msgctxt` is the [key](Text::key) of the thing, so that an entry stays with it whatever its text becomes.
//!
//! The crates that read this form report no places, give up previous texts and obsolete entries, and panic on some
//! inputs; what is needed of it takes a few screens.

pub(crate) mod catalogue;
mod language;
mod resolve;
mod text;
mod translations;
mod update;

pub use self::language::{SOURCE_LANGUAGE, is_right_to_left, is_tag};
pub(crate) use self::language::{name as language_name, shorter};
pub use self::resolve::resolve;
pub use self::text::{
    MessageKeys, MessageText, Text, error_code_key, error_codes_unit, error_table_key, interface_unit,
    message_unit, texts,
};
pub use self::translations::{Language, Translations};
pub use self::update::{new_catalogue, update};
