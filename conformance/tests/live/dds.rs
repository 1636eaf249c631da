//! DDS domains, with peers that use Cyclone DDS. Each test has its own domain on the loopback interface.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;
use tempfile::TempDir;

use super::python::Peer;

/// Cyclone DDS without multicast, on the loopback interface only.
pub(crate) const CYCLONE: &str = r#"<CycloneDDS><Domain>
    <General>
        <Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces>
        <AllowMulticast>false</AllowMulticast>
    </General>
    <Discovery>
        <ParticipantIndex>auto</ParticipantIndex>
        <MaxAutoParticipantIndex>9</MaxAutoParticipantIndex>
        <Peers><Peer address="127.0.0.1"/></Peers>
    </Discovery>
    <Tracing><OutputFile>/dev/null</OutputFile></Tracing>
</Domain></CycloneDDS>"#;

fn peer(domain: &str, action: &str, reliability: &str) -> Peer {
    run(&[domain, action, reliability])
}

fn run(arguments: &[&str]) -> Peer {
    Peer::start("dds.py", arguments, &[("CYCLONEDDS_URI", CYCLONE)])
}

/// The result of a probe.
struct Probed {
    status: Option<i32>,
    subject: Value,
}

impl Probed {
    /// The findings: the rule, and the first message.
    fn findings(&self) -> Vec<(&str, &str)> {
        let findings = self.subject["findings"].as_array().expect("a list");
        let found = findings.iter().map(|finding| {
            (
                finding["rule"].as_str().expect("a rule"),
                finding["examples"][0]["message"].as_str().expect("a text"),
            )
        });
        found.collect()
    }

    /// The number of values to which a rule applied.
    fn covered(&self, rule: &str) -> u64 {
        let rules = self.subject["rules"].as_array().expect("a list");
        let found = rules.iter().find(|found| found["id"] == rule).expect("the rule");
        found["exercised"].as_u64().expect("a number")
    }

    fn messages(&self) -> u64 {
        self.subject["records"].as_u64().expect("a number")
    }

    /// The texts of a list.
    fn texts(&self, list: &str) -> String {
        self.subject[list].to_string()
    }
}

/// Probes a domain on the loopback interface.
fn probe(domain: &str, seconds: &str) -> Probed {
    let folder = TempDir::new().expect("a folder");
    let report = folder.path().join("report.json");
    let output = Command::new(env!("CARGO_BIN_EXE_uavspec"))
        .args(["probe", &format!("dds://{domain}"), "--peer", "127.0.0.1", "--for", seconds])
        .arg("--report")
        .arg(format!("json={}", report.display()))
        .output()
        .expect("the program runs");
    let errors = String::from_utf8_lossy(&output.stderr);
    let report = fs::read(report).unwrap_or_else(|error| panic!("{error}\n{errors}"));
    let mut report: Value = serde_json::from_slice(&report).expect("JSON");
    Probed { status: output.status.code(), subject: report["subjects"][0].take() }
}

/// Probes a domain until messages arrive. On a busy machine, the peers take long to start.
fn probe_messages(domain: &str, seconds: &str) -> Probed {
    probe_until(domain, seconds, |probed| probed.messages() > 0)
}

/// Probes a domain until messages arrive, and a publisher and a subscriber are compared.
fn probe_pair(domain: &str, seconds: &str) -> Probed {
    probe_until(domain, seconds, |probed| probed.messages() > 0 && probed.covered("PX-QOS-01") > 0)
}

fn probe_until(domain: &str, seconds: &str, is_complete: fn(&Probed) -> bool) -> Probed {
    let mut attempts = (0..5).map(|_| probe(domain, seconds));
    attempts.find(is_complete).expect("messages of all peers")
}

#[test]
fn compatible_endpoints_have_no_findings() {
    let _peers = [peer("61", "publish", "best_effort"), peer("61", "subscribe", "best_effort")];
    let probed = probe_pair("61", "7");
    assert_eq!(probed.findings(), []);
    assert_eq!(probed.covered("PX-QOS-01"), 1);
    assert!(probed.covered("PX-HASH-01") > 0, "the type hash is known");
}

#[test]
fn reports_a_subscriber_that_requests_more_than_is_offered() {
    let _peers = [peer("62", "publish", "best_effort"), peer("62", "subscribe", "reliable")];
    let probed = probe_pair("62", "7");
    let text = "subscriber `/subscribe` requests reliability reliable, but publisher `/publish` offers best effort: \
                the subscriber receives nothing";
    assert_eq!(probed.findings(), [("PX-QOS-01", text)]);
    assert_eq!(probed.status, Some(1));
}

#[test]
fn endpoints_in_different_partitions_are_not_compared() {
    let _peers = [
        run(&["70", "publish", "best_effort"]),
        run(&["70", "publish", "best_effort", "wing"]),
        run(&["70", "subscribe", "best_effort"]),
        run(&["70", "subscribe", "reliable", "fleet"]),
    ];
    let is_complete = |probed: &Probed| {
        let bus = probed.texts("bus");
        let are_found = ["partition wing", "partition fleet"].iter().all(|name| bus.contains(name));
        probed.messages() > 0 && probed.covered("PX-QOS-01") > 0 && are_found
    };
    let probed = probe_until("70", "7", is_complete);
    assert_eq!(probed.findings(), []);
    assert_eq!(probed.covered("PX-QOS-01"), 1);
    let note = "the messages of a publisher in partition wing aren't received";
    assert!(probed.texts("notes").contains(note), "{}", probed.texts("notes"));
}

#[test]
fn endpoints_in_the_same_partition_are_compared() {
    let _peers =
        [run(&["76", "publish", "best_effort", "wing"]), run(&["76", "subscribe", "reliable", "wing"])];
    let probed = probe_until("76", "7", |probed| probed.covered("PX-QOS-01") > 0);
    assert!(matches!(probed.findings()[..], [("PX-QOS-01", _)]), "{:?}", probed.findings());
}

#[test]
fn checks_messages() {
    let _peer = peer("63", "truncate", "reliable");
    let probed = probe_messages("63", "7");
    let rules: Vec<&str> = probed.findings().into_iter().map(|(rule, _)| rule).collect();
    assert!(rules.contains(&"PX-CDR-02"), "{rules:?}");
}

#[test]
fn receives_messages_that_a_publisher_stored() {
    let _peer = peer("64", "store", "reliable");
    let probed = probe_messages("64", "8");
    assert_eq!((probed.findings(), probed.messages()), (vec![], 1));
}

#[test]
fn corrupt_packets_do_not_affect_other_messages() {
    let _hostile = Peer::start("dds_hostile.py", &["65", "corrupt"], &[]);
    let _peers = [peer("65", "publish", "best_effort"), peer("65", "subscribe", "best_effort")];
    let probed = probe_pair("65", "8");
    assert_eq!(probed.texts("incomplete"), "[]");
    assert_eq!(probed.findings(), []);
}

#[test]
fn ends_above_the_maximum_number_of_endpoints() {
    let _hostile = Peer::start("dds_hostile.py", &["66", "endpoints"], &[]);
    let probed = probe("66", "180");
    assert!(probed.texts("incomplete").contains("more than 10000"), "{}", probed.subject);
}

#[test]
fn ends_if_a_forged_fragment_claims_a_large_message() {
    let _hostile = Peer::start("dds_hostile.py", &["78", "fragment"], &[]);
    let probed = probe("78", "180");
    assert!(probed.texts("incomplete").contains("more than 2 GiB of memory"), "{}", probed.subject);
}

#[test]
fn reports_long_names() {
    let _hostile = Peer::start("dds_hostile.py", &["67", "names"], &[]);
    let probed = probe("67", "5");
    assert!(probed.texts("notes").contains("a name of more than 256 bytes"), "{}", probed.texts("notes"));
}

#[test]
#[ignore = "requires a C++ compiler, and Debian's libfastrtps-dev"]
fn fast_dds_is_a_peer() {
    let folder = TempDir::new().expect("a folder");
    let program = folder.path().join("fastdds");
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/live/peers/fastdds.cpp");
    let mut compile = Command::new("c++");
    compile.arg("-std=c++17").arg(source).arg("-o").arg(&program).args(["-lfastrtps", "-lfastcdr"]);
    assert!(compile.status().expect("a compiler").success());
    let _peer = Peer::run(Command::new(program).arg("69"));
    let probed = probe_messages("69", "8");
    assert_eq!(probed.findings(), []);
}
