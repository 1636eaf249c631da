//! Tests of baselines, through the command line.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};
use tempfile::TempDir;
use uavspec_test_support::words;

const GLIDER: &str = "\
# State of a glider

uint64 timestamp  # [us] Time since system start
float32 speed     # [m/s] [@range 0, 60] [@invalid -1] Speed
uint8 mark        # [-] Which mark it flies to
";

/// 9 May 2026, in seconds since 1970.
const TODAY: &str = "1778284800";

/// A folder with definitions and two message files. One file conforms, and the other one has two violations.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join("msg")).expect("a folder");
    fs::create_dir(folder.path().join("logs")).expect("a folder");
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("a file");
    write("msg/Glider.msg", GLIDER);
    let good = "{\"timestamp\":1,\"speed\":7,\"mark\":3}\n";
    write("logs/good.jsonl", good);
    write(
        "logs/odd.jsonl",
        "{\"timestamp\":1,\"speed\":70,\"mark\":3}\n{\"timestamp\":2,\"speed\":2,\"mark\":300}\n",
    );
    folder
}

/// Runs uavspec. Returns the exit status, standard output and standard error.
fn uavspec(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_uavspec"));
    command.args(arguments).current_dir(folder).env("SOURCE_DATE_EPOCH", TODAY);
    let output = command.output().expect("uavspec runs");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code(), text(output.stdout), text(output.stderr))
}

/// Runs `check` with a list.
fn check(folder: &TempDir, list: &str, arguments: &[&str]) -> (Option<i32>, String, String) {
    fs::write(folder.path().join("known.toml"), list).expect("a file");
    let always = ["check", "--definitions", "msg", "--type", "px4/Glider", "--baseline", "known.toml"];
    uavspec(folder.path(), &[&always, arguments].concat())
}

fn list_of(folder: &TempDir) -> String {
    fs::read_to_string(folder.path().join("known.toml")).expect("a list")
}

const MARKS: &str = "\
# Known failures of our gliders.

[[known]]
rule = \"PX-JSON-02\" # MUST
subject = \"Glider.mark\"
reason = \"marks are counted beyond 255\"
link = \"https://example.org/issues/7\"
expires = 2026-05-09
";

#[test]
fn shows_a_known_finding_without_counting_it() {
    let folder = folder();
    let (status, printed, output) = check(&folder, MARKS, &["logs"]);
    assert_eq!(status, Some(0), "{printed}{output}");
    for wanted in [
        "known   PX-JSON-02   MUST   Glider.mark: expected an integer from 0 to 255, found 300\n",
        "  marks are counted beyond 255 (until 2026-05-09) https://example.org/issues/7\n",
        "warning PX-RANGE-01  SHOULD Glider.speed: 70 is outside the range 0 to 60\n",
    ] {
        assert!(words(&printed).contains(&words(wanted)), "{wanted}: {printed}");
    }
    assert!(printed.contains("\nconforms, with 1 warning and 1 known failure\n"), "{printed}");
    assert_eq!(output, "");

    let (status, printed, _) = check(&folder, MARKS, &["--format", "json", "logs/odd.jsonl"]);
    let report: Value = serde_json::from_str(&printed).expect("JSON");
    let source = &report["subjects"][0];
    let excuse = json!({
        "kind": "known",
        "reason": "marks are counted beyond 255",
        "link": "https://example.org/issues/7",
        "expires": "2026-05-09",
    });
    assert_eq!((status, &source["findings"][0]["known"]), (Some(0), &excuse));
    assert_eq!(source["findings"][1]["known"], Value::Null);
    let verdict = |id: &str| {
        let rules = source["rules"].as_array().expect("a list");
        rules.iter().find(|rule| rule["id"] == id).map(|rule| rule["verdict"].clone())
    };
    assert_eq!(
        (verdict("PX-JSON-02"), verdict("PX-RANGE-01")),
        (Some("known".into()), Some("warning".into()))
    );

    // Findings that aren't in the list are still violations, even in other files.
    let elsewhere = MARKS.replace("reason", "file = \"old/*\"\nreason");
    let (status, printed, output) = check(&folder, &elsewhere, &["logs"]);
    assert_eq!(status, Some(1), "{printed}");
    assert!(output.contains("error[baseline-unmatched]") && output.contains("known.toml:5:11"), "{output}");
}

#[test]
fn fails_if_the_list_is_out_of_date() {
    let folder = folder();
    let (status, printed, output) = check(&folder, MARKS, &["logs/good.jsonl"]);
    assert_eq!(status, Some(4), "{printed}{output}");
    assert_eq!(
        output,
        "\
error[baseline-passes]: this subject of `PX-JSON-02` matches only passing results
 --> known.toml:5:11
  |
5 | subject = \"Glider.mark\"
  |           ^^^^^^^^^^^^^ remove the entry
error: a baseline is out of date
  help: run again with --fix-baseline to update it
"
    );
    assert_eq!(list_of(&folder), MARKS, "the list changes only with --fix-baseline");
    // A flaky rule may pass.
    assert_eq!(check(&folder, &MARKS.replace("[[known]]", "[[flaky]]"), &["logs/good.jsonl"]).0, Some(0));
    let (status, _, output) = check(&folder, &MARKS.replace("05-09", "05-08"), &["logs"]);
    assert_eq!(status, Some(4));
    assert!(output.contains("error[baseline-expired]: the entry expired on 2026-05-08"), "{output}");
    // An unreadable file takes precedence, because it might contain the listed findings.
    let (status, _, output) = check(&folder, MARKS, &["logs/good.jsonl", "logs/absent.jsonl"]);
    assert_eq!(status, Some(3));
    assert!(!output.contains("known"), "{output}");
    // A different violation of the same rule isn't a known failure.
    let (status, printed, output) = check(&folder, &(MARKS.to_owned() + "message = \"null\"\n"), &["logs"]);
    assert_eq!(status, Some(1));
    assert!(printed.contains("fail    PX-JSON-02"), "{printed}");
    assert!(output.contains("error[baseline-fails-otherwise]"), "{output}");
}

#[test]
fn fixes_a_list_and_checks_by_the_remaining_entries() {
    let folder = folder();
    let speed = "\n# apart\n\n[[known]]\nrule = \"PX-RANGE-01\"\nreason = \"a gauge\"   # of brass\nmessage = \"7\" # so\n";
    let gone = "\n# old\n[[known]]\nrule = \"PX-NAN-01\"\nsubject = \"Glider.mark\"\nreason = \"none\"\n";
    let list = MARKS.to_owned() + "message = \"null\"\n" + gone + speed;
    let (status, printed, output) = check(&folder, &list, &["--fix-baseline", "logs"]);
    assert_eq!(status, Some(0), "{printed}{output}");
    assert!(output.contains("note[baseline-fails-otherwise]") && output.contains("fixed: "), "{output}");
    assert!(printed.contains("\nconforms, with 2 known failures\n"), "{printed}");
    let fixed = "message = \"expected an integer from 0 to 255, found 300\"\n";
    assert_eq!(list_of(&folder), MARKS.to_owned() + fixed + speed);
    let again = list_of(&folder);
    let (status, _, output) = check(&folder, &again, &["--fix-baseline", "logs"]);
    assert_eq!((status, output.as_str(), list_of(&folder)), (Some(0), "", again));
    // An expired entry no longer excuses findings.
    let (status, printed, _) = check(&folder, &MARKS.replace("05-09", "05-08"), &["--fix-baseline", "logs"]);
    assert!(status == Some(1) && printed.contains("fail    PX-JSON-02"), "{printed}");
    assert_eq!(list_of(&folder), "# Known failures of our gliders.\n");
}

#[test]
fn reports_a_new_message_after_many_known_ones() {
    let folder = folder();
    let marks = |marks: &[u32]| -> String {
        marks.iter().map(|mark| format!("{{\"timestamp\":1,\"speed\":7,\"mark\":{mark}}}\n")).collect()
    };
    let list = MARKS.to_owned() + "message = \"expected an integer from 0 to 255, found 30\"\n";
    let write = |text: String| fs::write(folder.path().join("logs/odd.jsonl"), text).expect("a file");
    write(marks(&[300, 300, 300, 305, 300]));
    assert_eq!(check(&folder, &list, &["logs"]).0, Some(0));
    write(marks(&[300, 300, 300, 300, 7000, 300]));
    let (status, printed, output) = check(&folder, &list, &["logs"]);
    assert_eq!(status, Some(1), "{printed}{output}");
    assert!(printed.contains("fail    PX-JSON-02"), "{printed}");
    assert!(output.contains("baseline-fails-otherwise") && output.contains("found 7000"), "{output}");
}

#[test]
fn does_not_fix_messages_without_a_common_prefix() {
    let folder = folder();
    let speeds = [70, -7].map(|speed| format!("{{\"timestamp\":1,\"speed\":{speed},\"mark\":3}}\n"));
    fs::write(folder.path().join("logs/odd.jsonl"), speeds.concat()).expect("a file");
    let entry = "[[known]]\nrule = \"PX-RANGE-01\"\nreason = \"a gauge\"\nmessage = \"70\"\n";
    let gone = "\n[[known]]\nrule = \"PX-NAN-01\"\nreason = \"none\"\n";
    let (status, printed, output) = check(&folder, &(entry.to_owned() + gone), &["--fix-baseline", "logs"]);
    assert_eq!(status, Some(4), "{printed}{output}");
    assert!(
        output.contains("error[baseline-fails-otherwise]") && output.contains("write one entry for each"),
        "{output}"
    );
    assert!(printed.contains("warning PX-RANGE-01"), "{printed}");
    assert_eq!(list_of(&folder), entry, "the other entry is fixed");
}

#[test]
fn fails_if_the_list_cannot_be_fixed() {
    let folder = folder();
    fs::write(folder.path().join("known.toml"), MARKS).expect("a file");
    let path = folder.path().join("known.toml");
    let mut permissions = fs::metadata(&path).expect("a file").permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&path, permissions).expect("permissions can be set");
    let check = |file: &str| {
        let always = ["check", "--definitions", "msg", "--type", "px4/Glider", "--baseline", "known.toml"];
        uavspec(folder.path(), &[&always[..], &["--fix-baseline", "--format", "json", file]].concat())
    };
    let (status, printed, output) = check("logs/good.jsonl");
    assert_eq!(status, Some(2), "{printed}{output}");
    assert!(output.contains("known.toml") && list_of(&folder) == MARKS, "{output}");
    let report: Value = serde_json::from_str(&printed).expect("JSON");
    assert_eq!(report["outcome"]["kind"], "out of date");
    assert_eq!(check("logs/odd.jsonl").0, Some(0), "nothing to fix");

    write_responses(&folder, &json!("CDR"));
    let list = "[[known]]\ncase = \"decode-uorb/*\"\nreason = \"it was planned\"\n";
    fs::remove_file(&path).expect("a file");
    fs::write(&path, list).expect("a file");
    let mut permissions = fs::metadata(&path).expect("a file").permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&path, permissions).expect("permissions can be set");
    let always = ["test", "--definitions", "msg", "--replay", "answers", "--baseline", "known.toml"];
    assert_eq!(uavspec(folder.path(), &[&always[..], &["--fix-baseline"]].concat()).0, Some(2));
}

#[test]
fn keeps_entries_that_an_unreadable_part_may_match() {
    let folder = folder();
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::none());
    let text = fs::read(folder.path().join("logs/good.jsonl")).expect("a file").repeat(100);
    std::io::Write::write_all(&mut gzip, &text).expect("memory");
    let packed = gzip.finish().expect("memory");
    fs::write(folder.path().join("cut.jsonl.gz"), &packed[..packed.len() / 2]).expect("a file");
    let (status, printed, output) = check(&folder, MARKS, &["cut.jsonl.gz"]);
    assert_eq!(status, Some(6), "{printed}{output}");
    assert!(!output.contains("baseline-passes"), "{output}");
}

#[test]
fn writes_a_list_and_updates_it() {
    let folder = folder();
    let run = |arguments: &[&str]| {
        let always = ["check", "--definitions", "msg", "--type", "px4/Glider", "logs/odd.jsonl"];
        uavspec(folder.path(), &[&always, arguments].concat())
    };
    let (status, printed, errors) = run(&["--write-baseline", "known.toml"]);
    assert_eq!(status, Some(0), "{printed}{errors}");
    assert!(errors.contains("known.toml: 2 new entries; state the reason"), "{errors}");
    assert!(printed.contains("\nconforms, with 2 known failures\n"), "{printed}");
    let list = list_of(&folder);
    assert!(list.contains("rule = \"PX-JSON-02\"\nsubject = \"Glider.mark\"\nreason ="), "{list}");
    assert_eq!(run(&["--baseline", "known.toml"]).0, Some(0));
    // Without new findings, the list is unchanged.
    assert_eq!(run(&["--write-baseline", "known.toml"]).0, Some(0));
    assert_eq!(list_of(&folder), list);
    // Comments and reasons are kept. An expired entry is written again, like a new one.
    let expired = "\n[[known]]\nrule = \"PX-RANGE-01\"\nreason = \"a gauge\"\nexpires = 2020-01-01\n";
    fs::write(folder.path().join("known.toml"), MARKS.to_owned() + expired).expect("a file");
    let (status, _, errors) = run(&["--write-baseline", "known.toml"]);
    assert_eq!(status, Some(0), "{errors}");
    assert!(errors.contains("note[baseline-expired]") && errors.contains("1 new entry"), "{errors}");
    let added =
        "\n[[known]]\nrule = \"PX-RANGE-01\"\nsubject = \"Glider.speed\"\nreason = \"not assessed yet\"\n";
    assert_eq!(list_of(&folder), MARKS.to_owned() + added);
    // Findings that are in another list aren't written.
    let (status, _, errors) = run(&["--baseline", "known.toml", "--write-baseline", "new.toml"]);
    assert!(status == Some(0) && errors.contains("new.toml: 0 new entries"), "{errors}");
}

#[test]
fn writes_the_failing_cases() {
    let folder = folder();
    write_responses(&folder, &json!("CDR"));
    let (status, printed, _) = test(&folder, "", &["--write-baseline", "cases.toml"]);
    assert!(status == Some(0) && printed.contains(" passed, 0 failed, "), "{printed}");
    let list = fs::read_to_string(folder.path().join("cases.toml")).expect("a list");
    assert!(list.contains("\n[[known]]\ncase = \"decode-cdr/px4/Glider/zero\"\nreason = "), "{list}");
    assert_eq!(test(&folder, &list, &[]).0, Some(0));
}

#[test]
fn one_list_serves_all_commands() {
    let folder = folder();
    let lint = "[[known]]\nrule = \"unit-missing\"\nsubject = \"px4/*\"\nreason = \"old\"\n\n";
    assert_eq!(check(&folder, &(lint.to_owned() + MARKS), &["logs"]).0, Some(0));
    let lint = |level: &str| {
        let package = ["--package", "px4", "--dialect", "px4", "--input", "msg"];
        uavspec(
            folder.path(),
            &[&["lint", "--baseline", "known.toml", "--deny", level][..], &package].concat(),
        )
    };
    let (status, _, output) = lint("error");
    assert_eq!(status, Some(4), "{output}");
    assert!(output.contains("known.toml:3:11") && !output.contains("PX-JSON-02"), "{output}");
}

#[test]
fn rejects_invalid_lists() {
    let folder = folder();
    let (status, printed, output) = check(&folder, "[[known]]\nrule = \"PX-NONE-01\"\n", &["logs"]);
    assert_eq!((status, printed.as_str()), (Some(2), ""));
    assert!(output.contains("unknown rule `PX-NONE-01`") && output.contains("no `reason`"), "{output}");
    let check = |arguments: &[&str]| uavspec(folder.path(), &[&["check", "logs"], arguments].concat());
    let (status, _, output) = check(&["--baseline", "absent.toml"]);
    assert_eq!(status, Some(2));
    assert!(output.contains("error: absent.toml: "), "{output}");
    fs::write(folder.path().join("long.toml"), "#".repeat((4 << 20) + 1)).expect("a file");
    let (status, _, output) = check(&["--baseline", "long.toml"]);
    assert!(status == Some(2) && output.contains("the limit is 4194304 bytes"), "{output}");
    assert_eq!(check(&["--fix-baseline"]).0, Some(2), "nothing to fix");
    let mut command = Command::new(env!("CARGO_BIN_EXE_uavspec"));
    command.args(["check", "logs"]).current_dir(folder.path()).env("SOURCE_DATE_EPOCH", "soon");
    assert_eq!(command.output().expect("uavspec runs").status.code(), Some(2));
    for command in ["check", "test"] {
        let (status, printed, _) = uavspec(folder.path(), &[command, "--help"]);
        assert!(
            status == Some(0) && printed.contains("[[known]]") && printed.contains("--fix-baseline"),
            "{printed}"
        );
    }
}

/// Writes correct responses, except that `wrong` is the response to cases that decode CDR.
fn write_responses(folder: &TempDir, wrong: &Value) {
    let (status, requests, output) =
        uavspec(folder.path(), &["test", "--definitions", "msg", "--dump-cases", "-"]);
    assert_eq!(status, Some(0), "{output}");
    let mut answers = String::new();
    for request in requests.lines().map(|line| serde_json::from_str::<Value>(line).expect("JSON")) {
        let expected = &request["expected"];
        let (key, value) = match (&expected["ok"], &expected["rejected"]) {
            _ if (&request["op"], &request["format"]) == (&"decode".into(), &"cdr".into()) => ("ok", wrong),
            (_, Value::Bool(true)) => ("rejected", &Value::Null),
            (Value::Array(right), _) => ("ok", &right[0]),
            _ => ("ok", &Value::Null),
        };
        answers += &json!({ "id": request["id"], key: value }).to_string();
        answers.push('\n');
    }
    fs::write(folder.path().join("answers"), answers).expect("a file");
}

/// Runs `test` with responses and a list.
fn test(folder: &TempDir, list: &str, arguments: &[&str]) -> (Option<i32>, String, String) {
    fs::write(folder.path().join("known.toml"), list).expect("a file");
    let always = ["test", "--definitions", "msg", "--replay", "answers", "--baseline", "known.toml"];
    uavspec(folder.path(), &[&always, arguments].concat())
}

#[test]
fn counts_known_cases_separately() {
    let folder = folder();
    write_responses(&folder, &json!("CDR"));
    let list = "[[known]]\ncase = \"decode-cdr/*\"\nreason = \"CDR isn't supported yet\"\n";
    let (status, printed, output) = test(&folder, "", &[]);
    assert!(status == Some(1) && printed.contains("fail decode-cdr/px4/Glider/zero:"), "{printed}{output}");
    let (status, printed, output) = test(&folder, list, &[]);
    assert_eq!((status, output.as_str()), (Some(0), ""), "{printed}");
    assert!(printed.contains("known decode-cdr/px4/Glider/zero: CDR isn't supported yet\n"), "{printed}");
    assert!(printed.contains(" passed, 0 failed, ") && printed.contains(" known, "), "{printed}");
    assert!(printed.ends_with("conforms\n"), "{printed}");

    let (_, printed, _) = test(&folder, list, &["--format", "json"]);
    let report: Value = serde_json::from_str(&printed).expect("JSON");
    let report = &report["subjects"][0];
    assert_eq!(report["counts"]["fail"], 0);
    let cases = report["cases"].as_array().expect("a list");
    let known: Vec<&Value> = cases.iter().filter(|case| case["known"].is_object()).collect();
    assert_eq!(report["counts"]["known"], known.len());
    assert_eq!(
        (&known[0]["verdict"], &known[0]["known"]["reason"]),
        (&"fail".into(), &"CDR isn't supported yet".into())
    );

    // If a pattern also matches cases that pass, the fix restricts it to the cases that fail.
    let all = list.replace("decode-cdr/*", "decode-*/zero");
    let zeros = ["--filter", "decode-*/zero"];
    let (status, _, output) = test(&folder, &all, &zeros);
    assert_eq!(status, Some(4));
    assert!(
        output.contains("1 of 2 matching cases pass; the first is decode-uorb/px4/Glider/zero"),
        "{output}"
    );
    assert_eq!(test(&folder, &all, &[&zeros[..], &["--fix-baseline"]].concat()).0, Some(0));
    assert_eq!(list_of(&folder), list.replace("decode-cdr/*", "decode-cdr/px4/Glider/zero"));

    // Cases with known failures still count as checked. Entries for cases that weren't run stay unchanged.
    let (status, printed, output) = test(&folder, list, &["--filter", "decode-cdr/px4/Glider/zero"]);
    assert_eq!((status, output.as_str()), (Some(0), ""), "{printed}");
    let (status, _, output) = test(&folder, list, &["--filter", "decode-uorb/*"]);
    assert_eq!((status, output.as_str()), (Some(0), ""));
}

#[test]
fn reports_stale_entries_for_cases() {
    let folder = folder();
    write_responses(&folder, &json!("CDR"));
    let list = "\
[[known]]
case = \"decode-cdr/px4/Glider/*\"
reason = \"CDR isn't supported yet\"
message = \"expected\"

[[known]]
case = \"decode-uorb/px4/Glider/*\"
reason = \"it was planned\"

[[flaky]]
case = \"decode-cdr/px4/Plane/*\"
reason = \"we have no other planes\"

[[known]]
rule = \"PX-JSON-02\"
reason = \"irrelevant here\"
";
    let (status, printed, output) = test(&folder, list, &[]);
    assert_eq!(status, Some(4), "{printed}{output}");
    let codes: Vec<&str> =
        output.lines().filter(|line| line.starts_with("error[") || line.contains("-->")).collect();
    let expected = [
        "error[baseline-passes]: this case matches only passing results",
        " --> known.toml:7:8",
        "error[baseline-unmatched]: nothing in this run matches this case",
        "  --> known.toml:11:8",
    ];
    assert_eq!(codes, expected, "{output}");
    let (status, _, output) = test(&folder, &list.replace("\"expected\"", "\"crashed\""), &[]);
    assert!(status == Some(1) && output.contains("baseline-fails-otherwise"), "{output}");

    let (status, _, output) = test(&folder, list, &["--fix-baseline"]);
    assert_eq!(status, Some(0), "{output}");
    let (start, end) = (list.split("\n\n").next(), list.split("\n\n").last());
    assert_eq!(Some(list_of(&folder)), start.zip(end).map(|(start, end)| format!("{start}\n\n{end}")));
}
