//! A Zenoh router in Python, which declares tokens and publishes like `rmw_zenoh`.

use std::net::{TcpListener, TcpStream};
use std::sync::LazyLock;
use std::thread;
use std::time::{Duration, Instant};

use uavspec_conformance::definitions::Definitions;

use super::probe::Probed;
use super::python::Peer;

/// The time to listen, in seconds.
const TIME: u32 = 5;

/// The probe of the router, which all tests share.
static PROBED: LazyLock<Probed> = LazyLock::new(|| {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = listener.local_addr().expect("an address").port();
    drop(listener);
    let definitions = Definitions::built_in();
    let request = definitions.message_of_type("px4/ArmingCheckRequest").expect("defined");
    let hash = &definitions.schema.message(request).type_hash;
    let _router = Peer::start("zenoh_router.py", &[&port.to_string(), hash], &[]);
    let end = Instant::now() + Duration::from_secs(60);
    while TcpStream::connect(("127.0.0.1", port)).is_err() {
        assert!(Instant::now() < end, "the router doesn't start");
        thread::sleep(Duration::from_millis(50));
    }
    Probed::new(&format!("zenoh://127.0.0.1:{port}"), TIME)
});

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
    // rmw_zenoh connects a reliable subscriber to a best effort publisher.
    assert_eq!(PROBED.verdict("PX-QOS-01"), "not exercised");
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
