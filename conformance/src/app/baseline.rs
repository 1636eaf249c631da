//! Baselines of commands that check captures, servers and codecs.

use uavspec_check::baseline::{rule_ids, rule_outcomes, unread_outcome};
pub(super) use uavspec_codegen::cli::baseline::{BaselineArgs, Baselines};
use uavspec_lint::baseline::{Lists, Sums};
use uavspec_model::{Extent, Reason};
use uavspec_report::CheckedCapture;
use uavspec_schema::Failure;

use super::Status;
use super::outputs::Output;

/// The baseline file to write.
pub(super) fn outputs(args: &BaselineArgs) -> impl Iterator<Item = Output<'_>> {
    args.output().into_iter().map(|path| Output::new("--write-baseline", path))
}

/// Reads the baselines. Prints errors.
pub(super) fn read(args: &BaselineArgs) -> Result<Baselines, Status> {
    args.read(&rule_ids()).map_err(|failure| Status::Usage.failed(&failure))
}

/// Writes the baseline of `--write-baseline`. Returns the status that results from the baselines, one of which may be
/// outdated. Prints errors.
pub(super) fn write(baselines: &Baselines, is_outdated: Result<bool, Failure>) -> Status {
    match is_outdated.map(|is_outdated| (is_outdated, baselines.write())) {
        Err(failure) => Status::Usage.failed(&failure),
        Ok((_, Err(failure))) => Status::Unreadable.failed(&failure),
        Ok((true, Ok(()))) => Status::Stale,
        Ok((false, Ok(()))) => Status::Conforms,
    }
}

/// The outdated entries of the baselines, as reasons why the run fails.
pub(super) fn reasons(baselines: &Baselines) -> Vec<Reason> {
    let sources = baselines.lists.sources();
    let reasons = baselines.outdated.iter().map(|finding| Reason {
        message: finding.message.clone(),
        path: sources.path(sources.source_of(finding.span)).to_owned(),
        line: Some(sources.position(finding.span).line as u64),
    });
    reasons.collect()
}

/// Counts the results of a capture, for the comparison with the baselines.
pub(super) fn count_capture(lists: &Lists, sums: &mut Sums, capture: &CheckedCapture) {
    for (name, outcome) in rule_outcomes(&capture.path, &capture.result.findings) {
        lists.count(sums, &name, &outcome);
    }
    if capture.result.extent == Extent::Unreadable {
        count_unread(lists, sums, &capture.path);
    }
}

/// Counts a file that can't be read, for the comparison with the baselines.
pub(super) fn count_unread(lists: &Lists, sums: &mut Sums, path: &str) {
    for (name, outcome) in unread_outcome(path) {
        lists.count(sums, &name, &outcome);
    }
}
