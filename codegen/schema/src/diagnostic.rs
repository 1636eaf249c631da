//! Errors and warnings in definitions. [`Problem`] lists all kinds with their messages; [`render`](crate::render)
//! prints them.
//!
//! ```
//! use uavspec_schema::{Form, PackageInput, SourceMap, diagnostic::has_errors, msg::Dialect, read};
//!
//! let mut sources = SourceMap::default();
//! let id = sources.add("Wind.msg", "flaot32 speed\n".into()).unwrap();
//! let (_, diagnostics) = read(&sources, &[PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])]);
//! assert!(has_errors(&diagnostics));
//! assert_eq!(diagnostics[0].problem.code(), "unknown-type");
//! ```

use std::fmt;

use crate::span::Span;

/// The severity of a finding. Diagnostics are errors or warnings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, clap::ValueEnum)]
pub enum Level {
    /// Informational.
    #[value(help = "All findings")]
    Note,
    /// The definition can still be read as intended.
    #[value(help = "Warnings and errors")]
    Warning,
    /// No output is generated from the definitions.
    #[value(help = "Errors only")]
    Error,
}

impl Level {
    /// All levels, from least to most severe.
    pub const ALL: [Self; 3] = [Self::Note, Self::Warning, Self::Error];

    /// The name in reports and in `uavspec.toml`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

/// A problem and its location.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// The problem.
    pub problem: Problem,
    /// The location.
    pub span: Span,
    /// The advice for this case; if absent, [`Problem::hint`] applies.
    pub hint: Option<String>,
    /// Other relevant locations, each with a label.
    pub related: Vec<(Span, String)>,
}

impl Diagnostic {
    /// Creates a diagnostic with the problem's default hint.
    pub fn new(problem: Problem, span: Span) -> Self {
        Self { problem, span, hint: None, related: Vec::new() }
    }

    /// Replaces the problem's default hint.
    #[must_use]
    pub fn with_hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// Adds another location with a label.
    #[must_use]
    pub fn with_related(mut self, span: Span, label: impl Into<String>) -> Self {
        self.related.push((span, label.into()));
        self
    }

    /// The severity.
    pub fn level(&self) -> Level {
        self.problem.level()
    }

    /// The advice on how to fix the problem.
    pub fn hint(&self) -> String {
        self.hint.clone().unwrap_or_else(|| self.problem.hint())
    }
}

/// True if `diagnostics` contains an error. No output is written in this case.
pub fn has_errors(diagnostics: &[Diagnostic]) -> bool {
    diagnostics.iter().any(|diagnostic| diagnostic.level() == Level::Error)
}

/// The facts shared by all problems of one kind. In the templates, `{name}` is a placeholder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProblemKind {
    /// The permanent identifier.
    pub code: &'static str,
    /// The severity.
    pub level: Level,
    /// The message template, in `format!` syntax.
    pub message: &'static str,
    /// The hint template.
    pub hint: &'static str,
}

/// Declares [`Problem`]: the level, code, message and hint of each kind.
macro_rules! problems {
    ($($(#[$doc:meta])* $kind:ident $({ $($field:ident: $type:ty),* })? = $level:ident $code:literal
        $message:literal, $hint:literal;)*) => {
        /// A problem, with the values to insert into its message.
        #[derive(Clone, Debug, PartialEq)]
        #[allow(missing_docs)] // the message templates explain the fields
        pub enum Problem {
            $($(#[$doc])* $kind $({ $($field: $type),* })?,)*
        }

        impl Problem {
            /// All kinds of problems, grouped by processing stage.
            pub const KINDS: &[ProblemKind] = &[$(ProblemKind {
                code: $code,
                level: Level::$level,
                message: $message,
                hint: $hint,
            }),*];

            /// The permanent identifier.
            pub fn code(&self) -> &'static str {
                match self { $(Self::$kind $({ $($field: _),* })? => $code,)* }
            }

            /// The severity.
            pub fn level(&self) -> Level {
                match self { $(Self::$kind $({ $($field: _),* })? => Level::$level,)* }
            }

            /// The advice on how to fix the problem.
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
    // Text encoding
    InvalidUtf8 { byte: u8 } = Error "invalid-utf8"
        "byte 0x{byte:02x} is not valid UTF-8", "save the file as UTF-8";
    ByteOrderMark = Error "byte-order-mark"
        "the file starts with a byte order mark", "save it as UTF-8 without a byte order mark";
    SourceTooLong { len: usize, max: usize } = Error "source-too-long"
        "the file is {len} bytes long; the limit is {max} bytes", "check that this file is a definition";
    LineSeparator { name: &'static str } = Error "line-separator"
        "{name} within a line", "remove the character, or end the line with LF; some tools parse the text \
            after the character as a definition";
    ControlCharacter { code: u32 } = Error "control-character"
        "control character U+{code:04X}", "remove it";
    InvisibleCharacter { code: u32 } = Warning "invisible-character"
        "invisible character U+{code:04X}", "remove the character; the displayed text may differ from the \
            file content";

    // Lines of a `.msg` file
    MissingName { type_name: String } = Error "missing-name"
        "expected a name after `{type_name}`", "write a field as `type name`";
    InvalidType { text: String } = Error "invalid-type"
        "`{text}` is not a valid type", "write a built-in type such as `uint8`, or the name of a message";
    InvalidArray { text: String } = Error "invalid-array"
        "`{text}` is not a valid array length",
        "write a decimal number without spaces: `[8]`; ROS 2 also allows `[<=8]` and `[]`";
    MultiDimensional = Error "multi-dimensional"
        "multi-dimensional arrays are not supported", "move the inner array to a separate message";
    ArrayAfterName { name: String } = Error "array-after-name"
        "the array length follows the name `{name}`", "move it to the type: `type[N] name`";
    ZeroLength = Error "zero-length"
        "an array or string of length 0", "use a length of 1 or more, or remove the field";
    TooLarge { what: String, max: u64 } = Error "too-large"
        "{what} exceeds {max} bytes", "make it smaller; no transport carries a message of this size";
    TooManyFields { name: String, max: u64 } = Error "too-many-fields"
        "`{name}` has more than {max} fields, including nested fields", "nest fewer messages";
    TooMuchNesting { name: String, max: u64, what: &'static str } = Error "too-much-nesting"
        "with `{name}`, there are more than {max} {what}", "nest less";
    NotInDialect { what: String, dialect: &'static str } = Error "not-in-dialect"
        "the {dialect} dialect does not support {what}",
        "if this is a ROS 2 definition, set the dialect of its package to `ros2`";
    InvalidName { name: String } = Error "invalid-name"
        "`{name}` is not a valid name", "use letters, digits and `_`, and start with a letter";
    NameStyle { name: String, style: &'static str } = Warning "name-style"
        "`{name}` is not in {style}", "rename it; other tools reject or change it";
    NameStyleRos { name: String, style: &'static str } = Error "name-refused"
        "`{name}` is not in {style}, which ROS 2 requires", "choose another name";
    UnexpectedText { text: String } = Error "unexpected-text"
        "unexpected `{text}` after the declaration", "start a comment with `#`, or remove the text";
    MissingValue { name: String } = Error "missing-value"
        "the constant `{name}` has no value", "write a value after `=`";
    ConstantType { type_name: String } = Error "constant-type"
        "a constant cannot have the type `{type_name}`", "use a scalar type; ROS 2 also allows unbounded strings";
    InvalidLiteral { text: String, type_name: String } = Error "invalid-literal"
        "`{text}` is not a value of type `{type_name}`", "write a literal value, not an expression or a name";
    ConstantOutOfRange { text: String, type_name: String, min: String, max: String } = Error "constant-out-of-range"
        "{text} does not fit `{type_name}` ({min} to {max})", "use a value in this range, or a wider type";
    UnterminatedString = Error "unterminated-string"
        "the string has no closing quote", "close it on the same line";
    UnknownEscape { escape: String } = Warning "unknown-escape"
        "unknown escape sequence `{escape}`", "the sequence is kept as it is; write `\\\\` for a backslash";
    ArrayDefault { found: usize, length: usize } = Error "array-default"
        "{found} default values for an array of length {length}", "give exactly {length}";
    MisplacedSeparator = Error "misplaced-separator"
        "unexpected `---`", "a .srv file contains one separator; an .action file contains two; a .msg file contains \
            none";
    MissingSeparator { found: usize, expected: usize } = Error "missing-separator"
        "expected {expected} parts, found {found}", "separate the parts with a `---` line, even if a part is empty";
    InvalidSeparator { text: String } = Error "invalid-separator"
        "`{text}` does not separate parts", "write three dashes at the start of the line: `---`";
    UnsupportedAnnotation { text: String } = Error "unsupported-annotation"
        "uavspec does not support the annotation `{text}`", "remove it; write annotations for uavspec in comments, \
            such as `# [m/s] text`";
    NotPortable { tool: &'static str, text: String, instead: Option<String> } = Warning "not-portable"
        "{tool} does not accept `{text}`", "use the form that {tool} accepts";

    // Annotations in comments
    UnknownAnnotation { name: String, known: String } = Warning "unknown-annotation"
        "unknown annotation `@{name}`", "uavspec treats it as text; known annotations: {known}";
    MalformedAnnotation { text: String, form: &'static str } = Warning "malformed-annotation"
        "malformed annotation `{text}`", "write `{form}`; until then the annotation is treated as text";
    AnnotationNearMiss { found: String, expected: String } = Warning "annotation-near-miss"
        "`{found}` is read as `{expected}`", "write `{expected}`";
    AnnotationAfterText { found: String, expected: String, head: Option<Span> } = Warning "annotation-after-text"
        "the annotation `{found}` follows the text", "put annotations first: `# [unit] [@…] text`";
    UnknownUnit { unit: String } = Warning "unknown-unit"
        "unknown unit `{unit}`", "write a unit such as `m/s`, `deg` or `us`, or `-` for a number without a unit";

    // Resolving
    UnknownType { name: String, package: String } = Error "unknown-type"
        "package {package} has no message `{name}`", "add its definition to the inputs";
    UnknownPackage { package: String } = Error "unknown-package"
        "the inputs contain no package `{package}`", "add its definitions to the inputs";
    Cycle { path: String } = Error "cycle"
        "a message cannot contain itself: {path}", "break the cycle; PX4 and ROS 2 reject it";
    DuplicateField { name: String } = Error "duplicate-field"
        "duplicate field `{name}`", "rename or remove one of them";
    DuplicateConstant { name: String } = Error "duplicate-constant"
        "duplicate constant `{name}`", "rename or remove one of them";
    DuplicateMessage { name: String, package: String } = Error "duplicate-message"
        "duplicate definition of `{name}` in package {package}", "remove one of the two files from the inputs";
    MessageName { stem: String } = Error "message-name"
        "the file name `{stem}` is not a valid message name",
        "name the file after its message: letters and digits, in PascalCase";
    MessageNameStyle { stem: String } = Warning "message-name-style"
        "the message name `{stem}` is not in PascalCase", "rename the file";
    InvalidVersion { what: &'static str, min: u32 } = Error "invalid-version"
        "`{what}` must be an integer of at most 32 bits, with a value of at least {min}",
        "correct the constant, or rename it; PX4 gives this name a special meaning";
    InvalidTopic { topic: String } = Error "invalid-topic"
        "`{topic}` is not a valid topic name", "write topics in lower_snake_case, separated by spaces";
    DuplicateTopic { topic: String } = Warning "duplicate-topic"
        "the topic `{topic}` is listed twice", "remove one of them";
    UnknownEnum { prefix: String, place: String } = Warning "unknown-enum"
        "no constant of {place} starts with `{prefix}_`", "correct the prefix; until then the field is \
            treated as a plain number";
    TooManyMembers { max: usize } = Error "too-many-members"
        "the enums have more than {max} members in total", "refer to large groups of constants from fewer fields";
    UnknownConstant { name: String } = Warning "unknown-constant"
        "this message has no constant `{name}`",
        "write a number or the name of a constant; until then the annotation is ignored";
    EnumOnNonInteger { type_name: String } = Warning "enum-on-non-integer"
        "an enum requires an integer type, found `{type_name}`",
        "remove the annotation, or give the field an integer type";
    EnumValueOutOfRange { constant: String, value: String, type_name: String } = Warning "enum-value-out-of-range"
        "`{constant}` = {value} does not fit the field's type {type_name}", "widen the field, or correct the constant";
    UnknownCountTarget { name: String } = Error "unknown-count-target"
        "`@count` refers to `{name}`, which is not an array of this message", "name an array field of the same message";
    CountOnNonInteger { type_name: String } = Error "count-on-non-integer"
        "a field of type `{type_name}` cannot be a count", "use an integer type";
    RangeReversed { low: String, high: String } = Warning "range-reversed"
        "the range is reversed: {low} is greater than {high}", "write `{high}, {low}`; uavspec reads the range this \
            way";
    AnnotationValueType { text: String, type_name: String } = Warning "annotation-value-type"
        "{text} is not a value of type `{type_name}`", "correct the value, or the type of the field";

    // Specification tables
    NoTable = Error "no-table"
        "the page contains no definitions",
        "add a table with the columns Code, Abbr and Description, or a table with the columns Field, Required, Type \
            and Description";
    TableShape { expected: usize, found: usize } = Error "table-shape"
        "the row has {found} cells, but the table has {expected} columns", "give each row one cell per column";
    UnterminatedTable = Error "unterminated-table"
        "the table is not closed", "close it with `|===`";
    MergedCell = Error "merged-cell"
        "merged and repeated cells are not supported", "write out each cell";
    UnknownColumns { header: String } = Error "unknown-columns"
        "`{header}` is not the header of an error-code table", "name the columns Code, Abbr and Description";
    MissingHeading = Error "missing-heading"
        "the table has no heading", "add a heading with the class of its codes, such as `Warnings (codes 64-127)`";
    InvalidCode { text: String } = Error "invalid-code"
        "`{text}` is not a valid error code", "write a decimal integer without a sign or leading zeros";
    UnknownClass { heading: String } = Error "unknown-class"
        "the heading `{heading}` contains no class or range of error codes",
        "write a heading such as `Warnings (codes 64-127)`";
    ClassRange { class: String, found: String, expected: String } = Error "class-range"
        "{class} codes are {expected}, but the heading gives {found}", "correct the range or the class in the heading";
    CodeOutsideClass { code: u32, range: String } = Error "code-outside-class"
        "code {code} is under a heading for {range}", "move it to the table of its class";
    DuplicateCode { code: u32 } = Error "duplicate-code"
        "code {code} is defined twice", "define each code only once in a package";
    DuplicateAbbreviation { abbreviation: String, code: u32 } = Error "duplicate-abbreviation"
        "`{abbreviation}` is already the abbreviation of code {code} in this class",
        "use each abbreviation once per class";
    MissingAbbreviation { code: u32 } = Warning "missing-abbreviation"
        "code {code} has no abbreviation", "write `-` if user interfaces should show the number";
    DanglingCode { code: String } = Error "dangling-code"
        "code {code} is not defined", "correct the reference, or define the code";
    OneSidedAlternative { code: u32, other: u32 } = Warning "one-sided-alternative"
        "code {code} lists {other} as its alternative, but {other} does not list {code}",
        "uavspec treats each as an alternative of the other";
    TooManyAlternatives { code: u32, max: usize } = Error "too-many-alternatives"
        "code {code} lists more than {max} alternatives", "list only codes for the same event";
    OverlappingBlock { block: String } = Error "overlapping-block"
        "two tables cover the codes {block}", "give each vendor a separate block";

    // Types and messages in tables
    NearTypeTable { header: String, expected: String } = Warning "near-type-table"
        "`{header}` almost matches the header of a type table",
        "name the columns `{expected}`; until then the table is ignored";
    TypeName { heading: String } = Error "type-name"
        "`{heading}` is not a valid type name",
        "use one word in PascalCase; if the table defines no type, rename its columns";
    DuplicateType { name: String } = Error "duplicate-type"
        "duplicate definition of `{name}`", "rename or remove one of them";
    InvalidRequired { text: String } = Error "invalid-required"
        "expected yes or no, found `{text}`", "write `yes` if the field is required, otherwise `no`";
    TupleIndex { found: String, expected: usize } = Error "tuple-index"
        "expected index {expected}, found `{found}`", "use the indexes 0, 1, 2 and so on, in order";
    RequiredAfterOptional { name: String } = Error "required-after-optional"
        "`{name}` is required, but follows an optional element",
        "make the earlier elements required, or allow null for them";
    InvalidTypeExpression { text: String } = Error "invalid-type-expression"
        "`{text}` is not a valid type",
        "write, for example, `string`, `list of Name`, `map of integer`, `Name or null` or `one of A, B`";
    UndefinedType { name: String, package: String } = Error "undefined-type"
        "package {package} has no type `{name}`",
        "define it under a heading with this name, on any page of the package";
    EndlessType { path: String } = Error "endless-type"
        "infinitely nested type: {path}", "put the inner value in a list, a map or an optional field, or allow null";
    TooManyParts { name: String, what: &'static str, max: usize } = Error "too-many-parts"
        "`{name}` has more than {max} {what}",
        "move some of them to separate types, or use an object in place of a tuple";
    EmptyType { name: String } = Error "empty-type"
        "the table of `{name}` has no rows", "add at least one row; without rows, no value is valid";
    Openness { name: String, found: &'static str } = Error "openness"
        "`{name}` is {found}",
        "above the table, write `open set` or `closed set` for a set, and `closed object` or `further fields are \
            allowed` for an object";
    MixedSet { name: String } = Error "mixed-set"
        "the set `{name}` mixes integers and strings",
        "quote strings that look like integers, or define two sets";
    DuplicateValue { value: String } = Error "duplicate-value"
        "{value} is listed twice", "remove one of them";
    MissingFields { name: String, direction: &'static str } = Error "missing-fields"
        "the {direction} of `{name}` has no table of fields",
        "add a table with the columns Field, Required, Type and Description, or a paragraph `No fields besides type.`";
    MisplacedAnswer { what: &'static str } = Error "misplaced-answer"
        "`Answer:` is not allowed in a {what}",
        "move the line under the `Request` heading, or under the heading of a message with a request";
    UnknownAnswer { name: String } = Error "unknown-answer"
        "no message named `{name}` has a response", "refer only to messages that have a `Response` heading, \
            as in `Answer: ACK-ACK, ACK-NAK`";
    MissingAnswer { name: String } = Warning "missing-answer"
        "the request of `{name}` has no answer",
        "define a response, or name the messages that answer it: `Answer: ACK-ACK`";
    MisplacedAnnotation { annotation: &'static str, type_name: String } = Warning "misplaced-annotation"
        "`{annotation}` does not apply to `{type_name}`", "correct the type, or remove the annotation";

    // Event metadata
    InvalidJson { what: String } = Error "invalid-json"
        "invalid JSON: {what}", "correct the file; JSON has no comments and no commas before `}}` or `]`";
    TooManyEventValues { max: usize } = Error "too-many-event-values"
        "the file has more than {max} values", "split the file";
    MemberType { what: String, expected: &'static str } = Error "member-type"
        "{what} is not {expected}", "write {expected}";
    MissingMember { name: &'static str, what: &'static str } = Error "missing-member"
        "{what} without `{name}`", "add the member `{name}`";
    UnknownMember { name: String, what: &'static str, known: String } = Warning "unknown-member"
        "unknown member `{name}` of {what}", "uavspec ignores it; known members: {known}";
    DuplicateMember { name: String, what: &'static str } = Error "duplicate-member"
        "`{name}` appears twice in {what}", "remove one of them; other tools use only the last";
    EventVersion { version: u32 } = Warning "event-version"
        "version {version} of event metadata is unknown", "uavspec reads it as version 2, with which later versions \
            are compatible";
    EventNumber { text: String, what: &'static str, min: i128, max: i128 } = Error "event-number"
        "`{text}` is not {what}", "write a decimal number from {min} to {max}";
    EventName { name: String, what: &'static str, form: &'static str } = Error "event-name"
        "`{name}` is not a valid name for {what}", "use {form}";
    EventEnumType { name: String } = Error "event-enum-type"
        "`{name}` is not a valid type for an enum", "write an integer type from `uint8_t` to `int64_t`";
    EventBit { value: i128 } = Warning "event-bit"
        "{value} is not a single bit, so readers never show this entry", "use a power of two, or remove \
            `is_bitfield`";
    EventLine { what: &'static str } = Error "event-line"
        "the {what} has more than one line", "write one line";
    EventNamespace { id: u8, name: String, first: String } = Error "event-namespace"
        "component {id} has the namespace `{name}` here, but `{first}` where it was first defined", "use one name for each component";
    DuplicateInEvents { what: &'static str, name: String } = Error "duplicate-in-events"
        "duplicate {what} `{name}`", "rename or remove one of them";
    EventId { name: String, found: u32, expected: u32 } = Warning "event-id"
        "the id of `{name}` is {found}, but its name has the hash {expected}", "use the hash; PX4 computes the ids \
            of its events from their names";
    EventMessageLength { length: usize, max: usize } = Error "event-message-length"
        "the message has {length} characters", "write 1 to {max} characters, and the rest in the description";
    EventTextLength { length: usize, max: usize } = Error "event-text-length"
        "the text has {length} bytes", "write at most {max} bytes";
    EventText { what: String } = Error "event-text"
        "{what}", "correct the text; ground stations show it incorrectly";
    EventInstance { count: usize } = Error "event-instance"
        "`instance_arg_index` refers to none of the {count} arguments", "write the index of an argument, from 0";
    EventSize { name: String, size: usize, max: usize } = Error "event-size"
        "the arguments of `{name}` take {size} bytes", "use smaller types or fewer arguments; an event has room for \
            {max} bytes";
    EventType { name: String, group: String } = Error "event-type"
        "`{name}` is not a valid type for an event in the group `{group}`", "use `summary` only in the groups \
            `arming_check` and `health`, and `append_health_and_arming_messages` only in other groups";
    UnknownEventType { name: String } = Error "unknown-event-type"
        "unknown type `{name}`", "write a type such as `uint8_t` or `float`, or the name of an enum";
    EventArguments { name: String, expected: String } = Error "event-arguments"
        "the arguments of `{name}` differ from those that its group and type require", "start with the arguments \
            {expected}: `chunk_idx` and `health_component_index` have the type `uint8_t`, `mode` has `uint32_t`, and \
            the others are bit fields";

    // Translation catalogues
    MalformedCatalogue { what: &'static str } = Error "malformed-catalogue"
        "{what}", "write each entry as `msgctxt`, `msgid` and `msgstr`, each followed by strings in quotes";
    CatalogueHeader = Error "catalogue-header"
        "the catalogue has no header",
        "add a first entry with an empty `msgid`; `translate LANGUAGE` writes one";
    CatalogueEncoding { charset: String } = Error "catalogue-encoding"
        "the header declares the charset `{charset}`",
        "save the file as UTF-8, and write `Content-Type: text/plain; charset=UTF-8`";
    CatalogueName { stem: String } = Error "catalogue-name"
        "`{stem}` is not a valid language tag for a translation",
        "name the file after its language in BCP 47 form, such as `uk.po` or `pt-BR.po`; definitions are in English";
    CatalogueLanguage { found: String, tag: String } = Error "catalogue-language"
        "the language is `{found}` in the header, but `{tag}` in the file name", "correct one of them";
    DuplicateCatalogue { tag: String } = Error "duplicate-catalogue"
        "duplicate catalogue for `{tag}`", "move its entries to the first catalogue; each language can have only one file";
    DuplicateTranslation { key: String } = Error "duplicate-translation"
        "duplicate entry for `{key}`", "remove one of them";
    UnknownTranslation { what: String } = Warning "unknown-translation"
        "{what} does not match any definition",
        "correct it, or run `translate` to mark the entry as obsolete";
    TranslationStale { key: String } = Warning "translation-stale"
        "`{key}` has changed since it was translated",
        "run `translate`, translate the new text, and remove the `fuzzy` flag; until then the translation \
            is not used";
    TranslationFuzzy { key: String } = Warning "translation-fuzzy"
        "the translation of `{key}` is marked as fuzzy", "review the translation, then remove the flag; \
            until then the translation is not used";
    TranslationMissing { tag: String, unit: String, missing: usize, all: usize, some: String } = Warning "translation-missing"
        "{missing} of {all} texts of `{unit}` are not translated into `{tag}`: {some}",
        "run `translate` to add missing entries, and translate them; until then the texts are \
            shown in English";
}
