//! The rules of `breaking`. The output in the examples comes from the rules themselves.

use uavspec_dynamic::breaking::{Between, Category, RULES, Rule, breaking};
use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::{Example, packages};
use uavspec_schema::read::read;
use uavspec_schema::render;
use uavspec_schema::source::SourceMap;

use super::chapter::{Chapter, Listing, OVERVIEW, RulePage, rule_link};
use crate::docs::markdown::{Table, code, gist, text_column, with_code};

/// The text above the table.
const ABOUT: &str = "\
`uavspec breaking --against REV` compares the definitions with an earlier version. Each rule covers one \
kind of change. The columns show who is affected. `source` means programs built from the definitions. `json`, `cdr` \
(DDS and ROS 2) and `uorb` (memory and logs) mean peers that exchange messages in these formats. `version` means \
programs that use MESSAGE_VERSION. `semantic` means programs that depend on the meaning of a value.";

pub(super) fn chapter() -> Chapter {
    Chapter {
        title: "Breaking changes",
        about: ABOUT.to_owned(),
        topics: TOPICS,
        table: table(),
        pages: RULES.iter().map(|rule| page(rule)).collect(),
    }
}

/// The topics of the rules.
const TOPICS: &[(&str, &str)] = &[
    (
        "Changes to fields",
        "array-length-changed field-added field-default-changed field-enum-changed field-frame-changed \
         field-invalid-changed field-moved field-range-changed field-removed field-renamed \
         field-type-changed field-unit-changed nested-changed",
    ),
    (
        "Changes to constants",
        "constant-added constant-removed constant-renamed constant-reused constant-type-changed \
         constant-value-changed",
    ),
    (
        "Changes to events",
        "event-added event-arguments-changed event-enum-changed event-meaning-changed event-removed",
    ),
    (
        "Changes to error codes",
        "error-code-abbreviation-changed error-code-added error-code-meaning-changed error-code-removed \
         error-code-renumbered error-code-reused",
    ),
    (
        "Changes to messages and topics",
        "message-added message-removed message-renamed message-version message-version-needless \
         message-version-removed queue-length-changed topic-added topic-removed",
    ),
];

fn table() -> Table {
    let mut columns = vec![text_column("Rule"), text_column("Change")];
    columns.extend(Category::ALL.map(|category| text_column(category.name())));
    let mut table = Table::new(&columns);
    for rule in RULES {
        let mut row = vec![rule_link(OVERVIEW, rule.id), with_code(&gist(rule.statement, usize::MAX))];
        row.extend(Category::ALL.map(|category| level(rule, category).map_or("", Level::name).to_owned()));
        table.row(row);
    }
    table
}

/// The level of a change in a category. `None` if the rule never reports a change that breaks the category.
fn level(rule: &Rule, category: Category) -> Option<Level> {
    rule.breaks.iter().find(|(broken, _)| *broken == category).map(|(_, level)| *level)
}

fn page(rule: &Rule) -> RulePage {
    let facts = Category::ALL
        .into_iter()
        .filter_map(|category| Some(format!("{}: {}", category.name(), level(rule, category)?.name())));
    let changes = rule.old.iter().zip(rule.new);
    let changes = changes.filter_map(|(old, new)| Listing::difference(old.file(), new.file()));
    RulePage {
        id: rule.id,
        statement: rule.statement,
        facts: facts.collect(),
        why: rule.why,
        example: changes.chain([Listing::output(output(rule))]).collect(),
        fix: rule.fix,
        corrected: Vec::new(),
        configuration: format!(
            "{} sets the lowest level at which the command fails. {} accepts the current changes.",
            code("--deny LEVEL"),
            code("--write-baseline FILE")
        ),
    }
}

/// The output of the rule for its example.
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
