//! Tests that the defmt decoder can read logged messages. A separate program logs values in the format of a device. The
//! decoder combines the program's output with the program's format strings.

// Other systems need a different linker script.
#![cfg(all(target_os = "linux", target_arch = "x86_64"))]

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use defmt_decoder::Table;

const TARGET: &str = "x86_64-unknown-linux-gnu";

#[test]
fn the_decoder_displays_names_and_values() {
    let (program, frames) = run();
    let table = Table::parse(&program).expect("valid format strings").expect("a section of format strings");
    let mut decoder = table.new_stream_decoder();
    decoder.received(&frames);
    let mut lines = Vec::new();
    while let Ok(frame) = decoder.decode() {
        lines.push(frame.display_message().to_string());
    }
    assert_eq!(lines.len(), 7, "{lines:?}");
    let ones = ["1"; 25].join(", ");
    assert_eq!(
        lines[0],
        format!("Event {{ timestamp: 0, id: 7, event_sequence: 0, arguments: [{ones}], log_levels: 0 }}")
    );
    assert_eq!(
        lines[1],
        "RegisterExtComponentReply { timestamp: 0, request_id: 0, name: \"Land\", px4_ros2_api_version: 0, \
         success: true, arming_check_id: 0, mode_id: -3, mode_executor_id: 0 }"
    );
    assert!(lines[2].contains("name: b\"\\xff\\xff"), "{}", lines[2]);
    assert_eq!(lines[3], "CRITICAL 0x8002 200");
    for part in ["BatteryStatus { ", "warning: CRITICAL", "faults: 0x8002", "temperature: NaN"] {
        assert!(lines[4].contains(part), "{}", lines[4]);
    }
    assert_eq!(lines[5], "199 LOWBAT 65602 fatal");
    assert_eq!(lines[6], "7 {x} 8");
}

/// Builds and runs the program. Returns its executable and its output.
fn run() -> (Vec<u8>, Vec<u8>) {
    let repository = fs::canonicalize(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..")).expect("a path");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("log");
    fs::create_dir_all(folder.join("src")).expect("a folder");
    let generated = repository.join("generated");
    let manifest = format!(
        "[package]\nname = \"log\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[dependencies]\ndefmt = {{ version = \"1\", \
         features = [\"encoding-raw\"] }}\nuavspec-types = {{ path = \"{}\", features = [\"defmt\"] }}\nuavspec-runtime = {{ \
         path = \"{}\" }}\n\n[workspace]\n",
        generated.display(),
        generated.join("runtime").display()
    );
    fs::write(folder.join("Cargo.toml"), manifest).expect("a file");
    fs::copy(repository.join("Cargo.lock"), folder.join("Cargo.lock")).expect("a lock file");
    fs::write(folder.join("src/main.rs"), include_str!("log/device.rs")).expect("a file");
    fs::write(folder.join("build.rs"), include_str!("log/build.rs")).expect("a file");
    fs::write(folder.join("host.x"), include_str!("log/host.x")).expect("a file");
    // With an explicit target, the flags don't apply to build scripts and macros.
    let output = Command::new(env!("CARGO"))
        .args(["build", "--quiet", "--target", TARGET])
        .current_dir(&folder)
        .env("CARGO_TARGET_DIR", folder.join("target"))
        .env("CARGO_NET_OFFLINE", "true")
        .env("RUSTFLAGS", "-C relocation-model=static")
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let program = folder.join("target").join(TARGET).join("debug/log");
    let output = Command::new(&program).stderr(Stdio::inherit()).output().expect("the program runs");
    assert!(output.status.success());
    (fs::read(program).expect("the program"), output.stdout)
}
