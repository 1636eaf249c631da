//! The meanings of error codes.

use std::collections::BTreeMap;

use uavspec_rules::definitions::Definitions;
use uavspec_runtime::Severity;
use uavspec_schema::ErrorCode;

/// The error codes of the definitions.
#[derive(Clone, Debug, Default)]
pub struct Codes(BTreeMap<u32, ErrorCode>);

impl Codes {
    /// Collects the codes of all tables.
    pub fn new(definitions: &Definitions) -> Self {
        let tables = definitions.schema.packages.iter().flat_map(|package| &package.error_tables);
        Self(tables.flat_map(|table| &table.codes).map(|code| (code.code, code.clone())).collect())
    }

    fn abbreviation(&self, code: u32) -> Option<&str> {
        self.0.get(&code)?.abbreviation.as_deref()
    }

    /// The abbreviation of a code, or its number.
    pub(crate) fn short(&self, code: u32) -> String {
        self.abbreviation(code).map_or_else(|| code.to_string(), str::to_owned)
    }

    /// The number of a code, and its abbreviation if it has one.
    pub(crate) fn named(&self, code: u32) -> String {
        self.abbreviation(code).map_or_else(|| code.to_string(), |short| format!("{code} {short}"))
    }

    /// The meaning of a code, or a note that it is unknown.
    pub(crate) fn meaning(&self, code: u32) -> &str {
        self.0.get(&code).map_or("unknown code", |known| &known.description)
    }
}

/// The name of a severity, at most seven letters long.
pub(super) fn severity_name(severity: Severity) -> &'static str {
    match severity {
        Severity::Informational => "info",
        other => other.name(),
    }
}

/// A letter for a severity.
pub(super) fn severity_letter(severity: Severity) -> &'static str {
    match severity {
        Severity::Fatal => "F",
        Severity::Error => "E",
        Severity::Warning => "W",
        Severity::Informational => "i",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_have_the_meanings_of_the_definitions() {
        let codes = Codes::new(&Definitions::built_in());
        assert_eq!(codes.named(66), "66 LOWBAT");
        assert_eq!(codes.short(1), "GROUND");
        assert!(codes.meaning(199).len() > 10);
        assert_eq!((codes.named(12).as_str(), codes.short(40_000).as_str()), ("12", "40000"));
        assert_eq!(codes.meaning(12), "unknown code");
    }
}
