//! `severity-bits`: codes as grave as their texts say.

use uavspec_runtime::Severity;

use super::rule::{Check, Levels, Rule, Sink};
use crate::diagnostic::Level;
use crate::example::Example;
use crate::schema::{ErrorCode, Package};
use crate::source::SourceMap;

pub(super) const RULE: Rule = Rule {
    id: "severity-bits",
    purpose: "Bits 6 and 7 of an error code say how grave it is, in the ranges of vendors too. Where the table \
              or the description says otherwise, receivers that go by the bits stop a flight for a warning, or \
              show a failure as a hint.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "winch.md",
        text: "# Winch (codes 512-767)\n\n| Code | Abbr | Description |\n\
               |-----:|------|-------------|\n| 576 | ROPE | Fatal: the rope is torn. |\n",
    },
    good: Example {
        path: "winch.md",
        text: "# Winch (codes 512-767)\n\n| Code | Abbr | Description |\n\
               |-----:|------|-------------|\n| 704 | ROPE | Fatal: the rope is torn. |\n",
    },
    measured: None,
    check: Check::ErrorCodes(check),
};

/// Words for severities, in lower case and the singular.
const WORDS: &[(&str, Severity)] = &[
    ("info", Severity::Informational),
    ("information", Severity::Informational),
    ("informational", Severity::Informational),
    ("notice", Severity::Informational),
    ("warn", Severity::Warning),
    ("warning", Severity::Warning),
    ("error", Severity::Error),
    ("fatal", Severity::Fatal),
    ("fatal error", Severity::Fatal),
    ("critical", Severity::Fatal),
    ("critical error", Severity::Fatal),
];

/// Parts of abbreviations that can't mean anything else: many codes of any severity tell of an `ERR`.
const MARKS: &[(&str, Severity)] = &[
    ("INFO", Severity::Informational),
    ("WARN", Severity::Warning),
    ("WARNING", Severity::Warning),
    ("FATAL", Severity::Fatal),
    ("CRIT", Severity::Fatal),
    ("CRITICAL", Severity::Fatal),
];

/// From here on no range of codes belongs to one severity.
const FIRST_OF_VENDORS: u32 = 256;

fn check(package: &Package, _: &SourceMap, sink: &mut Sink<'_>) {
    for table in &package.error_tables {
        let of_table = of_title(&table.title);
        for code in table.codes.iter().filter(|code| code.code >= FIRST_OF_VENDORS) {
            let stated = of_description(&code.description).or_else(|| of_abbreviation(code)).or(of_table);
            if let Some(stated) = stated.filter(|stated| *stated != code.severity()) {
                let found = code.severity();
                sink.report(
                    code.span,
                    format!("code {} is called {stated}, its bits say {found}", code.code),
                    "move it to a code whose bits 6 and 7 say so, or correct the text",
                );
            }
        }
    }
}

/// `Warnings of the winch`: one severity, and nothing about error codes as such.
fn of_title(title: &str) -> Option<Severity> {
    let lower = title.to_lowercase().replace("error code", "code");
    let words = lower.split(|c: char| !c.is_alphanumeric()).map(|word| word.trim_end_matches('s'));
    let mut found = None;
    for severity in words.filter_map(|word| of_word(word, WORDS)) {
        match found {
            // A fatal error is one severity in two words.
            Some(Severity::Fatal) if severity == Severity::Error => {}
            Some(other) if other != severity => return None,
            _ => found = Some(severity),
        }
    }
    found
}

fn of_abbreviation(code: &ErrorCode) -> Option<Severity> {
    let mut words = code.abbreviation.as_deref()?.split(|c: char| !c.is_alphanumeric());
    words.find_map(|word| of_word(word, MARKS))
}

/// `Warning: …`, or `(warning) …`.
fn of_description(description: &str) -> Option<Severity> {
    let (head, _) = match description.strip_prefix('(') {
        Some(rest) => rest.split_once(')')?,
        None => description.split_once(':')?,
    };
    of_word(&head.to_lowercase(), WORDS)
}

fn of_word(word: &str, words: &[(&str, Severity)]) -> Option<Severity> {
    words.iter().find(|(known, _)| *known == word).map(|(_, severity)| *severity)
}
