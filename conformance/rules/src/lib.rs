//! The rules, grouped by family, with one file per rule.
//!
//! A rule is a statement with a permanent id. Rules on single PX4 values are checked by a plan that is compiled once
//! per format (`px4`). Each rule on a sequence of records keeps a separate state.
//!
//! ```
//! use uavspec_rules::{RULES, rule};
//!
//! let rule = rule("FW-SYS-VER-02").unwrap();
//! println!("{} ({}): {}", rule.id, rule.level, rule.statement);
//! assert!(RULES.iter().any(|other| other.id == rule.id));
//! ```

#![cfg_attr(not(test), warn(clippy::disallowed_macros, clippy::disallowed_methods))]

pub mod definitions;
pub mod limits;

pub mod flockwave;
pub mod px4;
pub mod sample;

use uavspec_model::{Detail, Findings, Location, Rule, SubjectName};
use uavspec_px4::event::EventMetadata;
use uavspec_schema::MessageId;
use uavspec_schema::source::Span;

use self::sample::Flight;
use crate::definitions::Definitions;

/// All rules, sorted by id.
pub static RULES: [&Rule; flockwave::RULES.len() + px4::RULES.len()] = {
    let mut rules = [&flockwave::RULES[0].rule; flockwave::RULES.len() + px4::RULES.len()];
    let mut at = 0;
    while at < rules.len() {
        rules[at] = match at.checked_sub(flockwave::RULES.len()) {
            None => &flockwave::RULES[at].rule,
            Some(at) => &px4::RULES[at].rule,
        };
        at += 1;
    }
    rules
};

/// A mutant of a PX4 or Flockwave rule.
#[derive(Clone, Debug)]
pub struct Mutant {
    /// The rule that the mutant violates.
    pub rule: &'static Rule,
    /// The change.
    pub name: &'static str,
    /// The other rules that the mutant violates.
    pub also: Vec<&'static Rule>,
    make: Make,
}

#[derive(Clone, Copy, Debug)]
enum Make {
    Session(&'static flockwave::Mutant),
    Flight(px4::Change),
}

impl Mutant {
    /// The captures, each with a title. Empty if the flight's definitions don't allow the change.
    pub fn captures(&self, flight: &Flight<'_>) -> Vec<(String, Vec<u8>)> {
        match self.make {
            Make::Session(mutant) => {
                let capture = mutant.capture(self.rule);
                capture.map(|bytes| (self.name.to_owned(), bytes)).into_iter().collect()
            }
            Make::Flight(change) => {
                let title = |encoding: sample::Encoding| format!("{} ({})", self.name, encoding.name());
                change
                    .captures(flight)
                    .into_iter()
                    .map(|(encoding, bytes)| (title(encoding), bytes))
                    .collect()
            }
        }
    }
}

/// The mutants of all rules, in rule order.
pub fn mutants() -> impl Iterator<Item = Mutant> {
    let sessions = flockwave::RULES.iter().flat_map(|entry| {
        entry.mutants.iter().map(|mutant| Mutant {
            rule: &entry.rule,
            name: mutant.name,
            also: mutant.also.to_vec(),
            make: Make::Session(mutant),
        })
    });
    let flights = px4::RULES.iter().flat_map(|entry| {
        entry.mutants.iter().map(|px4::Mutant { name, change, also }| Mutant {
            rule: &entry.rule,
            name,
            also: also.iter().map(|also| &also.rule).collect(),
            make: Make::Flight(*change),
        })
    });
    sessions.chain(flights)
}

/// Describes how a rule is checked.
pub fn checked_by(rule: &Rule) -> &'static str {
    let keeps_state = |check: &flockwave::Check| matches!(check, flockwave::Check::Session(_));
    let flockwave = flockwave::rule(rule.id).map(|entry| {
        if entry.checks.iter().any(keeps_state) {
            BY_STATE
        } else {
            "one message at a time, using earlier messages from the same connection"
        }
    });
    let px4 = px4::RULES.iter().find(|entry| entry.rule.id == rule.id).map(|entry| match entry.check {
        px4::Check::Value => "one value at a time, with checks compiled once per message format",
        px4::Check::Source => "while reading, because data that violates the rule can't be read",
        px4::Check::State(_) => BY_STATE,
    });
    flockwave.or(px4).unwrap_or_default()
}

const BY_STATE: &str = "one record at a time, keeping a small amount of state";

/// The context of a check: its rule, the definitions, and the findings and coverage that it updates.
pub struct RuleContext<'c> {
    /// The rule.
    pub rule: &'static Rule,
    /// The definitions that the capture is checked against.
    pub definitions: &'c Definitions,
    /// The metadata of the events.
    pub events: &'c EventMetadata,
    /// All findings of the run.
    pub findings: &'c mut Findings,
    /// The number of items that the rule checked.
    pub coverage: &'c mut u64,
}

impl RuleContext<'_> {
    /// The location of a definition.
    pub(crate) fn defined(&self, definition: Option<MessageId>) -> Option<Span> {
        definition.map(|id| self.definitions.schema.message(id).span)
    }

    /// The location of a field in its definition.
    pub(crate) fn field(&self, definition: Option<MessageId>, name: &str) -> Option<Span> {
        let fields = &self.definitions.schema.message(definition?).fields;
        fields.iter().find(|field| field.name == name).map(|field| field.span)
    }

    /// Counts one checked item, regardless of the result.
    pub(crate) fn covered(&mut self) {
        *self.coverage += 1;
    }

    /// Reports a violation of the rule.
    pub(crate) fn violation(&mut self, subject: &str, location: Location, detail: impl FnOnce() -> Detail) {
        self.violation_of(subject, location, None, detail);
    }

    /// Reports a violation, with the location of the violated definition.
    pub(crate) fn violation_of<'s>(
        &mut self,
        subject: impl Into<SubjectName<'s>>,
        location: Location,
        definition: Option<Span>,
        detail: impl FnOnce() -> Detail,
    ) {
        self.findings.report(self.rule, subject, location, definition, detail);
    }
}

// A rule without a mutant would not be tested.
const _: () = {
    let mut at = 0;
    while at < flockwave::RULES.len() {
        let rule = flockwave::RULES[at];
        assert!(!rule.checks.is_empty(), "a rule without a check");
        assert!(!rule.bug.description.is_empty(), "a rule without a bug");
        assert!(!rule.mutants.is_empty(), "a rule without a mutant");
        at += 1;
    }
    let mut at = 0;
    while at < px4::RULES.len() {
        assert!(!px4::RULES[at].mutants.is_empty(), "a rule without a mutant");
        at += 1;
    }
};

/// Finds a rule by its id.
pub fn rule(id: &str) -> Option<&'static Rule> {
    RULES.binary_search_by_key(&id, |rule| rule.id).ok().map(|at| RULES[at])
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use uavspec_model::{Level, Status};

    use super::*;

    #[test]
    fn rules_are_sorted_by_id() {
        assert!(RULES.windows(2).all(|pair| pair[0].id < pair[1].id));
    }

    #[test]
    fn disputed_rules_are_not_at_level_must() {
        let is_disputed = |rule: &&&Rule| matches!(rule.status, Status::Disputed(_));
        let levels: Vec<Level> = RULES.iter().filter(is_disputed).map(|rule| rule.level).collect();
        assert!(!levels.is_empty() && !levels.contains(&Level::Must), "{levels:?}");
    }

    #[test]
    fn every_rule_has_a_reason_an_example_and_a_fix() {
        let is_incomplete = |rule: &&&Rule| {
            [rule.statement, rule.source, rule.applies_to, rule.why, rule.example, rule.fix].contains(&"")
        };
        let incomplete: Vec<&str> = RULES.iter().filter(is_incomplete).map(|rule| rule.id).collect();
        assert_eq!(incomplete, Vec::<&str>::new());
    }

    #[test]
    fn describes_how_a_rule_is_checked() {
        for (id, start) in [
            ("FW-ASY-17", BY_STATE),
            ("FW-ENV-04", "one message at a time"),
            ("PX-DATA-02", "while reading"),
            ("PX-FSF-03", BY_STATE),
            ("PX-RANGE-01", "one value at a time"),
        ] {
            let text = checked_by(rule(id).expect("a rule"));
            assert!(text.starts_with(start), "{id}: {text}");
        }
    }

    #[test]
    fn lines_of_rules_are_short_enough_for_rustfmt() {
        const MAX_WIDTH: usize = 110;
        for family in ["flockwave", "px4"] {
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src").join(family);
            for file in fs::read_dir(folder).expect("a folder") {
                let path = file.expect("an entry").path();
                let text =
                    if path.is_file() { fs::read_to_string(&path).expect("a file") } else { String::new() };
                let rule = text.lines().skip_while(|line| !line.contains("static RULE: "));
                let mut rule = rule.take_while(|line| !line.is_empty());
                // If a line is longer, rustfmt doesn't format the whole rule.
                let long = rule.find(|line| line.chars().count() > MAX_WIDTH);
                assert_eq!(long, None, "{path:?}");
            }
        }
    }

    #[test]
    fn examples_fit_on_a_screen() {
        let fits = |example: &str| {
            example.lines().count() <= 8 && example.lines().all(|line| line.chars().count() <= 100)
        };
        let long: Vec<&str> = RULES.iter().filter(|rule| !fits(rule.example)).map(|rule| rule.id).collect();
        assert_eq!(long, Vec::<&str>::new());
    }
}
