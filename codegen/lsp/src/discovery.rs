//! Finds the packages in a folder that has no configuration file.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use uavspec_codegen::load::{
    Inputs, Plan, PlannedPackage, by_package, detected, entries, is_definition, is_msg_file, manifest_name,
    msg_file,
};
use uavspec_emit::identifier::Scope;
use uavspec_schema::Form;
use uavspec_schema::source::SourceMap;
use uavspec_schema::table::{self, error_code, type_table};

use crate::limits::MAX_ENTRIES;

/// The name of the package that contains open pages.
const PAGES: &str = "pages";

/// Plans the packages below a folder: the packages of all definitions, and one package for open pages that contain
/// definitions.
pub(super) fn plan(folder: &Path, open: &BTreeMap<PathBuf, String>) -> Plan {
    let saved = entries(folder).take(MAX_ENTRIES).filter_map(Result::ok).filter_map(msg_file);
    // Include open documents, which may not have been saved yet.
    let unsaved = open.keys().filter(|path| path.starts_with(folder) && is_msg_file(path)).cloned();
    let files: BTreeSet<PathBuf> = saved.chain(unsaved).collect();
    let mut packages = Vec::new();
    let mut names = Scope::default();
    for (folder, files) in by_package(files.into_iter(), folder) {
        let (dialect, detected) = detected(&files);
        let name = unique(&manifest_name(&folder).unwrap_or(detected), &mut names);
        packages.push(PlannedPackage::new(&name, Form::Msg(dialect), Inputs::Files(files)));
    }
    let pages = open.iter().filter(|(path, text)| path.starts_with(folder) && is_page(path, text));
    let pages: Vec<PathBuf> = pages.map(|(path, _)| path.clone()).collect();
    if !pages.is_empty() {
        packages.push(PlannedPackage::new(&unique(PAGES, &mut names), Form::Table, Inputs::Files(pages)));
    }
    Plan::of_packages(packages)
}

/// True if the text of an open document belongs to the packages below a folder.
pub(super) fn is_read(folder: &Path, path: &Path, text: &str) -> bool {
    path.starts_with(folder) && (is_msg_file(path) || is_page(path, text))
}

/// A package name that is not used yet, even if case is ignored.
fn unique(name: &str, names: &mut Scope) -> String {
    let unique = names.unique(&name.to_ascii_lowercase());
    format!("{name}{}", &unique[name.len()..])
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

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn packages_of_one_name_are_numbered() {
        let allocated = |count: usize| {
            let folder = tempfile::tempdir().expect("a folder");
            for number in 0..count {
                let package = folder.path().join(format!("{number:03}"));
                fs::create_dir_all(package.join("msg")).expect("a folder");
                fs::write(package.join("msg/Wind.msg"), "uint64 timestamp\n").expect("a file");
                let name = if number % 2 == 0 { "wind" } else { "Wind" };
                fs::write(package.join("package.xml"), format!("<name>{name}</name>")).expect("a file");
            }
            let mut names = Vec::new();
            let allocated = allocation_counter::measure(|| {
                names = plan(folder.path(), &BTreeMap::new()).packages;
            });
            let names: Vec<&str> = names.iter().map(|package| package.name.as_str()).collect();
            assert_eq!(names[..4], ["wind", "Wind_2", "wind_3", "Wind_4"]);
            allocated.bytes_total
        };
        let [once, twice] = [100, 200].map(allocated);
        assert!(10 * twice < 22 * once, "{once} and {twice} bytes");
    }
}
