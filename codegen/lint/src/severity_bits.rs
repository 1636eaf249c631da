//! `severity-bits`: an error code whose text contradicts its severity bits.

use uavspec_runtime::Severity;
use uavspec_schema::{ErrorCode, Package};

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "severity-bits",
    statement: "An error code whose text contradicts its severity bits.",
    why: "Bits 6 and 7 of a code encode its severity, even in vendor ranges. If the bits are wrong, receivers may \
        stop a flight for a warning, or show a failure as a hint.",
    fix: "Choose a number whose bits 6 and 7 match the severity, or correct the text.",
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
    check: Check::Package(check),
};

/// Words for severities, in lower case and singular.
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

/// Parts of abbreviations that clearly name a severity. `ERR` is omitted, because codes of any severity contain it.
const MARKS: &[(&str, Severity)] = &[
    ("INFO", Severity::Informational),
    ("WARN", Severity::Warning),
    ("WARNING", Severity::Warning),
    ("FATAL", Severity::Fatal),
    ("CRIT", Severity::Fatal),
    ("CRITICAL", Severity::Fatal),
];

/// The first code of the vendor ranges, which contain all severities.
const FIRST_OF_VENDORS: u32 = 256;

fn check(package: &Package, _: &SourceMap, sink: &mut Sink<'_>) {
    for table in &package.error_tables {
        let table_severity = title_severity(&table.title);
        for code in table.codes.iter().filter(|code| code.code >= FIRST_OF_VENDORS) {
            let stated = description_severity(&code.description)
                .or_else(|| abbreviation_severity(code))
                .or(table_severity);
            if let Some(stated) = stated.filter(|stated| *stated != code.severity()) {
                let found = code.severity();
                sink.report(
                    code.span,
                    format!("code {} is described as {stated}, but its bits mean {found}", code.code),
                    "choose a code whose bits 6 and 7 match the severity, or correct the text",
                );
            }
        }
    }
}

/// The severity in a title such as `Warnings of the winch`, if there is exactly one. `Error codes` doesn't count as a
/// severity.
fn title_severity(title: &str) -> Option<Severity> {
    let lower = title.to_lowercase().replace("error code", "code");
    let words = lower.split(|c: char| !c.is_alphanumeric()).map(|word| word.trim_end_matches('s'));
    let mut found = None;
    for severity in words.filter_map(|word| find_severity(word, WORDS)) {
        match found {
            // `Fatal error` is one severity.
            Some(Severity::Fatal) if severity == Severity::Error => {}
            Some(other) if other != severity => return None,
            _ => found = Some(severity),
        }
    }
    found
}

fn abbreviation_severity(code: &ErrorCode) -> Option<Severity> {
    let mut words = code.abbreviation.as_deref()?.split(|c: char| !c.is_alphanumeric());
    words.find_map(|word| find_severity(word, MARKS))
}

/// The severity at the start of a description: `Warning: …` or `(warning) …`.
fn description_severity(description: &str) -> Option<Severity> {
    let (head, _) = match description.strip_prefix('(') {
        Some(rest) => rest.split_once(')')?,
        None => description.split_once(':')?,
    };
    find_severity(&head.to_lowercase(), WORDS)
}

fn find_severity(word: &str, words: &[(&str, Severity)]) -> Option<Severity> {
    words.iter().find(|(known, _)| *known == word).map(|(_, severity)| *severity)
}
