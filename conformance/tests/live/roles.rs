//! Tests of roles in arming checks over DDS, with the reference and the probe as participants. Each test has a separate
//! domain on the loopback interface.

use std::fs;
use std::process::{Child, Command, Stdio};

use serde_json::Value;
use tempfile::TempDir;

/// A running `uavspec serve`.
struct Reference(Child);

impl Reference {
    fn start(domain: &str, arguments: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_uavspec"));
        command.args(["serve", "--px4", &format!("dds://{domain}"), "--peer", "127.0.0.1", "--for", "60"]);
        Self(command.args(arguments).stdout(Stdio::null()).spawn().expect("the program runs"))
    }
}

impl Drop for Reference {
    fn drop(&mut self) {
        // The program may have ended.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Probes a domain. Returns the violated rules, the number of covered rules on arming checks, and the notes. Also
/// asserts that the same rules are violated in the recording.
fn probe(domain: &str, arguments: &[&str]) -> (Vec<String>, usize, Value) {
    let folder = TempDir::new().expect("a folder");
    let [report, checked, bag] =
        ["report.json", "checked.json", "run.mcap"].map(|name| folder.path().join(name));
    let run = |arguments: &[&str], report: &std::path::Path| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_uavspec"));
        command.args(arguments).arg("--report").arg(format!("json={}", report.display()));
        let output = command.output().expect("the program runs");
        let errors = String::from_utf8_lossy(&output.stderr);
        let text = fs::read(report).unwrap_or_else(|error| panic!("{error}\n{errors}"));
        serde_json::from_slice::<Value>(&text).expect("JSON")["subjects"][0].take()
    };
    let (address, bag) = (format!("dds://{domain}"), bag.display().to_string());
    let base = ["probe", &address, "--peer", "127.0.0.1", "--for", "9", "--record", &bag];
    let live = run(&[&base[..], arguments].concat(), &report);
    let recorded = run(&["check", &bag], &checked);
    let violated = |subject: &Value| {
        let findings = subject["findings"].as_array().expect("a list");
        findings
            .iter()
            .map(|finding| finding["rule"].as_str().expect("a rule").to_owned())
            .collect::<Vec<_>>()
    };
    assert_eq!(violated(&live), violated(&recorded));
    let rules = live["rules"].as_array().expect("a list");
    let is_covered = |rule: &&Value| {
        rule["id"].as_str().is_some_and(|id| id.starts_with("PX-EXT")) && rule["covered"].as_u64() > Some(0)
    };
    (violated(&live), rules.iter().filter(is_covered).count(), live["notes"].clone())
}

#[test]
fn a_component_probes_the_reference_autopilot() {
    let _reference = Reference::start("81", &[]);
    let (violated, covered, notes) = probe("81", &["--as", "component"]);
    assert_eq!((violated, covered), (vec![], 7), "{notes}");
    assert_eq!(notes, serde_json::json!([]));
}

#[test]
fn an_autopilot_probes_the_reference_component() {
    let _reference = Reference::start("82", &["--component"]);
    let (violated, covered, notes) = probe("82", &["--as", "autopilot"]);
    assert_eq!((violated, covered), (vec![], 7), "{notes}");
    assert_eq!(notes, serde_json::json!([]));
}

#[test]
fn a_bug_of_the_reference_is_found() {
    let _reference = Reference::start("83", &["--component", "--bug", "PX-EXT-03"]);
    let (violated, _, notes) = probe("83", &["--as", "autopilot"]);
    assert_eq!(violated, ["PX-EXT-03"], "{notes}");
}

#[test]
fn references_communicate_without_findings() {
    let _references = [Reference::start("84", &[]), Reference::start("84", &["--component"])];
    let (violated, covered, notes) = probe("84", &[]);
    assert_eq!(violated, Vec::<String>::new(), "{notes}");
    assert!(covered > 4, "{covered}");
}
