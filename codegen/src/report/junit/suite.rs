//! Suites of cases, and their XML.

use quick_junit::{NonSuccessKind, TestCase, TestCaseStatus, TestSuite};

use crate::report::model::Place;

/// Cases that belong together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Suite {
    /// What they are of.
    pub name: String,
    /// The cases; readers tell them apart by class and name.
    pub cases: Vec<Case>,
}

/// A case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Case {
    /// What groups it with others, such as `check.PX-RANGE-01`.
    pub class: String,
    /// Its name, on one line.
    pub name: String,
    /// What came of it.
    pub outcome: Outcome,
    /// What else is to be said of it; may be empty.
    pub output: String,
    /// What it said on standard error; may be empty.
    pub errors: String,
    /// Where it is about something in a file.
    pub place: Option<Place>,
}

/// What came of a case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All is well.
    Passed,
    /// Something isn't as it should be.
    Failed(Reason),
    /// It couldn't be tried.
    Error(Reason),
    /// It wasn't tried, and why.
    Skipped(String),
}

/// Why a case didn't pass.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reason {
    /// What kind of failure it is, such as the id of a rule.
    pub kind: String,
    /// What is the matter, in short.
    pub message: String,
    /// All that is known of it.
    pub text: String,
}

impl Case {
    /// A case that passed.
    pub fn passed(class: impl Into<String>, name: impl Into<String>) -> Self {
        Self {
            class: class.into(),
            name: name.into(),
            outcome: Outcome::Passed,
            output: String::new(),
            errors: String::new(),
            place: None,
        }
    }

    fn write(&self) -> TestCase {
        let non_success = |kind, reason: &Reason| {
            let mut status = TestCaseStatus::non_success(kind);
            status.set_message(one_line(&reason.message)).set_type(one_line(&reason.kind));
            status.set_description(visible(&reason.text));
            status
        };
        let status = match &self.outcome {
            Outcome::Passed => TestCaseStatus::success(),
            Outcome::Failed(reason) => non_success(NonSuccessKind::Failure, reason),
            Outcome::Error(reason) => non_success(NonSuccessKind::Error, reason),
            Outcome::Skipped(why) => {
                let mut status = TestCaseStatus::skipped();
                status.set_message(one_line(why));
                status
            }
        };
        let mut case = TestCase::new(one_line(&self.name), status);
        case.set_classname(one_line(&self.class));
        if !self.output.is_empty() {
            case.set_system_out(visible(&self.output));
        }
        if !self.errors.is_empty() {
            case.set_system_err(visible(&self.errors));
        }
        if let Some(place) = &self.place {
            // GitLab and others lead to the file by this.
            case.extra.insert("file".into(), visible(&place.path).into());
            if let Some(line) = place.region.line() {
                case.extra.insert("line".into(), line.to_string().into());
            }
        }
        case
    }
}

/// Suites as a document, which has a name.
pub fn write(name: &str, suites: &[Suite]) -> String {
    let mut whole = quick_junit::Report::new(name);
    for suite in suites {
        let mut written = TestSuite::new(one_line(&suite.name));
        written.add_test_cases(suite.cases.iter().map(Case::write));
        whole.add_test_suite(written);
    }
    // Writing to memory can't fail.
    whole.to_string().unwrap_or_default()
}

/// A text on one line, as attributes want it.
pub(super) fn one_line(text: &str) -> String {
    visible(&text.split_whitespace().collect::<Vec<_>>().join(" "))
}

/// A text of characters that XML can hold. The library would drop some of the others silently, and with them
/// what a message is about.
pub(super) fn visible(text: &str) -> String {
    text.chars()
        .map(|character| match character {
            '\n' => '\n',
            '\t' => ' ',
            '\u{fffe}' | '\u{ffff}' => char::REPLACEMENT_CHARACTER,
            _ if character.is_control() => char::REPLACEMENT_CHARACTER,
            _ => character,
        })
        .collect()
}
