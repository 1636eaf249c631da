//! Cases of error codes and of lists of them.
//!
//! Any integer of 32 bits is a code: a UAV may send what a later version of the specification defines.
//! So a case that is valid may hold a code that no table has, and its class and severity count.

use std::collections::BTreeMap;

use uavspec_runtime::{ErrorClass, Severity};

use super::case::Case;
use super::print::quote;
use crate::schema::Package;

/// The ids of rules on error codes.
mod rule {
    /// Codes are integers, 0 or more.
    pub(super) const CODE: &str = "FW-ERR-01";
    /// 0 isn't listed.
    pub(super) const ZERO: &str = "FW-ERR-02";
    /// Alternatives don't stand together.
    pub(super) const ALTERNATIVES: &str = "FW-ERR-07";
    /// Error codes come in a list.
    pub(super) const LIST: &str = "FW-UST-ERRORS";
}

/// Cases of a single code: all that the tables have, and the ends of each class.
pub(super) fn codes(package: &Package) -> Vec<Case> {
    let mut known: BTreeMap<u32, String> = BTreeMap::new();
    for class in ErrorClass::ALL {
        for code in [class.codes().start(), class.codes().end()] {
            known.insert(*code, format!("an end of class \"{}\", in no table", class.name()));
        }
    }
    for code in package.error_tables.iter().flat_map(|table| &table.codes) {
        known.insert(code.code, code.abbreviation.clone().unwrap_or_else(|| code.class.name().to_owned()));
    }
    let valid = known.into_iter().map(|(code, description)| Case {
        class: Some((ErrorClass::of(code).name(), Severity::of(code).name())),
        ..case(format!("code-{code}"), &description, code.to_string(), None)
    });
    valid.chain(misshapen("66")).collect()
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
        case("empty", "nothing to report", "[]".to_owned(), None),
        case("one", "one code", format!("[{one}]"), None),
        case("many", "all codes of the tables but alternatives of others", listed(together.collect()), None),
        Case {
            schema_verdict: Some(true),
            ..case("zero", "no error, listed as one", "[0]".to_owned(), Some(rule::ZERO))
        },
        case("null", "null instead of a list", "null".to_owned(), Some(rule::LIST)),
        case("single", "a code instead of a list", one.clone(), Some(rule::LIST)),
        case("object", "an object instead of a list", "{}".to_owned(), Some(rule::LIST)),
    ];
    for code in codes() {
        for other in code.alternatives.iter().filter(|other| **other > code.code) {
            let id = format!("alternatives-{}-{other}", code.code);
            let json = format!("[{},{other}]", code.code);
            let broken = case(id, "two codes of which one is enough", json, Some(rule::ALTERNATIVES));
            cases.push(Case { schema_verdict: Some(true), ..broken });
        }
    }
    cases.extend(misshapen(&one).map(|case| Case {
        id: format!("item-{}", case.id),
        description: format!("its only item is {}", case.description),
        json: case.json.map(|json| format!("[{json}]")),
        ..case
    }));
    cases
}

/// What is no code.
fn misshapen(code: &str) -> impl Iterator<Item = Case> {
    let above = (u64::from(u32::MAX) + 1).to_string();
    let text = quote(code);
    [
        ("below", "a number below zero", "-1".to_owned()),
        ("above", "a number of more than 32 bits", above),
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
