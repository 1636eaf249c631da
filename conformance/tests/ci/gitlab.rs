//! Runs the jobs for GitLab.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::process::Command;

use quick_junit::Report as Junit;
use serde_json::Value;
use uavspec_test_support::write;

use super::{MESSAGE, Project, capture, example, members, path_with_uavspec, repository, string, yaml};

/// The variable that only merge request pipelines have.
const MERGE_REQUEST: &str = "CI_MERGE_REQUEST_DIFF_BASE_SHA";

/// The result of a job.
struct Job {
    is_success: bool,
    log: String,
    issues: Vec<Value>,
    junit: Junit,
}

/// The configuration of the example, combined with the file that it includes. Variables in the including file take
/// precedence.
fn pipeline() -> (Value, BTreeMap<String, String>) {
    let own = yaml(&example(".gitlab-ci.yml"));
    assert_eq!(own["include"][0]["local"], "ci/uavspec.yml");
    let template = fs::read_to_string(repository().join("conformance/ci/gitlab/uavspec.yml"));
    let template = yaml(&template.expect("the template"));
    let variables = members(&template["variables"]).chain(members(&own["variables"]));
    for (name, _) in members(&own["variables"]) {
        assert!(template["variables"].get(name).is_some(), "the template has no variable {name}");
    }
    let variables = variables.map(|(name, value)| (name.clone(), string(value))).collect();
    (template, variables)
}

/// Runs the jobs of a merge request pipeline, or of a branch pipeline if `changes` clears [`MERGE_REQUEST`].
fn run(project: &Project, changes: &[(&str, &str)]) -> BTreeMap<String, Job> {
    let (template, mut variables) = pipeline();
    variables.insert(MERGE_REQUEST.to_owned(), project.base.clone());
    variables.extend(changes.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())));
    let is_set = |name: &str| variables.get(name).is_some_and(|value| !value.is_empty());
    let matches = |rule: &Value| {
        let condition = rule.get("if").map(|condition| condition.as_str().expect("a condition"));
        condition.is_none_or(|condition| is_set(condition.strip_prefix('$').expect("a variable")))
    };
    let applies = |job: &Value| {
        let rules = job["rules"].as_array();
        // GitLab adds jobs that have no rules only to pipelines for branches and tags.
        rules.map_or(!is_set(MERGE_REQUEST), |rules| rules.iter().any(matches))
    };
    let jobs = members(&template).filter(|(_, job)| job.get("script").is_some() && applies(job));
    jobs.map(|(name, job)| (name.clone(), run_job(project, job, &variables))).collect()
}

fn run_job(project: &Project, job: &Value, variables: &BTreeMap<String, String>) -> Job {
    let lines: Vec<String> = job["script"].as_array().expect("a script").iter().map(string).collect();
    let output = Command::new("sh")
        .args(["-e", "-c", &lines.join("\n")])
        .current_dir(project.path())
        .env("PATH", path_with_uavspec())
        .envs(variables)
        .envs(members(&job["variables"]).map(|(name, value)| (name, string(value))))
        .output()
        .expect("sh runs");
    let log = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert_eq!(job["artifacts"]["when"], "always", "a job with findings must keep its reports");
    let report = |kind: &str| {
        let path = project.path().join(string(&job["artifacts"]["reports"][kind]));
        let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{kind}: {error}\n{log}"));
        fs::remove_file(path).expect("the report");
        text
    };
    let issues: Vec<Value> = serde_json::from_str(&report("codequality")).expect("a JSON list");
    check_issues(&issues, project);
    let junit = Junit::deserialize_from_str(&report("junit")).expect("JUnit");
    Job { is_success: output.status.success(), log, issues, junit }
}

/// Checks the members that GitLab requires in each issue.
fn check_issues(issues: &[Value], project: &Project) {
    let mut fingerprints = BTreeSet::new();
    for issue in issues {
        for member in ["description", "check_name", "fingerprint"] {
            assert!(issue[member].as_str().is_some_and(|text| !text.is_empty()), "{issue}");
        }
        let severity = issue["severity"].as_str().expect("a severity");
        assert!(["info", "minor", "major", "critical", "blocker"].contains(&severity), "{issue}");
        let path = issue["location"]["path"].as_str().expect("a path");
        assert!(project.path().join(path).is_file(), "{issue}");
        assert!(issue["location"]["lines"]["begin"].as_u64() > Some(0), "{issue}");
        assert!(fingerprints.insert(issue["fingerprint"].as_str()), "{issue}");
    }
}

#[test]
fn the_example_reports_all_findings() {
    let project = Project::with_findings();
    let jobs = run(&project, &[]);
    for (name, rule, path, class) in [
        ("uavspec-lint", "unit-missing", "msg/Gust.msg", "lint.unit-missing"),
        ("uavspec-breaking", "field-type-changed", "msg/Wind.msg", "breaking.field-type-changed"),
        ("uavspec-check", "PX-JSON-01", "logs/bad flight.jsonl", "logs/bad flight.jsonl"),
        ("uavspec-check", "incomplete", "logs/cut.ulg", "logs/cut.ulg"),
    ] {
        let Job { is_success, log, issues, junit } = &jobs[name];
        assert!(!is_success, "{log}");
        let issue =
            issues.iter().find(|issue| issue["check_name"] == rule && issue["location"]["path"] == path);
        assert!(issue.is_some(), "{name}: {issues:?}");
        let mut failures = junit
            .test_suites
            .iter()
            .flat_map(|suite| &suite.test_cases)
            .filter(|case| matches!(case.status, quick_junit::TestCaseStatus::NonSuccess { .. }));
        assert!(failures.any(|case| case.classname.as_deref() == Some(class)), "{name}: {junit:?}");
    }
}

#[test]
fn jobs_without_findings_succeed() {
    let project = Project::clean();
    let jobs = run(&project, &[]);
    assert_eq!(jobs.len(), 3);
    for (name, Job { is_success, log, issues, junit }) in jobs {
        assert!(is_success, "{name}: {log}");
        assert_eq!(issues, Vec::<Value>::new(), "{name}");
        assert!(junit.test_suites.iter().any(|suite| !suite.test_cases.is_empty()), "{name}: {junit:?}");
    }
}

#[test]
fn variables_change_the_commands() {
    let project = Project::with_findings();
    let uavspec = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_uavspec"));
        command.args(arguments).current_dir(project.path()).output().expect("it runs").status.code()
    };
    assert_eq!(uavspec(&["lint", "--write-baseline", "known findings.toml"]), Some(0));
    let variables = [
        ("UAVSPEC_CAPTURES", ""),
        ("UAVSPEC_PRESET", ""),
        ("UAVSPEC_BASELINE", "known findings.toml"),
        ("UAVSPEC_CONFIG", "uavspec.toml"),
        (MERGE_REQUEST, ""),
    ];
    let jobs = run(&project, &variables);
    let names: Vec<&str> = jobs.keys().map(String::as_str).collect();
    assert_eq!(names, ["uavspec-lint"]);
    assert!(jobs["uavspec-lint"].is_success, "{}", jobs["uavspec-lint"].log);

    let message = MESSAGE.replace("\"mode_id\": 1", "\"mode_id\": 300");
    write(project.path(), "logs/gust.jsonl", capture(&message));
    assert_eq!(uavspec(&["check", "--write-baseline", "known failures.toml", "logs/gust.jsonl"]), Some(0));
    for (baseline, is_success) in [("", false), ("known failures.toml", true)] {
        let variables = [("UAVSPEC_CAPTURES", "logs/gust.jsonl"), ("UAVSPEC_CHECK_BASELINE", baseline)];
        let job = &run(&project, &variables)["uavspec-check"];
        assert_eq!(job.is_success, is_success, "{}", job.log);
    }
}
