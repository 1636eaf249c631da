//! Tests with fake adapters, which require no installation.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::process::Command;
use std::time::Duration;

use tempfile::TempDir;

use super::adapter::{self, Answers, End};
use super::job::{Case, Form, Job, Jobs};
use super::known::Known;
use super::tally::{Count, Does, Record, Tally};
use super::tool::Tool;
use super::{CONTENTS, PAGE, RECORD, SOURCE, configuration, job, page};
use crate::paths::repository;

/// A time limit that no script reaches.
const LONG: Duration = Duration::from_secs(120);

const ANSWERS: &str = r#"
echo '{"version": "1.2.3"}'
echo '{"job": 0}'
echo '{"job": 0, "case": 0, "valid": true}'
echo '{"job": 0, "case": 1, "valid": true}'
echo '{"job": 0, "case": 2, "error": "too long"}'
echo '{"job": 1, "error": "no references"}'
"#;

fn case(id: &str, is_valid: bool) -> Case {
    Case { id: id.to_owned(), text: "{}".to_owned(), is_valid, beyond: None }
}

/// Two jobs: one with three cases, including an invalid one, and one with one case.
fn jobs() -> Vec<Job> {
    let job = |name: &str, cases| Job {
        form: Form::Files,
        name: format!("demo/{name}"),
        schema: format!("https://example.com/{name}.schema.json"),
        cases,
    };
    let cases = vec![case("calm", true), case("speed-above-range", false), case("storm", true)];
    vec![job("Wind", cases), job("Mark", vec![case("zero", true)])]
}

fn tool(kind: &str, more: &str) -> Tool {
    let text = format!(
        "name = \"fake\"\nkind = \"{kind}\"\nlanguage = \"sh\"\ndraft = \"7\"\nenvironment = \"node\"\nadapter = \
         \"fake.sh\"\nnote = \"\"\n{more}"
    );
    toml::from_str(&text).expect("a tool")
}

/// Runs a shell script as an adapter.
fn run(script: &str, limit: Duration) -> Answers {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut command = Command::new("sh");
    adapter::run(command.args(["-c", script]), &jobs(), &folder.path().join("log.txt"), limit)
}

fn tally(kind: &str, script: &str) -> Tally {
    Tally::of(&tool(kind, ""), &jobs(), &run(script, LONG))
}

fn total(tally: &Tally) -> Count {
    tally.record.counts[&Form::Files]["demo"]
}

#[test]
#[cfg(unix)]
fn compares_verdicts_with_expected_results() {
    let tally = tally("validator", ANSWERS);
    assert_eq!((tally.record.version.as_str(), tally.record.end), ("1.2.3", End::Finished));
    let count =
        Count { schemas: 1, schemas_failed: 1, agreed: 1, disagreed: 2, not_run: 1, refused: 0, taken: 0 };
    assert_eq!(total(&tally), count);
    let found: Vec<_> = tally.disagreements.iter().map(|found| (found.place.as_str(), found.does)).collect();
    let expected = [
        ("demo/Wind#speed-above-range", Does::Takes),
        ("demo/Wind#storm", Does::Fails),
        ("demo/Mark", Does::RefusesSchema),
    ];
    assert_eq!(found, expected);
}

#[test]
#[cfg(unix)]
fn ignores_invalid_instances_that_generated_code_accepts() {
    let tally = tally("generator", ANSWERS);
    let count =
        Count { schemas: 1, schemas_failed: 1, agreed: 1, disagreed: 1, not_run: 1, refused: 0, taken: 1 };
    assert_eq!(total(&tally), count);
    assert!(tally.disagreements.iter().all(|found| found.does != Does::Takes));
}

#[test]
#[cfg(unix)]
fn ignores_jobs_in_an_unsupported_form() {
    let tally = Tally::of(&tool("validator", "form = \"bundle\""), &jobs(), &run(ANSWERS, LONG));
    assert!(tally.record.counts.is_empty() && tally.disagreements.is_empty());
}

#[test]
#[cfg(unix)]
fn counts_answers_before_a_crash() {
    let script = "echo '{\"job\": 0}'; echo '{\"job\": 0, \"case\": 0, \"valid\": true}'; exit 3";
    let answers = run(script, LONG);
    assert!(answers.end == End::Crashed && answers.reason.contains('3'), "{answers:?}");
    let tally = tally("validator", script);
    assert_eq!((total(&tally).agreed, total(&tally).not_run), (1, 3));
    let silent = tally.disagreements.iter().filter(|found| found.does == Does::SaysNothing);
    let places: Vec<&str> = silent.map(|found| found.place.as_str()).collect();
    assert_eq!(places, ["demo/Wind#speed-above-range", "demo/Wind#storm", "demo/Mark"]);
}

#[test]
#[cfg(unix)]
fn stops_an_adapter_that_hangs() {
    for script in ["exec sleep 600", "exec >&-; exec sleep 600"] {
        let answers = run(script, Duration::from_millis(200));
        assert_eq!(answers.end, End::Hung, "{script}");
        assert!(answers.lines.is_empty(), "{answers:?}");
    }
}

#[test]
#[cfg(unix)]
fn stops_an_adapter_that_prints_invalid_lines() {
    let garbage = [
        ("echo hello", "line 1 column 1"),
        ("echo '{}'", "expected a version or a job"),
        ("echo '{\"job\": 2}'", "unknown job 2"),
        ("echo '{\"job\": 0, \"case\": 0, \"valid\": true}'", "a case of job 0 precedes its schema"),
        ("echo '{\"job\": 0}'; echo '{\"job\": 0}'", "duplicate job 0"),
        ("echo '{\"job\": 0}'; echo '{\"job\": 0, \"case\": 3, \"valid\": true}'", "unknown case 3 of job 0"),
        ("echo '{\"job\": 0}'; echo '{\"job\": 0, \"case\": 0}'", "case 0 of job 0 has no verdict"),
        ("cat /dev/zero", "line 1 column 1"),
    ];
    for (script, expected) in garbage {
        let answers = run(script, LONG);
        assert!(answers.end == End::Garbage && answers.reason.contains(expected), "{answers:?}");
    }
    let twice =
        "echo '{\"job\": 0}'; for i in 1 2; do echo '{\"job\": 0, \"case\": 0, \"valid\": false}'; done";
    let answers = run(twice, LONG);
    assert_eq!((answers.end, answers.reason.as_str()), (End::Garbage, "duplicate case of job 0"));
    assert_eq!(answers.lines[&(0, Some(0))].valid, Some(false), "earlier answers count");
}

#[test]
fn a_missing_program_is_a_crash() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut command = Command::new(folder.path().join("no-such-adapter"));
    let answers = adapter::run(&mut command, &jobs(), &folder.path().join("log.txt"), LONG);
    assert_eq!(answers.end, End::Crashed);
}

/// Classifies the disagreements of the tools `fake` and `other` with `entries`. Both tools have the same disagreements.
/// Returns the tallies, and the errors.
#[cfg(unix)]
fn classify(entries: &str) -> (BTreeMap<String, Tally>, Vec<String>) {
    let known: Known = toml::from_str(entries).expect("entries");
    let mut tallies =
        BTreeMap::from(["fake", "other"].map(|name| (name.to_owned(), tally("validator", ANSWERS))));
    let errors = known.classify(&mut tallies);
    (tallies, errors)
}

fn entry(id: &str, tools: &str, does: &str, places: &str) -> String {
    format!(
        "[[disagreement]]\nid = \"{id}\"\ntools = {tools}\ndoes = \"{does}\"\nplaces = {places}\nright = \
         \"schema\"\nsection = \"Core 4.2.1\"\nreason = \"So it is.\"\n"
    )
}

#[test]
#[cfg(unix)]
fn every_disagreement_must_be_explained() {
    let both = r#"["fake", "other"]"#;
    let takes = entry("speed", both, "takes", r#"["demo/*#speed-*"]"#);
    let fails = entry("length", both, "fails", r#"["demo/Wind#storm"]"#);
    let schema = entry("references", r#"["other"]"#, "refuses-schema", r#"["demo/Mark"]"#);
    let (tallies, errors) = classify(&[takes, fails, schema].concat());
    assert_eq!(errors, Vec::<String>::new());
    let left: Vec<usize> = tallies.values().map(|tally| tally.disagreements.len()).collect();
    assert_eq!(left, [1, 0]);
    assert_eq!(tallies["other"].record.explained["references"], 1);
}

#[test]
#[cfg(unix)]
fn an_unused_explanation_is_an_error() {
    let unused = entry("speed", r#"["fake"]"#, "refuses", r#"["demo/*#speed-*"]"#);
    assert_eq!(
        classify(&unused).1,
        ["`speed` matches no disagreement of fake", "`speed`: `demo/*#speed-*` matches no disagreement"]
    );
    let wide = entry("speed", r#"["fake"]"#, "takes", r#"["demo/*#speed-*", "demo/*#height-*"]"#);
    assert_eq!(classify(&wide).1, ["`speed`: `demo/*#height-*` matches no disagreement"]);
    // The first entry hides the second one.
    let second = entry("again", r#"["fake"]"#, "takes", r#"["demo/Wind#*"]"#);
    assert_eq!(classify(&[wide.replace(", \"demo/*#height-*\"", ""), second].concat()).1.len(), 2);
    let elsewhere = entry("speed", r#"["fake"]"#, "takes", r#"["demo/*"]"#)
        .replace("places", "form = \"bundle\"\nplaces");
    assert_eq!(classify(&elsewhere).1.len(), 2);
    // Entries of tools that didn't run are not checked.
    assert_eq!(classify(&unused.replace("\"fake\"", "\"absent\"")).1, Vec::<String>::new());
}

#[test]
fn all_errors_in_the_list_are_reported() {
    let parse = |entries: &[String]| Known::parse(&entries.concat(), &BTreeSet::from(["fake"]));
    let error =
        parse(&[entry("a", r#"["fake", "unknown"]"#, "takes", "[]"), entry("a", "[]", "takes", "[]")]);
    assert_eq!(error.expect_err("errors"), "`a`: unknown tool `unknown`; duplicate entry `a`");
    let error = parse(&[entry("a", "[]", "takes", r#"["{"]"#)]).expect_err("an error");
    assert!(error.contains("error parsing glob"), "{error}");
}

#[test]
fn rules_beyond_schemas_are_listed_exactly() {
    let known: Known = toml::from_str("[[beyond]]\nrule = \"G-2\"\nreason = \"\"\n").expect("a list");
    let rules = |rule: &str| BTreeMap::from([(rule.to_owned(), 1)]);
    assert_eq!(known.check_beyond(&rules("G-2")), Vec::<String>::new());
    assert_eq!(known.check_beyond(&rules("G-1")).len(), 2);
}

/// A folder with files as the generator writes them.
fn generated() -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |path: &str, text: &str| {
        let path = folder.path().join(path);
        fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
        fs::write(path, text).expect("a file");
    };
    write("schemas/demo/Wind.schema.json", r#"{"$id": "https://example.com/demo/Wind.schema.json"}"#);
    write(
        "schemas/demo.bundle.schema.json",
        r#"{"$id": "https://example.com/demo.bundle.schema.json", "$defs": {"Wind": {}}}"#,
    );
    write("vectors/vectors.schema.json", r#"{"$id": "https://example.com/vectors.schema.json"}"#);
    write(
        "vectors/demo/Wind.vectors.json",
        r#"{"type": "demo/Wind", "schema": "https://example.com/demo/Wind.schema.json", "cases": [
            {"id": "calm", "valid": true, "json": {"speed":1.0}, "uorb": "00"},
            {"id": "bytes", "valid": false, "rule": "G-1", "uorb": "00"},
            {"id": "odd", "valid": false, "rule": "G-2", "json": 18446744073709551616},
            {"id": "huge", "valid": false, "rule": "G-3", "json": 1e999}]}"#,
    );
    write(
        "vectors/json-schema-test-suite/tests/draft2020-12/demo/Wind.json",
        r#"[{"tests": [{"description": "calm: no wind", "valid": true}, {"description": "odd: more", "valid": true}]}]"#,
    );
    folder
}

#[test]
fn jobs_contain_the_cases_with_json_in_both_forms() {
    let folder = generated();
    let jobs = Jobs::read(folder.path()).expect("jobs");
    let schemas: Vec<&str> = jobs.list.iter().map(|job| job.schema.as_str()).collect();
    let expected = [
        "https://example.com/demo/Wind.schema.json",
        "https://example.com/demo.bundle.schema.json#/$defs/Wind",
    ];
    assert_eq!(schemas, expected);
    let cases: Vec<(&str, &str, bool)> =
        jobs.list[0].cases.iter().map(|case| (case.id.as_str(), case.text.as_str(), case.is_valid)).collect();
    // Numbers are preserved as written, even if this program can't represent them.
    let expected =
        [("calm", "{\"speed\":1.0}", true), ("odd", "18446744073709551616", true), ("huge", "1e999", false)];
    assert_eq!(cases, expected);
    assert_eq!(jobs.beyond_schemas(), BTreeMap::from([("G-2".to_owned(), 1)]));
    assert_eq!(jobs.text().lines().count(), 3 + 2);
    assert!(jobs.text().contains(r#""cases":["{\"speed\":1.0}","18446744073709551616","1e999"]"#));
}

#[test]
fn a_bundle_without_a_type_is_an_error() {
    let folder = generated();
    let bundle = folder.path().join("schemas/demo.bundle.schema.json");
    fs::write(bundle, r#"{"$id": "https://example.com/demo.bundle.schema.json", "$defs": {}}"#)
        .expect("a file");
    let error = Jobs::read(folder.path()).expect_err("an error");
    assert!(error.contains("doesn't define `Wind`"), "{error}");
}

#[test]
#[cfg(unix)]
fn the_page_shows_the_recorded_results() {
    let known: Known =
        toml::from_str(&entry("speed", r#"["fake", "other"]"#, "takes", r#"["demo/*#speed-*"]"#))
            .expect("an entry");
    let tools = [tool("validator", "")];
    let mut record = Record::default();
    assert!(page::text(&tools, &known, &record).contains("fake (not run), other (not run)"));
    let mut tallies = BTreeMap::from([("fake".to_owned(), tally("validator", ANSWERS))]);
    known.classify(&mut tallies);
    record.tools.extend(tallies.into_iter().map(|(name, tally)| (name, tally.record)));
    let page = page::text(&tools, &known, &record);
    for part in ["| fake 1.2.3 | sh | 7 | 1 of 4 (1 of 2 schemas) |", "fake (1), other (not run)"] {
        assert!(page.contains(part), "{page}");
    }
    let read: Record = serde_json::from_str(&record.text()).expect("a record");
    assert_eq!(read, record);
}

#[test]
fn the_documentation_page_matches_the_record() {
    let (tools, known) = configuration().expect("the tools and entries");
    let record: Record = job::parse(&repository().join(RECORD)).expect("a record");
    let expected = page::text(&tools, &known, &record);
    if std::env::var_os("UAVSPEC_UPDATE_FIXTURES").is_some() {
        fs::write(repository().join(PAGE), &expected).expect("a written page");
    }
    let read = |path: &str| fs::read_to_string(repository().join(path)).expect("a file");
    let advice = "run `cargo xtask interop`. If only texts changed: `UAVSPEC_UPDATE_FIXTURES=1 cargo test -p xtask interop`";
    assert!(read(PAGE) == expected, "{advice}");
    assert!(read(CONTENTS) == page::CONTENTS, "{advice}");
    assert!(tools.iter().all(|tool| record.tools.contains_key(&tool.name)), "{advice}");
}

#[test]
fn lock_files_contain_no_hosts() {
    let source = repository().join(SOURCE);
    for path in ["node/package-lock.json", "python/requirements.txt"] {
        let text = fs::read_to_string(source.join(path)).expect("a lock file");
        assert!(!text.contains("\"resolved\"") && !text.contains("index-url"), "{path}");
    }
}
