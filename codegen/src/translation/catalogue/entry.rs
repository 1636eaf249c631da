//! Entries of a catalogue.

use crate::source::Span;

/// The flag of an entry whose translation has to be looked at: it isn't used until somebody takes the flag away.
pub(crate) const FUZZY: &str = "fuzzy";

/// What a catalogue holds.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Catalogue {
    /// Its entries in their order, the header and obsolete ones too.
    pub entries: Vec<Entry>,
    /// Comments after the last entry.
    pub end: Vec<String>,
}

/// An entry: a text and its translation.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Entry {
    /// Lines that translators wrote, and all others that begin with `#` and mean nothing here; as they stand.
    pub comments: Vec<String>,
    /// What is told to translators (`#.`), by line.
    pub notes: Vec<String>,
    /// Where the text comes from (`#:`), by line.
    pub references: Vec<String>,
    /// Flags (`#,`).
    pub flags: Vec<String>,
    /// The context and the text that the translation was made of, where they have changed since (`#|`).
    pub previous_context: Option<String>,
    /// See there.
    pub previous_id: Option<String>,
    /// What the text belongs to (`msgctxt`): the key of the thing.
    pub context: Option<String>,
    /// The text (`msgid`); that of the header is empty.
    pub id: String,
    /// The translation (`msgstr`); empty where there is none yet.
    pub translation: String,
    /// Whether nothing has such a text any more (`#~`).
    pub is_obsolete: bool,
}

impl Entry {
    /// Whether it tells of the catalogue itself.
    pub fn is_header(&self) -> bool {
        self.context.is_none() && self.id.is_empty() && !self.is_obsolete
    }

    /// Whether there is any translation, be it a good one or not. White space is none.
    pub fn is_translated(&self) -> bool {
        !self.translation.trim().is_empty()
    }

    /// Whether somebody has to look at it.
    pub fn is_fuzzy(&self) -> bool {
        self.flags.iter().any(|flag| flag == FUZZY)
    }

    /// A line of the header, `Name: value`.
    pub fn header_field(&self, name: &str) -> Option<&str> {
        self.translation.lines().find_map(|line| {
            let (found, value) = line.split_once(':')?;
            found.trim().eq_ignore_ascii_case(name).then_some(value.trim())
        })
    }
}

impl Catalogue {
    /// What the catalogue tells of itself.
    pub fn header(&self) -> Option<&Entry> {
        self.entries.first().filter(|entry| entry.is_header())
    }
}

/// Where the parts of an entry stand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Places {
    /// The strings of its context; those of its text, where it has none.
    pub context: Span,
    /// The strings of its text.
    pub id: Span,
    /// The strings of its translation.
    pub translation: Span,
}
