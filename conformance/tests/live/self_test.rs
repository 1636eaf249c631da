//! The self-test of the PX4 references over DDS. The pairs of participants are distributed over several domains on the
//! loopback interface.

use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use super::python::Peer;

fn self_test(buses: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_uavspec"));
    let Output { status, stdout, stderr } =
        command.args(["self-test", "--px4"]).args(buses).output().expect("the program runs");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (status.code(), text(stdout), text(stderr))
}

#[test]
fn each_bug_is_found_over_dds() {
    let domains: Vec<String> = (31..39).map(|domain| format!("dds://{domain}")).collect();
    let (status, output, errors) = self_test(&domains.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!(status, Some(0), "{output}{errors}");
    for line in [
        "  ok    PX-QOS-01    found\n",
        "  skip  PX-TYPE-01   the bug requires a bus that announces type hashes",
        "\nall checks passed\n",
    ] {
        assert!(output.contains(line), "{output}");
    }
}

#[test]
fn a_bus_with_a_vehicle_is_not_used() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_uavspec"));
    command.args(["serve", "--px4", "dds://39", "--peer", "127.0.0.1", "--for", "60"]);
    let _vehicle = Peer::run(command.stdout(Stdio::null()));
    // The vehicle may start late.
    let end = Instant::now() + Duration::from_secs(600);
    loop {
        let (status, output, errors) = self_test(&["dds://39"]);
        if status == Some(3) {
            assert!(errors.contains("dds://39: the bus is in use"), "{errors}");
            return;
        }
        assert!(Instant::now() < end, "{output}{errors}");
    }
}
