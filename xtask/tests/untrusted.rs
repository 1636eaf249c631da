//! Tests that definitions, their file names and arguments don't reach the terminal or the log of a CI system raw.

#![cfg(unix)]

use crate::support::{write, xtask};

/// Text that starts new lines, and contains terminal sequences and commands of CI systems.
const HOSTILE: &str =
    "x\n::error::FORGED\nFORGED \u{1b}]0;t\u{7}\r\u{9b}2J\u{202e}\u{2028}##[error]y##vso[task.complete]z";

const CONFIG: &str = "[[package]]\nname = \"soar\"\ndialect = \"table\"\ninclude = [\"pages/*.md\"]\n\n[[output]]\n\
                      kind = \"docs\"\nout = \"docs\"\n";

#[track_caller]
fn assert_harmless(text: &str, is_github: bool) {
    let is_hidden = |character: char| {
        character.is_control() && character != '\n' || matches!(character, '\u{2028}'..='\u{202e}')
    };
    assert!(!text.contains(is_hidden) && !text.contains("##[") && !text.contains("##vso["), "{text:?}");
    let is_own = |line: &str| {
        is_github && ["::notice ", "::warning ", "::error "].iter().any(|own| line.starts_with(own))
    };
    let is_forged = |line: &&str| {
        !is_own(line) && ["::", "FORGED"].iter().any(|start| line.trim_start().starts_with(start))
    };
    assert_eq!(text.lines().find(is_forged), None, "{text}");
}

#[test]
fn definitions_and_arguments_are_harmless() {
    let folder = tempfile::tempdir().expect("a folder");
    write(&folder, "uavspec.toml", CONFIG);
    let page = format!(
        "# {HOSTILE}\n\n## Warnings (codes 64-127)\n\n| Code | Abbr | Description |\n|---|---|---|\n| 64 | ##[error] | \u{202e} ::error::x |\n| 64 | A | B |\n| x | ##vso[a] | C |\n"
    );
    write(&folder, &format!("pages/{}.md", HOSTILE.replace('/', "")), &page);
    write(&folder, "pages/##[error]codes.md", &page);
    let option = format!("--{HOSTILE}");
    for arguments in [
        &["codegen"][..],
        &["codegen", "--config", HOSTILE],
        &["codegen", "--package", HOSTILE],
        &["codegen", &option],
        &[HOSTILE],
        &["lint", "--rule", HOSTILE],
        &["lint"],
        &["lint", "--format", "json"],
        &["lint", "--format", "sarif"],
        &["lint", "--format", "junit"],
        &["lint", "--format", "github"],
        &["fmt", "--check"],
        &["inspect"],
        &["translate", HOSTILE],
        &["breaking", "--against", HOSTILE],
    ] {
        let output = xtask(&folder, arguments);
        for text in [output.stdout, output.stderr] {
            let text = String::from_utf8(text).expect("UTF-8");
            assert_harmless(&text, arguments.contains(&"github"));
        }
    }
}
