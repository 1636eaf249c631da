//! The rules, a file each, by family.
//!
//! A rule is a statement with a permanent id. Rules on single values are checked by a plan that is made once for each format
//! (`px4`); rules on the course of things keep a state of their own.
//!
//! ```
//! use uavspec_conformance::rules::{RULES, rule};
//!
//! let rule = rule("FW-SYS-VER-02").unwrap();
//! println!("{} ({}): {}", rule.id, rule.level, rule.statement);
//! assert!(RULES.iter().any(|other| other.id == rule.id));
//! ```

pub mod flockwave;
pub(crate) mod px4;
pub(crate) mod sample;

use uavspec_codegen::schema::MessageId;
use uavspec_codegen::source::Span;

use self::sample::Flight;
use crate::definitions::Definitions;
use crate::model::{Detail, Findings, Location, Rule};

/// Every rule, by id.
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

/// A mutant of a rule of either family.
#[derive(Clone, Debug)]
pub(crate) struct Mutant {
    /// The rule that it violates.
    pub rule: &'static Rule,
    /// The change.
    pub name: &'static str,
    /// Other rules that it violates too.
    pub also: Vec<&'static Rule>,
    make: Make,
}

#[derive(Clone, Copy, Debug)]
enum Make {
    Session(fn() -> Option<Vec<u8>>),
    Flight(px4::Change),
}

impl Mutant {
    /// The captures, made of a flight or a session, each with its title; none if the definitions have nothing that could
    /// be changed so.
    pub(crate) fn captures(&self, flight: &Flight<'_>) -> Vec<(String, Vec<u8>)> {
        match self.make {
            Make::Session(make) => make().map(|bytes| (self.name.to_owned(), bytes)).into_iter().collect(),
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

/// The mutants of all rules, in the order of these.
pub(crate) fn mutants() -> impl Iterator<Item = Mutant> {
    let sessions = flockwave::RULES.iter().flat_map(|of| {
        of.mutants.iter().map(|flockwave::Mutant { name, make, also }| Mutant {
            rule: &of.rule,
            name,
            also: also.to_vec(),
            make: Make::Session(*make),
        })
    });
    let flights = px4::RULES.iter().flat_map(|of| {
        of.mutants.iter().map(|px4::Mutant { name, change, also }| Mutant {
            rule: &of.rule,
            name,
            also: also.iter().map(|also| &also.rule).collect(),
            make: Make::Flight(*change),
        })
    });
    sessions.chain(flights)
}

/// The way in which a rule is checked, in words.
pub(crate) fn checked_by(rule: &Rule) -> &'static str {
    let keeps_state = |check: &flockwave::Check| matches!(check, flockwave::Check::Session(_));
    let flockwave = flockwave::rule(rule.id).map(|of| {
        if of.checks.iter().any(keeps_state) {
            BY_STATE
        } else {
            "message by message, with what went over the connection before"
        }
    });
    let px4 = px4::RULES.iter().find(|of| of.rule.id == rule.id).map(|of| match of.check {
        px4::Check::Value => "value by value, by a plan that is made once for each format",
        px4::Check::Source => "reading: what breaks it can't be read as anything",
        px4::Check::State(_) => BY_STATE,
    });
    flockwave.or(px4).unwrap_or_default()
}

const BY_STATE: &str = "following the records of a source with a small state for each topic";

/// The surroundings of a check: what it is checked by, and where its findings and its coverage are counted.
pub(crate) struct RuleContext<'c> {
    /// The rule.
    pub rule: &'static Rule,
    /// The definitions that captures are checked against.
    pub definitions: &'c Definitions,
    /// All findings of the run.
    pub findings: &'c mut Findings,
    /// The number of times that the rule had something to check.
    pub coverage: &'c mut u64,
}

impl RuleContext<'_> {
    /// The line where a definition starts.
    pub(crate) fn defined(&self, definition: Option<MessageId>) -> Option<Span> {
        definition.map(|id| self.definitions.schema.message(id).span)
    }

    /// The line where a definition has this field.
    pub(crate) fn field(&self, definition: Option<MessageId>, name: &str) -> Option<Span> {
        let fields = &self.definitions.schema.message(definition?).fields;
        fields.iter().find(|field| field.name == name).map(|field| field.span)
    }

    /// Counts that the rule had something to check, whatever the result.
    pub(crate) fn covered(&mut self) {
        *self.coverage += 1;
    }

    /// Reports a violation of the rule.
    pub(crate) fn violation(&mut self, subject: &str, location: Location, detail: impl FnOnce() -> Detail) {
        self.violation_of(subject, location, None, detail);
    }

    /// Reports a violation of what a definition says at this line.
    pub(crate) fn violation_of(
        &mut self,
        subject: &str,
        location: Location,
        definition: Option<Span>,
        detail: impl FnOnce() -> Detail,
    ) {
        self.findings.report(self.rule, subject, location, definition, detail);
    }
}

// A rule that finds nothing is none.
const _: () = {
    let mut at = 0;
    while at < flockwave::RULES.len() {
        assert!(!flockwave::RULES[at].mutants.is_empty(), "a rule without a mutant");
        at += 1;
    }
    let mut at = 0;
    while at < px4::RULES.len() {
        assert!(!px4::RULES[at].mutants.is_empty(), "a rule without a mutant");
        at += 1;
    }
};

/// The rule of an id.
pub fn rule(id: &str) -> Option<&'static Rule> {
    RULES.binary_search_by_key(&id, |rule| rule.id).ok().map(|at| RULES[at])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_sorted_so_that_they_can_be_looked_up() {
        assert!(RULES.windows(2).all(|pair| pair[0].id < pair[1].id));
    }
}
