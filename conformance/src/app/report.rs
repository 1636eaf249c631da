//! The options `--format` and `--report`.

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use anstream::StripStream;
use clap::{Args, ValueEnum as _};
use uavspec_check::timeline::Timeline;
use uavspec_model::text::terminal;
use uavspec_report::{
    Action, Kind, Origin, Report, Stream, Subject, TableFormat, Totals, Unreadable, end_text, subject_text,
};
use uavspec_schema::stage::{folder_of, write_file};

use super::outputs::Output;
use super::tables::{Dataset, Done};
use super::{Exit, Status, unprinted};

/// The path that means standard output.
const STANDARD_OUTPUT: &str = "-";

/// The help for a folder that can't be continued.
const RESUMABLE: &str = "specify a folder that `--report parquet=DIR` or `--resume DIR` wrote";

/// The reports to write, and their paths.
#[derive(Args, Clone, Debug)]
pub(super) struct ReportArgs {
    /// Format of the report [default: text].
    ///
    /// The report is printed to standard output. The formats are text, short (one line for each finding), json,
    /// junit (XML for CI systems), sarif (for editors and code scanning), codequality (for GitLab), html (a self-contained page) and markdown (for pull requests and CI summaries).
    #[arg(long, value_name = "KIND", hide_possible_values = true)]
    format: Option<Kind>,
    /// Write a report to a file (repeatable).
    ///
    /// For example, html=report.html. KIND is one of the formats above, or parquet or arrow: tables in the files of a new
    /// folder. Tables require a program that was built with the feature `tables`. Separate multiple reports with
    /// commas. The path `-` means standard output. A report never replaces an input.
    #[arg(long, value_name = "KIND=PATH", value_delimiter = ',')]
    report: Vec<Target>,
}

/// The reports of a run. Each report is completed after the run, and contains subjects that have already been dropped.
pub(super) struct Outputs<'a> {
    args: &'a ReportArgs,
    stream: Stream,
    tables: Vec<Dataset>,
    /// The first error in printing. It is reported together with the errors from writing report files.
    unprinted: Option<String>,
}

/// A value of `--report`.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Target {
    kind: TargetKind,
    path: PathBuf,
}

/// The kind of a report that is written to files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TargetKind {
    /// A single file, which is written after the run.
    File(Kind),
    /// The files of a folder, which are written during the run.
    Tables(TableFormat),
}

impl TargetKind {
    /// All kinds, with their names.
    fn all() -> impl Iterator<Item = (String, Self)> {
        let files = Kind::value_variants()
            .iter()
            .filter_map(|kind| Some((kind.to_possible_value()?.get_name().to_owned(), Self::File(*kind))));
        files.chain(TableFormat::ALL.map(|format| (format.name().to_owned(), Self::Tables(format))))
    }

    /// The kind of a report in a single file.
    const fn file(self) -> Option<Kind> {
        match self {
            Self::File(kind) => Some(kind),
            Self::Tables(_) => None,
        }
    }

    fn name(self) -> String {
        Self::all().find(|(_, kind)| *kind == self).map(|(name, _)| name).unwrap_or_default()
    }
}

impl FromStr for Target {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, path) = text.split_once('=').filter(|(_, path)| !path.is_empty()).ok_or_else(|| {
            format!("expected KIND=PATH, such as html=report.html; KIND is one of {}", kinds())
        })?;
        let kind = TargetKind::all().find(|(known, _)| known == name).map(|(_, kind)| kind);
        let unknown = || format!("unknown kind `{}`; expected one of {}", terminal::shown(name), kinds());
        Ok(Self { kind: kind.ok_or_else(unknown)?, path: path.into() })
    }
}

fn kinds() -> String {
    TargetKind::all().map(|(name, _)| name).collect::<Vec<_>>().join(", ")
}

impl ReportArgs {
    /// The error if the arguments contradict each other.
    pub(super) fn problem(&self) -> Option<String> {
        if let Some(target) =
            self.report.iter().find(|target| target.is_printed() && target.kind.file().is_none())
        {
            return Some(format!(
                "--report {}=-: tables can't be printed: specify a folder",
                target.kind.name()
            ));
        }
        let printed = self.report.iter().filter(|target| target.is_printed()).count();
        (printed + usize::from(self.format.is_some()) > 1).then(|| {
            "only one report can be printed to standard output: write the others to files".to_owned()
        })
    }

    /// True if a report consists of tables.
    pub(super) fn has_tables(&self) -> bool {
        self.report.iter().any(|target| target.kind.file().is_none())
    }

    /// The report files.
    pub(super) fn outputs(&self) -> impl Iterator<Item = Output<'_>> {
        self.report.iter().map(|target| {
            let kind = target.kind.name();
            Output { name: format!("--report {kind}={}", terminal::path(&target.path)), path: &target.path }
        })
    }

    /// The kind of the report on standard output.
    pub(super) fn printed(&self) -> Kind {
        let mut printed = self.report.iter().filter(|target| target.is_printed());
        let printed = printed.find_map(|target| target.kind.file());
        self.format.or(printed).unwrap_or(Kind::Text)
    }

    /// The reports that are single files.
    fn files(&self) -> impl Iterator<Item = (Kind, &Path)> {
        let files = self.report.iter().filter(|target| !target.is_printed());
        files.filter_map(|target| Some((target.kind.file()?, target.path.as_path())))
    }

    /// Creates the folders of tables. Prints errors.
    fn tables(&self, has_timeline: bool) -> Result<Vec<Dataset>, Status> {
        let tables = self.report.iter().filter_map(|target| match target.kind {
            TargetKind::Tables(format) => Some((format, target.path.as_path())),
            TargetKind::File(_) => None,
        });
        let created = tables.map(|(format, path)| {
            Dataset::create(path, format, has_timeline).map_err(|error| {
                let problem = format!("{}: can't write the tables: {error}", terminal::path(path));
                Status::Usage.with_help(problem, "specify a new folder")
            })
        });
        created.collect()
    }

    /// Starts the reports of a run. From now on, no other run can write to the folders of the tables. `has_timeline`
    /// adds the table of the timelines. Prints errors.
    pub(super) fn start(&self, action: Action, has_timeline: bool) -> Result<Outputs<'_>, Status> {
        // A text report is printed section by section. Reports in the other formats are printed after the report files
        // have been written.
        let printed = Some(self.printed()).filter(|kind| *kind != Kind::Text).map(|kind| (kind, None));
        let files = self.files().map(|(kind, path)| (kind, folder_for_parts(path)));
        let stream = Stream::new(action, &super::command(), files.chain(printed));
        let tables = self.tables(has_timeline)?;
        Ok(Outputs { args: self, stream, tables, unprinted: None })
    }
}

impl Outputs<'_> {
    /// Continues the tables of an earlier run. Returns the captures that they contain. Prints errors.
    pub(super) fn resume(&mut self, folder: &Path, has_timeline: bool) -> Result<Done, Status> {
        let (tables, done) = Dataset::resume(folder, has_timeline).map_err(|error| {
            Status::Usage.with_help(format_args!("--resume {}: {error}", terminal::path(folder)), RESUMABLE)
        })?;
        self.tables.push(tables);
        Ok(done)
    }

    /// Adds a subject to all reports. If the printed report is text, prints the section of the subject.
    pub(super) fn add(&mut self, subject: &Subject, origin: &Origin, timeline: Option<&Timeline>) {
        if self.args.printed() == Kind::Text {
            self.keep_error(print(&subject_text(subject)));
        }
        for tables in &mut self.tables {
            tables.add(subject, origin, timeline);
        }
        self.stream.add(subject);
    }

    /// Adds a file that can't be opened to the tables. The other reports list it at their end.
    pub(super) fn add_unreadable(&mut self, file: &Unreadable) {
        for tables in &mut self.tables {
            tables.add_unreadable(file);
        }
    }

    /// Returns the totals of all subjects. No further subjects can be added.
    pub(super) fn finish(&mut self) -> Totals {
        self.stream.finish()
    }

    /// Keeps the first error in printing until the reports are written.
    fn keep_error(&mut self, printed: io::Result<()>) {
        if let (Err(error), None) = (printed, &self.unprinted) {
            self.unprinted = Some(format!("standard output: can't print the report: {error}"));
        }
    }

    /// Prints and writes all reports, even if one of them fails. Prints errors. Returns the status of the run.
    pub(super) fn deliver(mut self, report: &Report) -> Status {
        let failures = self.write(report);
        for failure in &failures {
            terminal::error(failure, None);
        }
        if failures.is_empty() { (&report.outcome).into() } else { Status::Unreadable }
    }

    /// Writes the rest of the tables. Returns the error messages.
    fn finish_tables(&mut self) -> Vec<String> {
        let tables = std::mem::take(&mut self.tables).into_iter();
        let failures = tables.filter_map(|tables| {
            let folder = terminal::path(tables.folder());
            let error = tables.finish().err()?;
            Some(format!("{folder}: can't write the tables: {error}"))
        });
        failures.collect()
    }

    /// Writes all reports. Returns the error messages.
    fn write(&mut self, report: &Report) -> Vec<String> {
        let mut failures = Vec::new();
        for (index, (kind, path)) in self.args.files().enumerate() {
            let written = write_file(path, |file| match kind {
                // Files have no colours.
                Kind::Text => {
                    let mut plain = terminal::Guard::new(StripStream::new(file));
                    self.stream.write(index, report, &mut plain)
                }
                _ => self.stream.write(index, report, file),
            });
            failures.extend(
                written
                    .err()
                    .map(|error| format!("{}: can't write the report: {error}", terminal::path(path))),
            );
        }
        failures.extend(self.finish_tables());
        let printed = if self.args.printed() == Kind::Text {
            print(&end_text(report))
        } else {
            let mut stdout = BufWriter::new(io::stdout());
            let printed = self.stream.write(self.args.files().count(), report, &mut stdout);
            ignore_broken_pipe(printed.and_then(|()| stdout.flush()))
        };
        self.keep_error(printed);
        self.unprinted.take().into_iter().chain(failures).collect()
    }
}

impl Target {
    fn is_printed(&self) -> bool {
        self.path.as_os_str() == STANDARD_OUTPUT
    }
}

/// Prints text, with colours if the terminal supports them.
pub(super) fn print(text: &str) -> io::Result<()> {
    let mut stdout = terminal::stdout();
    ignore_broken_pipe(stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()))
}

/// Like [`print`], but prints errors.
pub(super) fn print_result(text: &str) -> Exit {
    print(text).map(|()| Status::Conforms).map_err(unprinted)
}

/// Ignores the error for a closed pipe.
fn ignore_broken_pipe(written: io::Result<()>) -> io::Result<()> {
    written.or_else(|error| if error.kind() == io::ErrorKind::BrokenPipe { Ok(()) } else { Err(error) })
}

/// The folder for the temporary file of a report. `None` for pipes and devices, whose folder might not be writable.
fn folder_for_parts(path: &Path) -> Option<&Path> {
    fs::metadata(path).map_or(true, |metadata| metadata.is_file()).then(|| folder_of(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parses_targets_and_lists_the_kinds_in_errors() {
        let target = |text: &str| text.parse::<Target>();
        assert_eq!(
            target("html=a=b.html"),
            Ok(Target { kind: TargetKind::File(Kind::Html), path: "a=b.html".into() })
        );
        for wrong in ["html", "html=", "pdf=a", "=a", ""] {
            let error = target(wrong).expect_err(wrong);
            assert!(
                error
                    .contains("text, short, json, junit, sarif, codequality, html, markdown, parquet, arrow"),
                "{error}"
            );
        }
    }

    #[cfg(unix)]
    #[test]
    fn temporary_files_are_next_to_reports_but_not_next_to_devices() {
        let folder = |path| folder_for_parts(Path::new(path));
        assert_eq!(folder("absent/a.json"), Some(Path::new("absent")));
        assert_eq!(folder("a.json"), Some(Path::new(".")));
        assert_eq!([folder("/dev/null"), folder("/")], [None, None]);
    }

    #[test]
    fn replaces_files_atomically() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("report.json");
        fs::write(&path, "old and long").expect("a file");
        let write = |path: &Path| super::write_file(path, |file| file.write_all(b"new"));
        let failed: io::Result<()> = super::write_file(&path, |file| {
            file.write_all(b"half")?;
            Err(io::Error::other("the disk is full"))
        });
        assert!(failed.is_err());
        assert_eq!(
            fs::read(&path).expect("a file"),
            b"old and long",
            "an incomplete report replaces nothing"
        );
        write(&path).expect("written");
        assert_eq!(fs::read(&path).expect("a file"), b"new");
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1, "no temporary files remain");
        assert!(write(&folder.path().join("absent/report.json")).is_err());
        assert!(write(folder.path()).is_err(), "the path is a folder");
    }
}
