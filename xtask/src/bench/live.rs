//! The load of a live vehicle: many large messages over each transport.

use std::ffi::OsStr;
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};
use std::{fs, thread};

use serde_json::Value;

/// A publisher of many messages.
struct Load {
    transport: &'static str,
    address: &'static str,
    /// The port, or the domain.
    port: &'static str,
    ty: &'static str,
    /// The size of a message in bytes.
    size: &'static str,
}

/// A type that no rule checks.
const UNKNOWN: &str = "load_msgs/msg/Load";

const LOADS: [Load; 4] = [
    Load { transport: "dds", address: "dds://88", port: "88", ty: UNKNOWN, size: "1336" },
    Load {
        transport: "dds",
        address: "dds://89",
        port: "89",
        ty: "px4_msgs/msg/EstimatorStates",
        size: "220",
    },
    Load { transport: "zenoh", address: "zenoh://127.0.0.1:17447", port: "17447", ty: UNKNOWN, size: "1336" },
    Load {
        transport: "foxglove",
        address: "foxglove://127.0.0.1:18765",
        port: "18765",
        ty: UNKNOWN,
        size: "1336",
    },
];

/// The number of topics, and the rate of each in Hz.
const TOPICS: [&str; 2] = ["60", "250"];

/// The duration of the load in seconds, and the longer duration of the probe.
const SECONDS: [&str; 2] = ["20", "26"];

/// The time between two readings of the memory.
const INTERVAL: Duration = Duration::from_millis(250);

/// The settings of Cyclone DDS: only the loopback interface, without multicast.
const CYCLONE: &str = "<CycloneDDS><Domain>\
    <General><Interfaces><NetworkInterface address='127.0.0.1'/></Interfaces><AllowMulticast>false</AllowMulticast></General>\
    <Discovery><ParticipantIndex>auto</ParticipantIndex><Peers><Peer address='127.0.0.1'/></Peers></Discovery>\
    </Domain></CycloneDDS>";

/// The Python interpreter of the publisher, in the environment that the tests of the transports create.
const PYTHON: &str = "target/live-peers/bin/python";

/// Prints the losses, the processor time and the memory of a probe.
pub(super) fn run() -> Result<(), String> {
    if !Path::new(PYTHON).exists() {
        let help = "cargo test -p uavspec --features live --test live";
        return Err(format!("{PYTHON} doesn't exist\n  help: run {help}"));
    }
    let program = super::program("live")?;
    let [topics, rate] = TOPICS;
    println!("{topics} topics, {rate} Hz each, {} s, one core each", SECONDS[0]);
    println!(
        "transport    bytes  judged    sent      received  lost    CPU      memory at 25, 50, 75 and 100 % of the time"
    );
    LOADS.iter().try_for_each(|load| measure(&program, load))
}

fn measure(program: &OsStr, load: &Load) -> Result<(), String> {
    let Load { transport, address, size, .. } = load;
    let (mut publisher, mut output) = start_publisher(load)?;
    let report = format!("target/live-load-{transport}.json");
    let mut probe = on_core("0", program);
    probe.args(["probe", address, "--for", SECONDS[1]]);
    if *transport == "dds" {
        probe.args(["--peer", "127.0.0.1"]);
    }
    probe.args(["--report", &format!("json={report}")]).stdout(Stdio::null());
    let mut probe = probe.spawn().map_err(|error| format!("cannot run uavspec: {error}"))?;
    thread::sleep(Duration::from_secs(3));
    if let Some(input) = &mut publisher.stdin {
        input.write_all(b"\n").map_err(|error| error.to_string())?;
    }
    let usage = watch(&mut probe)?;
    let mut sent = String::new();
    output.read_line(&mut sent).map_err(|error| error.to_string())?;
    let _ = publisher.wait();
    let sent: u64 = sent.split(' ').next().and_then(|count| count.parse().ok()).unwrap_or_default();
    let report = fs::read(&report).map_err(|error| error.to_string())?;
    let report: Value = serde_json::from_slice(&report).map_err(|error| error.to_string())?;
    let records = &report["subjects"][0]["coverage"]["records"];
    let [received, judged] = ["total", "checked"].map(|part| records[part].as_u64().unwrap_or_default());
    let memory: Vec<String> = (1..=4)
        .filter_map(|part| usage.memory.get((usage.memory.len() * part / 4).saturating_sub(1)))
        .map(|kilobytes| format!("{} MB", kilobytes / 1_000))
        .collect();
    let (lost, time) = (sent.saturating_sub(received), usage.time.as_secs_f64());
    println!(
        "{transport:<12} {size:<6} {judged:<9} {sent:<9} {received:<9} {lost:<7} {time:<6.2} s {}",
        memory.join(", ")
    );
    Ok(())
}

/// Starts a publisher, waits until it is ready, and returns its process and its output.
fn start_publisher(load: &Load) -> Result<(Child, BufReader<ChildStdout>), String> {
    let mut command = on_core("1", PYTHON);
    let Load { transport, port, ty, size, .. } = *load;
    command.arg("conformance/tests/live/peers/load.py").args([transport, port, ty]).args(TOPICS);
    command.args([size, SECONDS[0]]);
    command.env("CYCLONEDDS_URI", CYCLONE).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut publisher = command.spawn().map_err(|error| format!("cannot run {PYTHON}: {error}"))?;
    let mut output = BufReader::new(publisher.stdout.take().ok_or("the publisher has no output")?);
    let mut ready = String::new();
    output.read_line(&mut ready).map_err(|error| error.to_string())?;
    if ready.trim() == "ready" { Ok((publisher, output)) } else { Err(format!("{transport}: no publisher")) }
}

/// A command that runs on a single core.
fn on_core(core: &str, program: impl AsRef<OsStr>) -> Command {
    let mut command = Command::new("taskset");
    command.args(["--cpu-list", core]).arg(program);
    command
}

/// The resources that a process used.
#[derive(Default)]
struct Usage {
    time: Duration,
    /// The resident memory in kB.
    memory: Vec<u64>,
}

/// Measures the resources that a process uses until it ends.
fn watch(child: &mut Child) -> Result<Usage, String> {
    let (folder, mut usage) = (format!("/proc/{}", child.id()), Usage::default());
    let started = Instant::now();
    while child.try_wait().map_err(|error| error.to_string())?.is_none() {
        let status = fs::read_to_string(format!("{folder}/status")).unwrap_or_default();
        let resident = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
        usage
            .memory
            .extend(resident.and_then(|text| text.trim().trim_end_matches(" kB").parse::<u64>().ok()));
        let times = fs::read_to_string(format!("{folder}/stat")).unwrap_or_default();
        // The user time and the system time, in hundredths of a second.
        let ticks = times.rsplit(')').next().unwrap_or_default().split_whitespace().skip(11).take(2);
        let ticks: u64 = ticks.filter_map(|text| text.parse::<u64>().ok()).sum();
        usage.time = usage.time.max(Duration::from_millis(ticks * 10));
        thread::sleep(INTERVAL);
    }
    let status = child.wait().map_err(|error| error.to_string())?;
    if started.elapsed() < INTERVAL { Err(format!("the probe ended early: {status}")) } else { Ok(usage) }
}
