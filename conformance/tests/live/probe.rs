//! Runs of `uavspec probe`.

use std::fs;
use std::process::Command;

use serde_json::Value;
use tempfile::TempDir;

/// The result of a probe.
#[derive(Debug)]
pub(crate) struct Probed {
    /// The exit status.
    pub(crate) status: Option<i32>,
    /// The report in JSON.
    pub(crate) report: Value,
}

impl Probed {
    /// Probes a vehicle for some seconds.
    pub(crate) fn new(address: &str, seconds: u32) -> Self {
        Self::with(address, seconds, &[])
    }

    /// Probes a vehicle, with additional arguments.
    pub(crate) fn with(address: &str, seconds: u32, arguments: &[&str]) -> Self {
        let folder = TempDir::new().expect("a folder");
        let report = folder.path().join("report.json");
        let output = Command::new(env!("CARGO_BIN_EXE_uavspec"))
            .args(["probe", address, "--for", &seconds.to_string()])
            .args(arguments)
            .arg("--report")
            .arg(format!("json={}", report.display()))
            .output()
            .expect("the program runs");
        let errors = String::from_utf8_lossy(&output.stderr);
        let text = fs::read(report).unwrap_or_else(|error| panic!("{error}\n{errors}"));
        Self { status: output.status.code(), report: serde_json::from_slice(&text).expect("JSON") }
    }

    /// The part of the report about the vehicle.
    pub(crate) fn vehicle(&self) -> &Value {
        &self.report["subjects"][0]
    }

    /// The findings: the rule, and the first message.
    pub(crate) fn findings(&self) -> Vec<(&str, &str)> {
        let findings = self.vehicle()["findings"].as_array().expect("a list");
        let found = findings.iter().map(|finding| {
            (
                finding["rule"].as_str().expect("a rule"),
                finding["examples"][0]["message"].as_str().expect("a text"),
            )
        });
        found.collect()
    }

    /// The number of values to which a rule applied.
    pub(crate) fn covered(&self, rule: &str) -> u64 {
        let rules = self.vehicle()["rules"].as_array().expect("a list");
        let found = rules.iter().find(|found| found["id"] == rule).expect("the rule");
        found["covered"].as_u64().expect("a number")
    }

    /// The number of messages.
    pub(crate) fn messages(&self) -> u64 {
        self.vehicle()["records"].as_u64().expect("a number")
    }

    /// The texts of a list.
    pub(crate) fn texts(&self, list: &str) -> String {
        self.vehicle()[list].to_string()
    }

    /// The part of the report about a topic.
    pub(crate) fn topic(&self, name: &str) -> &Value {
        let channels = self.vehicle()["channels"].as_array().expect("channels");
        channels
            .iter()
            .find(|channel| channel["topic"] == name)
            .unwrap_or_else(|| panic!("no {name}: {self:#?}"))
    }

    /// The verdict of a rule.
    pub(crate) fn verdict(&self, rule: &str) -> &str {
        let rules = self.vehicle()["rules"].as_array().expect("rules");
        let rule = rules.iter().find(|known| known["id"] == rule).expect("the rule");
        rule["verdict"].as_str().expect("a verdict")
    }
}
