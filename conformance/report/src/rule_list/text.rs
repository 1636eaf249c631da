//! Rules in a terminal.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use uavspec_lint::report::rule_url;
use uavspec_model::Rule;
use uavspec_model::text::wrapped;
use uavspec_probe::self_test::Row;
use uavspec_rules::{Mutant, RULES};

use super::dispute;

/// Lists all rules with their sources.
pub fn list() -> String {
    let mut text = String::new();
    for rule in RULES {
        // Writing to a string can't fail.
        let _ = writeln!(text, "{:<18} {:<7} {}", rule.id, rule.level, rule.statement);
        let _ = writeln!(text, "                           source: {}", rule.source);
    }
    text
}

/// Explains one rule.
pub fn rule(rule: &Rule) -> String {
    let mut text = format!("{}  {}, {}\n\n", rule.id, rule.level, rule.status);
    text += &paragraph("", rule.statement);
    text.push('\n');
    let facts = [
        ("Disputed:", dispute(rule)),
        ("Applies to:", Some(rule.applies_to)),
        ("Source:", Some(rule.source)),
    ];
    for (label, fact) in facts {
        text += &fact.map_or_else(String::new, |fact| paragraph(&format!("{label:<13}"), fact));
    }
    let sections = [
        ("Why it matters", paragraph("  ", rule.why)),
        ("Example", rule.example.lines().map(|line| format!("  {line}\n")).collect()),
        ("How to fix", paragraph("  ", rule.fix)),
        ("What the rule finds", super::mutants_of(rule).map(|mutant| mutant_text(&mutant)).collect()),
    ];
    for (title, section) in sections.iter().filter(|(_, section)| !section.is_empty()) {
        let _ = write!(text, "\n{title}\n{section}");
    }
    let url = rule_url(rule.id);
    if !url.is_empty() {
        let _ = writeln!(text, "\n{url}");
    }
    text
}

fn mutant_text(mutant: &Mutant) -> String {
    let also = if mutant.also.is_empty() {
        String::new()
    } else {
        format!(" (also violates {})", list_ids(&mutant.also))
    };
    paragraph("  - ", &format!("{}{also}", mutant.name))
}

/// Wraps a text that starts after `first`. All other lines are indented like the first one.
fn paragraph(first: &str, text: &str) -> String {
    let words: Vec<&str> = text.split_whitespace().collect();
    let indent = first.chars().count();
    if words.is_empty() {
        return String::new();
    }
    format!("{first}{}\n", wrapped(&words.join(" "), indent, indent))
}

/// Formats the matrix: one line for each mutant, one column for each rule.
pub fn matrix(rows: &[Row]) -> String {
    let mut text = String::new();
    for (at, rule) in RULES.iter().enumerate() {
        let _ = writeln!(text, "{:>3} {}", at + 1, rule.id);
    }
    let _ = writeln!(text);
    let numbers: String = (1..=RULES.len()).map(|number| format!("{number:>3}")).collect();
    let width = rows.iter().map(|row| row.title.chars().count()).max().unwrap_or_default();
    let _ = writeln!(text, "{:<18} {:<width$}{numbers}", "rule", "mutant");
    for row in rows {
        let _ = writeln!(text, "{:<18} {:<width$}{}", row.rule.id, row.title, marks(row));
    }
    let unexpected = rows.iter().filter(|row| !row.is_right()).count();
    let _ = writeln!(
        text,
        "\n● violated, as expected · ○ also violated, as expected · ! unexpected result · - not possible with these \
         definitions\n{} mutants, {unexpected} with unexpected results",
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn explains_a_rule_in_80_columns() {
        let text = rule(uavspec_rules::rule("PX-RANGE-01").expect("a rule"));
        assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
        assert!(text.contains("\nHow to fix\n  Check the unit"), "{text}");
    }
}
