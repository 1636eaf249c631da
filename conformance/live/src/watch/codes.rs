//! The meanings of error codes.

use std::collections::BTreeMap;

use uavspec_rules::definitions::Definitions;
use uavspec_runtime::Severity;

/// An error code of the definitions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Code {
    /// The abbreviation for small displays.
    pub abbreviation: Option<String>,
    /// The meaning.
    pub meaning: String,
}

/// The error codes of the definitions.
#[derive(Clone, Debug, Default)]
pub struct Codes(BTreeMap<u32, Code>);

impl Codes {
    /// Collects the codes of all tables.
    pub fn new(definitions: &Definitions) -> Self {
        let tables = definitions.schema.packages.iter().flat_map(|package| &package.error_tables);
        let codes = tables.flat_map(|table| &table.codes).map(|code| {
            let known = Code { abbreviation: code.abbreviation.clone(), meaning: code.description.clone() };
            (code.code, known)
        });
        Self(codes.collect())
    }

    /// Looks up a code.
    pub(crate) fn get(&self, code: u32) -> Option<&Code> {
        self.0.get(&code)
    }

    /// The abbreviation of a code, or its number.
    pub(crate) fn short(&self, code: u32) -> String {
        let abbreviation = self.get(code).and_then(|known| known.abbreviation.clone());
        abbreviation.unwrap_or_else(|| code.to_string())
    }

    /// The number of a code, and its abbreviation if it has one.
    pub(crate) fn named(&self, code: u32) -> String {
        match self.get(code).and_then(|known| known.abbreviation.as_deref()) {
            Some(abbreviation) => format!("{code} {abbreviation}"),
            None => code.to_string(),
        }
    }

    /// The meaning of a code, or a note that it is unknown.
    pub(crate) fn meaning(&self, code: u32) -> &str {
        self.get(code).map_or("unknown code", |known| &known.meaning)
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
