//! What a tool said, beside what is true.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::AddAssign;

use serde::{Deserialize, Serialize};

use super::adapter::{Answer, Answers, End, Verdict};
use super::job::{Case, Form, Job};
use super::tool::{Kind, Tool};

/// The outcome of a tool's run.
#[derive(Debug)]
pub(super) struct Tally {
    pub(super) version: Option<String>,
    pub(super) end: End,
    pub(super) counts: BTreeMap<(Form, String), Count>,
    pub(super) disagreements: Vec<Disagreement>,
}

/// How often a tool agreed, over the cases of a package in one form.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
pub(super) struct Count {
    /// Schemas that it could use, or make code of that compiles.
    pub(super) schemas: usize,
    /// Schemas that it couldn't.
    pub(super) schemas_failed: usize,
    pub(super) agreed: usize,
    pub(super) disagreed: usize,
    /// Cases that it said nothing of, mostly since it couldn't use their schema.
    pub(super) not_run: usize,
    /// Invalid cases that a generator's code refuses. It needn't: types can't say everything.
    pub(super) refused: usize,
    /// Invalid cases that it takes.
    pub(super) taken: usize,
}

/// Something that a tool sees in another way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Disagreement {
    pub(super) form: Form,
    /// The type; after `#` the case, if it is about one.
    pub(super) place: String,
    pub(super) does: Does,
    /// The tool's own words.
    pub(super) message: String,
}

/// What a tool does that it shouldn't do.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Does {
    /// It takes an invalid instance.
    Takes,
    /// It refuses a valid instance.
    Refuses,
    /// It fails on an instance.
    Fails,
    /// It can't use a schema.
    RefusesSchema,
    /// It says nothing of cases whose schema it has compiled, or of a schema.
    SaysNothing,
}

impl fmt::Display for Does {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Takes => "accepts invalid instances",
            Self::Refuses => "refuses valid instances",
            Self::Fails => "fails on instances",
            Self::RefusesSchema => "can't use the schema",
            Self::SaysNothing => "says nothing",
        })
    }
}

impl AddAssign for Count {
    fn add_assign(&mut self, other: Self) {
        self.schemas += other.schemas;
        self.schemas_failed += other.schemas_failed;
        self.agreed += other.agreed;
        self.disagreed += other.disagreed;
        self.not_run += other.not_run;
        self.refused += other.refused;
        self.taken += other.taken;
    }
}

impl Tally {
    /// Compares answers with what is true of the cases. Jobs of a form that the tool can't be given are left out.
    pub(super) fn of(tool: &Tool, jobs: &[Job], answers: Answers) -> Self {
        let mut tally = Self {
            version: answers.version,
            end: answers.end,
            counts: BTreeMap::new(),
            disagreements: Vec::new(),
        };
        let is_given = |job: &Job| tool.form.is_none_or(|form| form == job.form);
        for (job, answer) in jobs.iter().zip(answers.jobs).filter(|(job, _)| is_given(job)) {
            tally.add(tool.kind, job, answer);
        }
        tally
    }

    /// The sum over all packages and forms.
    pub(super) fn total(&self) -> Count {
        self.counts.values().fold(Count::default(), |mut total, count| {
            total += *count;
            total
        })
    }

    fn add(&mut self, kind: Kind, job: &Job, answer: Answer) {
        let count = self.counts.entry((job.form, job.package.clone())).or_default();
        let mut disagree = |place: String, does, message| {
            self.disagreements.push(Disagreement { form: job.form, place, does, message });
        };
        // Of generated code only valid instances are a matter.
        let matters = |case: &&Case| kind == Kind::Validator || case.is_valid;
        let verdicts = match answer {
            Answer::Verdicts(verdicts) => verdicts,
            Answer::NoSchema(error) => {
                count.schemas_failed += 1;
                count.not_run += job.cases.iter().filter(matters).count();
                return disagree(job.name.clone(), Does::RefusesSchema, error);
            }
            Answer::Nothing => {
                count.not_run += job.cases.iter().filter(matters).count();
                return disagree(job.name.clone(), Does::SaysNothing, String::new());
            }
        };
        count.schemas += 1;
        for (case, verdict) in job.cases.iter().zip(verdicts) {
            if !matters(&case) {
                match verdict {
                    Some(Verdict::Valid) => count.taken += 1,
                    Some(_) => count.refused += 1,
                    None => {}
                }
                continue;
            }
            let place = || format!("{}#{}", job.name, case.id);
            let (does, message) = match (verdict, case.is_valid) {
                (Some(Verdict::Valid), true) | (Some(Verdict::Invalid(_)), false) => {
                    count.agreed += 1;
                    continue;
                }
                (None, _) => {
                    count.not_run += 1;
                    disagree(place(), Does::SaysNothing, String::new());
                    continue;
                }
                (Some(Verdict::Valid), false) => (Does::Takes, String::new()),
                (Some(Verdict::Invalid(message)), true) => (Does::Refuses, message),
                (Some(Verdict::Failed(message)), _) => (Does::Fails, message),
            };
            count.disagreed += 1;
            disagree(place(), does, message);
        }
    }
}
