//! Runs the hooks with pre-commit.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use uavspec_test_support::python::python;
use uavspec_test_support::write;

use super::{GUST, Project, commit, example, git, path_with_uavspec, repository};

/// The version of pre-commit.
const VERSION: &str = "pre-commit==4.7.0";

/// Installs pre-commit in the target folder.
fn program() -> PathBuf {
    python("pre-commit", &[VERSION]).with_file_name("pre-commit")
}

/// A package without a program. pre-commit installs it instead of compiling uavspec.
const PACKAGE: &str = "[project]\nname = \"stub\"\nversion = \"0\"\n";

/// Creates a repository with the hooks of this repository. Returns the revision of the new repository.
fn hooks(folder: &Path) -> String {
    fs::create_dir(folder).expect("a folder");
    let own = repository().join(".pre-commit-hooks.yaml");
    fs::copy(own, folder.join(".pre-commit-hooks.yaml")).expect("the hooks");
    write(folder, "pyproject.toml", PACKAGE);
    git(folder, &["init", "--quiet"]);
    commit(folder);
    git(folder, &["rev-parse", "HEAD"])
}

#[test]
#[ignore = "requires Python and the network"]
fn the_hooks_format_and_check_changed_definitions() {
    let pre_commit = program();
    let temporary = tempfile::tempdir().expect("a folder");
    let hooks_folder = temporary.path().join("hooks");
    let revision = hooks(&hooks_folder);
    let project = Project::clean();
    let folder = project.path();
    let config = example(".pre-commit-config.yaml");
    let config = config.replace("REPOSITORY", &hooks_folder.to_string_lossy()).replace("REVISION", &revision);
    write(folder, ".pre-commit-config.yaml", config);
    let run = |arguments: &[&str]| {
        git(folder, &["add", "."]);
        let output = Command::new(&pre_commit)
            .args(["run", "--color=never"])
            .args(arguments)
            .current_dir(folder)
            .env("PATH", path_with_uavspec())
            .env("PRE_COMMIT_HOME", temporary.path().join("cache"))
            .output()
            .expect("pre-commit runs");
        (output.status.success(), String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let read = |path: &str| fs::read_to_string(folder.join(path)).expect("a file");

    assert!(run(&["--all-files"]).0, "there are no findings yet");
    // A file that belongs to no package.
    write(folder, "other/Odd.msg", "uint8   odd\n");
    commit(folder);
    let formatted = read("msg/Wind.msg");
    write(folder, "msg/Wind.msg", formatted.replace("float32 speed     #", "float32   speed #"));
    let (is_success, log) = run(&["--all-files"]);
    assert!(!is_success && log.contains("files were modified by this hook"), "{log}");
    assert_eq!(read("msg/Wind.msg"), formatted);
    assert_eq!(read("other/Odd.msg"), "uint8   odd\n");
    let (is_success, log) = run(&["--all-files"]);
    assert!(is_success, "{log}");

    // The message contains another one that isn't passed to the hook.
    write(folder, "msg/Gust.msg", GUST);
    let (is_success, log) = run(&[]);
    assert!(!is_success && log.contains("unit-missing") && !log.contains("unknown-type"), "{log}");
    write(folder, "msg/Gust.msg", GUST.replace("# Duration", "# [s] Duration"));
    let (is_success, log) = run(&[]);
    assert!(is_success, "{log}");
}
