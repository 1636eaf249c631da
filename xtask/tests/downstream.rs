//! Tests that the workspace in the chapter "Use it in your build" of the guide compiles.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The files on the page: each is a line with a path in backticks, followed by a fenced block.
fn files_of_page() -> Vec<(String, String)> {
    let page = repository().join("xtask/site/guide/your-build.md");
    let page = fs::read_to_string(page).expect("the page");
    let mut files = Vec::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        let Some(path) = line.strip_prefix('`').and_then(|rest| rest.strip_suffix('`')) else { continue };
        let fenced = lines.by_ref().skip_while(|line| !line.starts_with("```")).skip(1);
        let text: Vec<&str> = fenced.take_while(|line| *line != "```").collect();
        files.push((path.to_owned(), text.join("\n") + "\n"));
    }
    files
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn cargo(folder: &Path, arguments: &[&str]) {
    let output = Command::new(env!("CARGO"))
        .args(arguments)
        .current_dir(folder)
        // Reuse the compiled dependencies of this build.
        .env("CARGO_TARGET_DIR", Path::new(env!("CARGO_TARGET_TMPDIR")).join(".."))
        .env("CARGO_NET_OFFLINE", "true")
        .output()
        .expect("cargo runs");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && !errors.contains("warning:"), "cargo {arguments:?}\n{errors}");
}

#[test]
#[ignore = "slow"]
fn the_workspace_in_the_guide_compiles() {
    let parent = tempfile::tempdir().expect("a temporary folder");
    let folder = parent.path().join("workspace");
    let repository = fs::canonicalize(repository()).expect("the repository");
    let files = files_of_page();
    assert!(files.len() >= 8, "the page shows all files: {files:?}");
    for (path, text) in &files {
        let path = folder.join(path);
        fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
        // In the guide, the clone is next to the workspace.
        let own = |part: &str| format!("\"{}\"", repository.join(part).display());
        let text = text.replace("\"../../uavspec/codegen\"", &own("codegen"));
        let text = text.replace("\"../../uavspec/generated/runtime\"", &own("generated/runtime"));
        // In the shared target folder, the program must not replace this workspace's `xtask`, which other tests run.
        let text = text.replace("name = \"xtask\"", "name = \"downstream-xtask\"");
        let text = text.replace("--package xtask", "--package downstream-xtask");
        fs::write(path, text).expect("a file");
    }
    // Use the locked versions, which are already available.
    fs::copy(repository.join("Cargo.lock"), folder.join("Cargo.lock")).expect("a lock file");
    cargo(&folder, &["xtask", "codegen"]);
    cargo(&folder, &["xtask", "codegen", "--check"]);
    cargo(&folder, &["check", "--package", "messages"]);
    cargo(&folder, &["check", "--package", "messages", "--features", "uavspec-runtime/serde"]);
    for path in [
        "messages/src/generated/my_msgs/wind.rs",
        "schemas/my_msgs/Wind.schema.json",
        "docs/messages/my_msgs/Wind.md",
    ] {
        assert!(folder.join(path).exists(), "{path} is missing");
    }
}
