//! The definitions of releases, as facts without comments.
//!
//! ```
//! use uavspec_definitions::releases::releases;
//!
//! let release = releases().find(|release| release.name() == "1.16").unwrap();
//! assert!(release.text().contains("MSG: px4_msgs/msg/BatteryStatus\n"));
//! ```

use alloc::borrow::Cow;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt::Write as _;

use include_dir::{Dir, File, include_dir};

static FOLDER: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/releases");

/// The definitions of a release: a file in a folder for its family.
#[derive(Clone, Copy, Debug)]
pub struct Release(&'static File<'static>);

/// All releases.
pub fn releases() -> impl Iterator<Item = Release> {
    FOLDER.dirs().flat_map(Dir::files).map(Release)
}

impl Release {
    /// The family: `px4` or `ros2`.
    pub fn family(self) -> &'static str {
        self.0.path().parent().and_then(|folder| folder.to_str()).unwrap_or_default()
    }

    /// The name, such as `1.16` or `jazzy`.
    pub fn name(self) -> &'static str {
        self.0.path().file_stem().and_then(|name| name.to_str()).unwrap_or_default()
    }

    /// The definitions. Each one follows a line of `=` characters, and a line with its name.
    pub fn text(self) -> &'static str {
        self.0.contents_utf8().unwrap_or_default()
    }

    /// The definitions, with the constants that the firmware of the release uses. A constant from `errata.tsv`, which
    /// the definition states wrongly, has a comment with its source.
    pub fn corrected_text(self) -> Cow<'static, str> {
        let errata: Vec<Erratum<'_>> = errata().filter(|erratum| self.has(erratum)).collect();
        if errata.is_empty() {
            return self.text().into();
        }
        let mut message = "";
        let mut text = String::new();
        for line in self.text().lines() {
            message = line.strip_prefix("MSG: ").and_then(|name| name.rsplit('/').next()).unwrap_or(message);
            let (ty, constant) = line.split_once(' ').unwrap_or_default();
            match errata.iter().find(|erratum| erratum.message == message && erratum.stated == constant) {
                Some(Erratum { right: "", .. }) => {}
                Some(Erratum { stated, right, meaning, source, .. }) => {
                    let stated = stated.rsplit('=').next().unwrap_or_default();
                    let _ =
                        writeln!(text, "{ty} {right} # {meaning}; the definition states {stated} ({source})");
                }
                None => text.extend([line, "\n"]),
            }
        }
        text.into()
    }

    fn has(self, erratum: &Erratum<'_>) -> bool {
        self.family() == "px4" && erratum.releases.split(' ').any(|release| release == self.name())
    }
}

/// A constant that definitions state wrongly.
struct Erratum<'t> {
    /// The releases, separated by spaces.
    releases: &'t str,
    message: &'t str,
    /// The constant in the definition, as `NAME=VALUE`.
    stated: &'t str,
    /// The constant in the firmware, as `NAME=VALUE`. Empty if the firmware has no such value.
    right: &'t str,
    meaning: &'t str,
    source: &'t str,
}

/// The rows of `errata.tsv`.
fn errata() -> impl Iterator<Item = Erratum<'static>> {
    include_str!("releases/errata.tsv").lines().skip(1).filter_map(|line| {
        let mut cells = line.split('\t');
        let mut cell = || cells.next();
        let [releases, message, stated, right, meaning, source] =
            [cell()?, cell()?, cell()?, cell()?, cell()?, cell()?];
        Some(Erratum { releases, message, stated, right, meaning, source })
    })
}

/// A version of a PX4 message that no release contains, but that PX4's message translation node converts.
#[derive(Clone, Copy, Debug)]
pub struct OldVersion {
    /// The name of the message.
    pub message: &'static str,
    /// The version.
    pub version: u32,
    /// The name that the message had in this version.
    pub name: &'static str,
    /// PX4's hash of the fields.
    pub hash: u32,
}

/// The rows of `versions.tsv`.
pub fn old_versions() -> impl Iterator<Item = OldVersion> {
    include_str!("releases/versions.tsv").lines().skip(1).filter_map(|line| {
        let mut cells = line.split('\t');
        let mut cell = || cells.next();
        let (message, version, name, hash) = (cell()?, cell()?.parse().ok()?, cell()?, cell()?);
        Some(OldVersion { message, version, name, hash: u32::from_str_radix(hash, 16).ok()? })
    })
}

/// The fingerprints of the definitions in all releases: a table with tabs between its columns, and a heading.
pub static FINGERPRINTS: &str = include_str!("releases/fingerprints.tsv");

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_release_contains_an_old_version() {
        let rows = include_str!("releases/versions.tsv").lines().count() - 1;
        assert_eq!(old_versions().count(), rows);
        for old in old_versions() {
            let name = alloc::format!("px4_msgs/msg/{}\t", old.message);
            let versions = FINGERPRINTS.lines().filter(|line| line.starts_with(&name));
            let mut versions = versions.filter_map(|line| line.rsplit('\t').next()?.parse::<u32>().ok());
            assert!(versions.any(|version| version > old.version), "{old:?}");
        }
    }

    #[test]
    fn each_erratum_corrects_a_constant_of_its_releases() {
        for erratum in errata() {
            for name in erratum.releases.split(' ') {
                let is_it = |release: &Release| release.family() == "px4" && release.name() == name;
                let release = releases().find(is_it).expect("a release");
                let count = |text: &str, constant: &str| {
                    let is_it = |line: &&str| line.split(' ').nth(1) == Some(constant);
                    text.lines().filter(is_it).count()
                };
                let (text, corrected) = (release.text(), release.corrected_text());
                assert_eq!((count(text, erratum.stated), count(&corrected, erratum.stated)), (1, 0));
                assert_eq!(count(&corrected, erratum.right), usize::from(!erratum.right.is_empty()));
            }
        }
    }
}
