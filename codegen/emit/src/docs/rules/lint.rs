//! The rules of `lint`. The output in the examples comes from the rules themselves.

use uavspec_dynamic::conversion::Request;
use uavspec_lint::{Check, Levels, Measured, Preset, RULES, Rule, Settings, lint};
use uavspec_schema::diagnostic::Level;
use uavspec_schema::example::{CONVERTED, catalogues, hints, is_catalogue, packages};
use uavspec_schema::finding::Finding;
use uavspec_schema::msg::{Dialect, Kind};
use uavspec_schema::source::SourceMap;
use uavspec_schema::{Form, render};

use super::chapter::{Chapter, Listing, OVERVIEW, RulePage, rule_link};
use crate::docs::markdown::{Table, code, gist, text_column, with_code};

/// The level shown for a rule that a preset excludes.
const OFF: &str = "off";

pub(super) fn chapter() -> Chapter {
    let rules: Vec<Described> = RULES.iter().map(|rule| Described::of(rule)).collect();
    Chapter {
        title: "Lint",
        about: ABOUT.to_owned(),
        topics: TOPICS,
        table: table(&rules),
        pages: rules.iter().map(Described::page).collect(),
    }
}

/// The text above the table.
const ABOUT: &str = "\
`uavspec lint` finds definitions that are valid but misleading, incomplete or inconsistent. The `px4` preset \
contains the rules of PX4's documentation standard and rules for mistakes that mislead readers or parsers. The \
`strict` preset contains all rules except `unit-unlisted`. Set `lint.preset` and `lint.levels` in `uavspec.toml`. \
Each page gives the number of findings in PX4's own messages (`px4_msgs` main at a4a9864). A finding counts as \
correct if an expert would change the definition.";

/// The topics of the rules.
const TOPICS: &[(&str, &str)] = &[
    (
        "Annotations",
        "annotation-after-text annotation-near-miss annotation-value-type command-parameters \
         frame-unknown malformed-annotation misplaced-annotation range-reversed unknown-annotation",
    ),
    (
        "Comments and descriptions",
        "blank-start comment-continued comment-lost constant-comment-missing description-missing \
         field-comment-missing header-end header-missing",
    ),
    (
        "Enums and constants",
        "constant-without-enum enum-alias enum-of-bits enum-on-non-integer enum-type \
         enum-value-out-of-range unknown-constant unknown-enum",
    ),
    ("Units", "unit-alias unit-missing unit-missing-integer unit-unlisted unknown-unit"),
    (
        "Messages, names and topics",
        "count-missing duplicate-topic message-name-style name-style queue-length timestamp-missing \
         timestamp-type topic-default-absent topic-list-empty topic-redundant version-type",
    ),
    (
        "White space and syntax",
        "invisible-character leading-white-space not-portable repeated-white-space trailing-white-space \
         unknown-escape",
    ),
    (
        "Pages with tables and error codes",
        "missing-abbreviation missing-answer near-type-table one-sided-alternative severity-bits",
    ),
    (
        "Event metadata",
        "event-argument-unused event-bit event-enum-differs event-id event-mode-missing event-version \
         unknown-member",
    ),
    ("Failsafe flags", "PX-FSF-01 PX-FSF-02"),
    ("Translations", "translation-fuzzy translation-missing translation-stale unknown-translation"),
    (
        "Conversions and ignored findings",
        "conversion-undecided hint-invalid hint-unused invalid-ignore unused-ignore",
    ),
];

/// A rule with its output for the bad example.
struct Described {
    rule: &'static Rule,
    output: String,
    is_fixable: bool,
}

impl Described {
    fn of(rule: &'static Rule) -> Self {
        let (sources, findings) = lint_bad_example(rule);
        let is_fixable = findings.iter().any(|finding| !finding.fix.is_empty());
        Self { rule, output: render::findings(&findings, &sources, false), is_fixable }
    }

    fn page(&self) -> RulePage {
        let Rule { id, statement, why, fix, levels, bad, good, measured, .. } = *self.rule;
        let mut facts = vec![format!("Level: {}", levels_text(levels))];
        if self.is_fixable {
            facts.push("Fixed by `lint --fix`".to_owned());
        }
        facts.extend(measured.map(measured_text));
        RulePage {
            id,
            statement,
            facts,
            why,
            example: vec![Listing::output(self.output.clone())],
            fix,
            corrected: Listing::difference(bad.file(), good.file()).into_iter().collect(),
            configuration: configuration(self.rule),
        }
    }
}

fn table(rules: &[Described]) -> Table {
    let columns = [
        text_column("Rule"),
        text_column("What it reports"),
        text_column("`px4`"),
        text_column("`strict`"),
        text_column("`--fix`"),
    ];
    let mut table = Table::new(&columns);
    for described in rules {
        let Rule { id, statement, levels, .. } = *described.rule;
        table.row([
            rule_link(OVERVIEW, id),
            with_code(&gist(statement, usize::MAX)),
            name(levels.px4).to_owned(),
            name(levels.strict).to_owned(),
            if described.is_fixable { "yes".to_owned() } else { String::new() },
        ]);
    }
    table
}

fn name(level: Option<Level>) -> &'static str {
    level.map_or(OFF, Level::name)
}

fn levels_text(levels: Levels) -> String {
    let of = |preset| name(levels.of(preset));
    let (px4, strict) = (of(Preset::Px4), of(Preset::Strict));
    if px4 == strict {
        format!("{px4} in all presets")
    } else {
        format!("{px4} in `px4`, {strict} in `strict`")
    }
}

/// The number of findings in PX4's messages, and how many of the sampled findings are correct.
fn measured_text(measured: Measured) -> String {
    let Measured { findings, sample, right } = measured;
    match findings {
        0 => "PX4's messages: no findings".to_owned(),
        1 => format!("PX4's messages: 1 finding, {right} of {sample} correct"),
        _ if findings == sample => {
            format!("PX4's messages: {findings} findings, {right} of {sample} correct")
        }
        _ => format!("PX4's messages: {findings} findings, {right} of {sample} sampled findings correct"),
    }
}

/// A line that explains how to ignore a finding and how to switch the rule off.
fn configuration(rule: &Rule) -> String {
    let id = rule.id;
    let off = format!("set {} in `lint.levels` of `uavspec.toml`", code(&format!("{id} = \"off\"")));
    if matches!(rule.check, Check::Ignores) {
        return format!("To switch the rule off, {off}.");
    }
    let ignore = match form(rule.bad.path) {
        _ if rule.bad.is_data() => {
            let file = if is_catalogue(rule.bad.path) { "catalogue" } else { "file" };
            format!(
                "add an entry to `lint.ignore` with the rule {}, the path of the {file} and a reason",
                code(id)
            )
        }
        Form::Table | Form::Events => {
            format!("add {} to the line", code(&format!("<!-- uavspec:ignore {id} REASON -->")))
        }
        Form::Msg(_) => format!("add {} to the line", code(&format!("# uavspec:ignore {id} REASON"))),
    };
    format!("To ignore a finding, {ignore}. To switch the rule off, {off}.")
}

/// The form of an example, by its extension.
fn form(path: &str) -> Form {
    if Kind::of(path).is_some() { Form::Msg(Dialect::Px4) } else { Form::Table }
}

/// Checks the bad example of a rule. Returns the sources and the findings.
fn lint_bad_example(rule: &Rule) -> (SourceMap, Vec<Finding>) {
    let mut sources = SourceMap::default();
    let packages = packages(rule.bad.files(), "", &mut sources);
    let catalogues = catalogues(rule.bad.files(), "", &mut sources);
    let level = rule.levels.px4.or(rule.levels.strict).unwrap_or(Level::Warning);
    let levels = [(rule.id.to_owned(), Some(level))].into();
    let hints = hints(rule.bad.files(), "", &mut sources);
    let conversions = hints.map(|hints| {
        let [from, to] = CONVERTED.map(|example| example.package().to_owned());
        Request { from, to, hints: Some(hints) }
    });
    let settings = Settings {
        preset: Preset::Strict,
        levels,
        ignores: Vec::new(),
        conversions: conversions.into_iter().collect(),
    };
    let mut findings = lint(&sources, &packages, &catalogues, &settings);
    findings.retain(|finding| finding.rule == rule.id);
    (sources, findings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn describes_what_was_measured() {
        let text = |findings, sample, right| measured_text(Measured { findings, sample, right });
        assert_eq!(text(0, 0, 0), "PX4's messages: no findings");
        assert_eq!(text(1, 1, 1), "PX4's messages: 1 finding, 1 of 1 correct");
        assert_eq!(text(90, 30, 28), "PX4's messages: 90 findings, 28 of 30 sampled findings correct");
    }
}
