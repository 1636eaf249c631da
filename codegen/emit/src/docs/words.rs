//! The fixed text of pages, in English and in other languages.
//!
//! Like translations of definitions, these translations are in PO files, such as `words/uk.po`. The English text is the
//! `msgid`. Languages without a file use English.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use uavspec_runtime::{ErrorClass, Severity};
use uavspec_schema::msg::attribute::Attribute;
use uavspec_schema::msg::constraint::{self, ConstraintKind};
use uavspec_schema::source::SourceMap;
use uavspec_schema::translation::{catalogue, shorter};
use uavspec_schema::wording::plural;

/// Catalogues by language tag.
const CATALOGUES: &[(&str, &str)] = &[("uk", include_str!("words/uk.po"))];

/// A fixed text. `{name}` is a placeholder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Word(&'static str);

impl Word {
    /// The text of an attribute.
    pub(super) fn of(attribute: &'static Attribute) -> Self {
        Self(attribute.words)
    }

    /// The text of a constraint.
    pub(super) const fn of_constraint(kind: &'static ConstraintKind) -> Self {
        Self(kind.words)
    }

    /// The English text.
    pub(super) const fn english(self) -> &'static str {
        self.0
    }
}

/// Declares all fixed strings.
macro_rules! words {
    ($($name:ident = $english:literal;)*) => {
        $(pub(super) const $name: Word = Word($english);)*

        /// All fixed strings.
        #[cfg(test)]
        const ALL: &[Word] = &[$($name),*];
    };
}

words! {
    // Facts of a message
    PACKAGE = "Package";
    PACKAGE_FROM = "{package}, from {origin}";
    ORIGIN_AT = "{origin} at {revision}";
    DEFINITION = "Definition";
    TOPIC = "Topic";
    TOPICS = "Topics";
    MESSAGE_VERSION = "Message version";
    QUEUE_LENGTH = "Queue length";
    UORB_SIZE = "uORB size";
    UORB_HASH = "uORB hash";
    CDR_SIZE = "CDR size";
    CDR_SIZE_OF = "CDR size of the {part}";
    ROS_TYPE = "ROS 2 type";
    ROS_TYPE_HASH = "ROS 2 type hash";
    JSON_SCHEMA = "JSON Schema";
    TEST_VECTORS = "Test vectors";
    OF_PART = "{fact} of the {part}";
    BYTES = "{count} bytes";
    OR_MORE = "at least {size}";
    WITH_HEADER = "{size}, including 4 for the encapsulation header";
    WITHOUT_PADDING = "{size}, {count} without trailing padding";
    MEMORY_LAYOUT = "Memory layout";
    MEMORY_LAYOUT_OF = "Memory layout of {name}";
    MEMORY_LAYOUT_MEANS = "Order and offsets of the fields in uORB and in ULog data messages. Each row has eight bytes.";
    USED_BY = "Used by";

    // History of a definition
    HISTORY = "History";
    RELEASE = "Release";
    CHANGES = "Changes";
    OLDEST_RELEASE = "oldest known release";
    NO_CHANGES = "no changes";
    FIELDS_OF_RELEASES = "This page shows the fields of {releases}.";
    FIELDS_OF_NO_RELEASE = "No release has exactly the fields on this page.";

    // Composing a message
    COMPOSE = "Compose";
    COMPOSE_MEANS = "In the HTML book, this section is a form that shows the message as JSON and as uORB bytes.";
    FIELDS_OF = "Fields of {name}";
    SET_TO_ZERO = "Set all to zero";
    COPY_JSON = "Copy JSON";
    COPY_BYTES = "Copy bytes";
    COPIED = "Copied";
    COPYING_REFUSED = "Copying failed";
    UORB_OF_SIZE = "uORB: {size}";
    PADDED_SIZE = "{size}, the last {padding} are padding";
    PADDING = "padding";
    BYTE_OF = "byte {at}: {field}";
    BYTE_IS = "byte {at} is {value}";
    AND_MORE = "and {count} more";
    ANOTHER_VALUE = "another value";
    UP_TO_BYTES = "up to {most} UTF-8 bytes";
    UP_TO_VALUES = "{type}, up to {most} values separated by spaces; missing values are 0";
    NOT_ALL_FIT = "Some values are invalid; see the marked fields.";
    EXPECTED_INTEGER = "expected an integer from {low} to {high}";
    EXPECTED_NUMBER = "expected a number or NaN";
    EXPECTED_BOOL = "expected true or false";
    OUT_OF_RANGE = "expected {low} to {high}, found {value}";
    TOO_MANY_BYTES = "expected at most {most} UTF-8 bytes, found {count}";
    TOO_MANY_VALUES = "expected at most {most} values, found {count}";

    // Services and actions
    SERVICE = "{name} service";
    ACTION = "{name} action";
    REQUEST = "Request";
    RESPONSE = "Response";
    GOAL = "Goal";
    RESULT = "Result";
    FEEDBACK = "Feedback";

    // Fields
    FIELDS = "Fields";
    NO_FIELDS = "No fields.";
    FIELD = "Field";
    TYPE = "Type";
    UNIT = "Unit";
    VALUES = "Values";
    DESCRIPTION = "Description";
    OFFSET = "Offset";
    OTHERS = "Others";
    LEFT_OUT = "not set";
    EMPTY = "empty";
    DEFAULT = "default {value}";
    FIRST_IN_USE = "used entries: the first {counter}";
    IN_USE = "number of used entries in {array}";
    IN_USE_AT_MOST = "number of used entries in {array}, at most {most}";
    TEXT = "text";

    // Constants
    ENUMS = "Enums";
    COMMANDS = "Commands";
    PARAMETER_VALUES = "Parameter values";
    CONSTANTS = "Constants";
    CONSTANT = "Constant";
    MASK = "Mask";
    VALUE = "Value";
    BIT = "Bit";
    NAME = "Name";
    COMMAND = "Command";
    PARAMETER = "Parameter";
    PARAMETER_OF = "parameter {number} of {command}";
    ONE_OF = "one of {enum}";
    BITS_OF = "bits of {enum}";
    USED_BY_FIELDS = "Used by {fields}.";
    OTHER_BITS = "Any combination of these bits is valid, and other bits may be set.";
    OTHER_VALUES = "Other values may occur.";
    ANOTHER_NAME_OF = "Alias of {name}.";

    // Error codes
    ERROR_CODES = "Error codes";
    SEVERITY_MEANS = "Two bits of a code contain its severity. The value `(code & 0xFF) >> 6` is 0 for informational codes, 1 for warnings, 2 for errors and 3 for fatal errors. All codes below 256 follow this rule, and all other codes should follow it.";
    TABLE = "Table";
    CODE_RANGE = "Range";
    SEVERITY = "Severity";
    CODES = "Codes";
    CODE = "Code";
    ABBREVIATION = "Abbreviation";
    MEANING = "Meaning";
    ALTERNATIVES = "Alternatives";
    SEE_ALSO = "See also";
    SINCE = "Since";
    AND_ABOVE = "{first} and above";
    TABLE_FACTS = "Range: {range} ({class}). This table lists {count}, defined in {source}. See also {all}.";
    ALL_ERROR_CODES = "all error codes";
    COUNT_OF_CODES = "{count} codes";
    ONE_OF_ALTERNATIVES = "A code and its alternatives denote one condition at different severities. Send only one of them.";
    FIND_A_CODE = "Find a code";
    FIND_EXAMPLE = "number, abbreviation, word …";
    SHOWN_OF_ALL = "{shown} of {all} codes";
    // Events
    EVENTS_OF = "Events of {component}";
    EVENT_GROUP = "Group";
    EVENT_MESSAGE = "Message";
    ID = "Id";
    ARGUMENTS = "Arguments";
    PLACEHOLDER = "Placeholder";
    FIND_AN_EVENT = "Find an event";
    EVENT_EXAMPLE = "id, name, word …";
    SHOWN_OF_EVENTS = "{shown} of {all} events";

    // Severities and classes
    NO_ERROR = "no error";
    INFORMATIONAL = "informational";
    WARNING = "warning";
    ERROR = "error";
    FATAL = "fatal";
    UAV_SPECIFIC = "UAV-specific";
    USER_DEFINED = "user-defined";
}

/// An inclusive range.
pub(super) const RANGE: Word = Word::of_constraint(&constraint::RANGE);

/// The fixed strings in one language.
#[derive(Clone, Copy, Debug)]
pub(super) struct Words {
    /// Translations by English text. `None` for English.
    translations: Option<&'static BTreeMap<String, String>>,
}

/// The English texts.
pub(super) const ENGLISH: Words = Words { translations: None };

impl Words {
    /// The fixed strings for a language tag or for its longest known prefix, or the English strings if neither is
    /// known.
    pub(super) fn of(tag: &str) -> Self {
        let known = known();
        Self { translations: shorter(tag).find_map(|tag| known.get(tag)) }
    }

    /// True for English.
    pub(super) fn are_english(self) -> bool {
        self.translations.is_none()
    }

    /// A text without placeholders.
    pub(super) fn get(self, word: Word) -> &'static str {
        self.translations.and_then(|words| words.get(word.0)).map_or(word.0, String::as_str)
    }

    /// A text with its placeholders replaced.
    pub(super) fn fill(self, word: Word, parts: &[(&str, &str)]) -> String {
        let mut filled = String::new();
        let mut rest = self.get(word);
        while let Some((before, after)) = rest.split_once('{') {
            let (name, after) = after.split_once('}').unwrap_or((after, ""));
            filled.push_str(before);
            filled.push_str(parts.iter().find(|(known, _)| *known == name).map_or("", |(_, part)| part));
            rest = after;
        }
        filled + rest
    }

    /// A number of bytes.
    pub(super) fn bytes(self, count: u64) -> String {
        self.count(BYTES, "byte", count)
    }

    /// A number of error codes.
    pub(super) fn codes(self, count: u64) -> String {
        self.count(COUNT_OF_CODES, "code", count)
    }

    /// A count with its noun. Some other languages have complex plural forms, so translations avoid inflected nouns.
    /// For example, the Ukrainian text uses `Б` for bytes.
    fn count(self, word: Word, noun: &str, count: u64) -> String {
        if self.are_english() {
            plural(count, noun)
        } else {
            self.fill(word, &[("count", &count.to_string())])
        }
    }

    /// A severity.
    pub(super) fn severity(self, severity: Severity) -> &'static str {
        self.get(match severity {
            Severity::Informational => INFORMATIONAL,
            Severity::Warning => WARNING,
            Severity::Error => ERROR,
            Severity::Fatal => FATAL,
        })
    }

    /// A class of error codes.
    pub(super) fn class(self, class: ErrorClass) -> &'static str {
        self.get(match class {
            ErrorClass::NoError => NO_ERROR,
            ErrorClass::Informational => INFORMATIONAL,
            ErrorClass::Warning => WARNING,
            ErrorClass::Error => ERROR,
            ErrorClass::Fatal => FATAL,
            ErrorClass::UavSpecific => UAV_SPECIFIC,
            ErrorClass::UserDefined => USER_DEFINED,
        })
    }

    /// A part of a service or action, by its ROS name.
    pub(super) fn part(self, name: &'static str) -> &'static str {
        let parts = [REQUEST, RESPONSE, GOAL, RESULT, FEEDBACK];
        parts.into_iter().find(|part| part.0 == name).map_or(name, |part| self.get(part))
    }
}

/// All catalogues, parsed once.
fn known() -> &'static BTreeMap<&'static str, BTreeMap<String, String>> {
    static KNOWN: OnceLock<BTreeMap<&str, BTreeMap<String, String>>> = OnceLock::new();
    KNOWN.get_or_init(|| CATALOGUES.iter().map(|(tag, text)| (*tag, read(text))).collect())
}

fn read(text: &str) -> BTreeMap<String, String> {
    let mut sources = SourceMap::default();
    let Ok(id) = sources.add("words.po", text.as_bytes().to_vec()) else { return BTreeMap::new() };
    let (catalogue, _, _) = catalogue::parse(&sources, id);
    let entries = catalogue.entries.into_iter().filter(|entry| !entry.is_header() && !entry.is_obsolete);
    entries.map(|entry| (entry.id, entry.translation)).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use uavspec_schema::msg::attribute::ATTRIBUTES;
    use uavspec_schema::msg::constraint::CONSTRAINTS;
    use uavspec_schema::translation::SOURCE_LANGUAGE;

    use super::*;

    /// The sorted names of the placeholders in a text.
    fn placeholders(text: &str) -> Vec<&str> {
        let mut placeholders: Vec<&str> =
            text.split('{').skip(1).filter_map(|rest| rest.split_once('}')).map(|(name, _)| name).collect();
        placeholders.sort_unstable();
        placeholders
    }

    #[test]
    fn catalogues_translate_exactly_the_fixed_texts() {
        let attributes = ATTRIBUTES.iter().map(|attribute| Word::of(attribute));
        let constraints = CONSTRAINTS.iter().map(|kind| Word::of_constraint(kind));
        let all: Vec<Word> = ALL.iter().copied().chain(attributes).chain(constraints).collect();
        let words: BTreeSet<&str> = all.iter().map(|word| word.0).collect();
        assert_eq!(words.len(), all.len(), "a text is declared twice");
        for (tag, text) in CATALOGUES {
            let mut sources = SourceMap::default();
            let id = sources.add("words.po", text.as_bytes().to_vec()).expect("a text");
            let (catalogue, _, diagnostics) = catalogue::parse(&sources, id);
            assert!(diagnostics.is_empty(), "{tag}: {diagnostics:?}");
            assert!(catalogue.entries.iter().all(|entry| !entry.is_fuzzy()), "{tag}");
            let translated = read(text);
            assert_eq!(translated.keys().map(String::as_str).collect::<BTreeSet<_>>(), words, "{tag}");
            for (english, translation) in &translated {
                assert!(!translation.is_empty(), "{tag}: {english}");
                assert_eq!(placeholders(english), placeholders(translation), "{tag}: {english}");
            }
        }
    }

    #[test]
    fn does_not_expand_placeholders_in_values() {
        let filled = ENGLISH.fill(RANGE, &[("low", "{high}"), ("high", "2")]);
        assert_eq!(filled, "{high} to 2");
    }

    #[test]
    fn falls_back_from_region_to_language() {
        assert!(!Words::of("uk-UA").are_english());
        assert!(Words::of("tlh").are_english());
        assert_eq!(SOURCE_LANGUAGE, "en", "fixed texts are in the language of the definitions");
    }
}
