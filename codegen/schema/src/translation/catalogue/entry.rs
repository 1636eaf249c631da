//! Entries of a catalogue.

use crate::source::Span;

/// The flag of an entry whose translation needs review. The translation is not used until a translator removes the
/// flag.
pub const FUZZY: &str = "fuzzy";

/// The parsed form of a PO file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Catalogue {
    /// All entries in order, including the header and obsolete entries.
    pub entries: Vec<Entry>,
    /// Comments after the last entry.
    pub end: Vec<String>,
}

/// An entry: a text and its translation.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Entry {
    /// Translators' comments, and all unrecognized lines that start with `#`, verbatim.
    pub comments: Vec<String>,
    /// Notes for translators (`#.`), by line.
    pub notes: Vec<String>,
    /// Locations of the text (`#:`), by line.
    pub references: Vec<String>,
    /// Flags (`#,`).
    pub flags: Vec<String>,
    /// The previous context, if it changed after the translation (`#|`).
    pub previous_context: Option<String>,
    /// The previous text, if it changed after the translation (`#|`).
    pub previous_id: Option<String>,
    /// The key of the text (`msgctxt`).
    pub context: Option<String>,
    /// The text (`msgid`), which is empty in the header.
    pub id: String,
    /// The translation (`msgstr`), which is empty until the text is translated.
    pub translation: String,
    /// True if the text no longer exists (`#~`).
    pub is_obsolete: bool,
}

impl Entry {
    /// True if this is the header of the catalogue.
    pub fn is_header(&self) -> bool {
        self.context.is_none() && self.id.is_empty() && !self.is_obsolete
    }

    /// True if there is a translation, reviewed or not. A translation that contains only white space doesn't count.
    pub fn is_translated(&self) -> bool {
        !self.translation.trim().is_empty()
    }

    /// True if the translation needs review.
    pub fn is_fuzzy(&self) -> bool {
        self.flags.iter().any(|flag| flag == FUZZY)
    }

    /// The value of a header field (`Name: value`).
    pub fn header_field(&self, name: &str) -> Option<&str> {
        self.translation.lines().find_map(|line| {
            let (found, value) = line.split_once(':')?;
            found.trim().eq_ignore_ascii_case(name).then_some(value.trim())
        })
    }
}

impl Catalogue {
    /// The header of the catalogue.
    pub fn header(&self) -> Option<&Entry> {
        self.entries.first().filter(|entry| entry.is_header())
    }
}

/// Locations of the parts of an entry.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Places {
    /// Location of the context, or of the text if there is no context.
    pub context: Span,
    /// Location of the text.
    pub id: Span,
    /// Location of the translation.
    pub translation: Span,
}
