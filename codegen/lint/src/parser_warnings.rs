//! The warnings of the parser that have no automatic fix, as rules. The parser finds the violations.

use super::prelude::*;

/// The defaults of the rules in this module.
const WARNING: Rule = Rule {
    id: "",
    statement: "",
    why: "",
    fix: "",
    levels: Levels::both(Level::Warning),
    bad: glider![],
    good: glider![],
    measured: Some(Measured { findings: 0, sample: 0, right: 0 }),
    check: Check::Reader(no_fix),
};

/// The defaults of rules that don't apply to PX4's definitions.
const UNMEASURED: Rule = Rule { measured: None, ..WARNING };

pub(super) const ANNOTATION_VALUE_TYPE: Rule = Rule {
    id: "annotation-value-type",
    statement: "An annotation with a value that the type of the field can't represent.",
    why: "The value can't occur; for example, an integer is never NaN. Checks that rely on the annotation have no \
        effect.",
    fix: "Use a value of the field's type, or change the type.",
    bad: glider!["uint8 crew  # [-] [@invalid NaN] People on board"],
    good: glider!["uint8 crew  # [-] [@invalid 255] People on board"],
    ..WARNING
};

pub(super) const ENUM_ON_NON_INTEGER: Rule = Rule {
    id: "enum-on-non-integer",
    statement: "An enum annotation on a field or constant that isn't an integer.",
    why: "The annotation has no effect, so values are not checked and have no names.",
    fix: "Use an integer type for the field and the constants.",
    bad: glider![
        "uint8 GEAR_UP = 0    # Retracted",
        "uint8 GEAR_DOWN = 1  # Extended",
        "",
        "float32 gear  # [@enum GEAR] Landing gear"
    ],
    good: glider![
        "uint8 GEAR_UP = 0    # Retracted",
        "uint8 GEAR_DOWN = 1  # Extended",
        "",
        "uint8 gear  # [@enum GEAR] Landing gear"
    ],
    ..WARNING
};

pub(super) const ENUM_VALUE_OUT_OF_RANGE: Rule = Rule {
    id: "enum-value-out-of-range",
    statement: "An enum constant whose value doesn't fit into the field.",
    why: "The value is truncated when it is assigned, and readers see a different value.",
    fix: "Use a wider type for the field, or a smaller value.",
    bad: glider![
        "uint16 GEAR_UP = 0      # Retracted",
        "uint16 GEAR_DOWN = 256  # Extended",
        "",
        "uint8 gear  # [@enum GEAR] Landing gear"
    ],
    good: glider![
        "uint16 GEAR_UP = 0      # Retracted",
        "uint16 GEAR_DOWN = 256  # Extended",
        "",
        "uint16 gear  # [@enum GEAR] Landing gear"
    ],
    ..WARNING
};

pub(super) const EVENT_BIT: Rule = Rule {
    id: "event-bit",
    statement: "An entry of a bit field in event metadata that isn't a single bit.",
    why: "Readers look up each bit of a value, so they never show the entry.",
    fix: "Use a power of two, or remove `is_bitfield` if the values aren't bits.",
    bad: winch_events![
        " \"enums\": {\"end_t\": {\"type\": \"uint8_t\", \"is_bitfield\": true, \"entries\": {",
        "  \"3\": {\"name\": \"both\", \"description\": \"Both ends\"}}}}"
    ],
    good: winch_events![
        " \"enums\": {\"end_t\": {\"type\": \"uint8_t\", \"is_bitfield\": true, \"entries\": {",
        "  \"4\": {\"name\": \"both\", \"description\": \"Both ends\"}}}}"
    ],
    ..UNMEASURED
};

pub(super) const EVENT_ID: Rule = Rule {
    id: "event-id",
    statement: "An event whose id isn't the hash of its name.",
    why: "PX4 computes the id of an event from its name. The firmware sends an id that the metadata doesn't contain, \
        so no reader finds the text.",
    fix: "Use the lower 24 bits of the FNV-1a hash of the name. Only the component `common` numbers its events.",
    bad: winch_events![
        " \"event_groups\": {\"default\": {\"events\": {",
        "  \"12\": {\"name\": \"rope_torn\", \"message\": \"Rope torn\"}}}}"
    ],
    good: winch_events![
        " \"event_groups\": {\"default\": {\"events\": {",
        "  \"6674671\": {\"name\": \"rope_torn\", \"message\": \"Rope torn\"}}}}"
    ],
    ..UNMEASURED
};

pub(super) const EVENT_VERSION: Rule = Rule {
    id: "event-version",
    statement: "Event metadata of an unknown version.",
    why: "The file may contain more than uavspec reads.",
    fix: "Use version 2, or a newer version of uavspec.",
    bad: winch_events![version 3:
        " \"event_groups\": {\"default\": {\"events\": {",
        "  \"6674671\": {\"name\": \"rope_torn\", \"message\": \"Rope torn\"}}}}"
    ],
    good: winch_events![version 2:
        " \"event_groups\": {\"default\": {\"events\": {",
        "  \"6674671\": {\"name\": \"rope_torn\", \"message\": \"Rope torn\"}}}}"
    ],
    ..UNMEASURED
};

pub(super) const INVISIBLE_CHARACTER: Rule = Rule {
    id: "invisible-character",
    statement: "A zero-width character, or a character that changes the text direction.",
    why: "A name or number may look different from the text that tools read, and searches may not find it.",
    fix: "Remove the character.",
    bad: glider!["float32 sink  # [m/s] Sink\u{200b} rate"],
    good: glider!["float32 sink  # [m/s] Sink rate"],
    ..WARNING
};

pub(super) const MALFORMED_ANNOTATION: Rule = Rule {
    id: "malformed-annotation",
    statement: "An annotation with invalid arguments.",
    why: "The annotation is treated as text, so the value is not checked.",
    fix: "Write the arguments that the annotation expects.",
    bad: glider!["float32 sink  # [m/s] [@range 0 to 10] Sink rate"],
    good: glider!["float32 sink  # [m/s] [@range 0, 10] Sink rate"],
    ..WARNING
};

pub(super) const MESSAGE_NAME_STYLE: Rule = Rule {
    id: "message-name-style",
    statement: "A message file whose name is not in PascalCase.",
    why: "Tools derive the topic and type names from the file name, and ROS 2 rejects names that are not in \
        PascalCase.",
    fix: "Rename the file.",
    bad: Example {
        path: "glider_state.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n",
    },
    good: Example {
        path: "GliderState.msg",
        text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n",
    },
    ..WARNING
};

pub(super) const MISPLACED_ANNOTATION: Rule = Rule {
    id: "misplaced-annotation",
    statement: "An annotation that doesn't apply to the type of the value.",
    why: "The annotation has no effect, so the value is not checked. Units and ranges apply only to numbers. \
        Patterns and formats apply only to strings. Lengths apply only to strings and lists.",
    fix: "Use an annotation that applies to this type.",
    bad: winch![fields: "| name | yes | string | [@range 1, 8] Its name |"],
    good: winch![fields: "| name | yes | string | [@length 1, 8] Its name |"],
    ..UNMEASURED
};

pub(super) const MISSING_ABBREVIATION: Rule = Rule {
    id: "missing-abbreviation",
    statement: "An error code without an abbreviation.",
    why: "User interfaces show the abbreviation if there is little space. Without an abbreviation, they show the \
        number.",
    fix: "Add an abbreviation, or `-` if the code should have none.",
    bad: winch![codes: "| 64 | | The rope is worn. |"],
    good: winch![codes: "| 64 | ROPE | The rope is worn. |"],
    ..UNMEASURED
};

pub(super) const MISSING_ANSWER: Rule = Rule {
    id: "missing-answer",
    statement: "A request type without a response.",
    why: "Clients don't know what to expect. A response has the type of the request, or one of the types in the \
        `Answer:` line under the `Request` heading.",
    fix: "Add a `Response` section, or an `Answer:` line with the types of the answers.",
    bad: Example {
        path: "winch.md",
        text: "# Winch\n\n## ROPE-CUT\n\n### Request\n\nNo fields besides `type`.\n",
    },
    good: Example {
        path: "winch.md",
        text: "# Winch\n\n## ROPE-CUT\n\n### Request\n\nNo fields besides `type`.\n\nAnswer: ROPE-INF\n\n\
               ## ROPE-INF\n\n### Response\n\nNo fields besides `type`.\n",
    },
    ..UNMEASURED
};

pub(super) const NAME_STYLE: Rule = Rule {
    id: "name-style",
    statement: "A field that is not in lower_snake_case, or a constant that is not in UPPER_SNAKE_CASE.",
    why: "ROS 2 rejects names in other styles, and also names that contain `__` or end with `_`. A message with such \
        a name can't be bridged to ROS 2.",
    fix: "Rename the field or the constant.",
    bad: glider!["float32 sinkRate  # [m/s] Sink rate"],
    good: glider!["float32 sink_rate  # [m/s] Sink rate"],
    ..WARNING
};

pub(super) const NEAR_TYPE_TABLE: Rule = Rule {
    id: "near-type-table",
    statement: "A table whose columns are similar to the columns of a type table.",
    why: "If a column is missing or misspelt, the table is treated as text and defines no fields.",
    fix: "Correct the columns: `Field`, `Required`, `Type`, `Description`.",
    bad: Example {
        path: "winch.md",
        text: "# Winch\n\n## Rope\n\n| Field | Requried | Type |\n\
               |-------|----------|------|\n| name | yes | string |\n",
    },
    good: winch![fields: "| name | yes | string | Its name |"],
    ..UNMEASURED
};

pub(super) const ONE_SIDED_ALTERNATIVE: Rule = Rule {
    id: "one-sided-alternative",
    statement: "An error code that lists an alternative, but is not listed by that alternative.",
    why: "Only one of the two codes may be reported for an event. A developer who reads only the \
        alternative's description may report both codes.",
    fix: "Mention each code in the description of the other.",
    bad: winch![codes:
        "| 64 | ROPE | The rope is worn. Use this code only if it holds; otherwise use code 65. |",
        "| 65 | ROPE2 | The rope is torn. |",
    ],
    good: winch![codes:
        "| 64 | ROPE | The rope is worn. Use this code only if it holds; otherwise use code 65. |",
        "| 65 | ROPE2 | The rope is torn. Use this code only if it doesn't hold; otherwise use code 64. |",
    ],
    ..UNMEASURED
};

pub(super) const TRANSLATION_FUZZY: Rule = Rule {
    id: "translation-fuzzy",
    statement: "A translation that is marked as fuzzy.",
    why: "The translation was guessed or made from a different text, so it is not used until a translator reviews it.",
    fix: "Review the translation, and remove the flag.",
    bad: Example {
        path: "uk.po",
        text: "msgid \"\"\nmsgstr \"\"\n\"Content-Type: text/plain; charset=UTF-8\\n\"\n\n\
               #, fuzzy\n#| msgid \"Speed of sinking\"\nmsgctxt \"demo/Glider.sink\"\nmsgid \"Sink rate\"\n\
               msgstr \"Швидкість опускання\"\n\n\
               msgctxt \"demo/Glider.timestamp\"\nmsgid \"Time since system start\"\nmsgstr \"Час від запуску системи\"\n\n\
               msgctxt \"demo/Glider\"\nmsgid \"State of a glider\"\nmsgstr \"Стан планера\"\n",
    },
    good: ukrainian![
        "demo/Glider.sink", "Sink rate", "Швидкість зниження";
        "demo/Glider.timestamp", "Time since system start", "Час від запуску системи";
        "demo/Glider", "State of a glider", "Стан планера";
    ],
    ..UNMEASURED
};

pub(super) const TRANSLATION_MISSING: Rule = Rule {
    id: "translation-missing",
    statement: "A missing translation in a partly translated message, service, action or list of error codes.",
    why: "The page mixes two languages. Items with no translations at all are shown in English and not reported.",
    fix: "Translate the remaining texts.",
    bad: ukrainian![
        "demo/Glider", "State of a glider", "Стан планера";
        "demo/Glider.timestamp", "Time since system start", "";
    ],
    good: ukrainian![
        "demo/Glider", "State of a glider", "Стан планера";
        "demo/Glider.timestamp", "Time since system start", "Час від запуску системи";
        "demo/Glider.sink", "Sink rate", "Швидкість зниження";
    ],
    ..UNMEASURED
};

pub(super) const TRANSLATION_STALE: Rule = Rule {
    id: "translation-stale",
    statement: "A translation whose English text has changed.",
    why: "The translation is not used, and the page shows the English text.",
    fix: "Run `translate`, which updates the text and keeps the old text for comparison. \
        Then update the translation.",
    bad: ukrainian![
        "demo/Glider", "State of a glider", "Стан планера";
        "demo/Glider.timestamp", "Time since start", "Час від запуску";
        "demo/Glider.sink", "Sink rate", "Швидкість зниження";
    ],
    good: ukrainian![
        "demo/Glider", "State of a glider", "Стан планера";
        "demo/Glider.timestamp", "Time since system start", "Час від запуску системи";
        "demo/Glider.sink", "Sink rate", "Швидкість зниження";
    ],
    ..UNMEASURED
};

pub(super) const UNKNOWN_ANNOTATION: Rule = Rule {
    id: "unknown-annotation",
    statement: "An annotation that doesn't exist.",
    why: "The annotation is treated as text and has no effect. PX4's own tool stops with an error.",
    fix: "Use an existing annotation, or write plain text.",
    bad: glider!["float32 sink  # [m/s] [@limits 0, 10] Sink rate"],
    good: glider!["float32 sink  # [m/s] [@range 0, 10] Sink rate"],
    ..WARNING
};

pub(super) const UNKNOWN_CONSTANT: Rule = Rule {
    id: "unknown-constant",
    statement: "An annotation that refers to an unknown constant.",
    why: "The annotation has no effect.",
    fix: "Use the name of a constant in the message, or a limit such as `UINT8_MAX`.",
    bad: glider!["uint8 crew  # [-] [@invalid CREW_UNKNOWN] People on board"],
    good: glider!["uint8 crew  # [-] [@invalid UINT8_MAX] People on board"],
    ..WARNING
};

pub(super) const UNKNOWN_ENUM: Rule = Rule {
    id: "unknown-enum",
    statement: "An enum prefix that matches no constant of the message.",
    why: "The field stays a plain number, and its values have no names.",
    fix: "Correct the prefix, or define the constants.",
    bad: glider![
        "uint8 GEAR_UP = 0    # Retracted",
        "uint8 GEAR_DOWN = 1  # Extended",
        "",
        "uint8 gear  # [@enum GEARS] Landing gear"
    ],
    good: glider![
        "uint8 GEAR_UP = 0    # Retracted",
        "uint8 GEAR_DOWN = 1  # Extended",
        "",
        "uint8 gear  # [@enum GEAR] Landing gear"
    ],
    measured: Some(Measured { findings: 2, sample: 2, right: 2 }),
    ..WARNING
};

pub(super) const UNKNOWN_MEMBER: Rule = Rule {
    id: "unknown-member",
    statement: "A member of event metadata that the format doesn't define.",
    why: "Readers ignore the member. Its name may be misspelt.",
    fix: "Correct the name, or remove the member.",
    bad: winch_events![
        " \"event_groups\": {\"default\": {\"events\": {",
        "  \"6674671\": {\"name\": \"rope_torn\", \"text\": \"Torn\", \"message\": \"Rope torn\"}}}}"
    ],
    good: winch_events![
        " \"event_groups\": {\"default\": {\"events\": {",
        "  \"6674671\": {\"name\": \"rope_torn\", \"description\": \"Torn\", \"message\": \"Rope torn\"}}}}"
    ],
    ..UNMEASURED
};

pub(super) const UNKNOWN_TRANSLATION: Rule = Rule {
    id: "unknown-translation",
    statement: "A translation of an unknown item.",
    why: "The translation is not used. The `msgctxt` is misspelt, or the item was removed.",
    fix: "Correct the `msgctxt`, or remove the entry. Valid forms are `px4/Wind`, `px4/Wind.speed`, \
        `px4/Wind::SPEED_LOW` and `flockwave/error-code/134`.",
    bad: ukrainian!["demo/Glider.sinking", "Sink rate", "Швидкість зниження"],
    good: ukrainian!["demo/Glider.sink", "Sink rate", "Швидкість зниження"],
    ..UNMEASURED
};

pub(super) const UNKNOWN_UNIT: Rule = Rule {
    id: "unknown-unit",
    statement: "A unit that is not in uavspec's list.",
    why: "Values in this unit can't be converted or compared, and the text may not be a unit at all.",
    fix: "Use a unit from the list.",
    bad: glider!["float32 sink  # [furlong/h] Sink rate"],
    good: glider!["float32 sink  # [m/s] Sink rate"],
    measured: Some(Measured { findings: 1, sample: 1, right: 1 }),
    ..WARNING
};
