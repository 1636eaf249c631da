//! Formats of reports, and report files.

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::ValueEnum;
use uavspec_lint::report::Format;
use uavspec_schema::failure::Failure;
use uavspec_schema::identity::Identity;
use uavspec_schema::stage::write_file;
use uavspec_schema::terminal;

/// A format of reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum FormatName {
    /// Readable text that quotes the line of each finding
    Text,
    /// A JSON list; with --summary, a JSON object
    Json,
    /// GitHub workflow annotations
    Github,
    /// SARIF 2.1.0, for code scanning
    Sarif,
    /// Test results as XML, for CI systems
    Junit,
    /// Code Quality report of GitLab
    Codequality,
}

impl FormatName {
    /// The machine-readable format, or `None` for text.
    pub(super) fn format(self) -> Option<Format> {
        match self {
            Self::Text => None,
            Self::Json => Some(Format::Json),
            Self::Github => Some(Format::Github),
            Self::Sarif => Some(Format::Sarif),
            Self::Junit => Some(Format::Junit),
            Self::Codequality => Some(Format::Codequality),
        }
    }
}

/// A value of `--report`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Target {
    pub(super) format: FormatName,
    path: PathBuf,
}

impl FromStr for Target {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, path) = text
            .split_once('=')
            .filter(|(_, path)| !path.is_empty())
            .ok_or("expected FORMAT=PATH, such as sarif=lint.sarif")?;
        let format = FormatName::from_str(name, false).map_err(|_| {
            format!("unknown format `{}`; expected one of {}", terminal::shown(name), formats())
        })?;
        if path == "-" {
            return Err(format!("a report is a file; --format {name} writes to standard output"));
        }
        Ok(Self { format, path: path.into() })
    }
}

fn formats() -> String {
    let values = FormatName::value_variants().iter().filter_map(FormatName::to_possible_value);
    values.map(|value| value.get_name().to_owned()).collect::<Vec<_>>().join(", ")
}

/// Fails if two reports are the same file.
pub(super) fn check_distinct(targets: &[Target]) -> Result<(), Failure> {
    let files: Vec<(&Target, Identity)> =
        targets.iter().filter_map(|target| Some((target, Identity::of(&target.path)?))).collect();
    let repeated = files.iter().enumerate().find_map(|(at, (target, identity))| {
        let (other, _) = files[..at].iter().find(|(_, other)| other.is_same(identity))?;
        Some((other, target))
    });
    repeated.map_or(Ok(()), |(other, target)| {
        let [other, target] = [other, target].map(|target| terminal::path(&target.path));
        let message = format!("the reports {other} and {target} are the same file");
        Err(Failure::new(message).with_hint("choose another file for one of them"))
    })
}

impl Target {
    /// Fails if the report would replace an input.
    pub(super) fn protect(&self, input: &Path) -> Result<(), Failure> {
        let is_same = || Identity::of(&self.path)?.is_same(&Identity::of(input)?).then_some(());
        if is_same().is_none() {
            return Ok(());
        }
        let message = format!("the report would overwrite the input {}", terminal::path(input));
        Err(Failure::new(message).with_hint("choose another file for the report"))
    }

    /// Writes the report.
    pub(super) fn write(&self, text: &str) -> Result<(), Failure> {
        let written = write_file(&self.path, |file| file.write_all(text.as_bytes()));
        written.map_err(|error: io::Error| {
            Failure::new(format!("{}: can't write the report: {error}", terminal::path(&self.path)))
                .with_hint("check that the folder exists and is writable")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_reports_are_never_the_same_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let check = |paths: [&str; 2]| {
            let target = |path: &str| Target { format: FormatName::Sarif, path: folder.path().join(path) };
            check_distinct(&paths.map(target))
        };
        std::fs::create_dir(folder.path().join("d")).expect("a folder");
        for paths in [["r", "r"], ["r", "./r"], ["r", "d/../r"]] {
            assert!(check(paths).is_err(), "{paths:?}");
        }
        std::fs::write(folder.path().join("r"), "").expect("a file");
        std::fs::hard_link(folder.path().join("r"), folder.path().join("s")).expect("a link");
        assert!(check(["r", "s"]).is_err());
        assert!(check(["r", "t"]).is_ok());
    }

    #[test]
    fn parses_formats_and_paths_and_lists_the_formats_in_errors() {
        let target = |text: &str| text.parse::<Target>();
        assert_eq!(
            target("sarif=a=b.sarif"),
            Ok(Target { format: FormatName::Sarif, path: "a=b.sarif".into() })
        );
        for wrong in ["sarif", "sarif=", "pdf=a", "=a", ""] {
            let error = target(wrong).expect_err(wrong);
            assert!(error.contains("FORMAT=PATH") || error.contains("text, json, github, sarif"), "{error}");
        }
        assert!(target("json=-").is_err_and(|error| error.contains("--format json")));
    }
}
