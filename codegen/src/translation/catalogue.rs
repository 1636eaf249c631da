//! Catalogues as text: gettext's PO form, read with the place of each entry, and written.
//!
//! Everything that translators and their tools write is kept: comments, flags, previous texts, obsolete entries.
//! Plural forms are refused, since no text of a definition has any.

mod entry;
mod parser;
#[cfg(any(test, feature = "cli"))]
mod print;

pub(crate) use self::entry::{Catalogue, Entry, FUZZY, Places};
pub(crate) use self::parser::parse;
#[cfg(any(test, feature = "cli"))]
pub(crate) use self::print::print;
