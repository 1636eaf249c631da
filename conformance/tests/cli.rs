//! Tests of the command line of `uavspec`.

use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::process::Command;

use flate2::Compression;
use flate2::write::GzEncoder;
use ruzstd::encoding::{CompressionLevel, compress_to_vec};
use serde_json::Value;
use uavspec_test_support::{padded, words, write_typical_definitions};

/// Runs `uavspec`, and returns its exit status, standard output and standard error.
fn uavspec(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let run = Command::new(env!("CARGO_BIN_EXE_uavspec")).args(arguments).current_dir(folder).output();
    let output = run.expect("uavspec runs");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code(), text(output.stdout), text(output.stderr))
}

/// Runs `uavspec check` with definitions for the topics in typical logs.
fn check(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    write_typical_definitions(folder);
    uavspec(folder, &[&["check", "--definitions", "msg"], arguments].concat())
}

#[test]
fn the_exit_status_is_the_outcome_for_a_log() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("flight.ulg"), padded(20)).expect("a file");
    let (status, printed, _) = check(folder.path(), &["flight.ulg"]);
    assert_eq!(status, Some(0), "{printed}");
    assert!(printed.starts_with("flight.ulg  PX4, 0 s, 20 topics, 400 records"), "{printed}");
    let start = "\n\noutcome      conforms\n\
                 checked      20 of 20 topics (100 %), 400 of 400 records, 1,200 of 1,200 values\n";
    assert!(printed.contains(start), "{printed}");

    let mut odd = padded(20);
    odd.truncate(odd.len() - 3);
    fs::write(folder.path().join("cut.ulg"), odd).expect("a file");
    let (status, printed, _) = check(folder.path(), &["cut.ulg"]);
    assert_eq!(status, Some(6), "{printed}");
    assert!(
        printed.contains("corrupt      byte")
            && printed.contains("\noutcome      incomplete: the log is truncated\n"),
        "{printed}"
    );

    fs::write(folder.path().join("empty.ulg"), "").expect("a file");
    let (status, printed, _) = check(folder.path(), &["empty.ulg"]);
    assert_eq!(status, Some(6), "{printed}");
    assert!(printed.contains("\noutcome      incomplete: the file is empty\n"), "{printed}");
    let (status, _, output) = check(folder.path(), &["absent.ulg", "flight.ulg"]);
    assert_eq!(status, Some(3));
    assert!(output.contains("error: absent.ulg"), "{output}");
    let (status, _, output) = uavspec(folder.path(), &["check", "flight.ulg", "--definitions", "nowhere"]);
    assert_eq!(status, Some(2));
    assert!(output.contains("nowhere") && output.contains("help:"), "{output}");
    assert_eq!(uavspec(folder.path(), &["check"]).0, Some(2));
}

/// The reports of `check` on a file, in all formats.
fn reports(folder: &Path, file: &str) -> Vec<(&'static str, String)> {
    let kinds = ["text", "json", "junit", "sarif", "html", "markdown"];
    let printed = |kind| check(folder, &["--format", kind, file]).1;
    kinds.into_iter().map(|kind| (kind, printed(kind))).collect()
}

/// The level of the first result about corruption in a SARIF report.
fn corruption_level(report: &str) -> String {
    let report: Value = serde_json::from_str(report).expect("JSON");
    let results = report["runs"][0]["results"].as_array().expect("a list");
    let corruption = results.iter().find(|result| result["ruleId"] == "corruption").expect("a corrupt part");
    corruption["level"].as_str().expect("a level").to_owned()
}

#[test]
fn an_unreadable_file_is_incomplete_in_each_format() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut gzip = GzEncoder::new(Vec::new(), Compression::fast());
    gzip.write_all(&padded(200)).expect("memory");
    let gzip = gzip.finish().expect("memory");
    let zstd = compress_to_vec(&padded(200)[..], CompressionLevel::Fastest);
    let trailing = [&zstd[..], b"not a frame"].concat();
    // If a frame is truncated within its window, nothing in it can be read.
    fs::write(folder.path().join("cut.ulg"), &zstd[..zstd.len() - 9]).expect("a file");
    assert_eq!(check(folder.path(), &["cut.ulg"]).0, Some(6));
    for packed in [&gzip[..gzip.len() / 2], &trailing] {
        fs::write(folder.path().join("flight.ulg"), packed).expect("a file");
        assert_eq!(check(folder.path(), &["flight.ulg"]).0, Some(6));
        for (kind, reported) in reports(folder.path(), "flight.ulg") {
            let output = match kind {
                "text" => "\noutcome      incomplete: the log can't be read completely\n",
                "json" => "\"extent\": \"unreadable\"",
                "junit" => "message=\"the log can&apos;t be read completely\"",
                "sarif" => "the rest is unreadable",
                _ => "Incomplete: the log can't be read completely",
            };
            assert!(reported.contains(output), "{kind}: {reported}");
            assert!(kind != "sarif" || corruption_level(&reported) == "error", "{reported}");
        }
    }
    fs::write(folder.path().join("good.ulg"), padded(20)).expect("a file");
    let (status, printed, _) = check(folder.path(), &["good.ulg", "flight.ulg", "--format=json"]);
    let report: Value = serde_json::from_str(&printed).expect("JSON");
    let output = &report["outcome"]["text"];
    assert_eq!((status, output), (Some(6), &"Incomplete: 1 of 2 files".into()));
    let (status, printed, _) = check(folder.path(), &["good.ulg", "flight.ulg"]);
    assert_eq!(status, Some(6));
    let end = "\n     1 conforms\n     1 incomplete\nincomplete: 1 of 2 files\n";
    assert!(printed.ends_with(end), "{printed}");
}

#[test]
fn skipped_data_is_incomplete_in_each_format() {
    let folder = tempfile::tempdir().expect("a folder");
    let log = padded(20);
    let (start, end) = log.split_at(log.len() / 2);
    let garbage = [start, &vec![0; 200_000], end].concat();
    let early = &log[..log.len() - 3];
    let message = r#"{"type":"msg/Topic0","message":{"timestamp":1,"xyz":[0.5],"kind":1}}"#;
    let lines = format!("{message}\nnot JSON\n{message}\n");
    for (name, bytes, reason) in [
        ("gap.ulg", &garbage[..], "parts of the log are corrupt"),
        ("early.ulg", early, "the log is truncated"),
        ("gap.jsonl", lines.as_bytes(), "parts of the file are corrupt"),
    ] {
        fs::write(folder.path().join(name), bytes).expect("a file");
        let (status, printed, _) = check(folder.path(), &[name]);
        assert_eq!(status, Some(6), "{name}: {printed}");
        assert!(printed.contains(&format!("\noutcome      incomplete: {reason}\n")), "{name}: {printed}");
        for (kind, reported) in reports(folder.path(), name) {
            match kind {
                "text" => {}
                "junit" => assert!(reported.contains("errors=\"1\""), "{name}: {reported}"),
                "sarif" => {
                    assert!(reported.contains("\"ruleId\": \"incomplete\""), "{name}: {reported}");
                    assert_eq!(corruption_level(&reported), "warning", "{name}: {reported}");
                }
                _ => {
                    let outcome = format!("Incomplete: {reason}");
                    assert!(reported.contains(&outcome), "{name}: {kind}: {reported}");
                }
            }
        }
    }
}

#[test]
fn detects_encrypted_and_very_short_logs() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("a.ulge"), b"ULogEnc\x01\0\0\0\0\0\0\0\0\x04").expect("a file");
    let (status, printed, output) = uavspec(folder.path(), &["check", "a.ulge"]);
    assert_eq!((status, output.as_str()), (Some(6), ""));
    assert!(
        printed.contains("an encrypted PX4 log") && printed.contains("decrypt it with its key"),
        "{printed}"
    );
    for begun in [&b"ULog"[..], b"ULog\x01\x12", b"ULog\x01\x12\x35\x01"] {
        fs::write(folder.path().join("begun.ulg"), begun).expect("a file");
        let (status, printed, _) = uavspec(folder.path(), &["check", "begun.ulg"]);
        let wanted = format!("expected a header of 16 bytes, found {}", begun.len());
        assert!(status == Some(6) && printed.contains(&wanted), "{printed}");
    }
    fs::write(folder.path().join("begun.mcap"), b"\x89MCAP0").expect("a file");
    let (status, printed, _) = uavspec(folder.path(), &["check", "begun.mcap"]);
    assert!(status == Some(6) && printed.contains("doesn't start with the magic bytes of MCAP"), "{printed}");
    for text in ["UL", "ULo", "ULogs of today\n"] {
        fs::write(folder.path().join("text"), text).expect("a file");
        let (status, printed, _) = uavspec(folder.path(), &["check", "text"]);
        assert!(status == Some(6) && printed.contains("incomplete: unknown file type: "), "{printed}");
    }
}

#[test]
fn checks_json_messages_with_and_without_a_type() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("a file");
    let message = r#"{"timestamp":1,"request_id":2,"registration_id":0}"#;
    let reply = |message: &str| {
        format!(r#"{{"op":"publish","topic":"/fmu/out/unregister_ext_component","msg":{message}}}"#)
    };
    let fields = r#""timestamp":1,"arming_check_id":2,"mode_id":3,"mode_executor_id":-1"#;
    let good = format!(r#"{{{fields},"name":"mode"}}"#);
    write("good.jsonl", &format!("{}\n{{\"op\":\"ping\"}}\n", reply(&good)));
    let (status, printed, output) = uavspec(folder.path(), &["check", "good.jsonl"]);
    assert_eq!(status, Some(0), "{printed}{output}");
    assert!(printed.starts_with("good.jsonl  2 lines, 1 message of 1 type ("), "{printed}");
    assert!(printed.contains("skipped      1 rosbridge message other than `publish`"), "{printed}");
    assert!(printed.contains("\noutcome      conforms\n"), "{printed}");

    write("bare.jsonl", &format!("{good}\n{{{fields},\"name\":NaN}}\n{message}\n{good}"));
    let ty = ["--type", "px4/UnregisterExtComponent"];
    let (status, printed, _) = uavspec(folder.path(), &["check", "bare.jsonl", ty[0], ty[1]]);
    assert_eq!(status, Some(1), "{printed}");
    for wanted in [
        "bare.jsonl  4 lines, 4 messages of 1 type (",
        "dialect      bare NaN or Infinity (Python)",
        "PX-JSON-01   MUST   UnregisterExtComponent.request_id: UnregisterExtComponent has no such field, but the message contains 2",
        "once at line 3   definitions/px4/UnregisterExtComponent.msg:",
        "PX-JSON-02   MUST   UnregisterExtComponent.name: expected a string, found a bare NaN",
        "once at line 2   definitions/px4/UnregisterExtComponent.msg:",
    ] {
        assert!(words(&printed).contains(&words(wanted)), "{wanted}: {printed}");
    }
    let (status, printed, _) = uavspec(folder.path(), &["check", "bare.jsonl"]);
    assert_eq!(status, Some(6), "{printed}");
    assert!(printed.contains("corrupt      line 1: unknown message type"), "{printed}");
    assert!(
        printed.contains("\noutcome      incomplete: the file contains no readable messages\n"),
        "{printed}"
    );
    let (status, _, output) = uavspec(folder.path(), &["check", "bare.jsonl", "--type", "px4/Nothing"]);
    assert_eq!(status, Some(2));
    assert!(output.contains("--type px4/Nothing: no such message in the definitions"), "{output}");

    let arguments = ["check", "--format", "json", "bare.jsonl", ty[0], ty[1]];
    let report: Value = serde_json::from_str(&uavspec(folder.path(), &arguments).1).expect("JSON");
    let source = &report["subjects"][0];
    assert_eq!((&source["kind"], &source["lines"], &source["types"]), (&"json".into(), &4.into(), &1.into()));
    let finding = &source["findings"][0];
    assert_eq!((&finding["rule"], &finding["examples"][0]["line"]), (&"PX-JSON-01".into(), &3.into()));
}

#[test]
fn checks_folders_and_compressed_files_in_order() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join("day")).expect("a folder");
    let zstd = compress_to_vec(&padded(20)[..], CompressionLevel::Fastest);
    fs::write(folder.path().join("day/b.ulg.zst"), zstd).expect("a file");
    fs::write(folder.path().join("day/a.ulg"), padded(30)).expect("a file");
    for jobs in ["1", "4"] {
        let (status, printed, _) = check(folder.path(), &["--jobs", jobs, "day"]);
        assert_eq!(status, Some(0), "{printed}");
        let heads: Vec<&str> = printed.lines().filter(|line| line.starts_with("day/")).collect();
        assert!(heads[0].starts_with("day/a.ulg") && heads[0].contains("600 records"), "{printed}");
        assert!(heads[1].starts_with("day/b.ulg.zst") && heads[1].contains("400 records"), "{printed}");
    }
}

#[test]
fn strict_formats_and_required_rules_fail_the_run() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("flight.ulg"), padded(20)).expect("a file");
    fs::create_dir(folder.path().join("msg")).expect("a folder");
    let topic = "# A topic\n\nuint64 timestamp  # [us] Time\nfloat32 other     # [-] Another field\n# TOPICS topic_3\n";
    fs::write(folder.path().join("msg/Topic.msg"), topic).expect("a file");
    let check = |arguments: &[&str]| {
        let all = [&["check", "flight.ulg", "--definitions", "msg"], arguments].concat();
        uavspec(folder.path(), &all)
    };
    assert_eq!(check(&[]).0, Some(0));
    let (status, printed, _) = check(&["--strict-formats"]);
    assert_eq!(status, Some(1), "{printed}");
    assert!(printed.contains("differs    topic_3: missing fields: other (float32)"), "{printed}");
    let (_, printed, _) = check(&[]);
    assert!(
        printed.contains("not checked  19 topics without a definition, 1 with a different format"),
        "{printed}"
    );
    assert!(
        printed
            .contains("\noutcome      no violations found, partial coverage: 0 of 20 topics fully checked\n"),
        "{printed}"
    );
    assert_eq!(check(&["--require", "PX-TIME-01,PX-FMT-01"]).0, Some(0));
    let (status, _, output) = check(&["--require", "PX-VER-01"]);
    assert_eq!(status, Some(1));
    assert!(output.contains("PX-VER-01 is required"), "{output}");
    for (kind, marks) in [
        ("junit", &["failures=\"1\"", "name=\"as a whole\"", "PX-VER-01 is required"][..]),
        ("sarif", &["\"ruleId\": \"run\"", "PX-VER-01 is required"]),
        ("json", &["\"reasons\": [\n    {\n      \"message\": \"PX-VER-01 is required"]),
        ("markdown", &["PX-VER-01 is required"]),
        ("html", &["PX-VER-01 is required"]),
        ("text", &["\nfailed       PX-VER-01 is required", "\ndoes not conform"]),
        ("short", &["\nuavspec: error: PX-VER-01 is required"]),
    ] {
        let (_, printed, _) = check(&["--require", "PX-VER-01", "--format", kind]);
        assert!(marks.iter().all(|mark| printed.contains(mark)), "{kind}: {printed}");
    }
    let (status, _, output) = check(&["--require", "PX-NONE-01"]);
    assert_eq!(status, Some(2));
    assert!(output.contains("no such rule") && output.contains("help:"), "{output}");
}

#[test]
fn rejects_an_invalid_glob_pattern() {
    let folder = tempfile::tempdir().expect("a folder");
    let (status, _, output) = uavspec(folder.path(), &["check", "[day"]);
    assert_eq!(status, Some(2));
    assert!(output.starts_with("error: [day: "), "{output}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_report_that_cannot_be_printed_fails_the_run() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("flight.ulg"), padded(20)).expect("a file");
    for arguments in [&["check", "flight.ulg"][..], &["check", "flight.ulg", "--format", "json"], &["rules"]]
    {
        let mut command = Command::new(env!("CARGO_BIN_EXE_uavspec"));
        let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("a device");
        let output =
            command.args(arguments).current_dir(folder.path()).stdout(full).output().expect("it runs");
        assert_eq!(output.status.code(), Some(3), "{arguments:?}");
        let output = String::from_utf8(output.stderr).expect("UTF-8");
        assert!(output.contains("error: standard output: "), "{output}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn commands_for_definitions_fail_if_their_output_cannot_be_printed() {
    let folder = tempfile::tempdir().expect("a folder");
    let config = "[[package]]\nname = \"px4\"\ndialect = \"px4\"\ninclude = [\"*.msg\"]\n";
    fs::write(folder.path().join("uavspec.toml"), config).expect("a file");
    fs::write(folder.path().join("Wind.msg"), "uint64   timestamp # [us] Time\n").expect("a file");
    for arguments in [
        &["lint"][..],
        &["lint", "--rules"],
        &["lint", "--format", "sarif"],
        &["lint", "--summary"],
        &["inspect"],
        &["fmt", "--check"],
    ] {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("a device");
        let mut command = Command::new(env!("CARGO_BIN_EXE_uavspec"));
        let output =
            command.args(arguments).current_dir(folder.path()).stdout(full).output().expect("it runs");
        let printed = String::from_utf8(output.stderr).expect("UTF-8");
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {printed}");
        assert!(printed.contains("error: standard output: "), "{printed}");
    }
}

#[test]
fn prints_json_reports() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("flight.ulg"), padded(20)).expect("a file");
    let (status, printed, _) = check(folder.path(), &["--format", "json", "flight.ulg"]);
    assert_eq!(status, Some(0));
    let report: Value = serde_json::from_str(&printed).expect("JSON");
    assert_eq!(report["version"], 1);
    let source = &report["subjects"][0];
    assert_eq!(
        (&source["path"], &source["records"], &source["checked"]),
        (&"flight.ulg".into(), &400.into(), &400.into())
    );
    let coverage = &source["coverage"];
    assert_eq!(coverage["units"], serde_json::json!({ "checked": 20, "total": 20 }));
    // Each topic has a message every 4 ms.
    let part = serde_json::json!({
        "name": "topic_0",
        "result": "checked",
        "records": { "checked": 20, "total": 20 },
        "values": { "checked": 60, "total": 60 },
        "first_us": 1_000_000,
        "last_us": 1_076_000,
        "rate_hz": 250.0,
    });
    assert_eq!(coverage["parts"][0], part);
    let rules = source["rules"].as_array().expect("a list");
    let verdict = |id: &str| rules.iter().find(|rule| rule["id"] == id).map(|rule| rule["verdict"].clone());
    assert_eq!(verdict("PX-TIME-01"), Some("pass".into()));
    assert_eq!(verdict("PX-VER-01"), Some("not covered".into()));
}

#[test]
fn writes_several_reports_in_one_run() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("flight.ulg"), padded(20)).expect("a file");
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).expect("a report");
    let all = "--report=json=a.json,junit=a.xml,sarif=a.sarif";
    let (status, printed, _) = check(
        folder.path(),
        &["flight.ulg", all, "--report", "html=a.html", "--report=markdown=a.md,text=a.txt"],
    );
    assert_eq!(status, Some(0), "{printed}");
    assert!(printed.contains("\noutcome      conforms\n"), "the text report is still printed: {printed}");
    let report: Value = serde_json::from_str(&read("a.json")).expect("JSON");
    assert_eq!(report["outcome"]["text"], "Conforms");
    assert!(
        report["command"]
            .as_str()
            .is_some_and(|line| line.starts_with("uavspec check --definitions msg flight.ulg")),
        "{report}"
    );
    for (name, start) in [
        ("a.xml", "<?xml"),
        ("a.sarif", "{"),
        ("a.html", "<!DOCTYPE html>"),
        ("a.md", "<!-- "),
        ("a.txt", "flight.ulg"),
    ] {
        assert!(read(name).starts_with(start), "{name}");
    }
    // A report that is written to standard output replaces the text report.
    let (_, printed, _) = check(folder.path(), &["flight.ulg", "--report", "markdown=-,json=b.json"]);
    assert_eq!(printed.lines().nth(2), Some("# ✅ Conforms"), "{printed}");
    assert_eq!(
        check(folder.path(), &["flight.ulg", "--format", "markdown"]).1.lines().nth(2),
        Some("# ✅ Conforms")
    );
    // A report that can't be written is an error, but the other reports are written.
    let (status, _, output) = check(folder.path(), &["flight.ulg", "--report", "json=no/a.json,html=c.html"]);
    assert_eq!(status, Some(3), "{output}");
    assert!(output.contains("error: no/a.json: can't write the report"), "{output}");
    assert!(read("c.html").ends_with("</html>\n"));
}

#[test]
fn rejects_invalid_report_arguments() {
    let here = Path::new(".");
    for (arguments, wanted) in [
        (
            &["--report", "pdf=a.pdf"][..],
            "expected one of text, short, json, junit, sarif, codequality, html, markdown",
        ),
        (&["--report", "html"], "KIND=PATH"),
        (&["--report", "html=-,json=-"], "only one report can be printed to standard output"),
        (&["--report", "html=-", "--format", "json"], "only one report can be printed to standard output"),
        (&["--report", "html=a,json=a"], "--report html=a and --report json=a are the same file"),
    ] {
        for command in ["check", "test"] {
            let rest: &[&str] = if command == "check" { &["absent.ulg"] } else { &["--", "absent"] };
            let (status, _, output) = uavspec(here, &[&[command], arguments, rest].concat());
            assert_eq!(status, Some(2), "{output}");
            assert!(output.contains(wanted), "{output}");
        }
    }
}

#[cfg(not(feature = "schemas"))]
#[test]
fn missing_schemas_name_the_feature() {
    let folder = tempfile::tempdir().expect("a folder");
    for command in [["check", "absent.jsonl"], ["probe", "tcp://127.0.0.1:1"]] {
        let (status, _, output) = uavspec(folder.path(), &[&command[..], &["--schema", "soar"]].concat());
        let problem = "error: soar: this program can't read JSON Schemas";
        assert_eq!(status, Some(2), "{output}");
        assert!(output.starts_with(problem) && output.contains("--features schemas"), "{output}");
    }
}

#[test]
fn prints_rules_and_help() {
    let here = Path::new(".");
    let (status, printed, _) = uavspec(here, &["rules", "PX-RANGE-01"]);
    assert_eq!(status, Some(0));
    let url = uavspec_lint::report::rule_url("PX-RANGE-01");
    for wanted in ["PX-RANGE-01  SHOULD, normative", "What the rule finds", &url] {
        assert!(printed.contains(wanted), "{wanted}: {printed}");
    }
    let (status, _, output) = uavspec(here, &["rules", "PX-NONE-01"]);
    assert_eq!(status, Some(2));
    assert!(output.contains("no such rule") && output.contains("help:"), "{output}");
    let list: Value = serde_json::from_str(&uavspec(here, &["rules", "--format", "json"]).1).expect("JSON");
    assert_eq!(list.as_array().map(Vec::len), Some(uavspec_rules::RULES.len()));
    let rows: Value =
        serde_json::from_str(&uavspec(here, &["rules", "--matrix", "--format", "json"]).1).expect("JSON");
    assert!(
        rows.as_array().is_some_and(|rows| rows.iter().all(|row| row["violated"] == row["expected"])),
        "{rows}"
    );
    let (status, printed, _) = uavspec(here, &["rules"]);
    assert_eq!(status, Some(0));
    for rule in uavspec_rules::RULES {
        assert!(printed.contains(rule.id) && printed.contains(rule.statement), "{}", rule.id);
    }
    let (status, printed, _) = uavspec(here, &["check", "--help"]);
    assert_eq!(status, Some(0));
    assert!(
        printed.contains("Examples, with the files of `uavspec sample`:")
            && printed.contains("uavspec check flight.ulg"),
        "{printed}"
    );
}

#[test]
fn explains_why_a_self_test_of_px4_references_cannot_start() {
    for (arguments, expected, wrong) in [
        (&["dds://999"][..], 2, "from 0 to 232"),
        (&["--recordings-only"], 2, "cannot be used with"),
        (&["--", "codec"], 2, "cannot be used with"),
        (&["foxglove://127.0.0.1:1"], 3, "error: foxglove://127.0.0.1:1: "),
    ] {
        let (status, printed, errors) =
            uavspec(Path::new("."), &[&["self-test", "--px4"], arguments].concat());
        assert_eq!((status, printed.as_str()), (Some(expected), ""), "{errors}");
        assert!(errors.contains(wrong), "{errors}");
    }
}

/// The names of all commands in the help.
fn commands(folder: &Path) -> Vec<String> {
    let (_, help, _) = uavspec(folder, &["--help"]);
    let list = help.split("Commands:\n").nth(1).and_then(|rest| rest.split("\n\n").next()).expect("a list");
    let names = list.lines().filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    names.filter_map(|line| line.split_whitespace().next()).map(str::to_owned).collect()
}

#[test]
fn every_command_has_an_example_a_man_page_and_completions() {
    let folder = tempfile::tempdir().expect("a folder");
    let commands = commands(folder.path());
    assert!(commands.len() > 15, "{commands:?}");
    let (status, page, _) = uavspec(folder.path(), &["man"]);
    assert!(status == Some(0) && page.contains(".TH uavspec 1"), "{page}");
    assert_eq!(uavspec(folder.path(), &["man", "--out", "man/man1"]).0, Some(0));
    let scripts: Vec<String> = ["bash", "elvish", "fish", "powershell", "zsh"]
        .map(|shell| uavspec(folder.path(), &["completions", shell]).1)
        .to_vec();
    for command in commands.iter().filter(|command| *command != "help") {
        let (status, help, errors) = uavspec(folder.path(), &[command, "--help"]);
        assert_eq!((status, errors.as_str()), (Some(0), ""), "{command}");
        assert!(help.contains(&format!("\n  uavspec {command}")), "{command}: {help}");
        assert!(!help.contains("xtask"), "{command}: {help}");
        assert!(help.lines().all(|line| line.chars().count() <= 80), "{command}: {help}");
        let page = fs::read_to_string(folder.path().join(format!("man/man1/uavspec-{command}.1")));
        assert!(page.is_ok_and(|page| page.contains("SYNOPSIS")), "{command}");
        assert!(scripts.iter().all(|script| script.contains(command.as_str())), "{command}");
    }
    let (status, _, errors) = uavspec(folder.path(), &["completions", "tcsh"]);
    assert!(status == Some(2) && errors.contains("[possible values: bash, elvish"), "{errors}");
    fs::write(folder.path().join("file"), "").expect("a file");
    let (status, _, errors) = uavspec(folder.path(), &["man", "--out", "file"]);
    assert!(status == Some(3) && errors.starts_with("error: file: "), "{errors}");
}

#[test]
fn definitions_are_maintained_without_a_workspace() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join("msg")).expect("a folder");
    fs::write(folder.path().join("msg/Wind.msg"), "# Wind\n\nuint64 timestamp # [us] Time\n")
        .expect("a file");
    let package = ["--package", "my_msgs", "--dialect", "px4", "--input", "msg"];
    let run = |command: &[&str]| uavspec(folder.path(), &[command, &package].concat());
    let (status, printed, _) = run(&["lint", "--summary"]);
    assert!(status == Some(0) && printed.contains("no findings"), "{printed}");
    let (status, printed, errors) = run(&["fmt", "--check"]);
    assert_eq!(status, Some(1), "{printed}{errors}");
    assert_eq!(run(&["fmt"]).0, Some(0));
    assert_eq!(run(&["fmt", "--check"]).0, Some(0));
    assert_eq!(run(&["codegen", "--out", "out"]).0, Some(0));
    assert!(folder.path().join("out").is_dir());
}

/// Encodes an MCAP record.
fn mcap_record(opcode: u8, parts: &[&[u8]]) -> Vec<u8> {
    let body = parts.concat();
    [&[opcode][..], &(body.len() as u64).to_le_bytes(), &body].concat()
}

#[test]
fn reports_how_mcap_channels_were_checked() {
    let folder = tempfile::tempdir().expect("a folder");
    let text =
        |text: &str| [&u32::try_from(text.len()).expect("short").to_le_bytes()[..], text.as_bytes()].concat();
    let channel = |id: u8, topic: &str, encoding: &str| {
        mcap_record(4, &[&[id, 0, 0, 0], &text(topic), &text(encoding), &text("")])
    };
    let message = |id: u8, payload: &[u8]| mcap_record(5, &[&[id, 0], &[0; 20], payload]);
    let request = [&[0, 1, 0, 0][..], &9_u64.to_le_bytes(), &[3, 0, 0, 0], &[0; 4]].concat();
    let magic = b"\x89MCAP0\r\n".to_vec();
    let file = [
        magic.clone(),
        mcap_record(1, &[&text("ros2"), &text("hand")]),
        channel(1, "/fmu/out/arming_check_request", "cdr"),
        channel(2, "/picture", "protobuf"),
        channel(3, "/talk", "cdr"),
        message(1, &request),
        message(2, b"what"),
        message(3, b"what"),
        mcap_record(15, &[&[0; 4]]),
        mcap_record(2, &[&[0; 20]]),
        magic,
    ]
    .concat();
    fs::create_dir(folder.path().join("bag")).expect("a folder");
    fs::write(folder.path().join("bag/bag_0.mcap"), &file).expect("a file");
    let (status, printed, output) = uavspec(folder.path(), &["check", "bag"]);
    assert_eq!(status, Some(0), "{printed}{output}");
    assert!(printed.starts_with("bag/bag_0.mcap  ros2 (hand), 0 s, 3 channels, 3 messages ("), "{printed}");
    for line in [
        "checked      1 of 3 topics (33 %), 1 of 3 records, 3 values\n",
        "not checked  1 topic without a definition, 1 in an unsupported encoding\n",
        "definitions  0 of 3 channels match, 0 differ, 1 without a comparable schema, 1\n             unknown\n",
        "  by name    /fmu/out/arming_check_request: no schema with fields\n",
        "  not read   /picture: unsupported encoding `protobuf`\n",
        "  undefined  /talk: no schema\n",
        "\noutcome      no violations found, partial coverage: 1 of 3 topics fully checked\n",
    ] {
        assert!(printed.contains(line), "{line}{printed}");
    }
    fs::write(folder.path().join("cut.mcap.zst"), compress_to_vec(&file[..300], CompressionLevel::Fastest))
        .expect("a file");
    let (status, printed, _) = uavspec(folder.path(), &["check", "--format", "json", "cut.mcap.zst"]);
    assert_eq!(status, Some(6), "{printed}");
    let report: Value = serde_json::from_str(&printed).expect("JSON");
    let source = &report["subjects"][0];
    assert_eq!((&source["kind"], &source["profile"]), (&"mcap".into(), &"ros2".into()));
    let channel = &source["channels"][0];
    assert_eq!(
        (&channel["result"], &channel["message"]),
        (&"by name".into(), &"no schema with fields".into()),
        "{channel}"
    );
    assert_eq!((&channel["encoding"], &channel["messages"]), (&"cdr".into(), &1.into()), "{channel}");
    assert_eq!(source["channels"][1]["result"], "unsupported");
    assert_eq!(source["corruption"][0]["byte"], 298, "{source}");
}
