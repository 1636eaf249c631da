//! Catalogues in gettext PO format: a parser that records the position of each entry, and a printer.
//!
//! Everything that translators and their tools write is preserved: comments, flags, previous texts, obsolete entries.
//! Plural forms are rejected, because definitions contain none.

mod entry;
mod parser;
#[cfg(any(test, feature = "cli"))]
mod print;

pub(crate) use self::entry::{Catalogue, Entry, FUZZY, Places};
pub(crate) use self::parser::parse;
#[cfg(any(test, feature = "cli"))]
pub(crate) use self::print::print;
