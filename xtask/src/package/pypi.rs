//! Builds the packages for `PyPI`: a wheel, and a source distribution from which flit builds the same wheel.

use data_encoding::BASE64URL_NOPAD;
use serde_json::Value;
use sha2::{Digest, Sha256};

use super::Package;
use super::archive::{tar_gz, zip};
use super::content::{Content, File};
use super::metadata::{DESCRIPTION, KEYWORDS, LICENSE, NAME, REPOSITORY, VERSION};

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

/// Builds the wheel and the source distribution.
pub(super) fn packages(content: &Content) -> Result<[Package; 2], String> {
    let version = python_version(VERSION)?;
    let mut modules = content.python.clone();
    modules.push(File::new("data.py", include_str!("pypi/data.py")));
    modules.extend(content.data.iter().cloned());
    for file in &mut modules {
        file.path = format!("{NAME}/{}", file.path);
    }
    modules.sort_by(|left, right| left.path.cmp(&right.path));
    Ok([wheel(content, &modules, &version)?, source_distribution(content, &modules, &version)?])
}

fn wheel(content: &Content, modules: &[File], version: &str) -> Result<Package, String> {
    let information = format!("{NAME}-{version}.dist-info");
    let mut files = modules.to_vec();
    files.push(File::new(format!("{information}/METADATA"), &metadata(content, version)));
    files.push(File::new(
        format!("{information}/WHEEL"),
        &format!(
            "Wheel-Version: 1.0\nGenerator: {NAME} {VERSION}\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
        ),
    ));
    let licences = content.licences.iter();
    files.extend(licences.map(|file| File::new(format!("{information}/licenses/{}", file.path), &file.text)));
    let path = format!("{information}/RECORD");
    files.push(File::new(path.clone(), &record(&files, &path)));
    Ok(Package {
        file_name: format!("{NAME}-{version}-py3-none-any.whl"),
        count: files.len(),
        bytes: zip(&files)?,
    })
}

fn source_distribution(content: &Content, modules: &[File], version: &str) -> Result<Package, String> {
    let mut files = modules.to_vec();
    files.extend(content.licences.iter().cloned());
    files.push(File::new("PKG-INFO", &metadata(content, version)));
    files.push(File::new("README.md", README));
    files.push(File::new("pyproject.toml", &pyproject(version)));
    files.sort_by(|left, right| left.path.cmp(&right.path));
    for file in &mut files {
        file.path = format!("{NAME}-{version}/{}", file.path);
    }
    Ok(Package { file_name: format!("{NAME}-{version}.tar.gz"), count: files.len(), bytes: tar_gz(&files)? })
}

/// The content of the wheel's `RECORD` file: the checksums of all other files.
fn record(files: &[File], own_path: &str) -> String {
    let line = |file: &File| {
        let checksum = BASE64URL_NOPAD.encode(&Sha256::digest(file.text.as_bytes()));
        format!("{},sha256={checksum},{}\n", csv(&file.path), file.text.len())
    };
    files.iter().map(line).collect::<String>() + &csv(own_path) + ",,\n"
}

/// Formats a cell, in quotes if required.
fn csv(cell: &str) -> String {
    if cell.contains([',', '"']) { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell.to_owned() }
}

/// The core metadata, version 2.4.
fn metadata(content: &Content, version: &str) -> String {
    let mut lines = vec![
        "Metadata-Version: 2.4".to_owned(),
        format!("Name: {NAME}"),
        format!("Version: {version}"),
        format!("Summary: {DESCRIPTION}"),
        format!("Keywords: {}", KEYWORDS.join(",")),
        format!("License-Expression: {LICENSE}"),
    ];
    lines.extend(content.licences.iter().map(|file| format!("License-File: {}", file.path)));
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
