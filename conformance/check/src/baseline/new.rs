//! Writes a new baseline.

use std::fmt::Write as _;

use super::fix::quote;
use super::pattern::exact;

/// An entry of a new list. The order is the order of the entries.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum NewEntry {
    /// The findings of a rule in a subject.
    Rule {
        /// The id of the rule.
        rule: String,
        /// The topic, field or type.
        subject: String,
    },
    /// A test case.
    Case(String),
}

/// The reason of each new entry.
const REASON: &str = "not assessed yet";

/// The text of a list with an entry for each failure. `command` is the command line of the run.
pub fn list<'e>(entries: impl IntoIterator<Item = &'e NewEntry>, command: &str) -> String {
    let command: String = command.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let mut text = format!("# Failures of `{command}`.\n# State the reason for each one.\n");
    for entry in entries {
        let keys = match entry {
            NewEntry::Rule { rule, subject } => {
                let subject = quote(exact(std::slice::from_ref(subject)));
                format!("rule = {}\nsubject = {subject}", quote(rule.clone()))
            }
            NewEntry::Case(name) => format!("case = {}", quote(exact(std::slice::from_ref(name)))),
        };
        // Writing to a string can't fail.
        let _ = write!(text, "\n[[known]]\n{keys}\nreason = {}\n", quote(REASON.to_owned()));
    }
    text
}

#[cfg(test)]
mod tests {
    use uavspec_rules::RULES;

    use super::*;
    use crate::baseline::{Lists, Name};

    #[test]
    fn a_new_list_names_exactly_its_failures() {
        let rule = RULES[0];
        let subjects = ["UAV-INF", "odd [*] \"subject\"", "wind\tvane", ""];
        let failure =
            |subject: &&str| NewEntry::Rule { rule: rule.id.to_owned(), subject: (*subject).to_owned() };
        let mut failures: Vec<NewEntry> = subjects.iter().map(failure).collect();
        failures.push(NewEntry::Case("decode-cdr/px4/Event/{a,b}".to_owned()));
        let text = list(&failures, "uavspec check a\u{1b}b.ulg");
        let lists = Lists::parse([("new.toml".to_owned(), text.clone().into_bytes())]).expect(&text);
        let is_known = |name| lists.excuse(name, &["any message".to_owned()]).is_some();
        for subject in subjects {
            assert!(
                is_known(Name::Rule { rule, subject: subject.into(), file: "a.ulg" }),
                "{subject}: {text}"
            );
        }
        assert!(!is_known(Name::Rule { rule, subject: "odd a \"subject\"".into(), file: "a.ulg" }));
        assert!(!is_known(Name::Rule { rule: RULES[1], subject: "UAV-INF".into(), file: "a.ulg" }));
        assert!(is_known(Name::Case("decode-cdr/px4/Event/{a,b}")));
        assert!(!is_known(Name::Case("decode-cdr/px4/Event/a")));
    }
}
