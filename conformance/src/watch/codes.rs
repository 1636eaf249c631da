//! What error codes mean.

use std::collections::BTreeMap;

use uavspec_runtime::Severity;

use crate::definitions::Definitions;

/// A code that the definitions have.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Code {
    /// What displays show that are short of room.
    pub abbreviation: Option<String>,
    /// What it means.
    pub meaning: String,
}

/// The error codes of some definitions.
#[derive(Clone, Debug, Default)]
pub(crate) struct Codes(BTreeMap<u32, Code>);

impl Codes {
    /// The codes of all tables.
    pub(crate) fn new(definitions: &Definitions) -> Self {
        let tables = definitions.schema.packages.iter().flat_map(|package| &package.error_tables);
        let codes = tables.flat_map(|table| &table.codes).map(|code| {
            let known = Code { abbreviation: code.abbreviation.clone(), meaning: code.description.clone() };
            (code.code, known)
        });
        Self(codes.collect())
    }

    /// What is known of a code.
    pub(crate) fn get(&self, code: u32) -> Option<&Code> {
        self.0.get(&code)
    }

    /// The shortest that says which code it is: its abbreviation, or its number.
    pub(crate) fn short(&self, code: u32) -> String {
        let abbreviation = self.get(code).and_then(|known| known.abbreviation.clone());
        abbreviation.unwrap_or_else(|| code.to_string())
    }

    /// Number and abbreviation.
    pub(crate) fn named(&self, code: u32) -> String {
        match self.get(code).and_then(|known| known.abbreviation.as_deref()) {
            Some(abbreviation) => format!("{code} {abbreviation}"),
            None => code.to_string(),
        }
    }

    /// What it means, also where nobody knows.
    pub(crate) fn meaning(&self, code: u32) -> &str {
        self.get(code).map_or("the definitions don't have it", |known| &known.meaning)
    }
}

/// A severity in a word of at most seven letters.
pub(super) fn severity_name(severity: Severity) -> &'static str {
    match severity {
        Severity::Informational => "info",
        other => other.name(),
    }
}

/// A severity in a letter.
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
    fn the_definitions_say_what_codes_mean() {
        let codes = Codes::new(&Definitions::built_in());
        assert_eq!(codes.named(66), "66 LOWBAT");
        assert_eq!(codes.short(1), "GROUND");
        assert!(codes.meaning(199).len() > 10);
        assert_eq!((codes.named(12).as_str(), codes.short(40_000).as_str()), ("12", "40000"));
        assert!(codes.meaning(12).contains("don't have it"));
    }
}
