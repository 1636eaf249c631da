//! Where reports go: `--format`, and any number of `--report`.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::OnceLock;

use clap::{Args, ValueEnum as _};

use crate::report::{Kind, Report, Subject, subject_text};

/// What stands for standard output.
const STANDARD_OUTPUT: &str = "-";

/// Which reports are written, and where to.
#[derive(Args, Clone, Debug)]
pub(super) struct ReportArgs {
    /// How to report on standard output; as text, where nothing is said.
    #[arg(long, value_name = "KIND")]
    format: Option<Kind>,
    /// More reports of the same run: text, json, junit, sarif, html or markdown, each with the file to write it to;
    /// - is standard output.
    #[arg(long, value_name = "KIND=PATH", value_delimiter = ',')]
    report: Vec<Target>,
    /// Why something couldn't be printed, which is told with the reports that can't be written.
    #[arg(skip)]
    unprinted: OnceLock<String>,
}

/// A report, and where it goes.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Target {
    kind: Kind,
    path: PathBuf,
}

impl FromStr for Target {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, path) = text.split_once('=').filter(|(_, path)| !path.is_empty()).ok_or_else(|| {
            format!("it should be KIND=PATH, such as html=report.html; kinds are {}", kinds())
        })?;
        let kind = Kind::from_str(name, false)
            .map_err(|_| format!("there is no kind {name} of report; kinds are {}", kinds()))?;
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
    /// What is wrong with them together.
    pub(super) fn problem(&self) -> Option<String> {
        let printed = self.report.iter().filter(|target| target.is_printed()).count();
        if printed + usize::from(self.format.is_some()) > 1 {
            return Some("only one report can go to standard output: write the others to files".to_owned());
        }
        let twice = |(at, target): (usize, &Target)| {
            !target.is_printed() && self.report[..at].iter().any(|other| other.path == target.path)
        };
        let at = self.report.iter().enumerate().position(twice)?;
        Some(format!("two reports would go to {}", self.report[at].path.display()))
    }

    /// The kind that goes to standard output.
    pub(super) fn printed(&self) -> Kind {
        let printed = self.report.iter().find(|target| target.is_printed()).map(|target| target.kind);
        self.format.or(printed).unwrap_or(Kind::Text)
    }

    /// Prints what is said of a source, where the report that is printed is the text, as soon as it is known.
    pub(super) fn print_subject(&self, subject: &Subject) {
        if self.printed() == Kind::Text {
            self.keep(print(&subject_text(subject)));
        }
    }

    /// Keeps the first failure of printing until the reports are written.
    fn keep(&self, printed: io::Result<()>) {
        if let Err(error) = printed {
            let _ = self.unprinted.set(format!("standard output: the report can't be printed: {error}"));
        }
    }

    /// Prints or writes all reports, also where one can't be; tells which that are, and why.
    pub(super) fn write(&self, report: &Report) -> Vec<String> {
        if self.printed() != Kind::Text {
            self.keep(ignore_broken_pipe(&mut io::stdout(), &report.to_text(self.printed())));
        }
        let files = self.report.iter().filter(|target| !target.is_printed());
        let write = |target: &Target| {
            let text = report.to_text(target.kind);
            let text = match target.kind {
                // A file has no colours.
                Kind::Text => anstream::adapter::strip_str(&text).to_string(),
                _ => text,
            };
            let error = write(&target.path, text.as_bytes()).err()?;
            Some(format!("{}: the report can't be written: {error}", target.path.display()))
        };
        self.unprinted.get().cloned().into_iter().chain(files.filter_map(write)).collect()
    }
}

impl Target {
    fn is_printed(&self) -> bool {
        self.path.as_os_str() == STANDARD_OUTPUT
    }
}

/// Prints a text with colours, where they are shown.
pub(super) fn print(text: &str) -> io::Result<()> {
    ignore_broken_pipe(&mut anstream::stdout(), text)
}

/// A reader that has seen enough closes the pipe: that is no failure.
fn ignore_broken_pipe(to: &mut impl Write, text: &str) -> io::Result<()> {
    match to.write_all(text.as_bytes()).and_then(|()| to.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        result => result,
    }
}

/// Writes a file at once: nobody sees half of it, and an old one stays where the new one can't be written.
fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    // A pipe or a terminal can't be replaced, and what a link leads to is meant, not the link.
    let path = match fs::canonicalize(path) {
        Ok(path) if !path.is_file() => return fs::write(path, bytes),
        Ok(path) => path,
        Err(_) => path.to_path_buf(),
    };
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // A folder of its own, so that the file gets the permissions that new files get.
    let stage = tempfile::Builder::new().prefix(".uavspec-").tempdir_in(parent)?;
    let staged = stage.path().join("report");
    fs::write(&staged, bytes)?;
    fs::rename(staged, path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_are_kinds_with_paths() {
        let target = |text: &str| text.parse::<Target>();
        assert_eq!(target("html=a=b.html"), Ok(Target { kind: Kind::Html, path: "a=b.html".into() }));
        for wrong in ["html", "html=", "pdf=a", "=a", ""] {
            let error = target(wrong).expect_err(wrong);
            assert!(error.contains("text, json, junit, sarif, html, markdown"), "{error}");
        }
    }

    #[test]
    fn files_are_replaced_whole_and_links_followed() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("report.json");
        fs::write(&path, "old and long").expect("a file");
        write(&path, b"new").expect("written");
        assert_eq!(fs::read(&path).expect("a file"), b"new");
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1, "nothing is left over");
        assert!(write(&folder.path().join("absent/report.json"), b"new").is_err());
        assert!(write(folder.path(), b"new").is_err(), "a folder is no file");
    }
}
