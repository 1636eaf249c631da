//! The rules of `lint`. What is said of the examples is what the rules themselves say, when the pages are
//! made.

use super::chapter::{Chapter, OVERVIEW, RulePage, Shown, rule_link};
use crate::diagnostic::Level;
use crate::emit::docs::markdown::{Table, code, gist, number_column, text_column, with_code};
use crate::example::{Example, catalogues, is_catalogue, packages};
use crate::finding::Finding;
use crate::lint::{Check, Levels, Measured, Preset, RULES, Rule, Settings, lint};
use crate::msg::{Dialect, Kind};
use crate::render;
use crate::schema::Form;
use crate::source::SourceMap;

/// How a level is shown that a preset doesn't give.
const OFF: &str = "off";

pub(super) fn chapter() -> Chapter {
    let rules: Vec<Described> = RULES.iter().map(|rule| Described::of(rule)).collect();
    Chapter {
        title: "Lint",
        about: ABOUT.to_owned(),
        table: table(&rules),
        pages: rules.iter().map(Described::page).collect(),
    }
}

/// What stands above the table.
const ABOUT: &str = "\
`cargo xtask lint` looks at definitions for what should be written otherwise. The preset `px4` holds what \
PX4's documentation standard asks and whatever makes readers go wrong, `strict` holds all rules but that on PX4's own list of units; \
`lint.preset` and `lint.levels` in `uavspec.toml` choose. Findings were counted in all messages of PX4 \
(`px4_msgs` main at a4a9864), and a sample of them was judged by hand: right is what somebody who knows the \
definition would change.";

/// A rule, and what it finds in its bad example.
struct Described {
    rule: &'static Rule,
    output: String,
    is_fixable: bool,
}

impl Described {
    fn of(rule: &'static Rule) -> Self {
        let (sources, findings) = judge(rule);
        let is_fixable = findings.iter().any(|finding| !finding.fix.is_empty());
        Self { rule, output: render::findings(&findings, &sources, false), is_fixable }
    }

    fn page(&self) -> RulePage {
        let Rule { id, purpose, levels, bad, good, measured, .. } = *self.rule;
        let mut facts = vec![("Level", shown_levels(levels))];
        if let Some(measured) = measured {
            facts.push(("In the messages of PX4", sentence(measured)));
        }
        if self.is_fixable {
            facts.push(("Mended by", "`cargo xtask lint --fix`".to_owned()));
        }
        let bad = Shown { heading: "Found", files: files(bad), output: self.output.clone() };
        let good = Shown { heading: "Not found", files: files(good), output: String::new() };
        RulePage { id, purpose, facts, examples: vec![bad, good], after: letting_stand(self.rule) }
    }
}

fn table(rules: &[Described]) -> Table {
    let columns = [
        text_column("Rule"),
        text_column("What it asks"),
        text_column("`px4`"),
        text_column("`strict`"),
        number_column("Findings in PX4"),
        text_column("Right"),
        text_column("Mended"),
    ];
    let mut table = Table::new(&columns);
    for described in rules {
        let Rule { id, purpose, levels, measured, .. } = *described.rule;
        let right = |measured: Measured| format!("{} of {}", measured.right, measured.sample);
        table.row([
            rule_link(OVERVIEW, id),
            with_code(&gist(purpose, usize::MAX)),
            name(levels.px4).to_owned(),
            name(levels.strict).to_owned(),
            measured.map(|measured| measured.findings.to_string()).unwrap_or_default(),
            measured.filter(|measured| measured.sample > 0).map(right).unwrap_or_default(),
            if described.is_fixable { "yes".to_owned() } else { String::new() },
        ]);
    }
    table
}

fn name(level: Option<Level>) -> &'static str {
    level.map_or(OFF, Level::name)
}

fn shown_levels(levels: Levels) -> String {
    let of = |preset| name(levels.of(preset));
    let (px4, strict) = (of(Preset::Px4), of(Preset::Strict));
    if px4 == strict {
        format!("{px4} in all presets")
    } else {
        format!("{px4} in `px4`, {strict} in `strict`")
    }
}

/// What was measured, in words.
fn sentence(measured: Measured) -> String {
    let Measured { findings, sample, right, remark } = measured;
    let findings = match findings {
        0 => return "no finding".to_owned(),
        1 => "1 finding".to_owned(),
        count => format!("{count} findings"),
    };
    let judged = match sample {
        0 => String::new(),
        _ if right == sample => format!("; of {sample} that were judged, all are right"),
        _ => format!("; of {sample} that were judged, {right} are right"),
    };
    let remark = if remark.is_empty() { String::new() } else { format!(" ({})", with_code(remark)) };
    format!("{findings}{judged}{remark}")
}

/// How to let a finding stand.
fn letting_stand(rule: &Rule) -> Vec<String> {
    let id = rule.id;
    let off =
        format!("To turn the rule off, write `{id} = \"off\"` below `[lint.levels]` in `uavspec.toml`.");
    if matches!(rule.check, Check::Ignores) {
        return vec![off];
    }
    if is_catalogue(rule.bad.path) {
        let stand = format!(
            "To let findings in a catalogue stand, name the rule, the file and the reason in a table `lint.ignore` of \
             `uavspec.toml`: {}.",
            code(&format!("{{ rule = \"{id}\", path = \"i18n/uk.po\", reason = \"…\" }}"))
        );
        return vec![stand, off];
    }
    let (request, whole) = match form(rule.bad.path) {
        Form::Table => (format!("<!-- uavspec:ignore {id} reason -->"), "On a line of its own"),
        Form::Msg(_) => (
            format!("# uavspec:ignore {id} reason"),
            "It may stand above the line, too. In the comment at the head",
        ),
    };
    let stand = format!(
        "To let a finding stand, write {} behind its line. {whole} it is for the whole file.",
        code(&request)
    );
    vec![stand, off]
}

fn files(example: Example) -> Vec<(String, String)> {
    example.files().into_iter().map(|(path, text)| (path.to_owned(), text.to_owned())).collect()
}

/// How an example is written, by its extension.
fn form(path: &str) -> Form {
    if Kind::of(path).is_some() { Form::Msg(Dialect::Px4) } else { Form::Table }
}

/// What a rule finds in its bad example, at the level that it has where it is on.
fn judge(rule: &Rule) -> (SourceMap, Vec<Finding>) {
    let mut sources = SourceMap::default();
    let packages = packages(rule.bad.files(), "", &mut sources);
    let catalogues = catalogues(rule.bad.files(), "", &mut sources);
    let level = rule.levels.px4.or(rule.levels.strict).unwrap_or(Level::Warning);
    let levels = [(rule.id.to_owned(), Some(level))].into();
    let settings = Settings { preset: Preset::Strict, levels, ignores: Vec::new() };
    let mut findings = lint(&sources, &packages, &catalogues, &settings);
    findings.retain(|finding| finding.rule == rule.id);
    (sources, findings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_measured_is_said_in_words() {
        let measured =
            |findings, sample, right, remark| sentence(Measured { findings, sample, right, remark });
        assert_eq!(measured(0, 0, 0, ""), "no finding");
        assert_eq!(measured(1, 1, 1, ""), "1 finding; of 1 that were judged, all are right");
        assert_eq!(
            measured(90, 30, 28, "two are `|` tables"),
            "90 findings; of 30 that were judged, 28 are right (two are <code>&#124;</code> tables)"
        );
    }
}
