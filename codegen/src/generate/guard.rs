//! Checks the paths of generated files before anything is written. No file is outside its output folder, and no two
//! files have the same path on any system.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::Path;

use uavspec_emit::OutputFile;
use uavspec_schema::failure::Failure;
use uavspec_schema::name::file_problem;
use uavspec_schema::source::{SourceMap, Span};
use uavspec_schema::{Package, Schema, render, terminal};

/// The start of the names of uavspec's own files in output folders.
const OWN: &str = ".uavspec-";

/// Fails if a definition has a name that can't be a file name on all systems. The failure contains the location.
pub(super) fn check_names(schema: &Schema, sources: &SourceMap) -> Result<(), Failure> {
    for package in &schema.packages {
        for (name, span) in names(schema, package) {
            if let Some(problem) = file_problem(name) {
                let message = format!("the name `{name}` {problem}");
                return Err(Failure::new(render::plain(&message, span.part(0..0), sources)).with_hint(
                    "rename it, or exclude it with `select`: output files are named after definitions",
                ));
            }
        }
    }
    Ok(())
}

/// The names in a package that occur in paths, with their definitions.
fn names<'s>(schema: &'s Schema, package: &'s Package) -> impl Iterator<Item = (&'s str, Span)> {
    let messages =
        package.messages.iter().map(|id| schema.message(*id)).map(|it| (it.name.as_str(), it.span));
    let interfaces = package.interfaces.iter().map(|it| (it.name.as_str(), it.span));
    let types =
        package.json_types.iter().map(|id| schema.json_type(*id)).map(|it| (it.name.as_str(), it.span));
    let json =
        package.json_messages.iter().map(|id| schema.json_message(*id)).map(|it| (it.name.as_str(), it.span));
    messages.chain(interfaces).chain(types).chain(json)
}

/// Fails if a file is outside the output folder, has a name that some systems reject, or differs from another file in
/// case only.
pub(super) fn check_paths(folder: &Path, files: &[OutputFile]) -> Result<(), Failure> {
    let mut known: BTreeMap<String, (&str, bool)> = BTreeMap::new();
    for file in files {
        check_path(folder, &file.path)?;
        let ends = file.path.match_indices('/').map(|(at, _)| (at, false));
        for (end, is_file) in ends.chain([(file.path.len(), true)]) {
            let path = file.path.get(..end).unwrap_or_default();
            match known.entry(path.to_lowercase()) {
                Entry::Vacant(entry) => drop(entry.insert((path, is_file))),
                Entry::Occupied(entry) if *entry.get() == (path, false) && !is_file => {}
                Entry::Occupied(entry) => {
                    let other = entry.get().0;
                    let message = format!(
                        "the outputs `{other}` and `{path}` in {} have the same path on some systems",
                        terminal::path(folder)
                    );
                    return Err(Failure::new(message).with_hint("rename one of the two definitions"));
                }
            }
        }
    }
    Ok(())
}

fn check_path(folder: &Path, path: &str) -> Result<(), Failure> {
    let own = |part: &str| part.starts_with(OWN).then_some("is reserved for uavspec");
    let wrong = path.split('/').find_map(|part| Some((part, file_problem(part).or_else(|| own(part))?)));
    let Some((part, problem)) = wrong else { return Ok(()) };
    let message = format!(
        "the output `{}` can't be written to {}: `{}` {problem}",
        path.escape_debug(),
        terminal::path(folder),
        part.escape_debug()
    );
    Err(Failure::new(message)
        .with_hint("rename the definition, the package or the option that contains this name"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(paths: &[&str]) -> Result<(), String> {
        let file = |path: &&str| OutputFile { path: (*path).to_owned(), text: String::new() };
        let files: Vec<OutputFile> = paths.iter().map(file).collect();
        check_paths(Path::new("out"), &files).map_err(|failure| failure.to_string())
    }

    #[test]
    fn accepts_paths_below_the_folder() {
        assert_eq!(check(&["mod.rs", "px4.rs", "px4/wind.rs", "px4/srv/tow.rs"]), Ok(()));
    }

    #[test]
    fn rejects_paths_that_leave_the_folder_or_name_devices() {
        for path in
            ["", "/etc/x", "../x", "px4/../../x", "./x", "px4//x", "C:/x", "px4\\..\\x", "px4/aux.rs", "a./b"]
        {
            let error = check(&[path]).expect_err(path);
            assert!(error.contains("can't be written to out") && error.contains("help: "), "{error}");
        }
        assert!(check(&[".uavspec-manifest"]).is_err());
    }

    #[test]
    fn rejects_paths_that_differ_in_case_only() {
        for paths in
            [&["a/b.md", "a/B.md"][..], &["px4/a.md", "Px4/b.md"], &["a", "a"], &["a", "a/b"], &["a/b", "A"]]
        {
            let error = check(paths).expect_err("the same path");
            assert!(error.contains("the same path on some systems"), "{error}");
        }
    }
}
