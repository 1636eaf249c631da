//! A testee's manners: whether it keeps to the protocol where `uavspec test` would not look, each tried by itself.
//!
//! Every check has a process or a connection of its own, so that what one of them breaks is no other's fault.

mod answers;
mod introduction;
mod leaving;
mod malformed;
mod numbers;
pub(crate) mod report;
mod session;
mod unknown;

use uavspec_codegen::dynamic::Types;

use self::session::{Session, Strays};
use super::case::Case;
use super::link::Link;
use super::options::Options;
use super::protocol::Hello;

/// Something that a testee should do.
pub struct Check {
    /// Its name; it never changes.
    pub id: &'static str,
    /// What is asked for.
    pub statement: &'static str,
    /// What to do where it fails.
    pub help: &'static str,
    attempt: fn(&mut Bench<'_>) -> CheckOutcome,
}

/// What came of a check.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CheckOutcome {
    /// The testee does it.
    Good,
    /// It doesn't, and what it does.
    Bad(String),
    /// It can't be tried, and why.
    NotApplicable(String),
}

impl CheckOutcome {
    /// Its name.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Good => "pass",
            Self::Bad(_) => "fail",
            Self::NotApplicable(_) => "not applicable",
        }
    }

    /// What there is to tell.
    pub fn message(&self) -> Option<&str> {
        match self {
            Self::Good => None,
            Self::Bad(what) | Self::NotApplicable(what) => Some(what),
        }
    }
}

impl From<Result<(), String>> for CheckOutcome {
    fn from(result: Result<(), String>) -> Self {
        result.map_or_else(Self::Bad, |()| Self::Good)
    }
}

/// All checks, in the order in which they are tried.
pub const CHECKS: &[Check] = &[
    introduction::INTRODUCTION,
    introduction::HELLO_MEMBERS,
    introduction::SECOND_HELLO,
    answers::ANSWERS_HAVE_IDS,
    answers::ONE_ANSWER_EACH,
    answers::IDS_OF_ANY_SIZE,
    answers::QUESTIONS_IN_ONE_WRITE,
    answers::QUESTION_IN_MANY_WRITES,
    answers::LONG_QUESTION,
    unknown::UNKNOWN_OP,
    unknown::UNKNOWN_TYPE,
    unknown::UNKNOWN_FORMAT,
    unknown::MISSING_MEMBER,
    malformed::EMPTY_LINE,
    malformed::NOT_JSON,
    malformed::NOT_UTF8,
    numbers::TAGGED_INTEGERS,
    numbers::TAGGED_FLOATS,
    leaving::ANSWERS_BEFORE_END,
    leaving::ENDS_BY_ITSELF,
    // The last, as it is about what the others heard.
    answers::ONLY_ANSWERS,
];

/// What came of all checks.
pub struct Found {
    /// Who was asked; none where it doesn't introduce itself.
    pub hello: Option<Hello>,
    /// The checks, and what came of each.
    pub outcomes: Vec<(&'static Check, CheckOutcome)>,
}

impl Found {
    /// Whether no check failed.
    pub fn are_good(&self) -> bool {
        self.outcomes.iter().all(|(_, manner)| !matches!(manner, CheckOutcome::Bad(_)))
    }
}

/// The check with this name.
pub fn check(id: &str) -> Option<&'static Check> {
    CHECKS.iter().find(|check| check.id == id)
}

/// Tries the manners of a testee; an error where it can't be started, or nobody takes the connection. `only` names the
/// checks, all where it is empty; the first is needed for all others. `progress` gets how many are done, and how many
/// there are.
pub fn lint(
    cases: &[Case],
    types: &Types,
    options: &Options,
    only: &[&Check],
    progress: &dyn Fn(usize, usize),
) -> Result<Found, String> {
    // Whether there is anything to try is not up to the checks.
    let first = Some(Link::open(options, false)?);
    let mut bench = Bench { cases, types, options, first, introduced: None, strays: Strays::default() };
    let is_first = |check: &Check| check.id == introduction::INTRODUCTION.id;
    let is_asked =
        |check: &&Check| only.is_empty() || is_first(check) || only.iter().any(|other| other.id == check.id);
    let checks: Vec<&Check> = CHECKS.iter().filter(is_asked).collect();
    let mut outcomes = Vec::new();
    for check in &checks {
        let manner = if is_first(check) || bench.introduced.is_some() {
            (check.attempt)(&mut bench)
        } else {
            CheckOutcome::NotApplicable("it doesn't introduce itself".to_owned())
        };
        outcomes.push((*check, manner));
        progress(outcomes.len(), checks.len());
    }
    Ok(Found { hello: bench.introduced.map(|(hello, _)| hello), outcomes })
}

/// What checks work with.
struct Bench<'b> {
    cases: &'b [Case],
    types: &'b Types,
    options: &'b Options,
    /// What was opened to see that it can be.
    first: Option<Link>,
    /// The hello that was read, and its line.
    introduced: Option<(Hello, Vec<u8>)>,
    /// What the testee said that answers nothing.
    strays: Strays,
}

impl Bench<'_> {
    /// Tries something in a session of its own, and keeps what was heard there that answers nothing.
    fn attempt(&mut self, act: impl FnOnce(&Self, &mut Session<'_>) -> Result<(), String>) -> CheckOutcome {
        let mut session = match Session::start(self.options) {
            Ok(session) => session,
            Err(wrong) => return CheckOutcome::Bad(wrong),
        };
        let result = act(self, &mut session);
        self.strays.append(session.into_strays());
        result.into()
    }

    /// The cases that the testee says it knows.
    fn known_cases(&self) -> impl Iterator<Item = &Case> {
        let hello = self.introduced.as_ref().map(|(hello, _)| hello);
        self.cases.iter().filter(move |case| hello.is_some_and(|hello| case.is_for(hello)))
    }

    /// A case that the testee knows and that is no mistake, the first for which this holds.
    fn known_case(&self, is_wanted: impl Fn(&Case) -> bool) -> Option<&Case> {
        self.known_cases().find(|case| case.rule.is_none() && is_wanted(case))
    }

    /// Something to ask. Where the testee knows nothing of what there is, that is a question that it doesn't know.
    fn plain_case(&self) -> Result<&Case, String> {
        let case = self.known_case(|_| true).or_else(|| self.cases.first());
        case.ok_or_else(|| "the definitions have no message to ask about".to_owned())
    }
}
