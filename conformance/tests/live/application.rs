//! Compares an application with a flight controller that uses Cyclone DDS.

use super::dds::CYCLONE;
use super::probe::Probed;
use super::python::Peer;

const FIELDS: [&str; 3] = ["uint64 timestamp", "uint8 request_id", "uint32 valid_registrations_mask"];

/// Compares an application with a flight controller whose `ArmingCheckRequest` has these fields. Allows for the long
/// time that the flight controller takes to start on a busy machine.
fn compare(domain: &str, fields: &[&str], application: &str) -> Probed {
    let arguments = [&[domain], fields].concat();
    let _peer = Peer::start("dds_formats.py", &arguments, &[("CYCLONEDDS_URI", CYCLONE)]);
    let probe = || {
        let arguments = ["--peer", "127.0.0.1", "--application", application];
        Probed::with(&format!("dds://{domain}"), 5, &arguments)
    };
    let mut attempts = (0..5).map(|_| probe());
    attempts.find(|probed| probed.verdict("PX-HASH-02") != "not covered").expect("an answer")
}

#[test]
fn an_application_of_the_same_release_conforms() {
    let probed = compare("92", &FIELDS, "px4@1.18");
    assert_eq!((probed.verdict("PX-HASH-02"), probed.status), ("pass", Some(0)), "{probed:#?}");
}

#[test]
fn an_application_of_another_release_is_found() {
    let probed = compare("93", &FIELDS, "px4@1.15");
    assert_eq!((probed.verdict("PX-HASH-02"), probed.status), ("fail", Some(1)), "{probed:#?}");
}

#[test]
fn definitions_of_no_release_are_compared() {
    let probed = compare("94", &FIELDS[..1], "px4@1.18");
    assert_eq!(probed.verdict("PX-HASH-02"), "fail");
    let message = &probed.vehicle()["findings"][0]["examples"][0]["message"];
    assert!(
        message.to_string().contains("the vehicle uses a definition that matches no known release"),
        "{message}"
    );
}
