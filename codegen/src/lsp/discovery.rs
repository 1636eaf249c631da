//! Finds the packages in a folder that has no configuration file.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use walkdir::{DirEntry, WalkDir};

use crate::load::{Inputs, Plan, PlannedPackage, detected, is_definition};
use crate::msg::Dialect;
use crate::name::package_problem;
use crate::schema::Form;
use crate::source::SourceMap;
use crate::table::{self, error_code, type_table};

/// The maximum number of files and folders that are searched. PX4 with all submodules has about 60,000.
const MAX_ENTRIES: usize = 200_000;

/// Folders that contain copies of definitions, or none: build output and dependencies.
const SKIPPED: [&str; 5] = ["build", "install", "log", "node_modules", "target"];

/// The folders of definitions in a package.
const KIND_FOLDERS: [&str; 3] = ["msg", "srv", "action"];

/// The name of the package of open pages.
const PAGES: &str = "pages";

/// Plans the packages below a folder: those of all definitions, and one of the open pages that contain definitions.
pub(super) fn plan(folder: &Path, open: &BTreeMap<PathBuf, String>) -> Plan {
    let found = WalkDir::new(folder).into_iter().filter_entry(is_searched).take(MAX_ENTRIES);
    let files = found.filter_map(Result::ok).filter(|entry| entry.file_type().is_file());
    let files = files.map(DirEntry::into_path).filter(|path| is_msg_file(path));
    // An open document may not have been saved yet.
    let unsaved = open.keys().filter(|path| path.starts_with(folder) && is_msg_file(path)).cloned();
    let files: BTreeSet<PathBuf> = files.chain(unsaved).collect();
    let mut by_folder: BTreeMap<&Path, Vec<PathBuf>> = BTreeMap::new();
    for file in &files {
        by_folder.entry(package_folder(file)).or_default().push(file.clone());
    }
    let mut packages: Vec<PlannedPackage> = Vec::new();
    for (folder, files) in by_folder {
        let (dialect, detected) = detected(&files);
        let name = ros_package(folder).unwrap_or(&detected);
        let name = unique(name, &packages);
        packages.push(PlannedPackage::new(&name, Form::Msg(dialect), Inputs::Files(files)));
    }
    let pages = open.iter().filter(|(path, text)| path.starts_with(folder) && is_page(path, text));
    let pages: Vec<PathBuf> = pages.map(|(path, _)| path.clone()).collect();
    if !pages.is_empty() {
        packages.push(PlannedPackage::new(&unique(PAGES, &packages), Form::Table, Inputs::Files(pages)));
    }
    Plan::of_packages(packages)
}

/// The name of a ROS package, by its folder.
fn ros_package(folder: &Path) -> Option<&str> {
    let name = folder.file_name()?.to_str()?;
    (folder.join("package.xml").is_file() && package_problem(name).is_none()).then_some(name)
}

/// True if the text of an open document belongs to the packages below a folder.
pub(super) fn is_read(folder: &Path, path: &Path, text: &str) -> bool {
    path.starts_with(folder) && (is_msg_file(path) || is_page(path, text))
}

/// True for `.msg`, `.srv` and `.action` files.
fn is_msg_file(path: &Path) -> bool {
    is_definition(path, Form::Msg(Dialect::Px4))
}

/// The folder of the package that contains a definition: the parent of the nearest folder `msg`, `srv` or `action`, or
/// the folder of the file.
pub(super) fn package_folder(file: &Path) -> &Path {
    let parent = file.parent().unwrap_or(Path::new(""));
    // PX4 keeps versioned messages in `msg/versioned`.
    let kind = parent.ancestors().take(2).find(|folder| {
        folder.file_name().and_then(OsStr::to_str).is_some_and(|name| KIND_FOLDERS.contains(&name))
    });
    kind.and_then(Path::parent).unwrap_or(parent)
}

fn is_searched(entry: &DirEntry) -> bool {
    let name = entry.file_name().to_string_lossy();
    entry.depth() == 0 || !(name.starts_with('.') || entry.file_type().is_dir() && SKIPPED.contains(&&*name))
}

/// A name that no package has yet, also if case is ignored.
fn unique(name: &str, packages: &[PlannedPackage]) -> String {
    let is_free = |name: &str| packages.iter().all(|package| !package.name.eq_ignore_ascii_case(name));
    let numbered = (2..).map(|number| format!("{name}_{number}"));
    std::iter::once(name.to_owned()).chain(numbered).find(|name| is_free(name)).unwrap_or_default()
}

/// True if a page contains a table of error codes, types or messages.
fn is_page(path: &Path, text: &str) -> bool {
    if !is_definition(path, Form::Table) {
        return false;
    }
    let mut sources = SourceMap::default();
    let Ok(id) = sources.add(path.to_string_lossy(), text.as_bytes().to_vec()) else { return false };
    let (page, _) = table::parse(&sources, id);
    let (types, _) = type_table::read(&page);
    let (codes, _) = error_code::read(&page);
    !codes.is_empty() || !types.types.is_empty() || !types.messages.is_empty()
}
