//! What is wrong with a definition, as data. The texts stand in one table, [`Problem`]; how they are
//! shown is the business of [`render`](crate::render).
//!
//! ```
//! use uavspec_codegen::{PackageInput, SourceMap, diagnostic::has_errors, msg::Dialect, read, schema::Form};
//!
//! let mut sources = SourceMap::default();
//! let id = sources.add("Wind.msg", "flaot32 speed\n".into()).unwrap();
//! let (_, diagnostics) = read(&sources, &[PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])]);
//! assert!(has_errors(&diagnostics));
//! assert_eq!(diagnostics[0].problem.code(), "unknown-type");
//! ```

use std::fmt;

use crate::span::Span;

/// How grave a finding is. Diagnostics are errors and warnings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Level {
    /// Worth a look.
    Note,
    /// The definition can still be read as meant.
    Warning,
    /// Nothing is generated from a definition that has one.
    Error,
}

impl Level {
    /// All levels, from the least.
    pub const ALL: [Self; 3] = [Self::Note, Self::Warning, Self::Error];

    /// Its name in reports and in `uavspec.toml`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

/// Something wrong at a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// What is wrong.
    pub problem: Problem,
    /// Where.
    pub span: Span,
    /// What to do about it, where that depends on the case; else [`Problem::hint`] says it.
    pub hint: Option<String>,
    /// Other places that have to do with it, each with a word on how.
    pub related: Vec<(Span, String)>,
}

impl Diagnostic {
    /// A diagnostic with the hint of its problem.
    pub fn new(problem: Problem, span: Span) -> Self {
        Self { problem, span, hint: None, related: Vec::new() }
    }

    /// Puts another hint in place of the problem's own.
    #[must_use]
    pub fn with_hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// Adds another place that has to do with the problem.
    #[must_use]
    pub fn with_related(mut self, span: Span, label: impl Into<String>) -> Self {
        self.related.push((span, label.into()));
        self
    }

    /// How grave it is.
    pub fn level(&self) -> Level {
        self.problem.level()
    }

    /// What to do about it.
    pub fn hint(&self) -> String {
        self.hint.clone().unwrap_or_else(|| self.problem.hint())
    }
}

/// Whether any of `diagnostics` keeps output from being written.
pub fn has_errors(diagnostics: &[Diagnostic]) -> bool {
    diagnostics.iter().any(|diagnostic| diagnostic.level() == Level::Error)
}

/// What every problem of a kind has in common. In its templates `{name}` stands for a fact of the case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProblemKind {
    /// Its code, a permanent name.
    pub code: &'static str,
    /// How grave it is.
    pub level: Level,
    /// The template of its message, as `format!` takes it.
    pub message: &'static str,
    /// The template of its hint.
    pub hint: &'static str,
}

/// Declares [`Problem`]: for each kind its level, its code, its message and the hint beside its caret.
macro_rules! problems {
    ($($(#[$doc:meta])* $kind:ident $({ $($field:ident: $type:ty),* })? = $level:ident $code:literal
        $message:literal, $hint:literal;)*) => {
        /// Each kind of problem, with the facts that its message needs.
        #[derive(Clone, Debug, PartialEq)]
        #[allow(missing_docs)] // of the fields: each is named in the message
        pub enum Problem {
            $($(#[$doc])* $kind $({ $($field: $type),* })?,)*
        }

        impl Problem {
            /// Every kind of problem, in the order in which a text is read.
            pub const KINDS: &[ProblemKind] = &[$(ProblemKind {
                code: $code,
                level: Level::$level,
                message: $message,
                hint: $hint,
            }),*];

            /// The code of every problem, each a permanent name.
            pub const CODES: &[&str] = &[$($code),*];

            /// How grave each is, in the order of [`Problem::CODES`].
            pub const LEVELS: &[Level] = &[$(Level::$level),*];

            /// Its code, a permanent name.
            pub fn code(&self) -> &'static str {
                match self { $(Self::$kind $({ $($field: _),* })? => $code,)* }
            }

            /// How grave it is.
            pub fn level(&self) -> Level {
                match self { $(Self::$kind $({ $($field: _),* })? => Level::$level,)* }
            }

            /// What to do about it.
            #[allow(unused_variables, clippy::useless_format)]
            pub fn hint(&self) -> String {
                match self { $(Self::$kind $({ $($field),* })? => format!($hint),)* }
            }
        }

        impl fmt::Display for Problem {
            #[allow(unused_variables)]
            fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                match self { $(Self::$kind $({ $($field),* })? => write!(formatter, $message),)* }
            }
        }
    };
}

problems! {
    // Texts
    InvalidUtf8 { byte: u8 } = Error "invalid-utf8"
        "the byte 0x{byte:02x} is not UTF-8", "save the file as UTF-8";
    ByteOrderMark = Error "byte-order-mark"
        "the file starts with a byte order mark", "save it as UTF-8 without one: other tools read it as part of the first word";
    SourceTooLong { len: usize, max: usize } = Error "source-too-long"
        "the file has {len} bytes; definitions end at {max}", "is this a definition?";
    LineSeparator { name: &'static str } = Error "line-separator"
        "{name} in a line", "some tools end the line here and read the rest as a definition: remove it, or end the line with LF";
    ControlCharacter { code: u32 } = Error "control-character"
        "the control character U+{code:04X}", "remove it";
    InvisibleCharacter { code: u32 } = Warning "invisible-character"
        "the invisible character U+{code:04X}", "it can make the text look other than it is: remove it";

    // Lines of a `.msg` file
    MissingName { type_name: String } = Error "missing-name"
        "`{type_name}` stands alone", "a field is a type, white space and a name";
    InvalidType { text: String } = Error "invalid-type"
        "`{text}` is no type", "write a built-in type such as `uint8`, or the name of a message";
    InvalidArray { text: String } = Error "invalid-array"
        "`{text}` is no array length", "write a decimal number without blanks: `[8]`, in ROS 2 also `[<=8]` or `[]`";
    MultiDimensional = Error "multi-dimensional"
        "arrays have one dimension", "put the inner array into a message of its own";
    ArrayAfterName { name: String } = Error "array-after-name"
        "the array length stands after the name `{name}`", "it belongs to the type: `type[N] name`";
    ZeroLength = Error "zero-length"
        "an array or string of no elements", "give it a length of 1 or more, or remove the field";
    TooLarge { what: String, max: u64 } = Error "too-large"
        "{what} takes more than {max} bytes", "no transport carries a message of this size";
    TooManyFields { name: String, max: u64 } = Error "too-many-fields"
        "`{name}` has more than {max} fields with all that it nests", "hold fewer messages";
    TooMuchNesting { name: String, max: u64 } = Error "too-much-nesting"
        "with `{name}` all messages have more than {max} fields, nested ones counted in each that holds them",
        "let messages hold fewer others";
    NotInDialect { what: String, dialect: &'static str } = Error "not-in-dialect"
        "the {dialect} dialect has no {what}", "if this is a ROS 2 definition, give its package the dialect `ros2`";
    InvalidName { name: String } = Error "invalid-name"
        "`{name}` is no name", "names are letters, digits and `_`, and start with a letter";
    NameStyle { name: String, style: &'static str } = Warning "name-style"
        "`{name}` is not in {style}", "rename it: other tools refuse or change it";
    NameStyleRos { name: String, style: &'static str } = Error "name-refused"
        "`{name}` is not in {style}, which ROS 2 demands", "rename it; a `_` stands single, and not at the end";
    UnexpectedText { text: String } = Error "unexpected-text"
        "`{text}` after the end of the declaration", "start a comment with `#`, or remove it";
    MissingValue { name: String } = Error "missing-value"
        "the constant `{name}` has no value", "write one after the `=`";
    ConstantType { type_name: String } = Error "constant-type"
        "a constant can't be of type `{type_name}`", "constants are scalars, and in ROS 2 also strings without a bound";
    InvalidLiteral { text: String, type_name: String } = Error "invalid-literal"
        "`{text}` is no value of type `{type_name}`", "write the value itself: no expression and no name";
    ConstantOutOfRange { text: String, type_name: String, least: String, greatest: String } = Error "constant-out-of-range"
        "{text} doesn't fit `{type_name}` ({least} to {greatest})", "pick a value in the range, or a wider type";
    UnterminatedString = Error "unterminated-string"
        "the string has no closing quote", "close it in the same line";
    UnknownEscape { escape: String } = Warning "unknown-escape"
        "`{escape}` is no escape sequence", "it is kept as it stands; write `\\\\` for a backslash";
    ArrayDefault { found: usize, length: usize } = Error "array-default"
        "{found} default values for an array of {length}", "give {length}";
    MisplacedSeparator = Error "misplaced-separator"
        "`---` where no further part can start", "a .srv file has one of them, an .action file two, a .msg file none";
    MissingSeparator { found: usize, expected: usize } = Error "missing-separator"
        "the file has {found} of {expected} parts", "divide the parts by a line `---`, also where one is empty";
    NotPortable { text: String, instead: Option<String> } = Warning "not-portable"
        "PX4's own generator doesn't read `{text}` as it stands", "write it as PX4 does";

    // Annotations in comments
    UnknownAnnotation { name: String, known: String } = Warning "unknown-annotation"
        "no annotation is called `@{name}`", "it stays part of the text; known are {known}";
    MalformedAnnotation { text: String, form: &'static str } = Warning "malformed-annotation"
        "`{text}` can't be read", "write `{form}`; as it is, it stays part of the text";
    AnnotationNearMiss { found: String, meant: String } = Warning "annotation-near-miss"
        "`{found}` is read as `{meant}`", "write `{meant}`";
    AnnotationAfterText { found: String, meant: String, head: Option<Span> } = Warning "annotation-after-text"
        "`{found}` stands after the text", "annotations come first: `# [unit] [@…] text`";
    UnknownUnit { unit: String } = Warning "unknown-unit"
        "`{unit}` is no known unit", "units are written as in `m/s`, `deg` or `us`; `-` says that the number has none";

    // Resolving
    UnknownType { name: String, package: String } = Error "unknown-type"
        "no message `{name}` in package {package}", "add its definition to the inputs";
    UnknownPackage { package: String } = Error "unknown-package"
        "no package `{package}` among the inputs", "add its definitions to the inputs";
    Cycle { path: String } = Error "cycle"
        "a message can't hold itself: {path}", "break the cycle: neither PX4 nor ROS 2 takes one";
    DuplicateField { name: String } = Error "duplicate-field"
        "a second field `{name}`", "rename or remove one of them";
    DuplicateConstant { name: String } = Error "duplicate-constant"
        "a second constant `{name}`", "rename or remove one of them";
    DuplicateMessage { name: String, package: String } = Error "duplicate-message"
        "a second definition of `{name}` in package {package}", "leave one of the two files out";
    MessageName { stem: String } = Error "message-name"
        "the file name `{stem}` gives no message name", "name the file after its message: letters and digits, in PascalCase";
    MessageNameStyle { stem: String } = Warning "message-name-style"
        "the message name `{stem}` is not in PascalCase", "rename the file";
    InvalidVersion { what: &'static str, least: u32 } = Error "invalid-version"
        "`{what}` is an integer of at most 32 bits, and from {least} on", "PX4 knows it by this name: correct it, or call the constant otherwise";
    InvalidTopic { topic: String } = Error "invalid-topic"
        "`{topic}` is no topic name", "topics are in lower_snake_case, separated by spaces";
    DuplicateTopic { topic: String } = Warning "duplicate-topic"
        "the topic `{topic}` is listed twice", "remove one";
    UnknownEnum { prefix: String, place: String } = Warning "unknown-enum"
        "no constant of {place} starts with `{prefix}_`", "correct the prefix; as it is, the field stays a plain number";
    TooManyMembers { max: usize } = Error "too-many-members"
        "all enums have more than {max} members", "let fewer fields hold each constant";
    UnknownConstant { name: String } = Warning "unknown-constant"
        "no constant of this message is called `{name}`", "write a number, or the name of a constant; as it is, the annotation says nothing";
    EnumOnNonInteger { type_name: String } = Warning "enum-on-non-integer"
        "values of an enum are integers, not `{type_name}`", "remove the annotation, or give the field an integer type";
    EnumValueOutOfRange { constant: String, value: String, type_name: String } = Warning "enum-value-out-of-range"
        "`{constant}` = {value} doesn't fit the field's {type_name}", "the field can never hold it: widen the field, or correct the constant";
    UnknownCountTarget { name: String } = Error "unknown-count-target"
        "`@count` names no array `{name}` of this message", "name an array field of the same message";
    CountOnNonInteger { type_name: String } = Error "count-on-non-integer"
        "a field of type `{type_name}` can't count", "counts are integers";
    RangeReversed { low: String, high: String } = Warning "range-reversed"
        "the range ends ({high}) before it starts ({low})", "it is read as `{high}, {low}`: write it so";
    AnnotationValueType { text: String, type_name: String } = Warning "annotation-value-type"
        "a field of type `{type_name}` is never {text}", "correct the value, or the type of the field";

    // Specification tables
    NoTable = Error "no-table"
        "the page defines nothing", "a table of error codes has the columns Code, Abbr and Description, one of a type Field, Required, Type and Description";
    TableShape { expected: usize, found: usize } = Error "table-shape"
        "a row of {found} cells in a table of {expected} columns", "give each row a cell for each column";
    UnterminatedTable = Error "unterminated-table"
        "the table is not closed", "close it with `|===`";
    MergedCell = Error "merged-cell"
        "the cell is written for several columns, rows or cells at once", "write each cell out";
    UnknownColumns { header: String } = Error "unknown-columns"
        "`{header}` is no header of an error-code table", "call its columns Code, Abbr and Description";
    MissingHeading = Error "missing-heading"
        "the table stands under no heading", "the heading names its class, for example `Warnings (codes 64-127)`";
    InvalidCode { text: String } = Error "invalid-code"
        "`{text}` is no error code", "codes are decimal integers from 0, without sign or leading zeros";
    UnknownClass { heading: String } = Error "unknown-class"
        "the heading `{heading}` names no class or range of error codes", "write for example `Warnings (codes 64-127)`";
    ClassRange { class: String, found: String, expected: String } = Error "class-range"
        "{class} codes are {expected}, the heading says {found}", "correct the range or the name in the heading";
    CodeOutsideClass { code: u32, range: String } = Error "code-outside-class"
        "code {code} stands under a heading for {range}", "move it to the table of its class";
    DuplicateCode { code: u32 } = Error "duplicate-code"
        "code {code} is defined twice", "codes are unique in all tables of a package";
    DuplicateAbbreviation { abbreviation: String, code: u32 } = Error "duplicate-abbreviation"
        "`{abbreviation}` is also the abbreviation of code {code} in this class", "within a class each abbreviation names one code";
    MissingAbbreviation { code: u32 } = Warning "missing-abbreviation"
        "code {code} has no abbreviation", "user interfaces will show the number; write `-` where that is meant";
    DanglingCode { code: String } = Error "dangling-code"
        "no table has a code {code}", "correct the reference, or define the code";
    OneSidedAlternative { code: u32, other: u32 } = Warning "one-sided-alternative"
        "code {code} names {other} as its alternative, but not the reverse", "they are read as alternatives of each other";
    TooManyAlternatives { code: u32, max: usize } = Error "too-many-alternatives"
        "code {code} names more than {max} alternatives", "name only the codes that stand for the same event";
    OverlappingBlock { block: String } = Error "overlapping-block"
        "two tables claim codes {block}", "blocks of two vendors must not overlap";

    // Types and messages in tables
    NearTypeTable { header: String, meant: String } = Warning "near-type-table"
        "`{header}` is nearly the header of a type table", "call its columns `{meant}`; as it is, the table defines nothing";
    TypeName { heading: String } = Error "type-name"
        "`{heading}` is no name of a type", "call a type by one word in PascalCase; tables that define none have other columns";
    DuplicateType { name: String } = Error "duplicate-type"
        "a second definition of `{name}`", "rename or remove one of them";
    InvalidRequired { text: String } = Error "invalid-required"
        "`{text}` is neither yes nor no", "write `yes` where the field may not be left out, and else `no`";
    TupleIndex { found: String, expected: usize } = Error "tuple-index"
        "index `{found}` where {expected} is due", "indices count from 0, in order";
    RequiredAfterOptional { name: String } = Error "required-after-optional"
        "`{name}` is required, but elements before it may be left out", "only the last elements of a tuple can be left out: require those before it, or let them be null";
    InvalidTypeExpression { text: String } = Error "invalid-type-expression"
        "`{text}` is no type", "write for example `string`, `list of Name`, `map of integer`, `Name or null` or `one of A, B`";
    UndefinedType { name: String, package: String } = Error "undefined-type"
        "no type `{name}` in package {package}", "define it under a heading of that name, in any page of the package";
    EndlessType { path: String } = Error "endless-type"
        "a value of this type would never end: {path}", "let a type hold itself only in a list, in a map, in a field that may be left out, or where null may stand";
    TooManyParts { name: String, what: &'static str, max: usize } = Error "too-many-parts"
        "`{name}` has more than {max} {what}", "define types of their own for some of them, or an object in the place of a tuple";
    EmptyType { name: String } = Error "empty-type"
        "the table of `{name}` has no rows", "give it one at least: nothing else could be a value";
    Openness { name: String, found: &'static str } = Error "openness"
        "`{name}` is {found}", "the paragraph above the table says one of both: `open set` or `closed set`, `closed object` or `further fields are allowed`";
    MixedSet { name: String } = Error "mixed-set"
        "the set `{name}` holds integers and strings", "put integers that are strings between quotes, or define two sets";
    DuplicateValue { value: String } = Error "duplicate-value"
        "{value} is listed twice", "remove one";
    MissingFields { name: String, direction: &'static str } = Error "missing-fields"
        "nothing says which fields a {direction} of `{name}` has", "give it a table with the columns Field, Required, Type and Description, or a paragraph `No fields beside type.`";
    MisplacedAnswer { what: &'static str } = Error "misplaced-answer"
        "a {what} has no answer", "put the line below `Request`, or below the heading of a message that has one";
    UnknownAnswer { name: String } = Error "unknown-answer"
        "no message `{name}` has a response", "name messages with a heading `Response`, separated by commas: `Answer: ACK-ACK, ACK-NAK`";
    MissingAnswer { name: String } = Warning "missing-answer"
        "`{name}` has a request, but nothing says what answers it", "define a response, or name the types that answer it: `Answer: ACK-ACK`";
    MisplacedAnnotation { annotation: &'static str, type_name: String } = Warning "misplaced-annotation"
        "`{annotation}` says nothing about `{type_name}`", "correct the type, or remove it";

    // Catalogues of translations
    MalformedCatalogue { what: &'static str } = Error "malformed-catalogue"
        "{what}", "an entry is `msgctxt`, `msgid` and `msgstr`, each with strings between quotes";
    CatalogueHeader = Error "catalogue-header"
        "the catalogue has no header", "begin it with an entry whose `msgid` is empty; `cargo xtask translate LANGUAGE` makes one";
    CatalogueEncoding { charset: String } = Error "catalogue-encoding"
        "the header says that the file is written in `{charset}`", "save it as UTF-8, and write `Content-Type: text/plain; charset=UTF-8`";
    CatalogueName { stem: String } = Error "catalogue-name"
        "`{stem}` is no tag of another language", "call the file after its language, as BCP 47 writes it: `uk.po`, `pt-BR.po`; definitions are in English";
    CatalogueLanguage { found: String, tag: String } = Error "catalogue-language"
        "the header says that the language is `{found}`, the name of the file `{tag}`", "correct the one that is wrong";
    DuplicateCatalogue { tag: String } = Error "duplicate-catalogue"
        "a second catalogue for `{tag}`", "put its entries into the first: a language has one file";
    DuplicateTranslation { key: String } = Error "duplicate-translation"
        "a second entry for `{key}`", "remove one of them";
    UnknownTranslation { what: String } = Warning "unknown-translation"
        "{what} names nothing in the definitions", "correct it, or let `cargo xtask translate` set the entry aside";
    TranslationStale { key: String } = Warning "translation-stale"
        "the definition of `{key}` has another text now", "it isn't used: `cargo xtask translate` takes over the new text, then translate anew and take the flag `fuzzy` away";
    TranslationFuzzy { key: String } = Warning "translation-fuzzy"
        "the translation of `{key}` is marked as fuzzy", "it isn't used: look at it, then take the flag away";
    TranslationMissing { tag: String, unit: String, missing: usize, all: usize, some: String } = Warning "translation-missing"
        "{missing} of {all} texts of `{unit}` have no translation into `{tag}`: {some}", "translate them, after `cargo xtask translate` where they have no entry yet; until then they are shown in English";
}
