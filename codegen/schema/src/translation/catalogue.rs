//! Catalogues in gettext PO format: a parser that records the position of each entry, and a printer.
//!
//! Everything that translators and their tools write is preserved: comments, flags, previous texts, obsolete entries.
//! Plural forms are rejected, because definitions contain none.

mod entry;
mod parser;
mod print;

pub use self::entry::{Catalogue, Entry, FUZZY, Places};
pub use self::parser::parse;
pub use self::print::print;
