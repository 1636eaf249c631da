//! Checks whether a testee implements the protocol, including parts that `uavspec test` doesn't use.
//!
//! Each check has a separate process or connection, so that a crash affects only the check that caused it.

mod answers;
mod introduction;
mod leaving;
mod malformed;
mod numbers;
pub mod report;
mod session;
mod unknown;

use uavspec_dynamic::Types;

use self::session::{Session, Strays};
use super::case::Case;
use super::link::Link;
use super::options::Options;
use super::protocol::Hello;
use super::timeouts::Timeouts;

/// A requirement of the protocol.
pub struct Check {
    /// The name. It never changes.
    pub id: &'static str,
    /// The requirement.
    pub statement: &'static str,
    /// The advice for fixing a failure.
    pub help: &'static str,
    attempt: fn(&mut Bench<'_>) -> CheckOutcome,
}

/// The outcome of a check.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CheckOutcome {
    /// The testee meets the requirement.
    Pass,
    /// The testee doesn't meet the requirement. Contains a description of the testee's behaviour.
    Fail(String),
    /// The check doesn't apply, for this reason.
    NotApplicable(String),
}

impl CheckOutcome {
    /// The name of the outcome.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail(_) => "fail",
            Self::NotApplicable(_) => "not applicable",
        }
    }

    /// The description of a failure, or the reason why the check doesn't apply.
    pub fn message(&self) -> Option<&str> {
        match self {
            Self::Pass => None,
            Self::Fail(what) | Self::NotApplicable(what) => Some(what),
        }
    }
}

impl From<Result<(), String>> for CheckOutcome {
    fn from(result: Result<(), String>) -> Self {
        result.map_or_else(Self::Fail, |()| Self::Pass)
    }
}

/// All checks, in the order in which they run.
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
    // This check comes last, because it reports lines that were received in the other checks.
    answers::ONLY_ANSWERS,
];

/// The result of all checks.
pub struct LintResult {
    /// The introduction of the testee. `None` if the testee sent no valid hello.
    pub hello: Option<Hello>,
    /// The checks and their outcomes.
    pub outcomes: Vec<(&'static Check, CheckOutcome)>,
}

impl LintResult {
    /// True if no check failed.
    pub fn is_ok(&self) -> bool {
        self.outcomes.iter().all(|(_, outcome)| !matches!(outcome, CheckOutcome::Fail(_)))
    }
}

/// The check with this id.
pub fn check(id: &str) -> Option<&'static Check> {
    CHECKS.iter().find(|check| check.id == id)
}

/// Checks a testee. Returns an error if the testee can't be started or accepts no connection. `only` selects checks. If
/// `only` is empty, all checks run. The first check always runs because the others require it. `progress` receives the
/// number of finished checks and the total number.
pub fn lint(
    cases: &[Case],
    types: &Types,
    options: &Options,
    only: &[&Check],
    progress: &dyn Fn(usize, usize),
) -> Result<LintResult, String> {
    // A testee that can't be started is an error of the run, not of a check.
    let first = Some(Link::open(options, false)?);
    let (introduced, strays, timeouts) = (None, Strays::default(), Timeouts::default());
    let mut bench = Bench { cases, types, options, first, introduced, strays, timeouts, gave_up: None };
    let is_first = |check: &Check| check.id == introduction::INTRODUCTION.id;
    let is_selected =
        |check: &&Check| only.is_empty() || is_first(check) || only.iter().any(|other| other.id == check.id);
    let checks: Vec<&Check> = CHECKS.iter().filter(is_selected).collect();
    let mut outcomes = Vec::new();
    for check in &checks {
        let outcome = if let Some(why) = &bench.gave_up {
            CheckOutcome::NotApplicable(format!("not checked: {why}"))
        } else if is_first(check) || bench.introduced.is_some() {
            (check.attempt)(&mut bench)
        } else {
            CheckOutcome::NotApplicable("the testee doesn't send a valid hello".to_owned())
        };
        outcomes.push((*check, outcome));
        progress(outcomes.len(), checks.len());
    }
    Ok(LintResult { hello: bench.introduced.map(|(hello, _)| hello), outcomes })
}

/// The state that checks share.
struct Bench<'b> {
    cases: &'b [Case],
    types: &'b Types,
    options: &'b Options,
    /// The first connection, opened before the checks.
    first: Option<Link>,
    /// The hello, and the line that contained it.
    introduced: Option<(Hello, Vec<u8>)>,
    /// Received lines that are not responses.
    strays: Strays,
    timeouts: Timeouts,
    /// The reason why no more checks run: the testee doesn't answer, and each check would wait for its time limit.
    gave_up: Option<String>,
}

impl Bench<'_> {
    /// Runs a check in a separate session, and collects the lines that are not responses.
    fn run(&mut self, act: impl FnOnce(&Self, &mut Session<'_>) -> Result<(), String>) -> CheckOutcome {
        let mut session = match Session::start(self.options) {
            Ok(session) => session,
            Err(wrong) => {
                self.gave_up = Some("the testee didn't start again".to_owned());
                return CheckOutcome::Fail(wrong);
            }
        };
        let result = act(self, &mut session);
        if session.has_response() {
            self.timeouts.answered();
        }
        if session.has_timed_out {
            self.gave_up = self.timeouts.count(self.options);
        }
        self.strays.append(session.received.strays);
        result.into()
    }

    /// The cases that the testee supports.
    fn known_cases(&self) -> impl Iterator<Item = &Case> {
        let hello = self.introduced.as_ref().map(|(hello, _)| hello);
        self.cases.iter().filter(move |case| hello.is_some_and(|hello| case.is_for(hello)))
    }

    /// The first supported case that has valid input and satisfies the predicate.
    fn known_case(&self, is_wanted: impl Fn(&Case) -> bool) -> Option<&Case> {
        self.known_cases().find(|case| case.rule.is_none() && is_wanted(case))
    }

    /// A case to send: a supported case, or any case if no case is supported.
    fn plain_case(&self) -> Result<&Case, String> {
        let case = self.known_case(|_| true).or_else(|| self.cases.first());
        case.ok_or_else(|| "the definitions contain no messages".to_owned())
    }
}
