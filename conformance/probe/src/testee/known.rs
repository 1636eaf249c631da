//! Converts case results to the form that baselines use, and applies the baselines.

use std::collections::BTreeMap;
use std::ptr;

use uavspec_check::baseline::excuse;
use uavspec_lint::baseline::{Lists, Name, Outcome};

use super::case::Case;
use super::outcome::{Outcome as Run, Verdict};

/// The outcomes of the cases in `names`, which contains all cases. Cases without a verdict in `run` were not run.
pub fn case_outcomes<'r>(names: &'r [(&'r Case, String)], run: &Run<'r>) -> Vec<(Name<'r>, Outcome)> {
    let requested: BTreeMap<*const Case, &Verdict> =
        run.verdicts.iter().map(|(case, verdict)| (ptr::from_ref(*case), verdict)).collect();
    let checked = names.iter().map(|(case, name)| {
        let outcome = match requested.get(&ptr::from_ref(*case)) {
            Some(Verdict::Pass) => Outcome::Passed,
            Some(Verdict::Unsupported) => Outcome::Idle,
            None | Some(Verdict::NotRun) => Outcome::NotRun,
            Some(failure) => Outcome::Failed(vec![failure.to_string()]),
        };
        (Name::case(name), outcome)
    });
    checked.collect()
}

/// Marks failures as known if an entry of a baseline covers them.
pub fn excuse_cases(lists: &mut Lists, run: &mut Run<'_>) {
    for (case, verdict) in run.verdicts.iter_mut().filter(|(_, verdict)| verdict.is_failure()) {
        let messages = [verdict.to_string()];
        if let Some(entry) = lists.find_or_add(&Name::case(&case.name()), &messages, None) {
            let failure = Box::new(std::mem::replace(verdict, Verdict::NotRun));
            *verdict = Verdict::Known { failure, excuse: excuse(entry) };
        }
    }
}
