//! Test suites and their XML.

use quick_junit::{NonSuccessKind, TestCase, TestCaseStatus, TestSuite};
use uavspec_schema::terminal::{guarded, path};

use crate::report::model::Place;

/// A suite of cases.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Suite {
    /// The name.
    pub name: String,
    /// The cases, identified by class and name.
    pub cases: Vec<Case>,
}

/// A test case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Case {
    /// The group, such as `check.PX-RANGE-01`.
    pub class: String,
    /// The name, on one line.
    pub name: String,
    /// The outcome.
    pub outcome: Outcome,
    /// The standard output; may be empty.
    pub output: String,
    /// The standard error; may be empty.
    pub errors: String,
    /// The location, if the case concerns a file.
    pub place: Option<Place>,
}

/// The outcome of a case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The case passed.
    Passed,
    /// The case failed.
    Failed(Reason),
    /// The case could not run.
    Error(Reason),
    /// The case was skipped, for this reason.
    Skipped(String),
}

/// The reason why a case didn't pass.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reason {
    /// The kind of failure, such as the id of a rule.
    pub kind: String,
    /// A short description.
    pub message: String,
    /// A full description.
    pub text: String,
}

impl Case {
    /// Creates a passed case.
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
            // GitLab and others use this attribute to link to the file.
            case.extra.insert("file".into(), path(&place.path).into());
            if let Some(line) = place.region.line() {
                case.extra.insert("line".into(), line.to_string().into());
            }
        }
        case
    }
}

/// The start and the end of an XML document, which enclose its suites.
const DOCUMENT: [&str; 2] = ["<testsuites ", "</testsuites>\n"];

/// The number of cases with each outcome, for documents whose suites are written one at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    tests: usize,
    skipped: usize,
    failures: usize,
    errors: usize,
}

impl Counts {
    /// Adds the cases of a suite, and returns the XML of the suite.
    pub fn add(&mut self, suite: &Suite) -> String {
        let mut written = TestSuite::new(one_line(&suite.name));
        written.add_test_cases(suite.cases.iter().map(Case::write));
        let mut whole = quick_junit::Report::new("");
        whole.add_test_suite(written);
        self.tests += whole.tests;
        self.skipped += whole.skipped;
        self.failures += whole.failures;
        self.errors += whole.errors;
        // Writing to memory can't fail.
        let text = whole.to_string().unwrap_or_default();
        let [start, end] = DOCUMENT;
        let suites = text.find(start).and_then(|at| Some(at + text[at..].find('\n')? + 1));
        let suites = suites.map_or("", |at| &text[at..]);
        suites.strip_suffix(end).unwrap_or(suites).to_owned()
    }

    /// The parts of the document before and after the suites.
    pub fn document(&self, name: &str) -> (String, &'static str) {
        let Self { tests, skipped, failures, errors } = *self;
        let mut whole = quick_junit::Report::new(name);
        (whole.tests, whole.skipped, whole.failures, whole.errors) = (tests, skipped, failures, errors);
        // Writing to memory can't fail.
        let text = whole.to_string().unwrap_or_default();
        let end = DOCUMENT[1];
        (text.strip_suffix(end).unwrap_or(&text).to_owned(), end)
    }
}

/// The suites as an XML document.
pub fn write(name: &str, suites: &[Suite]) -> String {
    let mut counts = Counts::default();
    let written: String = suites.iter().map(|suite| counts.add(suite)).collect();
    let (start, end) = counts.document(name);
    start + &written + end
}

/// Puts a text on one line, as attributes require.
pub(super) fn one_line(text: &str) -> String {
    visible(&text.split_whitespace().collect::<Vec<_>>().join(" "))
}

/// Escapes characters that XML doesn't allow, that are invisible, or that start commands of CI systems.
fn visible(text: &str) -> String {
    guarded(text).replace('\t', " ")
}
