//! Tests of `uavspec init`. They generate and compile the workspaces that it writes.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;
use uavspec_test_support::{files_of_guide, write};
use walkdir::WalkDir;

const RUNTIME: &str = "uavspec-runtime";

/// Runs `uavspec` in a folder, and returns its exit status, standard output and standard error.
fn uavspec(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let run = Command::new(env!("CARGO_BIN_EXE_uavspec")).args(arguments).current_dir(folder).output();
    let output = run.expect("uavspec runs");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code(), text(output.stdout), text(output.stderr))
}

/// Runs `uavspec`, which must succeed, and returns its standard output.
#[track_caller]
fn succeed(folder: &Path, arguments: &[&str]) -> String {
    let (status, printed, errors) = uavspec(folder, arguments);
    assert_eq!(status, Some(0), "{arguments:?}: {errors}");
    printed
}

/// Runs Cargo without the network, and with an empty cache of crates.
fn cargo(folder: &Path, arguments: &[&str]) {
    let empty = tempfile::tempdir().expect("a folder");
    run_cargo(
        Command::new(env!("CARGO")).args(arguments).current_dir(folder).env("CARGO_HOME", empty.path()),
    );
}

fn run_cargo(command: &mut Command) {
    let output = command
        .env("CARGO_NET_OFFLINE", "true")
        // The compiled dependencies of this build are reused.
        .env("CARGO_TARGET_DIR", Path::new(env!("CARGO_TARGET_TMPDIR")).join(".."))
        // The generator runs only once, so optimising it would take more time than it saves.
        .env("CARGO_PROFILE_DEV_OPT_LEVEL", "0")
        .output()
        .expect("cargo runs");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && !errors.contains("warning:"), "{command:?}\n{errors}");
}

/// The paths of all files in a folder, without the files in the copy of the runtime.
fn files(folder: &Path) -> Vec<String> {
    let entries = WalkDir::new(folder).sort_by_file_name().into_iter().map(|entry| entry.expect("an entry"));
    let files = entries.filter(|entry| !entry.file_type().is_dir());
    let paths =
        files.map(|file| file.path().strip_prefix(folder).expect("below").to_string_lossy().into_owned());
    paths.filter(|path| !path.starts_with(RUNTIME)).collect()
}

fn folder() -> (TempDir, PathBuf) {
    let parent = tempfile::tempdir().expect("a folder");
    let folder = parent.path().join("my-drone");
    (parent, folder)
}

#[test]
fn the_default_generates_output_for_all_languages_without_a_compiler() {
    let (parent, folder) = folder();
    let printed = succeed(parent.path(), &["init", "my-drone"]);
    assert!(printed.ends_with("\nNext:\n  cd my-drone\n  uavspec codegen\n"), "{printed}");
    assert_eq!(files(&folder), ["msg/Wind.msg", "uavspec.toml"]);
    for command in
        [&["codegen"][..], &["codegen", "--check"], &["fmt", "--check"], &["lint", "--deny", "note"]]
    {
        succeed(&folder, command);
    }
    for kind in ["schemas/my_drone/Wind.schema.json", "docs/my_drone/Wind.md", "typescript", "python"] {
        assert!(folder.join("generated").join(kind).exists(), "{kind} is missing");
    }
}

#[test]
fn schemas_only_generates_only_schemas() {
    let (parent, folder) = folder();
    fs::create_dir(&folder).expect("a folder");
    let printed = succeed(&folder, &["init", "--schemas-only"]);
    assert!(printed.ends_with("\nNext:\n  uavspec codegen\n"), "{printed}");
    succeed(&folder, &["codegen"]);
    let generated = fs::read_dir(folder.join("generated")).expect("output").count();
    assert!(generated == 1 && folder.join("generated/schemas/my_drone/Wind.schema.json").exists());
    drop(parent);
}

#[test]
fn rust_compiles_without_the_network() {
    let (parent, folder) = folder();
    let printed = succeed(parent.path(), &["init", "--rust", "my-drone"]);
    assert!(printed.ends_with("\nNext:\n  cd my-drone\n  uavspec codegen\n  cargo check\n"), "{printed}");
    let expected =
        ["Cargo.toml", "messages/Cargo.toml", "messages/src/lib.rs", "msg/Wind.msg", "uavspec.toml"];
    assert_eq!(files(&folder), expected);
    succeed(&folder, &["codegen"]);
    write(
        &folder,
        "messages/examples/wind.rs",
        "fn main() {\n    let wind = messages::my_drone::Wind::default();\n    \
          assert!(wind.speed.abs() < 0.1);\n}\n",
    );
    cargo(&folder, &["run", "--quiet", "--example", "wind"]);
    // The scaffold must not contain the name or the address of its user.
    for path in expected {
        let text = fs::read_to_string(folder.join(path)).expect("a file");
        assert!(!text.contains("http") && !text.contains("authors"), "{path}: {text}");
    }
}

#[test]
fn existing_definitions_are_used_with_their_package_and_dialect() {
    let (parent, folder) = folder();
    let manifest = "<package format=\"3\">\n  <name>sky_msgs</name>\n</package>\n";
    write(&folder, "ros/sky/package.xml", manifest);
    write(&folder, "ros/sky/msg/Cloud.msg", "string name\nfloat64[] heights\n");
    write(&folder, "ros/sky/srv/Count.srv", "---\nuint8 count\n");
    write(&folder, "msg/Wind.msg", "uint64 timestamp\nfloat32 speed\n");
    write(&folder, "msg/versioned/Mode.msg", "uint32 MESSAGE_VERSION = 0\nuint64 timestamp\n");
    let before = files(&folder);
    let printed = succeed(&folder, &["init", "--rust"]);
    assert!(
        printed.starts_with(
            "found package my_drone (px4): msg/*.msg, msg/versioned/*.msg\n\
         found package sky_msgs (ros2): ros/sky/msg/*.msg, ros/sky/srv/*.srv\n"
        ),
        "{printed}"
    );
    let mut expected = before;
    expected.extend(
        ["Cargo.toml", "messages/Cargo.toml", "messages/src/lib.rs", "uavspec.toml"].map(str::to_owned),
    );
    expected.sort();
    let mut found = files(&folder);
    found.sort();
    assert_eq!(found, expected, "there is no example");
    succeed(&folder, &["codegen"]);
    cargo(&folder, &["check", "--quiet"]);
    drop(parent);
}

#[test]
fn existing_files_are_listed_and_never_replaced() {
    let (parent, folder) = folder();
    write(&folder, "uavspec.toml", "mine");
    write(&folder, "messages", "a file with the name of a folder");
    write(&folder, "uavspec-runtime/notes.txt", "mine");
    let before: Vec<(String, Vec<u8>)> = files(&folder)
        .into_iter()
        .map(|path| (path.clone(), fs::read(folder.join(path)).expect("a file")))
        .collect();
    let (status, printed, errors) = uavspec(parent.path(), &["init", "--rust", "my-drone"]);
    assert_eq!((status, printed.as_str()), (Some(2), ""));
    let expected = "error: nothing was written, because these files exist:\n  my-drone/uavspec.toml\n  \
                    my-drone/messages\n  my-drone/uavspec-runtime\n  help: choose another folder, or move the files\n";
    assert_eq!(errors, expected);
    let after: Vec<(String, Vec<u8>)> = files(&folder)
        .into_iter()
        .map(|path| (path.clone(), fs::read(folder.join(path)).expect("a file")))
        .collect();
    assert_eq!(after, before);
    let (status, _, errors) = uavspec(parent.path(), &["init", "my-drone/messages"]);
    assert_eq!(status, Some(2));
    assert!(errors.contains("my-drone/messages: "), "{errors}");
}

/// Changes a workspace as the guide describes, and runs the generator with Cargo.
#[test]
#[ignore = "slow"]
fn the_generator_runs_as_cargo_xtask() {
    let (parent, folder) = folder();
    let repository =
        fs::canonicalize(Path::new(env!("CARGO_MANIFEST_DIR")).join("..")).expect("the repository");
    succeed(parent.path(), &["init", "--rust", "my-drone"]);
    let files = files_of_guide("your-build.md");
    assert!(files.len() >= 5, "the page shows all files: {files:?}");
    fs::remove_dir_all(folder.join(RUNTIME)).expect("the copy");
    for (path, text) in &files {
        // In the guide, the clone is next to the workspace.
        let text = text.replace("\"../../uavspec/", &format!("\"{}/", repository.display()));
        // The target folder is shared, so the program must not replace the `xtask` of this workspace, which other tests
        // run.
        let text = text.replace("name = \"xtask\"", "name = \"downstream-xtask\"");
        let text = text.replace("--package xtask", "--package downstream-xtask");
        write(&folder, path, text);
    }
    // The locked versions are used, because they are already available.
    fs::copy(repository.join("Cargo.lock"), folder.join("Cargo.lock")).expect("a lock file");
    for arguments in
        [&["xtask", "codegen"][..], &["xtask", "codegen", "--check"], &["check", "--package", "messages"]]
    {
        run_cargo(Command::new(env!("CARGO")).args(arguments).current_dir(&folder));
    }
}
