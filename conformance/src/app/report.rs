//! The options `--format` and `--report`.

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use anstream::StripStream;
use clap::{Args, ValueEnum as _};
use uavspec_codegen::stage::{folder_of, write_file};

use super::Status;
use super::known::{KnownArgs, NewList};
use super::outputs::Output;
use crate::report::{Action, Kind, Report, Stream, Subject, Totals, end_text, subject_text};
use crate::text::terminal;

/// The path that means standard output.
const STANDARD_OUTPUT: &str = "-";

/// The reports to write, and their paths.
#[derive(Args, Clone, Debug)]
pub(super) struct ReportArgs {
    /// Format of the report (default: text).
    ///
    /// The report is printed to standard output. The formats are text, short (one line for each finding), json,
    /// junit (XML for CI systems), sarif (for editors and code scanning), codequality (for GitLab), html (a self-contained page) and markdown (for pull requests and CI summaries).
    #[arg(long, value_name = "KIND", hide_possible_values = true)]
    format: Option<Kind>,
    /// Write a report to a file (repeatable).
    ///
    /// For example, html=report.html. KIND is one of the formats above. Separate multiple reports with commas. The
    /// path `-` means standard output. A report never replaces an input.
    #[arg(long, value_name = "KIND=PATH", value_delimiter = ',')]
    report: Vec<Target>,
}

/// The reports of a run. Each report is written after the run, but contains subjects that are already dropped.
pub(super) struct Outputs<'a> {
    args: &'a ReportArgs,
    stream: Stream,
    /// The list for `--init-known`.
    new_list: Option<NewList>,
    /// The first printing error, which is reported together with the errors from writing report files.
    unprinted: Option<String>,
}

/// A value of `--report`.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Target {
    kind: Kind,
    path: PathBuf,
}

impl FromStr for Target {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, path) = text.split_once('=').filter(|(_, path)| !path.is_empty()).ok_or_else(|| {
            format!("expected KIND=PATH, such as html=report.html; KIND is one of {}", kinds())
        })?;
        let kind = Kind::from_str(name, false)
            .map_err(|_| format!("unknown kind `{}`; expected one of {}", terminal::shown(name), kinds()))?;
        Ok(Self { kind, path: path.into() })
    }
}

fn kinds() -> String {
    let names = Kind::value_variants()
        .iter()
        .filter_map(|kind| Some(kind.to_possible_value()?.get_name().to_owned()));
    names.collect::<Vec<_>>().join(", ")
}

impl ReportArgs {
    /// Returns an error if the arguments contradict each other.
    pub(super) fn problem(&self) -> Option<String> {
        let printed = self.report.iter().filter(|target| target.is_printed()).count();
        (printed + usize::from(self.format.is_some()) > 1).then(|| {
            "only one report can be printed to standard output: write the others to files".to_owned()
        })
    }

    /// The report files.
    pub(super) fn outputs(&self) -> impl Iterator<Item = Output<'_>> {
        self.report.iter().map(|target| {
            let kind =
                target.kind.to_possible_value().map_or_else(String::new, |kind| kind.get_name().to_owned());
            Output { name: format!("--report {kind}={}", terminal::path(&target.path)), path: &target.path }
        })
    }

    /// The kind of the report on standard output.
    pub(super) fn printed(&self) -> Kind {
        let printed = self.report.iter().find(|target| target.is_printed()).map(|target| target.kind);
        self.format.or(printed).unwrap_or(Kind::Text)
    }

    /// The report files.
    fn files(&self) -> impl Iterator<Item = &Target> {
        self.report.iter().filter(|target| !target.is_printed())
    }

    /// Starts the reports of a run, and the list of new failures.
    pub(super) fn start(&self, action: Action, known: &KnownArgs) -> Outputs<'_> {
        // The sections of a text report are printed immediately. The other formats follow the report files.
        let printed = Some(self.printed()).filter(|kind| *kind != Kind::Text).map(|kind| (kind, None));
        let files = self.files().map(|target| (target.kind, folder_for_parts(&target.path)));
        let stream = Stream::new(action, super::command(), files.chain(printed));
        Outputs { args: self, stream, new_list: known.new_list(), unprinted: None }
    }
}

impl Outputs<'_> {
    /// Adds a subject to all reports. If the printed report is text, the section of the subject is printed.
    pub(super) fn add(&mut self, subject: Subject) {
        if self.args.printed() == Kind::Text {
            self.keep_error(print(&subject_text(&subject)));
        }
        if let Some(list) = &mut self.new_list {
            list.add(&subject);
        }
        self.stream.add(subject);
    }

    /// The totals of all subjects. No subject can be added afterwards.
    pub(super) fn finish(&mut self) -> Totals {
        self.stream.finish()
    }

    /// Keeps the first printing error until the reports are written.
    fn keep_error(&mut self, printed: io::Result<()>) {
        if let (Err(error), None) = (printed, &self.unprinted) {
            self.unprinted = Some(format!("standard output: can't print the report: {error}"));
        }
    }

    /// Prints and writes all reports, even if one fails, and the list of new failures. Errors are printed. Returns the
    /// status of the run.
    pub(super) fn deliver(mut self, report: &Report) -> Status {
        let failures = self.write(report);
        for failure in &failures {
            terminal::error(failure, None);
        }
        let status = if failures.is_empty() { (&report.outcome).into() } else { Status::Unreadable };
        self.new_list.map_or(status, |list| list.write(&report.command).max(status))
    }

    /// Writes all reports. Returns the error messages.
    fn write(&mut self, report: &Report) -> Vec<String> {
        let mut failures = Vec::new();
        for (index, target) in self.args.files().enumerate() {
            let written = write_file(&target.path, |file| match target.kind {
                // Files have no colours.
                Kind::Text => {
                    let mut plain = terminal::Guard::new(StripStream::new(file));
                    self.stream.write(index, report, &mut plain)
                }
                _ => self.stream.write(index, report, file),
            });
            failures.extend(
                written.err().map(|error| {
                    format!("{}: can't write the report: {error}", terminal::path(&target.path))
                }),
            );
        }
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

/// Like [`print`]. Errors are printed.
pub(super) fn print_result(text: &str) -> Result<(), Status> {
    print(text).map_err(|error| {
        terminal::error(format_args!("standard output: {error}"), None);
        Status::Unreadable
    })
}

/// A closed pipe is not an error.
fn ignore_broken_pipe(written: io::Result<()>) -> io::Result<()> {
    written.or_else(|error| if error.kind() == io::ErrorKind::BrokenPipe { Ok(()) } else { Err(error) })
}

/// The folder for the temporary file of a report. `None` for pipes and devices, whose folder may not be writable.
fn folder_for_parts(path: &Path) -> Option<&Path> {
    fs::metadata(path).map_or(true, |metadata| metadata.is_file()).then(|| folder_of(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parses_targets_and_lists_the_kinds_in_errors() {
        let target = |text: &str| text.parse::<Target>();
        assert_eq!(target("html=a=b.html"), Ok(Target { kind: Kind::Html, path: "a=b.html".into() }));
        for wrong in ["html", "html=", "pdf=a", "=a", ""] {
            let error = target(wrong).expect_err(wrong);
            assert!(
                error.contains("text, short, json, junit, sarif, codequality, html, markdown"),
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
