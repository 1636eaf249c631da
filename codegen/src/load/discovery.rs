//! Finds the packages in a folder that no configuration file describes.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use uavspec_schema::failure::Failure;
use uavspec_schema::msg::Dialect;
use uavspec_schema::name::package_problem;
use uavspec_schema::{Form, terminal};
use walkdir::{DirEntry, WalkDir};

use super::dialect::detected;
use super::files::is_definition;
use super::folder::{MANIFEST, is_skipped, manifest_name};

/// A name for a package whose folder has no valid name.
const DEFAULT_NAME: &str = "my_msgs";

/// A package of definitions that were found in a folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FoundPackage {
    /// The name.
    pub name: String,
    /// The dialect.
    pub dialect: Dialect,
    /// The glob patterns of the definitions, relative to the folder.
    pub include: Vec<String>,
}

/// Finds `.msg`, `.srv` and `.action` files below a folder, and the packages that they belong to. The folder of a package
/// has a `package.xml`, or contains `msg`, `srv` or `action`. All other files belong to a package of the given folder.
/// Hidden folders, links and build output are skipped. If several packages have the same name, all but the first get a
/// number.
///
/// ```
/// use uavspec_codegen::load::find_packages;
///
/// let folder = tempfile::tempdir()?;
/// std::fs::create_dir_all(folder.path().join("sky_msgs/msg"))?;
/// std::fs::write(folder.path().join("sky_msgs/msg/Wind.msg"), "float64 speed\n")?;
/// let packages = find_packages(folder.path())?;
/// assert_eq!((packages[0].name.as_str(), &packages[0].include[0][..]), ("sky_msgs", "sky_msgs/msg/*.msg"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn find_packages(folder: &Path) -> Result<Vec<FoundPackage>, Failure> {
    let entries: walkdir::Result<Vec<DirEntry>> = entries(folder).collect();
    let entries = entries.map_err(|error| Failure::new(error.to_string()))?;
    let packages = by_package(entries.into_iter().filter_map(msg_file), folder);
    let packages = packages.iter().map(|(root, files)| package(root, files, folder));
    let mut packages: Vec<FoundPackage> = packages.collect::<Result<_, _>>()?;
    make_names_unique(&mut packages);
    Ok(packages)
}

/// Adds a number to names that are already taken, even if they differ in case.
fn make_names_unique(packages: &mut [FoundPackage]) {
    let mut names: BTreeSet<String> = packages.iter().map(|package| package.name.to_lowercase()).collect();
    let mut seen = BTreeSet::new();
    for package in packages {
        if seen.insert(package.name.to_lowercase()) {
            continue;
        }
        let mut numbered = (2_u32..).map(|number| format!("{}_{number}", package.name));
        if let Some(name) = numbered.find(|name| names.insert(name.to_lowercase())) {
            package.name = name;
        }
    }
}

/// The files and folders below a folder, sorted by name. Hidden folders, links and build output are skipped.
pub fn entries(folder: &Path) -> impl Iterator<Item = walkdir::Result<DirEntry>> {
    let entries = WalkDir::new(folder).sort_by_file_name().into_iter();
    entries.filter_entry(|entry| entry.depth() == 0 || !is_skipped(entry))
}

/// The path of an entry that is a `.msg`, `.srv` or `.action` file.
pub fn msg_file(entry: DirEntry) -> Option<PathBuf> {
    (entry.file_type().is_file() && is_msg_file(entry.path())).then(|| entry.into_path())
}

/// True for `.msg`, `.srv` and `.action` files.
pub fn is_msg_file(path: &Path) -> bool {
    is_definition(path, Form::Msg(Dialect::Px4))
}

/// Groups files by the folders of their packages.
pub fn by_package(files: impl Iterator<Item = PathBuf>, folder: &Path) -> BTreeMap<PathBuf, Vec<PathBuf>> {
    let mut packages: BTreeMap<PathBuf, Vec<PathBuf>> = BTreeMap::new();
    for file in files {
        packages.entry(root_of(&file, folder)).or_default().push(file);
    }
    packages
}

/// A name for the package in a folder: the name of the folder, with `_` in place of other characters.
pub fn package_name(folder: &Path) -> String {
    let absolute = fs::canonicalize(folder).or_else(|_| std::path::absolute(folder));
    let name = absolute.ok().and_then(|path| Some(path.file_name()?.to_string_lossy().to_lowercase()));
    let name = name.unwrap_or_default().replace(|character: char| !character.is_ascii_alphanumeric(), "_");
    if package_problem(&name).is_none() { name } else { DEFAULT_NAME.to_owned() }
}

/// The folder of the package that contains a file.
fn root_of(file: &Path, folder: &Path) -> PathBuf {
    let mut inside = file.ancestors().skip(1).take_while(|ancestor| ancestor.starts_with(folder));
    let is_kind_folder = |ancestor: &&Path| {
        let name = ancestor.strip_prefix(folder).ok().and_then(Path::file_name);
        name.is_some_and(|name| ["msg", "srv", "action"].iter().any(|kind| name == *kind))
    };
    // PX4 keeps versioned messages in `msg/versioned`.
    let kind_folder = file.ancestors().skip(1).take(2).find(is_kind_folder);
    let root = inside.find(|ancestor| ancestor.join(MANIFEST).is_file());
    root.or_else(|| kind_folder?.parent()).unwrap_or(folder).to_path_buf()
}

fn package(root: &Path, files: &[PathBuf], folder: &Path) -> Result<FoundPackage, Failure> {
    let patterns: Result<BTreeSet<String>, Failure> =
        files.iter().map(|file| pattern(file, folder)).collect();
    Ok(FoundPackage {
        name: manifest_name(root).unwrap_or_else(|| package_name(root)),
        dialect: detected(files).0,
        include: patterns?.into_iter().collect(),
    })
}

/// The pattern for the files with the same extension in the same folder.
fn pattern(file: &Path, folder: &Path) -> Result<String, Failure> {
    let relative = file.strip_prefix(folder).unwrap_or(file);
    let parts: Option<Vec<&str>> = relative.iter().map(|part| part.to_str()).collect();
    let Some([folders @ .., name]) = parts.as_deref() else {
        return Err(Failure::new(format!("the path {} is not valid UTF-8", terminal::path(file))));
    };
    let extension = name.rsplit('.').next().unwrap_or_default();
    let folders = folders.iter().map(|part| globset::escape(part) + "/");
    Ok(format!("{}*.{extension}", folders.collect::<String>()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PX4: &str = "uint64 timestamp # [us] Time\n";

    fn found(files: &[(&str, &str)]) -> Vec<(String, Dialect, Vec<String>)> {
        let parent = tempfile::tempdir().expect("a folder");
        let folder = parent.path().join("My-Drone");
        for (path, text) in files {
            let path = folder.join(path);
            fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            fs::write(path, text).expect("a file");
        }
        let packages = find_packages(&folder).expect("packages");
        packages.into_iter().map(|package| (package.name, package.dialect, package.include)).collect()
    }

    fn package(name: &str, dialect: Dialect, include: &[&str]) -> (String, Dialect, Vec<String>) {
        (name.to_owned(), dialect, include.iter().map(|&pattern| pattern.to_owned()).collect())
    }

    #[test]
    fn messages_of_px4_are_one_package_named_after_the_folder() {
        let packages = found(&[
            ("msg/Wind.msg", PX4),
            ("msg/versioned/Mode.msg", PX4),
            ("srv/Arm.srv", "---\n"),
            ("README.md", ""),
        ]);
        let include = ["msg/*.msg", "msg/versioned/*.msg", "srv/*.srv"];
        assert_eq!(packages, [package("my_drone", Dialect::Px4, &include)]);
    }

    #[test]
    fn ros_packages_have_the_names_in_their_manifests() {
        let manifest =
            "<?xml version=\"1.0\"?>\n<package format=\"3\">\n  <name> sky_msgs </name>\n</package>\n";
        let packages = found(&[
            ("src/a/package.xml", manifest),
            ("src/a/interfaces/msg/Gust.msg", "string name\n"),
            ("src/b_msgs/msg/Wind.msg", "float64[] speeds\n"),
            ("src/b_msgs/srv/Get.srv", "---\nstring name\n"),
            ("odd [1]/Mark.msg", "string name\n"),
        ]);
        let expected = [
            package("my_drone", Dialect::Ros2, &["odd [[]1[]]/*.msg"]),
            package("sky_msgs", Dialect::Ros2, &["src/a/interfaces/msg/*.msg"]),
            package("b_msgs", Dialect::Ros2, &["src/b_msgs/msg/*.msg", "src/b_msgs/srv/*.srv"]),
        ];
        assert_eq!(packages, expected);
    }

    #[test]
    fn names_that_are_taken_get_a_number() {
        let packages = found(&[
            ("a/gusts/msg/Wind.msg", PX4),
            ("b/gusts/msg/Wind.msg", PX4),
            ("c/gusts_2/msg/Wind.msg", PX4),
            ("d/7/msg/Wind.msg", PX4),
            ("e/8/msg/Wind.msg", PX4),
            ("f/package.xml", "<package><name>Gusts</name></package>\n"),
            ("f/msg/Wind.msg", PX4),
        ]);
        let names: Vec<&str> = packages.iter().map(|(name, ..)| name.as_str()).collect();
        assert_eq!(names, ["gusts", "gusts_3", "gusts_2", "my_msgs", "my_msgs_2", "Gusts_4"]);
    }

    #[test]
    fn build_output_and_hidden_folders_are_skipped() {
        let packages = found(&[
            ("install/COLCON_IGNORE", ""),
            ("install/share/a/msg/Wind.msg", PX4),
            ("target/CACHEDIR.TAG", ""),
            ("target/Wind.msg", PX4),
            (".cache/Wind.msg", PX4),
            ("node_modules/a/Wind.msg", PX4),
        ]);
        assert_eq!(packages, []);
    }

    #[test]
    fn names_are_valid() {
        for (folder, name) in [
            ("/a/PX4-Autopilot", "px4_autopilot"),
            ("/a/7seas", "my_msgs"),
            ("/", "my_msgs"),
            ("/a/Ü", "my_msgs"),
        ] {
            assert_eq!(package_name(Path::new(folder)), name);
        }
    }
}
