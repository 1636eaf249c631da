//! Tests of the files that commands write: nothing outside the output folder, no input replaced, nothing left behind.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use support::{tree, write, xtask};
use tempfile::TempDir;
use uavspec_schema::stage::Stage;

use crate::support;

const WIND: &str = "uint64 timestamp  # [us] Since start\n";

/// A configuration with one package and one output.
fn config(include: &str, output: &str) -> String {
    format!(
        "[[package]]\nname = \"demo\"\ndialect = \"px4\"\ninclude = [\"{include}\"]\n[output]\n{output}\n"
    )
}

fn workspace() -> TempDir {
    let config = config("msg/*.msg", "json_schema = \"out\"");
    support::workspace(&[("work/msg/Wind.msg", WIND), ("work/uavspec.toml", &config)])
}

/// Runs a command in the folder `work`. Returns the exit status and standard error.
fn run(folder: &TempDir, arguments: &[&str]) -> (Option<i32>, String) {
    let output = xtask(folder.path().join("work"), arguments);
    (output.status.code(), String::from_utf8(output.stderr).expect("UTF-8"))
}

#[test]
fn a_package_name_is_never_a_path() {
    let folder = workspace();
    let absolute = folder.path().join("absolute").display().to_string();
    let before = tree(folder.path());
    for name in ["", ".", "..", "../up", "a/b", "a\\b", "C:", "aux", "my-msgs", &absolute] {
        for command in ["codegen", "lint", "fmt", "inspect"] {
            let package = ["--package", name, "--dialect", "px4", "--input", "msg"];
            let out: &[&str] = if command == "codegen" { &["--out", "out"] } else { &[] };
            let (status, printed) = run(&folder, &[&[command], &package[..], out].concat());
            // `fmt` doesn't use the name.
            let is_accepted = command == "fmt" && status == Some(0);
            assert!(is_accepted || status == Some(2), "{command} {name:?}: {printed}");
            assert!(is_accepted || printed.contains("package") && printed.contains("help: "), "{printed}");
        }
    }
    assert_eq!(tree(folder.path()), before);
}

/// Creates the temporary folder of a killed run.
fn abandon(folder: &Path) {
    fs::create_dir_all(folder).expect("a folder");
    let stage = Stage::claim(folder).expect("a temporary folder");
    let mark = fs::read_to_string(stage.path().join(".lock")).expect("a mark");
    drop(stage);
    write(folder, ".uavspec-stage/.lock", &mark);
    write(folder, ".uavspec-stage/0", "text");
}

#[test]
fn codegen_removes_what_a_killed_run_left() {
    let folder = workspace();
    let out = folder.path().join("work/out");
    abandon(&out);
    assert_eq!(run(&folder, &["codegen"]).0, Some(0));
    assert!(!out.join(".uavspec-stage").exists());
    let written = tree(&out);
    abandon(&out);
    let (status, printed) = run(&folder, &["codegen"]);
    assert!(status == Some(0) && printed.contains("0 written, 0 removed"), "{printed}");
    assert_eq!(tree(&out), written);
}

#[test]
fn fmt_removes_what_a_killed_run_left() {
    let folder = workspace();
    let msg = folder.path().join("work/msg");
    write(&msg, "Wind.msg", "uint64   timestamp # [us] Since start\n");
    abandon(&msg);
    assert_eq!(run(&folder, &["fmt"]).0, Some(0));
    assert_eq!(tree(&msg), [("Wind.msg".to_owned(), WIND.as_bytes().to_vec())]);
}

#[test]
fn concurrent_runs_leave_the_output_of_one_of_them() {
    let folder = workspace();
    let work = folder.path().join("work");
    for number in 0..40 {
        write(&work, &format!("one/One{number}.msg"), WIND);
        write(&work, &format!("two/Two{number}.msg"), WIND);
    }
    write(&work, "one.toml", &config("one/*.msg", "json_schema = \"out\"\ndocs = \"docs\""));
    write(&work, "two.toml", &config("two/*.msg", "docs = \"docs\"\njson_schema = \"out\""));
    let start = |config: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_xtask"));
        command.args(["codegen", "--config", config]).current_dir(&work).stderr(Stdio::piped());
        command.spawn().expect("xtask runs")
    };
    for _ in 0..4 {
        let runs = ["one.toml", "two.toml", "one.toml", "two.toml"].map(start);
        for run in runs {
            let output = run.wait_with_output().expect("it ends");
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        }
        let current =
            ["one.toml", "two.toml"].map(|config| run(&folder, &["codegen", "--check", "--config", config]));
        assert!(current.iter().any(|(status, _)| *status == Some(0)), "{current:?}");
        let files = tree(work.join("out"));
        let has = |part: &str| files.iter().any(|(path, _)| path.contains(part));
        assert!(has("/One") != has("/Two") && !has(".uavspec-stage"), "{files:?}");
    }
}

#[test]
fn codegen_never_replaces_an_input() {
    let folder = workspace();
    let work = folder.path().join("work");
    // The first run generates a page, which the second run reads.
    write(&work, "first.toml", &config("msg/*.msg", "docs = \"pages\""));
    assert_eq!(run(&folder, &["codegen", "--config", "first.toml"]).0, Some(0));
    let mut page = fs::read_to_string(work.join("pages/demo/Wind.md")).expect("a page");
    page.push_str("\n## Speed\n\ninteger, Speed.\n");
    fs::write(work.join("pages/demo/Wind.md"), page).expect("a page");
    let second = "[[package]]\nname = \"pages\"\ndialect = \"table\"\ninclude = [\"pages/demo/Wind.md\"]\n";
    write(&work, "second.toml", &(second.to_owned() + &config("msg/*.msg", "docs = \"pages\"")));
    let before = tree(folder.path());
    let (status, printed) = run(&folder, &["codegen", "--config", "second.toml"]);
    assert_eq!(status, Some(2), "{printed}");
    assert!(printed.contains("pages/demo/Wind.md would replace an input"), "{printed}");
    assert_eq!(tree(folder.path()), before);
}

#[test]
fn a_baseline_never_replaces_a_definition_or_the_configuration() {
    let folder = workspace();
    let before = tree(folder.path());
    for path in ["msg/Wind.msg", "uavspec.toml", "../work/uavspec.toml"] {
        let (status, printed) = run(&folder, &["lint", "--write-baseline", path]);
        assert_eq!(status, Some(2), "{path}: {printed}");
    }
    assert_eq!(tree(folder.path()), before);
}

#[cfg(unix)]
#[test]
fn follows_no_links_inside_the_output_folder() {
    use std::os::unix::fs::symlink;

    let folder = workspace();
    let at = |path: &str| folder.path().join(path);
    fs::create_dir_all(at("work/out")).expect("a folder");
    fs::create_dir_all(at("elsewhere")).expect("a folder");
    write(&folder, "elsewhere/0", "precious");
    for link in ["work/out/demo", "work/out/.uavspec-stage"] {
        symlink(at("elsewhere"), at(link)).expect("a link");
        let (status, printed) = run(&folder, &["codegen"]);
        assert_eq!(status, Some(2), "{printed}");
        fs::remove_file(at(link)).expect("a link");
    }
    assert_eq!(tree(at("elsewhere")).len(), 1);
    // The output folder itself may be a link.
    fs::remove_dir(at("work/out")).expect("an empty folder");
    symlink(at("elsewhere"), at("work/out")).expect("a link");
    assert_eq!(run(&folder, &["codegen"]).0, Some(0));
    assert!(at("elsewhere/demo/Wind.schema.json").is_file());
    assert_eq!(fs::read(at("elsewhere/0")).expect("a file"), b"precious");
}

#[cfg(unix)]
#[test]
fn never_waits_for_a_pipe_in_the_output_folder() {
    let folder = workspace();
    let at = |path: &str| folder.path().join(path);
    fs::create_dir_all(at("work/out/demo")).expect("a folder");
    for pipe in ["work/out/.uavspec-manifest", "work/out/demo/Wind.schema.json"] {
        let made = Command::new("mkfifo").arg(at(pipe)).status().expect("mkfifo runs");
        assert!(made.success(), "a pipe");
        let (status, printed) = run(&folder, &["codegen"]);
        assert_eq!(status, Some(2), "{printed}");
        assert!(printed.contains("expected a file"), "{printed}");
        fs::remove_file(at(pipe)).expect("a pipe");
    }
}
