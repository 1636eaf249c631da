//! Creates reports while subjects are being checked, so that each subject can be dropped before the run ends.

use std::io::{self, Write};
use std::path::Path;

use uavspec_schema::json_text;

use super::kind::Format;
use super::spool::Spool;
use super::totals::Totals;
use super::{Action, Kind, Report, Subject};

/// The reports of a run, and the totals of its subjects.
pub struct Stream {
    totals: Totals,
    /// The reports. `None` if a report has been written, because this is possible only once.
    formats: Vec<Option<Started>>,
}

/// A format, and the spool of its parts. If a part couldn't be written, the error replaces the spool.
type Started = (Box<dyn Format>, io::Result<Spool>);

impl Stream {
    /// Starts reports in these formats. Parts that don't fit in memory are stored temporarily in the given folders.
    pub fn new<'f>(
        action: Action,
        command: &str,
        kinds: impl IntoIterator<Item = (Kind, Option<&'f Path>)>,
    ) -> Self {
        let format = |(kind, folder): (Kind, _)| (kind.format(action, command), Ok(Spool::new(folder)));
        let formats = kinds.into_iter().map(|kind| Some(format(kind))).collect();
        Self { totals: Totals::default(), formats }
    }

    /// Adds a subject to the totals and to all reports.
    pub fn add(&mut self, subject: &Subject) {
        self.totals.add(subject);
        for (format, spool) in self.formats.iter_mut().flatten() {
            if let Ok(parts) = spool
                && let Err(error) = parts.push(&format.add(subject))
            {
                *spool = Err(error);
            }
        }
    }

    /// Returns the totals of all subjects. No further subjects can be added.
    pub fn finish(&mut self) -> Totals {
        std::mem::take(&mut self.totals)
    }

    /// Writes the report with this index.
    pub fn write(&mut self, index: usize, report: &Report, to: &mut dyn Write) -> io::Result<()> {
        let Some((format, parts)) = self.formats.get_mut(index).and_then(Option::take) else { return Ok(()) };
        format.finish(report, &mut parts?.into_reader()?, to)
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
            return json_text::pretty(self);
        }
        let mut format = kind.format(self.action, &self.command);
        let parts: String = self.subjects.iter().map(|subject| format.add(subject)).collect();
        let mut text = Vec::new();
        // Writing to memory can't fail.
        let _ = format.finish(self, &mut parts.as_bytes(), &mut text);
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
            let mut stream = Stream::new(Action::Check, &command(), kinds.iter().map(|kind| (*kind, None)));
            for subject in subjects {
                stream.add(subject);
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
            let kept = Report::new(
                Action::Check,
                command(),
                &definitions.name,
                subjects.to_vec(),
                unreadable,
                reasons,
            );
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
        let mut stream = Stream::new(Action::Check, "", kinds);
        // More than fits into memory.
        for subject in SUBJECTS.iter().cycle().take(extent(40 * SUBJECTS.len(), 600)) {
            stream.add(subject);
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
