//! Comparison of a tool's verdicts with the expected results, and the record of all results.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

use super::adapter::{Answers, End, Line};
use super::job::{Case, Form, Job};
use super::tool::{Kind, Tool};

/// The results of the latest run of each tool, in `xtask/interop/results.json`.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
pub(super) struct Record {
    /// The number of violating cases for each rule that schemas can't express.
    pub(super) beyond: BTreeMap<String, usize>,
    pub(super) tools: BTreeMap<String, ToolRecord>,
}

/// The results of a tool, without machine-dependent values.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
pub(super) struct ToolRecord {
    pub(super) version: String,
    pub(super) end: End,
    /// The counts by form and package.
    pub(super) counts: BTreeMap<Form, BTreeMap<String, Count>>,
    /// The number of disagreements that each entry explains.
    pub(super) explained: BTreeMap<String, usize>,
}

/// A tool's results for the cases of one package, with one form of references to schemas.
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

/// The result of a tool's run.
#[derive(Debug, Default)]
pub(super) struct Tally {
    pub(super) record: ToolRecord,
    pub(super) disagreements: Vec<Disagreement>,
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

impl Record {
    /// The text of the file.
    pub(super) fn text(&self) -> String {
        let text = serde_json::to_string_pretty(self).expect("records contain only string keys and numbers");
        format!("{text}\n")
    }
}

impl Tally {
    /// Compares answers with the expected results. Ignores jobs in a form that the tool doesn't support.
    pub(super) fn of(tool: &Tool, jobs: &[Job], answers: &Answers) -> Self {
        let mut tally = Self::default();
        tally.record.version = answers.version.clone().unwrap_or_else(|| "unknown".to_owned());
        tally.record.end = answers.end;
        let is_supported = |job: &Job| tool.form.is_none_or(|form| form == job.form);
        for (index, job) in jobs.iter().enumerate().filter(|(_, job)| is_supported(job)) {
            tally.add(tool.kind, job, |case| answers.lines.get(&(index, case)));
        }
        tally
    }

    fn add<'l>(&mut self, kind: Kind, job: &Job, line: impl Fn(Option<usize>) -> Option<&'l Line>) {
        let counts = self.record.counts.entry(job.form).or_default();
        let count = counts.entry(job.package().to_owned()).or_default();
        let mut disagree = |place: String, does, message: &str| {
            let message = message.to_owned();
            self.disagreements.push(Disagreement { form: job.form, place, does, message });
        };
        // Disagreements of generated code count only for valid instances.
        let is_relevant = |case: &&Case| kind == Kind::Validator || case.is_valid;
        let error = match line(None) {
            None => Some((Does::SaysNothing, "")),
            Some(schema) => schema.error.as_deref().map(|error| (Does::RefusesSchema, error)),
        };
        if let Some((does, message)) = error {
            count.schemas_failed += usize::from(does == Does::RefusesSchema);
            count.not_run += job.cases.iter().filter(is_relevant).count();
            return disagree(job.name.clone(), does, message);
        }
        count.schemas += 1;
        for (index, case) in job.cases.iter().enumerate() {
            let verdict = line(Some(index));
            if !is_relevant(&case) {
                match verdict {
                    Some(Line { error: None, valid: Some(true), .. }) => count.taken += 1,
                    Some(_) => count.refused += 1,
                    None => {}
                }
                continue;
            }
            let (does, message) = match verdict {
                None => (Does::SaysNothing, ""),
                Some(Line { error: Some(error), .. }) => (Does::Fails, error.as_str()),
                Some(line) if line.valid == Some(case.is_valid) => {
                    count.agreed += 1;
                    continue;
                }
                Some(_) if !case.is_valid => (Does::Takes, ""),
                Some(line) => (Does::Refuses, line.message.as_deref().unwrap_or_default()),
            };
            count.not_run += usize::from(does == Does::SaysNothing);
            count.disagreed += usize::from(does != Does::SaysNothing);
            disagree(format!("{}#{}", job.name, case.id), does, message);
        }
    }
}
