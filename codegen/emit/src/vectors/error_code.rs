//! Test cases for error codes and for lists of error codes.
//!
//! Every 32-bit integer is a valid code, because later versions of a specification may define it. A valid case may
//! therefore contain an unlisted code. The class and severity of an unlisted code are also defined.

use std::collections::BTreeMap;

use uavspec_runtime::{ErrorClass, Severity};
use uavspec_schema::Package;

use super::case::Case;
use super::print::quote;

/// Ids of rules about error codes.
mod rule {
    /// Codes are nonnegative integers.
    pub(super) const CODE: &str = "FW-ERR-01";
    /// A list doesn't contain 0.
    pub(super) const ZERO: &str = "FW-ERR-02";
    /// A list doesn't contain a code and its alternative.
    pub(super) const ALTERNATIVES: &str = "FW-ERR-07";
    /// Error codes are in a list.
    pub(super) const LIST: &str = "FW-UST-ERRORS";
}

/// Test cases for single codes: all listed codes, and the first and last code of each class.
pub(super) fn codes(package: &Package) -> Vec<Case> {
    let mut known: BTreeMap<u32, String> = BTreeMap::new();
    for class in ErrorClass::ALL {
        for code in [class.codes().start(), class.codes().end()] {
            known
                .insert(*code, format!("an unlisted code at the start or end of class \"{}\"", class.name()));
        }
    }
    for code in package.error_tables.iter().flat_map(|table| &table.codes) {
        known.insert(code.code, code.abbreviation.clone().unwrap_or_else(|| code.class.name().to_owned()));
    }
    let valid = known.into_iter().map(|(code, description)| Case {
        class: Some((ErrorClass::of(code).name(), Severity::of(code).name())),
        ..case(format!("code-{code}"), &description, code.to_string(), None)
    });
    valid.chain(malformed("66")).collect()
}

/// Cases of a list of codes.
pub(super) fn lists(package: &Package) -> Vec<Case> {
    let codes = || package.error_tables.iter().flat_map(|table| &table.codes).filter(|code| code.code != 0);
    let one = codes().next().map_or(1, |code| code.code).to_string();
    let listed = |codes: Vec<String>| format!("[{}]", codes.join(","));
    let together = codes()
        .filter(|code| code.alternatives.iter().all(|other| *other > code.code))
        .map(|code| code.code.to_string());
    let mut cases = vec![
        case("empty", "no errors", "[]".to_owned(), None),
        case("one", "one code", format!("[{one}]"), None),
        case("many", "all listed codes, one per set of alternatives", listed(together.collect()), None),
        Case {
            schema_verdict: Some(true),
            ..case("zero", "a list that contains 0, which means no error", "[0]".to_owned(), Some(rule::ZERO))
        },
        case("null", "null instead of a list", "null".to_owned(), Some(rule::LIST)),
        case("single", "a code instead of a list", one.clone(), Some(rule::LIST)),
        case("object", "an object instead of a list", "{}".to_owned(), Some(rule::LIST)),
    ];
    for code in codes() {
        for other in code.alternatives.iter().filter(|other| **other > code.code) {
            let id = format!("alternatives-{}-{other}", code.code);
            let json = format!("[{},{other}]", code.code);
            let invalid = case(id, "a code together with its alternative", json, Some(rule::ALTERNATIVES));
            cases.push(Case { schema_verdict: Some(true), ..invalid });
        }
    }
    cases.extend(malformed(&one).map(|case| Case {
        id: format!("item-{}", case.id),
        description: format!("a list whose only item is {}", case.description),
        json: case.json.map(|json| format!("[{json}]")),
        ..case
    }));
    cases
}

/// Values that aren't codes.
fn malformed(code: &str) -> impl Iterator<Item = Case> {
    let above = (u64::from(u32::MAX) + 1).to_string();
    let text = quote(code);
    [
        ("below", "a negative number", "-1".to_owned()),
        ("above", "a number that exceeds 32 bits", above),
        ("fraction", "a fraction", "0.5".to_owned()),
        ("string", "a string of digits", text),
        ("boolean", "a boolean", "true".to_owned()),
        ("null", "null", "null".to_owned()),
        ("object", "an object", "{}".to_owned()),
    ]
    .into_iter()
    .map(|(id, description, json)| case(id, description, json, Some(rule::CODE)))
}

fn case(id: impl Into<String>, description: &str, json: String, rule: Option<&'static str>) -> Case {
    Case {
        id: id.into(),
        description: description.to_owned(),
        rule,
        json: Some(json),
        schema_verdict: Some(rule.is_none()),
        ..Case::default()
    }
}
