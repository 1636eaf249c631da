//! Runs the steps of the GitHub action.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use tempfile::TempDir;
use uavspec_test_support::write;

use super::expression::{Context, expanded, value};
use super::{MESSAGE, Project, capture, example, members, path_with_uavspec, repository, string, yaml};

/// The inputs of github/codeql-action/upload-sarif.
const UPLOAD_INPUTS: [&str; 8] =
    ["sarif_file", "checkout_path", "ref", "sha", "token", "matrix", "category", "wait-for-processing"];

/// A replacement for Cargo in the build step. It checks the current folder, and copies the program of this build.
const CARGO: &str = r#"#!/bin/sh
grep -q conformance Cargo.toml || exit 1
while [ $# -gt 0 ]; do
  case "$1" in
    --target-dir) mkdir -p "$2/release" && ln -s "$UAVSPEC" "$2/release/uavspec"; shift ;;
  esac
  shift
done
"#;

/// The result of a run.
#[derive(Debug, Default)]
struct Run {
    failed: bool,
    log: String,
    summary: String,
    /// The path that was uploaded, if there was an upload.
    uploaded: Option<PathBuf>,
    /// Keeps the reports.
    _temporary: Option<TempDir>,
}

impl Run {
    /// The SARIF reports, by name.
    fn reports(&self) -> BTreeMap<String, Value> {
        let entries = self.uploaded.iter().flat_map(|folder| fs::read_dir(folder).expect("the reports"));
        let report = |entry: fs::DirEntry| {
            let text = fs::read_to_string(entry.path()).expect("a report");
            (entry.file_name().into_string().expect("UTF-8"), serde_json::from_str(&text).expect("JSON"))
        };
        entries.map(|entry| report(entry.expect("an entry"))).collect()
    }
}

/// Runs the action with these inputs, in the same way as GitHub.
fn run(project: &Project, inputs: &[(&str, &str)]) -> Run {
    let folder = repository().join("conformance/ci/github");
    let action = yaml(&fs::read_to_string(folder.join("action.yml")).expect("the action"));
    assert_eq!(action["runs"]["using"], "composite");
    let mut context: Context = members(&action["inputs"])
        .map(|(name, input)| (format!("inputs.{name}"), string(&input["default"])))
        .collect();
    for (name, given) in inputs {
        let known = context.insert(format!("inputs.{name}"), (*given).to_owned());
        assert!(known.is_some(), "the action has no input `{name}`");
    }
    let temporary = tempfile::tempdir().expect("a folder");
    let cargo = temporary.path().join("bin/cargo");
    write(temporary.path(), "bin/cargo", CARGO);
    fs::set_permissions(cargo, fs::Permissions::from_mode(0o755)).expect("permissions");
    let mut run = Run::default();
    for step in action["runs"]["steps"].as_array().expect("steps") {
        let condition = step["if"].as_str().map(|condition| value(condition, &context));
        if run.failed || condition.is_some_and(|value| value != "true") {
            continue;
        }
        match step["run"].as_str() {
            Some(script) => {
                run_script(project, step, script, &mut context, &mut run, temporary.path(), &folder);
            }
            None => run.uploaded = Some(upload(step, &context)),
        }
    }
    run.summary = fs::read_to_string(temporary.path().join("summary")).unwrap_or_default();
    Run { _temporary: Some(temporary), ..run }
}

fn run_script(
    project: &Project,
    step: &Value,
    script: &str,
    context: &mut Context,
    run: &mut Run,
    temporary: &Path,
    action: &Path,
) {
    assert!(
        !script.contains("${{"),
        "GitHub would expand an expression before the shell quotes it: {script}"
    );
    assert_eq!(step["shell"], "bash");
    write(temporary, "script", script);
    write(temporary, "output", "");
    let output = Command::new("bash")
        .args(["--noprofile", "--norc", "-eo", "pipefail"])
        .arg(temporary.join("script"))
        .current_dir(project.path())
        .env("PATH", format!("{}:{}", temporary.join("bin").display(), path_with_uavspec()))
        .env("RUNNER_TEMP", temporary)
        .env("GITHUB_ACTION_PATH", action)
        .env("GITHUB_OUTPUT", temporary.join("output"))
        .env("GITHUB_STEP_SUMMARY", temporary.join("summary"))
        .env("UAVSPEC", env!("CARGO_BIN_EXE_uavspec"))
        .envs(members(&step["env"]).map(|(name, text)| (name, expanded(&string(text), context))))
        .output();
    let output = output.expect("bash runs");
    run.failed = !output.status.success();
    run.log += &String::from_utf8_lossy(&output.stdout);
    run.log += &String::from_utf8_lossy(&output.stderr);
    let Some(id) = step["id"].as_str() else { return };
    for line in fs::read_to_string(temporary.join("output")).expect("the output").lines() {
        let (name, value) = line.split_once('=').expect("an output");
        context.insert(format!("steps.{id}.outputs.{name}"), value.to_owned());
    }
}

/// Checks the upload step, and returns the path of the reports.
fn upload(step: &Value, context: &Context) -> PathBuf {
    let uses = step["uses"].as_str().expect("a script or an action");
    let revision = uses.strip_prefix("github/codeql-action/upload-sarif@").expect(uses);
    assert!(revision.len() == 40 && revision.bytes().all(|byte| byte.is_ascii_hexdigit()), "{uses}");
    for (name, _) in members(&step["with"]) {
        assert!(UPLOAD_INPUTS.contains(&name.as_str()), "the action has no input `{name}`");
    }
    PathBuf::from(expanded(&string(&step["with"]["sarif_file"]), context))
}

/// Checks a SARIF report, and returns the rule and the file of each result.
fn results(report: &Value, project: &Project) -> BTreeSet<(String, String)> {
    assert_eq!(report["version"], "2.1.0");
    let [run] = &report["runs"].as_array().expect("runs")[..] else { panic!("one run: {report}") };
    assert_eq!(run["tool"]["driver"]["name"], "uavspec");
    let result = |result: &Value| {
        let index = usize::try_from(result["ruleIndex"].as_u64().expect("an index")).expect("small");
        assert_eq!(run["tool"]["driver"]["rules"][index]["id"], result["ruleId"]);
        assert!(result["message"]["text"].as_str().is_some_and(|text| !text.is_empty()), "{result}");
        let uri = string(&result["locations"][0]["physicalLocation"]["artifactLocation"]["uri"]);
        let path = uri.replace("%20", " ");
        assert!(project.path().join(&path).exists(), "{path} is not relative to the repository");
        (string(&result["ruleId"]), path)
    };
    run["results"].as_array().expect("results").iter().map(result).collect()
}

/// The inputs that the guide's example passes to the action.
fn inputs_of_example(project: &Project) -> Vec<(String, String)> {
    let workflow = yaml(&example(".github/workflows/interfaces.yml"));
    assert_eq!(workflow["permissions"]["security-events"], "write", "the upload requires the permission");
    let steps = workflow["jobs"]["uavspec"]["steps"].as_array().expect("steps");
    let [checkout, step] = &steps[..] else { panic!("two steps: {workflow}") };
    assert_eq!(checkout["with"]["fetch-depth"], 0, "`breaking` requires the history");
    let uses = step["uses"].as_str().expect("an action");
    let folder = uses.strip_prefix("OWNER/uavspec/").and_then(|rest| rest.strip_suffix("@REVISION"));
    assert!(repository().join(folder.expect("a path")).join("action.yml").exists(), "{uses}");
    let context = Context::from([("github.event.pull_request.base.sha".to_owned(), project.base.clone())]);
    members(&step["with"]).map(|(name, text)| (name.clone(), expanded(&string(text), &context))).collect()
}

#[test]
fn the_example_uploads_all_findings_and_then_fails() {
    let project = Project::with_findings();
    let inputs = inputs_of_example(&project);
    let inputs: Vec<(&str, &str)> =
        inputs.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    let run = run(&project, &inputs);
    assert!(run.failed, "{}", run.log);
    let reports = run.reports();
    let names: Vec<&str> = reports.keys().map(String::as_str).collect();
    assert_eq!(names, ["breaking.sarif", "check.sarif", "lint.sarif"], "{}", run.log);
    let ids: BTreeSet<String> =
        reports.values().map(|report| report["runs"][0]["automationDetails"]["id"].to_string()).collect();
    assert_eq!(ids.len(), 3, "the analyses of one commit must not replace each other");
    for (report, rule, path) in [
        ("breaking.sarif", "field-type-changed", "msg/Wind.msg"),
        ("lint.sarif", "unit-missing", "msg/Gust.msg"),
        ("check.sarif", "incomplete", "logs/cut.ulg"),
        ("check.sarif", "PX-JSON-01", "logs/bad flight.jsonl"),
    ] {
        let found = results(&reports[report], &project);
        assert!(found.contains(&(rule.to_owned(), path.to_owned())), "{report}: {found:?}");
    }
    for command in ["lint", "breaking", "check"] {
        assert!(run.summary.contains(&format!("- `uavspec {command}`: exit status 1\n")), "{}", run.summary);
    }
    assert!(run.summary.contains("`logs/cut.ulg`"), "{}", run.summary);
    assert!(
        run.log.contains("::error title=uavspec::uavspec lint failed with status 1. uavspec"),
        "{}",
        run.log
    );
}

#[test]
fn a_run_without_findings_succeeds() {
    let project = Project::clean();
    let run = run(
        &project,
        &[("preset", "strict"), ("deny", "note"), ("against", "main"), ("captures", "\nlogs\n\n")],
    );
    assert!(!run.failed, "{}", run.log);
    let reports = run.reports();
    assert_eq!(reports.len(), 3);
    for report in reports.values() {
        assert!(results(report, &project).is_empty(), "{report}");
    }
}

#[test]
fn inputs_select_the_commands_and_their_options() {
    let project = Project::with_findings();
    let folder = project.path();
    let uavspec = |arguments: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_uavspec"))
            .args(arguments)
            .current_dir(folder)
            .output()
            .expect("it runs")
    };
    uavspec(&["lint", "--write-baseline", "known.toml"]);
    uavspec(&["breaking", "--against", &project.base, "--write-baseline", "known.toml"]);
    let run_with = |inputs: &[(&str, &str)]| run(&project, inputs);
    let known = run_with(&[("baseline", "known.toml"), ("against", &project.base), ("deny", "note")]);
    assert!(!known.failed && known.reports().len() == 2, "{}", known.log);
    write(folder, "logs/gust.jsonl", capture(&MESSAGE.replace("\"mode_id\": 1", "\"mode_id\": 300")));
    uavspec(&["check", "--write-baseline", "failures.toml", "logs/gust.jsonl"]);
    let gust = [("lint", "false"), ("captures", "logs/gust.jsonl"), ("check-baseline", "failures.toml")];
    assert!(run_with(&gust[..2]).failed);
    let known = run_with(&gust);
    assert!(!known.failed, "{}", known.log);
    let quiet = run_with(&[("lint", "false"), ("captures", "logs/flight.jsonl")]);
    assert!(!quiet.failed && quiet.reports().len() == 1, "{}", quiet.log);
    let printed = run_with(&[("upload", "false"), ("deny", "warning")]);
    assert!(printed.failed && printed.uploaded.is_none());
    assert!(printed.log.contains("::warning file=msg/Gust.msg,line=5"), "{}", printed.log);
    // The reports name files relative to the repository, even if the configuration is in a subfolder.
    fs::create_dir(folder.join("interfaces")).expect("a folder");
    for name in ["msg", "uavspec.toml"] {
        fs::rename(folder.join(name), folder.join("interfaces").join(name)).expect("moved");
    }
    let moved = run_with(&[("config", "interfaces/uavspec.toml"), ("deny", "warning")]);
    let found = results(&moved.reports()["lint.sarif"], &project);
    assert!(found.contains(&("unit-missing".to_owned(), "interfaces/msg/Gust.msg".to_owned())), "{found:?}");
}

#[test]
fn inputs_are_never_executed() {
    let project = Project::clean();
    for hostile in [
        "$(touch pwned)",
        "`touch pwned`",
        "'; touch pwned; '",
        "\"; touch pwned; \"",
        "x\ntouch pwned",
        "--help",
    ] {
        let inputs =
            ["config", "preset", "against", "baseline", "captures", "definitions", "check-baseline", "deny"];
        let run = run(&project, &inputs.map(|input| (input, hostile)));
        assert!(run.failed && !project.path().join("pwned").exists(), "{hostile}\n{}", run.log);
        for command in ["lint", "breaking", "check"] {
            assert!(
                run.summary.contains(&format!("`uavspec {command}`: exit status")),
                "{hostile}\n{}",
                run.log
            );
        }
    }
}

#[test]
fn a_missing_program_fails_without_an_upload() {
    let project = Project::clean();
    let run = run(&project, &[("program", "./absent/uavspec")]);
    assert!(run.failed && run.uploaded.is_none(), "{}", run.log);
}
