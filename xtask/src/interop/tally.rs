//! Comparison of a tool's verdicts with the expected results.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::AddAssign;

use serde::{Deserialize, Serialize};

use super::adapter::{Answer, Answers, End, Verdict};
use super::job::{Case, Form, Job};
use super::tool::{Kind, Tool};

/// The result of a tool's run.
#[derive(Debug)]
pub(super) struct Tally {
    pub(super) version: Option<String>,
    pub(super) end: End,
    pub(super) counts: BTreeMap<(Form, String), Count>,
    pub(super) disagreements: Vec<Disagreement>,
}

/// A tool's results for the cases of one package, whose schemas are referred to in one form.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
pub(super) struct Count {
    /// The number of schemas that the tool could use. For generators, the generated code must compile.
    pub(super) schemas: usize,
    /// The number of schemas that the tool could not use.
    pub(super) schemas_failed: usize,
    pub(super) agreed: usize,
    pub(super) disagreed: usize,
    /// The number of cases without a verdict, usually because the tool could not use their schema.
    pub(super) not_run: usize,
    /// The number of invalid cases that generated code rejects. The code may also accept invalid cases, because types
    /// can't express all constraints.
    pub(super) refused: usize,
    /// The number of invalid cases that generated code accepts.
    pub(super) taken: usize,
}

/// A disagreement of a tool.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Disagreement {
    pub(super) form: Form,
    /// The type, followed by `#` and the case if the disagreement concerns a single case.
    pub(super) place: String,
    pub(super) does: Does,
    /// The message of the tool.
    pub(super) message: String,
}

/// The kind of disagreement.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Does {
    /// The tool accepts an invalid instance.
    Takes,
    /// The tool rejects a valid instance.
    Refuses,
    /// The tool fails on an instance.
    Fails,
    /// The tool rejects a schema.
    RefusesSchema,
    /// The tool gives no answer for a schema, or for a case of a compiled schema.
    SaysNothing,
}

impl fmt::Display for Does {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Takes => "accepts invalid instances",
            Self::Refuses => "rejects valid instances",
            Self::Fails => "fails on instances",
            Self::RefusesSchema => "can't use the schema",
            Self::SaysNothing => "gives no answer",
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
    /// Compares answers with the expected results. Ignores jobs in a form that the tool doesn't support.
    pub(super) fn of(tool: &Tool, jobs: &[Job], answers: Answers) -> Self {
        let mut tally = Self {
            version: answers.version,
            end: answers.end,
            counts: BTreeMap::new(),
            disagreements: Vec::new(),
        };
        let is_supported = |job: &Job| tool.form.is_none_or(|form| form == job.form);
        for (job, answer) in jobs.iter().zip(answers.jobs).filter(|(job, _)| is_supported(job)) {
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
        // Disagreements of generated code count only for valid instances.
        let is_relevant = |case: &&Case| kind == Kind::Validator || case.is_valid;
        let verdicts = match answer {
            Answer::Verdicts(verdicts) => verdicts,
            Answer::NoSchema(error) => {
                count.schemas_failed += 1;
                count.not_run += job.cases.iter().filter(is_relevant).count();
                return disagree(job.name.clone(), Does::RefusesSchema, error);
            }
            Answer::Nothing => {
                count.not_run += job.cases.iter().filter(is_relevant).count();
                return disagree(job.name.clone(), Does::SaysNothing, String::new());
            }
        };
        count.schemas += 1;
        for (case, verdict) in job.cases.iter().zip(verdicts) {
            if !is_relevant(&case) {
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
