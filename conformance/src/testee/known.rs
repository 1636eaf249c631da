//! The results of cases, as lists of known failures see them, and the cases that a list excuses.

use std::collections::BTreeMap;
use std::ptr;

use super::case::Case;
use super::outcome::{Outcome as Answers, Verdict};
use crate::check::known::{Checked, Lists, Name, Outcome};

/// What came of cases: of those that were asked, as `answers` says, and of all others, which were not. `names` are
/// the names of all cases.
pub(crate) fn case_outcomes<'r>(names: &'r [(&'r Case, String)], answers: &Answers<'r>) -> Vec<Checked<'r>> {
    let requested: BTreeMap<*const Case, &Verdict> =
        answers.verdicts.iter().map(|(case, verdict)| (ptr::from_ref(*case), verdict)).collect();
    let checked = names.iter().map(|(case, name)| {
        let outcome = match requested.get(&ptr::from_ref(*case)) {
            Some(Verdict::Pass) => Outcome::Passed,
            Some(Verdict::Unsupported) => Outcome::Idle,
            None | Some(Verdict::NotRun) => Outcome::NotRun,
            Some(failure) => Outcome::Failed(vec![failure.to_string()]),
        };
        Checked { name: Name::Case(name), outcome }
    });
    checked.collect()
}

/// Makes each failure that an entry excuses a known one.
pub(crate) fn excuse_cases(lists: &Lists, answers: &mut Answers<'_>) {
    for (case, verdict) in answers.verdicts.iter_mut().filter(|(_, verdict)| verdict.is_failure()) {
        let messages = [verdict.to_string()];
        if let Some(excuse) = lists.excuse(Name::Case(&case.name()), &messages) {
            let failure = std::mem::replace(verdict, Verdict::NotRun);
            *verdict = Verdict::Known { failure: Box::new(failure), excuse: excuse.clone() };
        }
    }
}
