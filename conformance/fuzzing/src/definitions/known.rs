//! Baselines of `lint` that follow their grammar.

use super::grammar::Table;

const RULES: &[&str] = &["\"unit-missing\"", "\"field-removed\"", "\"unit-mising\"", "\"\"", "[]"];

const SUBJECTS: &[&str] = &[
    "\"px4/Wind\"",
    "\"px4/*\"",
    "'px4/{Wind,Mark}.[a-z]?'",
    "\"[\"",
    "\"\\\\\"",
    "\"\"",
    "\"\\u202eé𝄞\"",
    "7",
];

const REASONS: &[&str] = &["\"old\"", "'''\nold\n[[known]]\n'''", "\" \"", "\"\"", "true"];

/// Entries with all keys, and without optional ones, which often have no mistakes.
pub(super) const TABLES: [Table; 4] = [
    (
        "[[known]]",
        &[
            ("rule", RULES),
            ("subject", SUBJECTS),
            ("count", &["1", "0", "-1", "99999999999999999999", "\"1\""]),
            ("reason", REASONS),
            ("link", &["\"https://hill.invalid\"", "\"\"", "7"]),
            ("expires", &["2027-06-30", "0000-01-01", "2027-06-30T00:00:00Z", "07:32:00", "\"2027-06-30\""]),
        ],
    ),
    ("[[known]]", &[("rule", RULES), ("subject", SUBJECTS), ("reason", REASONS)]),
    ("[[known]] # old", &[("subject", SUBJECTS), ("reason", REASONS), ("rule", RULES)]),
    ("[known]", &[("rule", RULES)]),
];
