//! Rule lists and rule pages for terminals, programs and the documentation.

pub mod pages;
mod text;

use serde::Serialize;
use serde_json::json;
use uavspec_lint::report::rule_url;
use uavspec_model::{Level, Rule, Status};
use uavspec_probe::self_test::Row;
use uavspec_rules::{Mutant, checked_by, mutants};
use uavspec_schema::json_text;

pub use self::pages::{CONTENTS, pages};
pub use self::text::{list as to_text, matrix as matrix_text, rule as rule_text};

/// A rule in JSON.
#[derive(Debug, Serialize, schemars::JsonSchema)]
#[schemars(rename = "Rule")]
pub(crate) struct Entry {
    /// The id.
    pub(crate) id: &'static str,
    /// The level.
    level: Level,
    /// The status of the requirement in the specification.
    status: String,
    /// The reason why the requirement is disputed.
    #[serde(skip_serializing_if = "Option::is_none")]
    dispute: Option<&'static str>,
    /// The requirement.
    statement: &'static str,
    /// The part of the specification that states it.
    source: &'static str,
    /// The messages that the rule applies to.
    applies_to: &'static str,
    /// The consequence of a violation.
    why: &'static str,
    /// A violation.
    example: &'static str,
    /// The way to conform.
    fix: &'static str,
    /// The way in which uavspec checks the rule.
    checked_by: &'static str,
    /// The bugs that the self-test inserts.
    mutants: Vec<&'static str>,
    /// The page about the rule; absent if the documentation site is not published.
    #[serde(skip_serializing_if = "String::is_empty")]
    url: String,
}

/// Formats rules as a JSON list.
pub fn to_json(rules: &[&'static Rule]) -> String {
    json_text::pretty(&rules.iter().map(|rule| entry(rule)).collect::<Vec<_>>())
}

/// A rule in JSON.
pub(crate) fn entry(rule: &'static Rule) -> Entry {
    Entry {
        id: rule.id,
        level: rule.level,
        status: rule.status.to_string(),
        dispute: dispute(rule),
        statement: rule.statement,
        source: rule.source,
        applies_to: rule.applies_to,
        why: rule.why,
        example: rule.example,
        fix: rule.fix,
        checked_by: checked_by(rule),
        mutants: mutants_of(rule).map(|mutant| mutant.name).collect(),
        url: rule_url(rule.id),
    }
}

/// Formats the matrix as a JSON list.
pub fn matrix_json(rows: &[Row]) -> String {
    let entry = |row: &Row| {
        let Row { rule, title, violated, .. } = row;
        json!({ "rule": rule.id, "mutant": title, "violated": violated, "expected": row.expected() })
    };
    json_text::pretty(&rows.iter().map(entry).collect::<Vec<_>>())
}

/// The contradiction in the specification, for a disputed rule.
pub(crate) fn dispute(rule: &Rule) -> Option<&'static str> {
    match rule.status {
        Status::Disputed(contradiction) | Status::DisputedCases(contradiction) => Some(contradiction),
        Status::Normative | Status::Advisory => None,
    }
}

/// The mutants of a rule.
fn mutants_of(rule: &Rule) -> impl Iterator<Item = Mutant> {
    mutants().filter(move |mutant| mutant.rule.id == rule.id)
}
