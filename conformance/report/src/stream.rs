//! Creates reports while subjects are being checked, so that subjects can be dropped before the run ends.

use std::io::{self, Write};
use std::path::Path;

use super::format::{Format, Run};
use super::spool::Spool;
use super::totals::Totals;
use super::{Action, Kind, Report, Subject, json};

/// The reports of a run, and the totals of its subjects.
pub struct Stream {
    action: Action,
    command: String,
    totals: Totals,
    /// The first subject, until it is known to be the only one.
    held: Option<Subject>,
    formats: Vec<Option<Box<dyn Format>>>,
    /// The first error of each format.
    errors: Vec<Option<io::Error>>,
}

impl Stream {
    /// Starts reports in these formats. Parts that don't fit into memory are temporarily stored in the given folders.
    pub fn new<'f>(
        action: Action,
        command: String,
        kinds: impl IntoIterator<Item = (Kind, Option<&'f Path>)>,
    ) -> Self {
        let formats: Vec<_> =
            kinds.into_iter().map(|(kind, folder)| Some(kind.format(Spool::new(folder)))).collect();
        let errors = formats.iter().map(|_| None).collect();
        Self { action, command, totals: Totals::default(), held: None, formats, errors }
    }

    /// Adds a subject to the totals and to all reports.
    pub fn add(&mut self, subject: Subject) {
        self.totals.add(&subject);
        if self.totals.is_single() {
            self.held = Some(subject);
            return;
        }
        if let Some(first) = self.held.take() {
            self.render(&first, false);
        }
        self.render(&subject, false);
    }

    /// The totals of all subjects. No subject can be added afterwards.
    pub fn finish(&mut self) -> Totals {
        if let Some(only) = self.held.take() {
            self.render(&only, true);
        }
        std::mem::take(&mut self.totals)
    }

    /// Writes the report with this index.
    pub fn write(&mut self, index: usize, report: &Report, to: &mut dyn Write) -> io::Result<()> {
        if let Some(error) = self.errors.get_mut(index).and_then(Option::take) {
            return Err(error);
        }
        let format = self.formats.get_mut(index).and_then(Option::take);
        format.map_or(Ok(()), |format| format.finish(report, to))
    }

    fn render(&mut self, subject: &Subject, is_single: bool) {
        let run = Run { action: self.action, command: &self.command, is_single };
        for (format, error) in self.formats.iter_mut().zip(&mut self.errors) {
            if let (Some(format), None) = (format, &error) {
                *error = format.add(subject, run).err();
            }
        }
    }
}

impl Report {
    /// The report as text without colours.
    pub fn to_plain_text(&self) -> String {
        anstream::adapter::strip_str(&self.to_text(Kind::Text)).to_string()
    }

    /// Renders the report. [`Kind::Text`] contains terminal colours, which `anstream` can remove.
    pub fn to_text(&self, kind: Kind) -> String {
        if kind == Kind::Json {
            return json::write(self);
        }
        let mut format = kind.format(Spool::in_memory());
        let is_single = self.subjects.len() == 1;
        let run = Run { action: self.action, command: &self.command, is_single };
        let mut text = Vec::new();
        // Writing to memory can't fail.
        let added = self.subjects.iter().try_for_each(|subject| format.add(subject, run));
        let _ = added.and_then(|()| format.finish(self, &mut text));
        String::from_utf8(text).unwrap_or_default()
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use std::sync::LazyLock;
    use std::time::Duration;

    use clap::ValueEnum as _;
    use uavspec_check::check_capture;
    use uavspec_rules::definitions::Definitions;
    use uavspec_rules::sample::Flight;
    use uavspec_test_support::extent;

    use super::*;
    use crate::{CheckedCapture, Settings, Unreadable};

    /// Captures that violate the tested rules.
    pub(crate) static SUBJECTS: LazyLock<Vec<Subject>> = LazyLock::new(|| {
        let definitions = Definitions::built_in();
        let flight = Flight::new(&definitions);
        let mutants = uavspec_rules::mutants().step_by(extent(1, 31));
        let subject = |(path, bytes): (String, Vec<u8>)| {
            let result = check_capture(&bytes[..], None, &definitions).expect("bytes can be read");
            let checked = CheckedCapture::new(path, result, Duration::from_millis(7));
            Subject::from_capture(checked, &definitions, &Settings::default())
        };
        mutants.flat_map(|mutant| mutant.captures(&flight)).map(subject).collect()
    });

    #[test]
    fn dropped_subjects_appear_in_all_reports() {
        let definitions = Definitions::built_in();
        let subjects = &*SUBJECTS;
        let kinds = Kind::value_variants();
        for number in [0, 1, 2, subjects.len()] {
            let subjects = &subjects[..number];
            let unreadable = vec![Unreadable { path: "gone".to_owned(), message: "absent".to_owned() }];
            let command = || "uavspec check".to_owned();
            let mut stream = Stream::new(Action::Check, command(), kinds.iter().map(|kind| (*kind, None)));
            for subject in subjects {
                stream.add(subject.clone());
            }
            let (totals, reasons) = (stream.finish(), Vec::new());
            let dropped = Report::of_totals(
                Action::Check,
                command(),
                &definitions.name,
                totals,
                unreadable.clone(),
                reasons.clone(),
            );
            let kept =
                Report::new(Action::Check, command(), &definitions, subjects.to_vec(), unreadable, reasons);
            for (index, kind) in kinds.iter().enumerate() {
                let mut written = Vec::new();
                stream.write(index, &dropped, &mut written).expect("a report");
                let written = String::from_utf8(written).expect("UTF-8");
                assert!(written == kept.to_text(*kind), "{kind:?} with {number} subjects");
            }
        }
    }

    #[test]
    fn a_report_that_misses_a_subject_is_an_error() {
        let definitions = Definitions::built_in();
        let folder = tempfile::tempdir().expect("a folder");
        let absent = folder.path().join("absent");
        let kinds = [(Kind::Json, Some(absent.as_path())), (Kind::Short, None)];
        let mut stream = Stream::new(Action::Check, String::new(), kinds);
        // More than fits into memory.
        for subject in SUBJECTS.iter().cycle().take(extent(40 * SUBJECTS.len(), 600)) {
            stream.add(subject.clone());
        }
        let totals = stream.finish();
        let report = Report::of_totals(
            Action::Check,
            String::new(),
            &definitions.name,
            totals,
            Vec::new(),
            Vec::new(),
        );
        assert!(stream.write(0, &report, &mut Vec::new()).is_err(), "there is no folder for temporary files");
        assert!(stream.write(1, &report, &mut Vec::new()).is_ok(), "the other report is complete");
    }
}
