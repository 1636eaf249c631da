//! Builds the packages for `PyPI`: a wheel, a source distribution from which flit builds the same wheel, and for each
//! platform a wheel that also contains the program.

use data_encoding::BASE64URL_NOPAD;
use serde_json::Value;
use sha2::{Digest, Sha256};

use super::Package;
use super::content::Content;
use super::metadata::{DESCRIPTION, KEYWORDS, LICENSE, NAME, REPOSITORY, TIME, VERSION};
use crate::archive::{File, tar_gz, zip};
use crate::platform::Program;

/// The minimum version of Python. Earlier versions don't support `list[int]` in expressions.
const REQUIRES_PYTHON: &str = ">=3.9";

/// A dependency for Python versions before 3.11, in which `typing` lacks `NotRequired`.
const DEPENDENCY: &str = "typing_extensions>=4.6; python_version < \"3.11\"";

/// The build backend. flit supports licence expressions from version 3.12; version 4 may be incompatible.
const BACKEND: &str = "flit_core>=3.12,<4";

const CLASSIFIERS: [&str; 6] = [
    "Development Status :: 4 - Beta",
    "Intended Audience :: Developers",
    "Programming Language :: Python :: 3",
    "Programming Language :: Python :: 3 :: Only",
    "Topic :: Scientific/Engineering",
    "Typing :: Typed",
];

const README: &str = include_str!("pypi/README.md");

/// Builds the wheel for all platforms, and the source distribution.
pub(super) fn packages(content: &Content) -> Result<[Package; 2], String> {
    let version = python_version(VERSION)?;
    Ok([wheel(content, &version, None)?, source_distribution(content, &version)?])
}

/// Builds the wheel for the platform of a program.
pub(super) fn platform_wheel(content: &Content, program: &Program) -> Result<Package, String> {
    wheel(content, &python_version(VERSION)?, Some(program))
}

/// The modules and their data, sorted by path.
fn modules(content: &Content) -> Vec<File> {
    let data = File::new("data.py", include_str!("pypi/data.py"));
    let files = content.python.iter().chain(&content.data).chain([&data]);
    let mut modules: Vec<File> = files.map(|file| file.below(NAME)).collect();
    modules.sort_by(|left, right| left.path.cmp(&right.path));
    modules
}

fn wheel(content: &Content, version: &str, program: Option<&Program>) -> Result<Package, String> {
    let information = format!("{NAME}-{version}.dist-info");
    let mut files = modules(content);
    let (platforms, licences) = match program {
        Some(program) => (program.platform.wheel, &program.licences),
        None => ("any", &content.licences),
    };
    if let Some(program) = program {
        files.push(program.file(&format!("{NAME}-{version}.data/scripts/{NAME}")));
    }
    files.push(File::new(format!("{information}/METADATA"), &metadata(licences, version)));
    files.push(File::new(format!("{information}/WHEEL"), &wheel_metadata(platforms)));
    files.extend(licences.iter().map(|file| file.below(&format!("{information}/licenses"))));
    let path = format!("{information}/RECORD");
    files.push(File::new(path.clone(), &record(&files, &path)));
    Ok(Package {
        file_name: format!("{NAME}-{version}-py3-none-{platforms}.whl"),
        count: files.len(),
        bytes: zip(&files)?,
    })
}

/// The content of the file `WHEEL`. `platforms` contains the platform tags, separated by dots.
fn wheel_metadata(platforms: &str) -> String {
    let tags: String = platforms.split('.').map(|platform| format!("Tag: py3-none-{platform}\n")).collect();
    let is_pure = platforms == "any";
    format!("Wheel-Version: 1.0\nGenerator: {NAME} {VERSION}\nRoot-Is-Purelib: {is_pure}\n{tags}")
}

fn source_distribution(content: &Content, version: &str) -> Result<Package, String> {
    let mut files = modules(content);
    files.extend(content.licences.iter().cloned());
    files.push(File::new("PKG-INFO", &metadata(&content.licences, version)));
    files.push(File::new("README.md", README));
    files.push(File::new("pyproject.toml", &pyproject(version)));
    let folder = format!("{NAME}-{version}");
    let mut files: Vec<File> = files.iter().map(|file| file.below(&folder)).collect();
    files.sort_by(|left, right| left.path.cmp(&right.path));
    Ok(Package { file_name: format!("{folder}.tar.gz"), count: files.len(), bytes: tar_gz(&files, TIME)? })
}

/// The content of the wheel's `RECORD` file: the checksums of all other files.
fn record(files: &[File], own_path: &str) -> String {
    let line = |file: &File| {
        let checksum = BASE64URL_NOPAD.encode(&Sha256::digest(&file.bytes));
        format!("{},sha256={checksum},{}\n", csv(&file.path), file.bytes.len())
    };
    files.iter().map(line).collect::<String>() + &csv(own_path) + ",,\n"
}

/// Formats a cell, in quotes if required.
fn csv(cell: &str) -> String {
    if cell.contains([',', '"']) { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell.to_owned() }
}

/// The core metadata, version 2.4.
fn metadata(licences: &[File], version: &str) -> String {
    let mut lines = vec![
        "Metadata-Version: 2.4".to_owned(),
        format!("Name: {NAME}"),
        format!("Version: {version}"),
        format!("Summary: {DESCRIPTION}"),
        format!("Keywords: {}", KEYWORDS.join(",")),
        format!("License-Expression: {LICENSE}"),
    ];
    lines.extend(licences.iter().map(|file| format!("License-File: {}", file.path)));
    lines.extend(CLASSIFIERS.map(|classifier| format!("Classifier: {classifier}")));
    lines.push(format!("Requires-Python: {REQUIRES_PYTHON}"));
    lines.push(format!("Requires-Dist: {DEPENDENCY}"));
    lines.extend((!REPOSITORY.is_empty()).then(|| format!("Project-URL: Source, {REPOSITORY}")));
    lines.push("Description-Content-Type: text/markdown; charset=UTF-8; variant=GFM".to_owned());
    lines.join("\n") + "\n\n" + README
}

/// The metadata for the build tool of the source distribution.
fn pyproject(version: &str) -> String {
    // TOML basic strings have the syntax of JSON strings.
    let text = |text: &str| Value::from(text).to_string();
    let list = |texts: &[&str]| texts.iter().map(|found| text(found)).collect::<Vec<_>>().join(", ");
    let urls = if REPOSITORY.is_empty() {
        String::new()
    } else {
        format!("\n[project.urls]\nSource = {}\n", text(REPOSITORY))
    };
    format!(
        "[build-system]
requires = [{backend}]
build-backend = \"flit_core.buildapi\"

[project]
name = {name}
version = {version}
description = {description}
readme = \"README.md\"
requires-python = {python}
license = {licence}
license-files = [\"LICENSE-APACHE\", \"LICENSE-MIT\"]
keywords = [{keywords}]
classifiers = [{classifiers}]
dependencies = [{dependencies}]
{urls}",
        backend = text(BACKEND),
        name = text(NAME),
        version = text(version),
        description = text(DESCRIPTION),
        python = text(REQUIRES_PYTHON),
        licence = text(LICENSE),
        keywords = list(&KEYWORDS),
        classifiers = list(&CLASSIFIERS),
        dependencies = list(&[DEPENDENCY]),
    )
}

/// Converts a version to PEP 440: `1.2.0-rc.1` becomes `1.2.0rc1`.
fn python_version(version: &str) -> Result<String, String> {
    let Some((release, pre)) = version.split_once('-') else { return Ok(version.to_owned()) };
    let kinds = [("alpha", "a"), ("beta", "b"), ("rc", "rc")];
    let found = kinds.iter().find_map(|(name, short)| {
        let number = pre.strip_prefix(name)?.trim_start_matches('.');
        let is_number = number.bytes().all(|byte| byte.is_ascii_digit());
        is_number.then(|| format!("{release}{short}{}", if number.is_empty() { "0" } else { number }))
    });
    found.ok_or_else(|| {
        format!(
            "PyPI does not support the version {version}\n  help: use a version such as {release} or {release}-rc.1"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn converts_prereleases_to_pep_440() {
        for (version, expected) in [
            ("1.2.3", "1.2.3"),
            ("1.2.0-rc.1", "1.2.0rc1"),
            ("1.0.0-alpha", "1.0.0a0"),
            ("0.2.0-beta.12", "0.2.0b12"),
        ] {
            assert_eq!(python_version(version).as_deref(), Ok(expected));
        }
        let error = python_version("1.0.0-nightly").expect_err("an error");
        assert!(error.contains("1.0.0-rc.1"), "{error}");
    }

    #[test]
    fn the_record_contains_the_checksum_of_each_file() {
        let files = [File::new("a,b", "abc")];
        let known = "ungWv48Bz-pBQUDeXa4iI7ADYaOWF3qctBD_YfIAFa0";
        assert_eq!(record(&files, "RECORD"), format!("\"a,b\",sha256={known},3\nRECORD,,\n"));
    }
}
