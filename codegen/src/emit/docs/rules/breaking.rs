//! The rules of `breaking`. What is said of the examples is what the rules themselves say, when the pages are
//! made.

use super::chapter::{Chapter, OVERVIEW, RulePage, Shown, rule_link};
use crate::breaking::{Between, Category, RULES, Rule, breaking};
use crate::diagnostic::Level;
use crate::emit::docs::markdown::{Table, gist, text_column, with_code};
use crate::example::{Example, packages};
use crate::read::read;
use crate::render;
use crate::source::SourceMap;

/// What stands above the table.
const ABOUT: &str = "\
`cargo xtask breaking --against REV` compares the definitions with an earlier state. A rule is one kind of \
change; the columns say whom it breaks: `source` programs that are built from the definitions, `json`, `cdr` \
(DDS and ROS 2) and `uorb` (memory, and with it logs) those that exchange messages so, `version` whoever \
relies on MESSAGE_VERSION, `semantic` whoever gives a value its meaning.";

pub(super) fn chapter() -> Chapter {
    Chapter {
        title: "Breaking changes",
        about: ABOUT.to_owned(),
        table: table(),
        pages: RULES.iter().map(|rule| page(rule)).collect(),
    }
}

fn table() -> Table {
    let mut columns = vec![text_column("Rule"), text_column("What changed")];
    columns.extend(Category::ALL.map(|category| text_column(category.name())));
    let mut table = Table::new(&columns);
    for rule in RULES {
        let mut row = vec![rule_link(OVERVIEW, rule.id), with_code(&gist(rule.purpose, usize::MAX))];
        row.extend(Category::ALL.map(|category| level(rule, category).map_or("", Level::name).to_owned()));
        table.row(row);
    }
    table
}

/// How badly a change breaks a category; none where it doesn't.
fn level(rule: &Rule, category: Category) -> Option<Level> {
    rule.breaks.iter().find(|(broken, _)| *broken == category).map(|(_, level)| *level)
}

fn page(rule: &Rule) -> RulePage {
    let facts = Category::ALL
        .into_iter()
        .filter_map(|category| Some((category.name(), level(rule, category)?.name().to_owned())));
    RulePage {
        id: rule.id,
        purpose: rule.purpose,
        facts: facts.collect(),
        examples: vec![
            Shown { heading: "Before", files: files(rule.old), output: String::new() },
            Shown { heading: "After", files: files(rule.new), output: output(rule) },
        ],
        after: Vec::new(),
    }
}

fn files(examples: &[Example]) -> Vec<(String, String)> {
    examples.iter().map(|example| (example.path.to_owned(), example.text.to_owned())).collect()
}

/// What the rule says of its examples.
fn output(rule: &Rule) -> String {
    let mut sources = SourceMap::default();
    let mut schema = |folder, examples: &[Example]| {
        let packages = packages(examples.iter().map(Example::file), folder, &mut sources);
        read(&sources, &packages).0
    };
    let (old, new) = (schema("before", rule.old), schema("after", rule.new));
    let mut findings = breaking(&sources, &old, &new, Between::Commits);
    findings.retain(|finding| finding.rule == rule.id);
    render::findings(&findings, &sources, false)
}
