//! Tests with a Zenoh router in Python, which declares tokens and publishes like `rmw_zenoh`, and with a ROS 2 node
//! that uses hiroz.

use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;
use std::time::{Duration, Instant};
use std::{fs, thread};

use serde_json::json;
use tempfile::NamedTempFile;
use uavspec_rules::definitions::Definitions;
use uavspec_test_support::free_address;

use super::probe::Probed;
use super::python::Peer;

/// The time to listen, in seconds.
const TIME: u32 = 5;

/// A probe of the router. The tests of the router share it.
static PROBED: LazyLock<Probed> = LazyLock::new(|| {
    let definitions = Definitions::built_in();
    let request = definitions.message_of_type("px4/ArmingCheckRequest").expect("defined");
    let (_router, port) = router(&[&definitions.schema.message(request).type_hash]);
    Probed::new(&format!("zenoh://127.0.0.1:{port}"), TIME)
});

/// Starts a router, and waits until it accepts connections. Returns the router and its port.
fn router(arguments: &[&str]) -> (Peer, u16) {
    let port = free_address().port();
    let router = Peer::start("zenoh_router.py", &[&[&*port.to_string()], arguments].concat(), &[]);
    let end = Instant::now() + Duration::from_secs(600);
    while TcpStream::connect(("127.0.0.1", port)).is_err() {
        assert!(Instant::now() < end, "the router doesn't start");
        thread::sleep(Duration::from_millis(50));
    }
    (router, port)
}

fn messages(topic: &str) -> u64 {
    let topic = PROBED.topic(&format!("/fmu/out/{topic}"));
    topic["messages"].as_u64().unwrap_or_else(|| panic!("{topic}"))
}

#[test]
fn messages_are_checked() {
    let request = PROBED.topic("/fmu/out/request");
    assert_eq!((&request["encoding"], &request["result"]), (&"cdr".into(), &"equal".into()), "{request}");
    assert!(messages("request") > 10);
    assert!(messages("corrupt") > 10);
    assert_eq!(PROBED.verdict("PX-CDR-02"), "fail", "{PROBED:#?}");
    assert_eq!(PROBED.status, Some(1));
}

#[test]
fn stored_messages_are_received() {
    assert_eq!(messages("latched"), 1);
}

#[test]
fn types_without_hashes_are_received() {
    assert!(messages("humble") > 10);
}

#[test]
fn only_differences_that_matter_are_found() {
    assert_eq!(PROBED.verdict("PX-TYPE-01"), "fail");
    // In rmw_zenoh, a reliable subscriber also receives messages from a best-effort publisher.
    assert_eq!(PROBED.verdict("PX-QOS-01"), "not covered");
}

#[test]
fn losses_and_unreadable_tokens_are_reported() {
    let text = PROBED.vehicle().to_string();
    for expected in
        ["found no node id", "found `ZZ`", "reliability", "found `*`", "expected at most 2048 bytes"]
    {
        assert!(text.contains(expected), "{expected}: {text}");
    }
    assert!(text.contains("/fmu/out/types: ignored messages of px4_msgs/msg/ArmingCheckRequest"), "{text}");
    assert!(text.contains("2 messages of /fmu/out/gaps were lost"), "{text}");
}

/// A ROS 2 node that uses hiroz and takes part in arming checks as the flight controller, with its router.
struct Hiroz {
    _peers: [Peer; 2],
    address: String,
    output: NamedTempFile,
}

impl Hiroz {
    fn start() -> Self {
        let (router, port) = router(&[]);
        let output = NamedTempFile::new().expect("a file");
        let mut command = Command::new(hiroz());
        command.arg(format!("tcp/127.0.0.1:{port}")).stdout(output.reopen().expect("a file"));
        let peers = [router, Peer::run(&mut command)];
        Self { _peers: peers, address: format!("zenoh://127.0.0.1:{port}"), output }
    }

    /// Probes until messages arrive, because the node takes long to start on a busy machine.
    fn probe(&self, arguments: &[&str]) -> Probed {
        let mut attempts = (0..5).map(|_| Probed::with(&self.address, TIME, arguments));
        attempts.find(|probed| probed.vehicle()["records"].as_u64() > Some(10)).expect("messages of the node")
    }
}

/// The program of the node, in `target/live-peers`.
fn hiroz() -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (source, target) =
        (folder.join("tests/live/peers/hiroz/Cargo.toml"), folder.join("../target/live-peers/hiroz"));
    let mut build = Command::new(env!("CARGO"));
    build
        .args(["build", "--quiet", "--locked", "--manifest-path"])
        .arg(source)
        .arg("--target-dir")
        .arg(&target)
        // The node compiles faster.
        .env("CARGO_PROFILE_DEV_OPT_LEVEL", "0");
    let status = build.status().unwrap_or_else(|error| panic!("{build:?}: {error}"));
    assert!(status.success(), "can't build the node with hiroz: {build:?} failed: {status}");
    target.join("debug/uavspec-hiroz-peer")
}

/// hiroz has independent code that computes type hashes and encodes messages.
#[test]
fn a_node_with_hiroz_is_discovered_and_checked() {
    let probed = Hiroz::start().probe(&[]);
    let bus = probed.vehicle()["bus"].as_array().expect("topics");
    let find = |name: &str| bus.iter().find(|topic| topic["topic"] == name).expect("the topic");
    let output = find("/fmu/out/arming_check_request_v1");
    let definitions = Definitions::built_in();
    let request = definitions.message_of_type("px4/ArmingCheckRequest").expect("defined");
    assert_eq!(output["type_hash"], *definitions.schema.message(request).type_hash);
    assert_eq!(output["type"], "px4_msgs/msg/ArmingCheckRequest");
    let qos = "best effort, transient local, keep last 1";
    assert_eq!(output["publishers"], json!([{ "node": "/hiroz_px4", "qos": qos }]));
    let input = find("/fmu/in/register_ext_component_request");
    assert_eq!(input["subscribers"], json!([{ "node": "/hiroz_px4", "qos": qos }]));
    assert_eq!(input["type"], "px4_msgs/msg/RegisterExtComponentRequest");
    assert_eq!(probed.topic("/fmu/out/arming_check_request_v1")["result"], "equal", "{probed:#?}");
    assert_eq!(probed.verdict("PX-CDR-02"), "pass", "{probed:#?}");
    assert_eq!(probed.vehicle()["findings"], json!([]), "{probed:#?}");
}

#[test]
fn a_node_with_hiroz_receives_messages_of_a_role() {
    let node = Hiroz::start();
    node.probe(&["--as", "component"]);
    let output = fs::read_to_string(&node.output).expect("the output");
    for expected in ["uavspec probe api 1 check true\n", "uavspec probe 2 api 1 check true\n"] {
        assert!(output.contains(expected), "{output}");
    }
}
