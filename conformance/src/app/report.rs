//! The options `--format` and `--report`.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::OnceLock;

use clap::{Args, ValueEnum as _};
use uavspec_codegen::stage::Stage;

use super::outputs::Output;
use crate::report::{Kind, Report, Subject, end_text, subject_text};
use crate::text::terminal;

/// The path that means standard output.
const STANDARD_OUTPUT: &str = "-";

/// The reports to write, and their paths.
#[derive(Args, Clone, Debug)]
pub(super) struct ReportArgs {
    /// Format of the report (default: text).
    ///
    /// The report is printed to standard output. The formats are text, json, junit (XML for CI systems), sarif (for
    /// editors and code scanning), html (a self-contained page) and markdown (for pull requests and CI summaries).
    #[arg(long, value_name = "KIND", hide_possible_values = true)]
    format: Option<Kind>,
    /// Write a report to a file (repeatable).
    ///
    /// For example, html=report.html. KIND is one of the formats above. Separate multiple reports with commas. The
    /// path `-` means standard output. A report never replaces an input.
    #[arg(long, value_name = "KIND=PATH", value_delimiter = ',')]
    report: Vec<Target>,
    /// The first printing error, which is reported together with the errors from writing report files.
    #[arg(skip)]
    unprinted: OnceLock<String>,
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

    /// Prints the section of a subject immediately, if the printed report is text.
    pub(super) fn print_subject(&self, subject: &Subject) {
        if self.printed() == Kind::Text {
            self.keep_error(print(&subject_text(subject)));
        }
    }

    /// Keeps the first printing error until the reports are written.
    fn keep_error(&self, printed: io::Result<()>) {
        if let Err(error) = printed {
            let _ = self.unprinted.set(format!("standard output: can't print the report: {error}"));
        }
    }

    /// Prints or writes all reports, even if one fails. Returns the error messages.
    pub(super) fn write(&self, report: &Report) -> Vec<String> {
        self.keep_error(match self.printed() {
            // The sections of the subjects are already printed.
            Kind::Text => print(&end_text(report)),
            kind => ignore_broken_pipe(&mut io::stdout(), &report.to_text(kind)),
        });
        let files = self.report.iter().filter(|target| !target.is_printed());
        let write = |target: &Target| {
            let text = report.to_text(target.kind);
            let text = match target.kind {
                // Files have no colours.
                Kind::Text => {
                    terminal::guarded(&anstream::adapter::strip_str(&text).to_string()).into_owned()
                }
                _ => text,
            };
            let error = write(&target.path, text.as_bytes()).err()?;
            Some(format!("{}: can't write the report: {error}", terminal::path(&target.path)))
        };
        self.unprinted.get().cloned().into_iter().chain(files.filter_map(write)).collect()
    }
}

impl Target {
    fn is_printed(&self) -> bool {
        self.path.as_os_str() == STANDARD_OUTPUT
    }
}

/// Prints text, with colours if the terminal supports them.
pub(super) fn print(text: &str) -> io::Result<()> {
    ignore_broken_pipe(&mut terminal::stdout(), text)
}

/// Writes text. A closed pipe is not an error.
fn ignore_broken_pipe(to: &mut impl Write, text: &str) -> io::Result<()> {
    match to.write_all(text.as_bytes()).and_then(|()| to.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        result => result,
    }
}

/// Writes a file atomically. If this fails, an existing file stays unchanged.
fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    // A pipe or a terminal can't be replaced. If the path is a link, the link's target is replaced. A pipe may have no
    // real path, and the target of a link may be absent.
    let path = match fs::metadata(path) {
        Ok(metadata) if metadata.is_file() => fs::canonicalize(path)?,
        Err(_) if !path.is_symlink() => path.to_path_buf(),
        _ => return fs::write(path, bytes),
    };
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // A new file in a temporary folder has default permissions. A temporary file would be private.
    let stage = Stage::new(parent)?;
    let staged = stage.path().join("report");
    fs::write(&staged, bytes)?;
    fs::rename(staged, path)
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
            assert!(error.contains("text, short, json, junit, sarif, html, markdown"), "{error}");
        }
    }

    #[test]
    fn replaces_files_atomically() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("report.json");
        fs::write(&path, "old and long").expect("a file");
        write(&path, b"new").expect("written");
        assert_eq!(fs::read(&path).expect("a file"), b"new");
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1, "no temporary files remain");
        assert!(write(&folder.path().join("absent/report.json"), b"new").is_err());
        assert!(write(folder.path(), b"new").is_err(), "the path is a folder");
    }
}
