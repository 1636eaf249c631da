//! Error codes of UAVs.

use uavspec_runtime::{ErrorClass, Severity};
use uavspec_schema::{ErrorCode as Defined, Schema};

use super::answer::{Code, ErrorCode};

/// Explains a code, whether or not it has a definition.
pub(super) fn numbered(schema: &Schema, code: u32) -> ErrorCode {
    let defined = all(schema).find(|defined| defined.code == code);
    defined.map_or_else(|| undefined(code), |defined| explain(schema, defined))
}

/// Explains the codes that have an abbreviation: one code for each severity. Ignores case.
pub(super) fn abbreviated(schema: &Schema, word: &str) -> Vec<ErrorCode> {
    let is_meant = |defined: &&Defined| {
        defined.abbreviation.as_ref().is_some_and(|abbreviation| abbreviation.eq_ignore_ascii_case(word))
    };
    all(schema).filter(is_meant).map(|defined| explain(schema, defined)).collect()
}

/// All codes of the definitions.
pub(super) fn all(schema: &Schema) -> impl Iterator<Item = &Defined> {
    schema.packages.iter().flat_map(|package| &package.error_tables).flat_map(|table| &table.codes)
}

fn explain(schema: &Schema, defined: &Defined) -> ErrorCode {
    let related = |codes: &[u32]| -> Vec<Code> {
        let find = |code: &u32| all(schema).find(|other| other.code == *code);
        let related = codes.iter().filter_map(find);
        related.map(|other| Code { code: other.code, description: other.description.clone() }).collect()
    };
    // The description mentions the alternatives as well.
    let is_other = |code: &&u32| !defined.alternatives.contains(code);
    let others: Vec<u32> = defined.see_also.iter().filter(is_other).copied().collect();
    ErrorCode {
        code: defined.code,
        abbreviation: defined.abbreviation.clone(),
        class: defined.class.name(),
        severity: defined.severity().name(),
        description: Some(defined.description.clone()),
        alternatives: related(&defined.alternatives),
        see_also: related(&others),
        since: defined.since.clone(),
    }
}

fn undefined(code: u32) -> ErrorCode {
    ErrorCode {
        code,
        abbreviation: None,
        class: ErrorClass::of(code).name(),
        severity: Severity::of(code).name(),
        description: None,
        alternatives: Vec::new(),
        see_also: Vec::new(),
        since: None,
    }
}
