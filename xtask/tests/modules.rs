//! Checks the `tests/` folders: with `autotests = false`, a file without a `mod` declaration is never compiled.

use std::fs;
use std::path::Path;

#[test]
fn each_file_in_a_tests_folder_is_a_module_of_its_program() {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let manifest = fs::read_to_string(repository.join("Cargo.toml")).expect("the workspace");
    let manifest: toml::Table = manifest.parse().expect("TOML");
    let members = manifest["workspace"]["members"].as_array().expect("the members");
    let mut programs = 0;
    for member in members {
        let folder = repository.join(member.as_str().expect("a path")).join("tests");
        let Ok(program) = fs::read_to_string(folder.join("main.rs")) else { continue };
        programs += 1;
        for entry in fs::read_dir(&folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
            if path.extension().is_none_or(|extension| extension != "rs") || name == "main" {
                continue;
            }
            let declaration = format!("mod {name};");
            assert!(program.lines().any(|line| line == declaration), "{} is not compiled", path.display());
        }
    }
    assert!(programs >= 5, "found only {programs} test programs");
}
