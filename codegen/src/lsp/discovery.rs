//! Finds the packages in a folder that has no configuration file.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::load::{
    Inputs, Plan, PlannedPackage, by_package, detected, entries, is_definition, is_msg_file, manifest_name,
    msg_file,
};
use crate::schema::Form;
use crate::source::SourceMap;
use crate::table::{self, error_code, type_table};

/// The maximum number of files and folders that are searched. PX4 with all submodules has about 60,000.
const MAX_ENTRIES: usize = 200_000;

/// The name of the package of open pages.
const PAGES: &str = "pages";

/// Plans the packages below a folder: those of all definitions, and one of the open pages that contain definitions.
pub(super) fn plan(folder: &Path, open: &BTreeMap<PathBuf, String>) -> Plan {
    let saved = entries(folder).take(MAX_ENTRIES).filter_map(Result::ok).filter_map(msg_file);
    // An open document may not have been saved yet.
    let unsaved = open.keys().filter(|path| path.starts_with(folder) && is_msg_file(path)).cloned();
    let files: BTreeSet<PathBuf> = saved.chain(unsaved).collect();
    let mut packages: Vec<PlannedPackage> = Vec::new();
    for (folder, files) in by_package(files.into_iter(), folder) {
        let (dialect, detected) = detected(&files);
        let name = unique(&manifest_name(&folder).unwrap_or(detected), &packages);
        packages.push(PlannedPackage::new(&name, Form::Msg(dialect), Inputs::Files(files)));
    }
    let pages = open.iter().filter(|(path, text)| path.starts_with(folder) && is_page(path, text));
    let pages: Vec<PathBuf> = pages.map(|(path, _)| path.clone()).collect();
    if !pages.is_empty() {
        packages.push(PlannedPackage::new(&unique(PAGES, &packages), Form::Table, Inputs::Files(pages)));
    }
    Plan::of_packages(packages)
}

/// True if the text of an open document belongs to the packages below a folder.
pub(super) fn is_read(folder: &Path, path: &Path, text: &str) -> bool {
    path.starts_with(folder) && (is_msg_file(path) || is_page(path, text))
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
