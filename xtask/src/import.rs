//! Imports the definitions of a release into `definitions/releases`.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use uavspec_codegen::load::{self, Definitions};
use uavspec_lint::release::{self, Fingerprint};
use uavspec_schema::msg::Dialect;
use uavspec_schema::stage::write_file;
use uavspec_schema::{Form, Schema, SourceMap, read};

use crate::paths::{repository, shown};

/// The folder of the releases, from the root of the repository.
const FOLDER: &str = "definitions/releases";

/// The extension of a release's file.
const EXTENSION: &str = "msg";

/// The start of a release's file.
const HEADING: &str = "# Facts of all definitions, written by `cargo xtask import`.\n";

/// Corrections of definitions that contradict the data of real vehicles: a line of a release's file, and its
/// replacement. `definitions/README.md` gives the reasons.
const CORRECTIONS: [(&str, &str); 1] =
    [("uint16 max_error # [%] [@range 1, 100]\n", "uint16 max_error # [%] [@range 1, 100] [@invalid 0]\n")];

/// Arguments of `import`.
#[derive(Args)]
pub(crate) struct Arguments {
    /// Family of the release
    #[arg(requires_all = ["release", "input"])]
    family: Option<Family>,
    /// Name of the release
    #[arg(long, value_name = "NAME", requires = "family", value_parser = release_name)]
    release: Option<String>,
    /// Folder with the definitions (repeatable)
    #[arg(long, value_name = "DIR", requires = "family")]
    input: Vec<PathBuf>,
    /// Only check that the stored fingerprints belong to the stored releases
    #[arg(long, conflicts_with_all = ["family", "release", "input"])]
    check: bool,
}

/// A family of releases.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
enum Family {
    /// PX4's uORB messages
    Px4,
    /// The common interfaces of a ROS 2 distribution
    Ros2,
}

impl Family {
    fn dialect(self) -> Dialect {
        match self {
            Self::Px4 => Dialect::Px4,
            Self::Ros2 => Dialect::Ros2,
        }
    }
}

/// Checks the name of a release, which becomes the name of a file.
fn release_name(name: &str) -> Result<String, String> {
    let is_word = |word: &str| {
        !word.is_empty() && word.bytes().all(|byte| byte.is_ascii_lowercase() || byte.is_ascii_digit())
    };
    if name.split('.').all(is_word) {
        Ok(name.to_owned())
    } else {
        Err("expected lower-case letters, digits and dots, such as 1.18 or jazzy".to_owned())
    }
}

/// Imports a release, or checks the stored releases. Returns false if the check fails.
pub(crate) fn run(arguments: &Arguments) -> Result<bool, String> {
    let folder = repository().join(FOLDER);
    if let (Some(family), Some(release)) = (arguments.family, &arguments.release) {
        let schema = definitions(family, &arguments.input)?;
        let path = folder.join(family.dialect().name()).join(format!("{release}.{EXTENSION}"));
        write(&path, &text_of(&schema))?;
        eprintln!("import: {} ({} messages)", shown(&path).display(), schema.messages.len());
    }
    let (path, text) = (folder.join("fingerprints.tsv"), fingerprints(&folder)?);
    if !arguments.check {
        write(&path, &text)?;
        return Ok(true);
    }
    let is_current = fs::read_to_string(&path).is_ok_and(|known| known == text);
    if !is_current {
        eprintln!("{} is outdated: run `cargo xtask import`", shown(&path).display());
    }
    Ok(is_current)
}

/// Reads the definitions of a release. Fails if a definition requires a package outside the inputs.
fn definitions(family: Family, inputs: &[PathBuf]) -> Result<Schema, String> {
    let form = Form::Msg(family.dialect());
    let Definitions { schema, left_out, .. } = load::read_package(family.dialect().name(), form, inputs)
        .map_err(|failure| crate::message_of(&failure))?;
    if left_out.is_empty() {
        return Ok(schema);
    }
    Err(format!(
        "these definitions require a package outside the inputs:\n    {}\n  help: also pass the folder of that \
         package with --input",
        left_out.join("\n    ")
    ))
}

/// The file of a release, with corrections.
fn text_of(schema: &Schema) -> String {
    let text = format!("{HEADING}{}", release::write(schema));
    CORRECTIONS.iter().fold(text, |text, (line, corrected)| text.replace(line, corrected))
}

fn write(path: &Path, text: &str) -> Result<(), String> {
    let failed = |error: std::io::Error| format!("{}: {error}", path.display());
    path.parent().map_or(Ok(()), fs::create_dir_all).map_err(failed)?;
    write_file(path, |file| file.write_all(text.as_bytes())).map_err(failed)
}

/// A release's family and name.
type Release = (Family, String);

/// The fingerprints of all stored releases as a table: one line for each distinct definition, with its releases.
fn fingerprints(folder: &Path) -> Result<String, String> {
    let mut known: BTreeMap<Fingerprint, Vec<String>> = BTreeMap::new();
    for (family, name) in releases(folder)? {
        for fingerprint in release::fingerprints(&schema(folder, family, &name)?) {
            known.entry(fingerprint).or_default().push(format!("{}@{name}", family.dialect().name()));
        }
    }
    let mut text =
        String::from("name\treleases\ttopics\tlayout\tCDR size\tkeys\tuORB hash\ttype hash\tversion\n");
    for (fingerprint, releases) in known {
        let Fingerprint { name, topics, layout, cdr_size, keys, hash, type_hash, version } = fingerprint;
        let hex = |hash: Option<u64>| hash.map(|hash| format!("{hash:016x}")).unwrap_or_default();
        let (layout, keys) = (hex(layout), hex(keys));
        let size = cdr_size.map(|size| size.to_string()).unwrap_or_default();
        let _ = writeln!(
            text,
            "{name}\t{}\t{}\t{layout}\t{size}\t{keys}\t{hash:08x}\t{type_hash}\t{version}",
            releases.join(" "),
            topics.join(" ")
        );
    }
    Ok(text)
}

/// The stored releases, from the oldest to the newest.
fn releases(folder: &Path) -> Result<Vec<Release>, String> {
    let mut found = Vec::new();
    for family in [Family::Px4, Family::Ros2] {
        let folder = folder.join(family.dialect().name());
        let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
        if !folder.exists() {
            continue;
        }
        for entry in fs::read_dir(&folder).map_err(failed)? {
            let path = entry.map_err(failed)?.path();
            let stem = path.file_stem().and_then(|stem| stem.to_str()).map(str::to_owned);
            if path.extension().is_some_and(|extension| extension == EXTENSION) {
                found.extend(stem.map(|stem| (family, stem)));
            }
        }
    }
    found.sort_by_cached_key(|(family, name)| (*family, release::age(name)));
    Ok(found)
}

/// Reads a stored release.
fn schema(folder: &Path, family: Family, name: &str) -> Result<Schema, String> {
    let path = folder.join(family.dialect().name()).join(format!("{name}.{EXTENSION}"));
    let text = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let mut sources = SourceMap::default();
    let packages = release::packages(&text, family.dialect(), "", &mut sources);
    Ok(read(&sources, &packages).0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stored_fingerprints_belong_to_the_stored_releases() {
        let folder = repository().join(FOLDER);
        let stored = fs::read_to_string(folder.join("fingerprints.tsv")).expect("a table");
        assert!(fingerprints(&folder).expect("the releases") == stored, "run `cargo xtask import`");
    }

    #[test]
    fn the_stored_releases_are_those_of_px4() {
        let Some(corpus) = uavspec_test_definitions::shared("corpus/px4") else { return };
        for (family, name) in releases(&repository().join(FOLDER)).expect("releases") {
            let folder = corpus.join(&name);
            if family == Family::Px4 && folder.exists() {
                let schema = definitions(family, &[folder]).expect("definitions");
                let path = repository().join(FOLDER).join(format!("px4/{name}.{EXTENSION}"));
                assert!(fs::read_to_string(path).expect("a release") == text_of(&schema), "{name} differs");
            }
        }
    }

    #[test]
    fn each_correction_applies_to_a_stored_release() {
        let folder = repository().join(FOLDER);
        let stored: Vec<String> = releases(&folder)
            .expect("releases")
            .into_iter()
            .map(|(family, name)| {
                let path = folder.join(family.dialect().name()).join(format!("{name}.{EXTENSION}"));
                fs::read_to_string(path).expect("a release")
            })
            .collect();
        for (line, corrected) in CORRECTIONS {
            assert!(stored.iter().any(|text| text.contains(corrected)), "unused: {corrected}");
            assert!(!stored.iter().any(|text| text.contains(line)), "not corrected: {line}");
        }
    }

    #[test]
    fn a_release_requires_all_packages_of_its_definitions() {
        let folder = tempfile::tempdir().expect("a folder");
        for (path, text) in [
            ("tow/tow_msgs/msg/Tow.msg", "sky_msgs/Mark mark\n"),
            ("tow/tow_msgs/msg/Rope.msg", "float64 length\n"),
            ("sky/sky_msgs/msg/Mark.msg", "float64 height\n"),
        ] {
            let path = folder.path().join(path);
            fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            fs::write(path, text).expect("a file");
        }
        let inputs = ["tow", "sky"].map(|name| folder.path().join(name));
        let error = definitions(Family::Ros2, &inputs[..1]).expect_err("a package is missing");
        assert!(error.contains("Tow.msg\n") && error.contains("--input"), "{error}");
        assert!(!error.contains("Rope.msg"), "{error}");
        assert_eq!(definitions(Family::Ros2, &inputs).expect("all packages").messages.len(), 3);
    }

    #[test]
    fn releases_are_sorted_by_age() {
        let mut names = ["main", "1.9", "1.18", "1.10"];
        names.sort_by_cached_key(|name| release::age(name));
        assert_eq!(names, ["1.9", "1.10", "1.18", "main"]);
        assert!(release_name("1.18").is_ok() && release_name("jazzy").is_ok());
        for name in ["", "..", "../1", "1 8", "A", "1."] {
            assert!(release_name(name).is_err(), "{name}");
        }
    }
}
