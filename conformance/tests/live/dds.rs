//! Tests of DDS domains, with peers that use Cyclone DDS. Each test has a separate domain on the loopback interface.

use std::path::Path;
use std::process::{Command, Stdio};

use tempfile::TempDir;

use super::probe::Probed;
use super::python::Peer;

/// A configuration of Cyclone DDS that uses only the loopback interface, without multicast.
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

/// Probes a domain on the loopback interface.
fn probe(domain: &str, seconds: u32) -> Probed {
    Probed::with(&format!("dds://{domain}"), seconds, &["--peer", "127.0.0.1"])
}

/// Probes a domain until messages arrive, because the peers take long to start on a busy machine.
fn probe_messages(domain: &str, seconds: u32) -> Probed {
    probe_until(domain, seconds, |probed| probed.messages() > 0)
}

/// Probes a domain until messages arrive, and a publisher has been compared with a subscriber.
fn probe_pair(domain: &str, seconds: u32) -> Probed {
    probe_until(domain, seconds, |probed| probed.messages() > 0 && probed.covered("PX-QOS-01") > 0)
}

fn probe_until(domain: &str, seconds: u32, is_complete: fn(&Probed) -> bool) -> Probed {
    let mut attempts = (0..5).map(|_| probe(domain, seconds));
    attempts.find(is_complete).expect("messages of all peers")
}

#[test]
fn compatible_endpoints_have_no_findings() {
    let _peers = [peer("61", "publish", "best_effort"), peer("61", "subscribe", "best_effort")];
    let probed = probe_pair("61", 7);
    assert_eq!(probed.findings(), []);
    assert_eq!(probed.covered("PX-QOS-01"), 1);
    assert!(probed.covered("PX-HASH-01") > 0, "the type hash is known");
}

#[test]
fn reports_a_subscriber_that_requests_more_than_is_offered() {
    let _peers = [peer("62", "publish", "best_effort"), peer("62", "subscribe", "reliable")];
    let probed = probe_pair("62", 7);
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
    let probed = probe_until("70", 7, is_complete);
    assert_eq!(probed.findings(), []);
    assert_eq!(probed.covered("PX-QOS-01"), 1);
    let note = "the messages of a publisher in partition wing aren't received";
    assert!(probed.texts("notes").contains(note), "{}", probed.texts("notes"));
}

#[test]
fn endpoints_in_the_same_partition_are_compared() {
    let _peers =
        [run(&["76", "publish", "best_effort", "wing"]), run(&["76", "subscribe", "reliable", "wing"])];
    let probed = probe_until("76", 7, |probed| probed.covered("PX-QOS-01") > 0);
    assert!(matches!(probed.findings()[..], [("PX-QOS-01", _)]), "{:?}", probed.findings());
}

#[test]
fn checks_messages() {
    let _peer = peer("63", "truncate", "reliable");
    let probed = probe_messages("63", 7);
    let rules: Vec<&str> = probed.findings().into_iter().map(|(rule, _)| rule).collect();
    assert!(rules.contains(&"PX-CDR-02"), "{rules:?}");
}

#[test]
fn receives_messages_that_a_publisher_stored() {
    let _peer = peer("64", "store", "reliable");
    let probed = probe_messages("64", 8);
    assert_eq!((probed.findings(), probed.messages()), (vec![], 1));
}

#[test]
fn corrupt_packets_do_not_affect_other_messages() {
    let _hostile = Peer::start("dds_hostile.py", &["65", "corrupt"], &[]);
    // Cyclone DDS prints a line for each corrupt packet.
    let quiet = |action| {
        let arguments = ["65", action, "best_effort"];
        let mut command = Peer::command("dds.py", &arguments, &[("CYCLONEDDS_URI", CYCLONE)]);
        Peer::run(command.stderr(Stdio::null()))
    };
    let _peers = [quiet("publish"), quiet("subscribe")];
    let probed = probe_pair("65", 8);
    assert_eq!(probed.texts("incomplete"), "[]");
    assert_eq!(probed.findings(), []);
}

#[test]
fn ends_above_the_maximum_number_of_endpoints() {
    let _hostile = Peer::start("dds_hostile.py", &["66", "endpoints"], &[]);
    let probed = probe("66", 180);
    assert!(probed.texts("incomplete").contains("more than 10000"), "{}", probed.vehicle());
}

#[test]
fn ends_if_a_forged_fragment_claims_a_large_message() {
    let _hostile = Peer::start("dds_hostile.py", &["78", "fragment"], &[]);
    let probed = probe("78", 180);
    assert!(probed.texts("incomplete").contains("more than 2 GiB of memory"), "{}", probed.vehicle());
}

#[test]
fn reports_long_names() {
    let _hostile = Peer::start("dds_hostile.py", &["67", "names"], &[]);
    let probed = probe("67", 5);
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
    let probed = probe_messages("69", 8);
    assert_eq!(probed.findings(), []);
    // The peer receives the messages of a role, and answers them.
    let probed = Probed::with("dds://69", 8, &["--peer", "127.0.0.1", "--as", "component"]);
    assert_eq!((probed.findings(), probed.texts("notes")), (vec![], "[]".to_owned()));
    assert!(probed.covered("PX-EXT-01") > 10, "{}", probed.vehicle());
}
