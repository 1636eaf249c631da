//! Rules at a terminal.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use uavspec_codegen::report::rule_url;

use super::{checked_by, dispute};
use crate::matrix::Row;
use crate::model::Rule;
use crate::rules::RULES;

/// All rules, with what lays them down.
pub(crate) fn list() -> String {
    let mut text = String::new();
    for rule in RULES {
        // Writing to a string can't fail.
        let _ = writeln!(text, "{:<18} {:<7} {}", rule.id, rule.level, rule.statement);
        let _ = writeln!(text, "                           by {}", rule.source);
    }
    text
}

/// All that is to be said of a rule.
pub(crate) fn rule(rule: &Rule) -> String {
    let mut text = format!("{}  {}, {}\n\n{}\n\n", rule.id, rule.level, rule.status, rule.statement);
    let mut line = |label: &str, value: &str| {
        let _ = writeln!(text, "{label:<12} {value}");
    };
    if let Some(how) = dispute(rule) {
        line("disputed", how);
    }
    line("laid down by", rule.source);
    line("applies to", rule.applies_to);
    line("checked", checked_by(rule));
    for (at, mutant) in super::mutants_of(rule).enumerate() {
        let also = if mutant.also.is_empty() {
            String::new()
        } else {
            format!(" (breaks {} too)", list_ids(&mutant.also))
        };
        line(if at == 0 { "has to find" } else { "" }, &format!("{}{also}", mutant.name));
    }
    line("page", &rule_url(rule.id));
    text
}

/// What each rule found: a line for each mutant, a column for each rule.
pub(crate) fn matrix(rows: &[Row]) -> String {
    let mut text = String::new();
    for (at, rule) in RULES.iter().enumerate() {
        let _ = writeln!(text, "{:>3} {}", at + 1, rule.id);
    }
    let _ = writeln!(text);
    let numbers: String = (1..=RULES.len()).map(|number| format!("{number:>3}")).collect();
    let width = rows.iter().map(|row| row.title.chars().count()).max().unwrap_or_default();
    let _ = writeln!(text, "{:<18} {:<width$}{numbers}", "rule", "what is changed");
    for row in rows {
        let _ = writeln!(text, "{:<18} {:<width$}{}", row.rule.id, row.title, marks(row));
    }
    let wrong = rows.iter().filter(|row| !row.is_right()).count();
    let _ = writeln!(
        text,
        "\n● found, as it has to be · ○ found too, as it can't but be · ! wrong · - the definitions have nothing to \
         change so\n{} changes, {wrong} of them not found as they should be",
        rows.len()
    );
    text
}

fn marks(row: &Row) -> String {
    let Some(violated) = &row.violated else { return "  -".to_owned() };
    let expected: BTreeSet<&str> = row.expected();
    let mark = |rule: &&'static Rule| match (violated.contains(rule.id), expected.contains(rule.id)) {
        (true, true) if rule.id == row.rule.id => "  ●",
        (true, true) => "  ○",
        (false, false) => "  ·",
        (true, false) | (false, true) => "  !",
    };
    RULES.iter().map(mark).collect()
}

fn list_ids(rules: &[&Rule]) -> String {
    rules.iter().map(|rule| rule.id).collect::<Vec<_>>().join(", ")
}
