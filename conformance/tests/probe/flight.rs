//! Tests of probes that are interrupted while UAVs obey their commands. A proxy records all requests, and interrupts
//! the probe at a specific request, so no test depends on speed.

use std::path::Path;
use std::process::{Child, Stdio};
use std::sync::Condvar;
use std::sync::atomic::AtomicUsize;

use uavspec_flockwave::transport::{Received, connect};
use uavspec_test_server::proxy::{Pass, Proxy, Watch};
use uavspec_test_support::deadline;
#[cfg(unix)]
use uavspec_test_support::send_signal;

use super::*;

pub(super) const UAV: &str = "glider-2";

/// The time limit for events that are certain to happen.
const PATIENCE: Duration = Duration::from_secs(600);

/// The error codes of a UAV that is on the ground, has running motors, or is asleep.
pub(super) const GROUND: u64 = 1;
pub(super) const MOTORS: u64 = 8;
pub(super) const SLEEP: u64 = 9;

/// A flag that one thread sets and another thread waits for.
#[derive(Clone, Default)]
struct Flag(Arc<(Mutex<bool>, Condvar)>);

impl Flag {
    fn raise(&self) {
        *self.0.0.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.0.1.notify_all();
    }

    fn wait(&self) {
        let raised = self.0.0.lock().unwrap_or_else(PoisonError::into_inner);
        let waited = self.0.1.wait_timeout_while(raised, PATIENCE, |raised| !*raised);
        assert!(*waited.unwrap_or_else(PoisonError::into_inner).0, "nothing happened");
    }
}

/// The requests that passed a proxy, in order.
#[derive(Clone, Default)]
pub(super) struct Requests(Arc<Mutex<Vec<Value>>>);

impl Requests {
    /// Records the requests in a segment, and returns their types.
    pub(super) fn take(&self, bytes: &[u8]) -> Vec<String> {
        let text = String::from_utf8_lossy(bytes);
        let starts = text.match_indices(r#"{"$fw.version""#).map(|(at, _)| at);
        let mut types = Vec::new();
        for start in starts {
            let mut values = serde_json::Deserializer::from_str(&text[start..]).into_iter::<Value>();
            let Some(Ok(message)) = values.next() else { continue };
            types.extend(message["body"]["type"].as_str().map(str::to_owned));
            self.0.lock().unwrap_or_else(PoisonError::into_inner).push(message["body"].clone());
        }
        types
    }

    fn all(&self) -> Vec<Value> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    pub(super) fn types(&self) -> Vec<String> {
        self.all().iter().filter_map(|body| body["type"].as_str().map(str::to_owned)).collect()
    }

    /// The types of the requests after the first request of this type.
    pub(super) fn after(&self, type_name: &str) -> Vec<String> {
        let types = self.types();
        let first = types.iter().position(|name| name == type_name).expect(type_name);
        types[first + 1..].to_vec()
    }
}

/// Options for a proxy that records all requests, and calls a function for each request.
fn recording(requests: &Requests, at: impl Fn(&str) -> Pass + Send + Sync + 'static) -> Watch {
    let requests = requests.clone();
    Arc::new(move |bytes| {
        let passes: Vec<Pass> = requests.take(bytes).iter().map(|name| at(name)).collect();
        passes.into_iter().find(|pass| *pass != Pass::Forward).unwrap_or(Pass::Forward)
    })
}

/// The state of the UAV on the server: its height above home in mm, and its error codes.
pub(super) fn state(server: &Server) -> (i64, Vec<u64>) {
    let url = server.listening()[0].to_string();
    let endpoint: Endpoint = url.parse().expect("an endpoint");
    let mut client = connect(&endpoint, deadline()).expect("a connection");
    let body = json!({ "type": "UAV-INF", "ids": [UAV] });
    let request = json!({ "$fw.version": "1.0", "id": "state", "body": body });
    client.send(request.to_string().as_bytes()).expect("sent");
    loop {
        let received = client.receive(deadline()).expect("an open connection");
        let Received::Message(text) = received else { panic!("{received:?}") };
        let message: Value = serde_json::from_slice(&text).expect("JSON");
        if message["refs"] == "state" {
            let status = &message["body"]["status"][UAV];
            let codes = status["errors"].as_array().into_iter().flatten().filter_map(Value::as_u64);
            return (status["position"][3].as_i64().expect("an altitude"), codes.collect());
        }
    }
}

/// Asserts that the UAV is awake and on the ground, and that its motors are stopped.
pub(super) fn assert_safe(server: &Server, context: &str) {
    let (height, codes) = state(server);
    assert_eq!((height, codes.contains(&GROUND)), (0, true), "{context}: {codes:?}");
    assert!(!codes.contains(&MOTORS) && !codes.contains(&SLEEP), "{context}: {codes:?}");
}

/// A probe that runs in a child process.
struct Running {
    child: Child,
    /// The standard error output so far.
    errors: Arc<Mutex<String>>,
    reader: thread::JoinHandle<()>,
    /// Set when the probe has noticed the first interrupt.
    noticed: Flag,
}

impl Running {
    /// Starts a probe that may send commands.
    fn flying(url: &str, more: &[&str]) -> Self {
        Self::start(&[&["--allow-commands", "--uav", UAV, url], more].concat())
    }

    fn start(arguments: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_uavspec"))
            .args(["probe", "--for", "0.1", "--no-trials"])
            .args(arguments)
            .env("CLICOLOR_FORCE", "1")
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts");
        let (errors, noticed) = (Arc::new(Mutex::new(String::new())), Flag::default());
        let mut stderr = BufReader::new(child.stderr.take().expect("a pipe"));
        let (shared, flag) = (Arc::clone(&errors), noticed.clone());
        let reader = thread::spawn(move || {
            let mut line = String::new();
            while stderr.read_line(&mut line).is_ok_and(|length| length > 0) {
                shared.lock().unwrap_or_else(PoisonError::into_inner).push_str(&line);
                if line.contains("interrupted") {
                    flag.raise();
                }
                line.clear();
            }
        });
        Self { child, errors, reader, noticed }
    }

    /// Waits for the end. Returns the exit status, standard output and standard error.
    fn wait(self) -> (Option<i32>, String, String) {
        let output = self.child.wait_with_output().expect("it ends");
        self.reader.join().expect("it reads to the end");
        let errors = self.errors.lock().unwrap_or_else(PoisonError::into_inner).clone();
        (output.status.code(), String::from_utf8(output.stdout).expect("UTF-8"), errors)
    }
}

/// A function that can be set after the proxy that calls it has started.
type Hook = Arc<Mutex<Option<Box<dyn Fn() + Send>>>>;

fn call(hook: &Hook) {
    if let Some(act) = &*hook.lock().unwrap_or_else(PoisonError::into_inner) {
        act();
    }
}

/// The options that select only a flight.
pub(super) const FLIGHT: [&str; 12] = [
    "--only",
    "UAV-TAKEOFF",
    "--only",
    "UAV-HOVER",
    "--only",
    "UAV-INF",
    "--only",
    "UAV-FLY",
    "--only",
    "UAV-RTH",
    "--only",
    "UAV-LAND",
];

/// The files that a probe writes.
fn outputs(folder: &Path) -> (String, String) {
    let path = |name: &str| folder.join(name).to_str().expect("UTF-8").to_owned();
    (path("run.jsonl"), path("report.json"))
}

/// Interrupts a probe at the first request of type `point` that follows a request of type `after`. The proxy forwards
/// the request after the interrupt. Returns the requests.
#[cfg(unix)]
fn interrupted_at(
    point: &'static str,
    after: &'static str,
    only: &[&str],
    signals: &'static [nix::sys::signal::Signal],
) -> Requests {
    let (server, _) = reference_server();
    let (requests, hook) = (Requests::default(), Hook::default());
    let is_interrupted = Mutex::new(false);
    let watch = {
        let (requests, hook) = (requests.clone(), Arc::clone(&hook));
        recording(&requests.clone(), move |name| {
            let is_after = after.is_empty() || requests.types().iter().any(|name| name == after);
            let mut is_interrupted = is_interrupted.lock().unwrap_or_else(PoisonError::into_inner);
            if name == point && is_after && !std::mem::replace(&mut *is_interrupted, true) {
                call(&hook);
            }
            Pass::Forward
        })
    };
    let proxy = Proxy { watch: Some(watch), ..Proxy::default() }.start(server.listening()[0].address);
    let folder = tempfile::tempdir().expect("a folder");
    let (record, report) = outputs(folder.path());
    let target = format!("json={report}");
    let arguments = [only, &["--record", &record, "--report", &target]].concat();
    let held = hook.lock().unwrap_or_else(PoisonError::into_inner);
    let running = Running::flying(&format!("tcp://{proxy}"), &arguments);
    let (process, noticed) = (running.child.id(), running.noticed.clone());
    let mut held = held;
    *held = Some(Box::new(move || {
        for signal in signals {
            send_signal(process, *signal);
        }
        noticed.wait();
    }));
    drop(held);
    let (status, printed, errors) = running.wait();
    let context = format!("{point} after {after:?}, {signals:?}: {:?}\n{errors}{printed}", requests.types());
    assert_safe(&server, &context);
    assert_eq!(status, Some(6), "{context}");
    assert!(!errors.contains("may still") || errors.contains("first makes the UAVs safe"), "{context}");
    assert!(!errors.contains("error:"), "{context}");
    let report: Value = serde_json::from_slice(&std::fs::read(report).expect("a report")).expect("JSON");
    assert_eq!(report["outcome"]["status"], 6, "{context}");
    let recording = std::fs::read(record).expect("a recording");
    let replayed = check_capture(&*recording, None, &DEFINITIONS).expect("bytes can be read");
    assert_eq!(replayed.corruption, vec![], "{context}");
    assert_eq!(replayed.findings.groups().count(), 0, "{context}");
    requests
}

#[cfg(unix)]
#[test]
fn an_interrupted_probe_makes_uavs_safe_at_each_point() {
    use nix::sys::signal::Signal::{
        SIGABRT, SIGALRM, SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGUSR1, SIGUSR2, SIGVTALRM, SIGXCPU, SIGXFSZ,
    };
    thread::scope(|scope| {
        // Each request at which the probe is interrupted, with the request that must follow.
        for (point, after, signals, expected) in [
            ("UAV-TAKEOFF", "", &[SIGINT][..], "UAV-LAND"),
            ("UAV-INF", "UAV-TAKEOFF", &[SIGTERM], "UAV-LAND"),
            // The other signals that end programs. Limits and timers repeat them.
            ("UAV-HOVER", "", &[SIGUSR1, SIGUSR2, SIGABRT, SIGVTALRM], "UAV-LAND"),
            ("UAV-FLY", "", &[SIGALRM, SIGXCPU, SIGXFSZ, SIGXCPU], "UAV-LAND"),
            // Tools and terminals that end programs repeat their signal.
            ("UAV-HOVER", "UAV-TAKEOFF", &[SIGINT, SIGTERM, SIGHUP], "UAV-LAND"),
            ("UAV-FLY", "", &[SIGHUP], "UAV-LAND"),
            ("UAV-RTH", "", &[SIGTERM], "UAV-LAND"),
            ("UAV-LAND", "", &[SIGINT], "UAV-INF"),
            ("UAV-INF", "UAV-LAND", &[SIGQUIT], "UAV-INF"),
        ] {
            scope.spawn(move || {
                let requests = interrupted_at(point, after, &FLIGHT, signals);
                let sent = requests.after(point);
                assert!(sent.iter().any(|name| name == expected), "{point}: {sent:?}");
            });
        }
        scope.spawn(|| {
            let requests = interrupted_at("UAV-MOTOR", "", &["--only", "UAV-MOTOR"], &[SIGINT]);
            let motors: Vec<Value> =
                requests.all().into_iter().filter(|body| body["type"] == "UAV-MOTOR").collect();
            assert_eq!(motors.last().expect("a request")["start"], false, "{motors:?}");
        });
        scope.spawn(|| {
            let requests = interrupted_at("UAV-SLEEP", "", &["--only", "UAV-SLEEP"], &[SIGTERM]);
            assert!(requests.after("UAV-SLEEP").contains(&"UAV-WAKEUP".to_owned()));
        });
        scope.spawn(|| {
            let only = ["--only", "UAV-CALIB", "--only", "ASYNC-RESUME", "--only", "UAV-TAKEOFF"];
            let requests = interrupted_at("ASYNC-RESUME", "UAV-CALIB", &only, &[SIGINT]);
            let types = requests.types();
            assert!(types.contains(&"ASYNC-CANCEL".to_owned()), "{types:?}");
            assert!(!types.contains(&"UAV-TAKEOFF".to_owned()), "{types:?}");
        });
        // The last request before the takeoff is a request for the altitude.
        scope.spawn(|| {
            let types = interrupted_at("UAV-INF", "", &["--only", "UAV-TAKEOFF"], &[SIGINT]).types();
            assert!(!types.iter().any(|name| name == "UAV-TAKEOFF" || name == "UAV-LAND"), "{types:?}");
        });
    });
}

/// All output goes to files, and the recording soon reaches the size limit for files.
#[cfg(unix)]
#[test]
fn a_size_limit_of_files_ends_no_flight() {
    let (server, url) = reference_server();
    let folder = tempfile::tempdir().expect("a folder");
    let (record, _) = outputs(folder.path());
    let flown = format!("{} {}", FLIGHT.join(" "), "--for 0.1 --no-trials --allow-commands");
    let probe = format!("ulimit -f 16; exec \"$0\" probe {flown} --uav {UAV} --record \"$1\" \"$2\"");
    let output = Command::new("sh")
        .args(["-c", &probe, env!("CARGO_BIN_EXE_uavspec"), &record, &url])
        .output()
        .expect("it runs");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{errors}");
    assert!(errors.contains("can't write the recording"), "{errors}");
    assert_safe(&server, &errors);
}

/// If no commands were sent, nothing has to be undone.
#[cfg(unix)]
#[test]
fn an_interrupted_probe_without_commands_reports_what_it_has_seen() {
    use nix::sys::signal::Signal::SIGINT;
    // This server never answers one of the requests.
    let reached = Flag::default();
    let flag = reached.clone();
    let url = serve(move |mut stream, _| {
        let reader = BufReader::new(stream.try_clone().expect("a stream"));
        let mut number = 0;
        for line in reader.lines().map_while(Result::ok) {
            if line.contains("SYS-PORTS") {
                flag.raise();
                continue;
            }
            let Some(answer) = answer(line.as_bytes(), &mut number) else { continue };
            if stream.write_all(answer.as_bytes()).is_err() {
                return;
            }
        }
    });
    let running = Running::start(&[&url, "--timeout", "60", "--limit", "300", "--format", "json"]);
    reached.wait();
    send_signal(running.child.id(), SIGINT);
    let (status, printed, errors) = running.wait();
    assert!(errors.contains("interrupted"), "{errors}");
    let report: Value = serde_json::from_str(&printed).expect("JSON");
    let reasons = report["subjects"][0]["incomplete"].to_string();
    assert!(reasons.contains("interrupted: "), "{reasons}");
    // A response that the probe didn't wait for doesn't count as missing.
    assert!(!printed.contains("no response to `SYS-PORTS`"), "{printed}");
    assert!(matches!(status, Some(1 | 6)), "{status:?}");
}

#[cfg(unix)]
#[test]
fn a_second_interrupt_leaves_immediately_and_warns() {
    use nix::sys::signal::Signal::{SIGINT, SIGTERM, SIGXCPU};
    let (server, _) = reference_server();
    let (requests, hook) = (Requests::default(), Hook::default());
    let called = Arc::clone(&hook);
    let watch = recording(&requests, move |name| {
        if matches!(name, "UAV-FLY" | "UAV-LAND") {
            call(&called);
        }
        // The UAV can't land.
        if name == "UAV-LAND" { Pass::Lose } else { Pass::Forward }
    });
    let proxy = Proxy { watch: Some(watch), ..Proxy::default() }.start(server.listening()[0].address);
    let mut held = hook.lock().unwrap_or_else(PoisonError::into_inner);
    let running = Running::flying(&format!("tcp://{proxy}"), &FLIGHT);
    let (process, noticed, count) = (running.child.id(), running.noticed.clone(), AtomicUsize::new(0));
    *held = Some(Box::new(move || match count.fetch_add(1, Ordering::SeqCst) {
        0 => {
            send_signal(process, SIGINT);
            noticed.wait();
        }
        // Limits repeat their signals.
        1..=2 => send_signal(process, SIGXCPU),
        // Only a later signal has an effect. Until then, the command to land is sent repeatedly.
        _ => send_signal(process, SIGTERM),
    }));
    drop(held);
    let (status, printed, errors) = running.wait();
    assert_eq!((status, printed.as_str()), (Some(130), ""), "{errors}");
    let last = errors.lines().last().expect("a line");
    assert!(last.starts_with("\u{1b}[1m\u{1b}[31merror: UAV glider-2 may still be flying"), "{last:?}");
    assert!(state(&server).0 > 0, "the proxy lost the command to land");
    let landings = requests.types().iter().filter(|name| *name == "UAV-LAND").count();
    assert!(landings >= 3, "{landings}");
}

#[cfg(unix)]
#[test]
fn a_probe_with_commands_can_not_be_suspended() {
    use nix::sys::signal::Signal::{SIGINT, SIGTSTP};
    let requests = {
        let (server, _) = reference_server();
        let (requests, hook) = (Requests::default(), Hook::default());
        let called = Arc::clone(&hook);
        let watch = recording(&requests, move |name| {
            if name == "UAV-FLY" {
                call(&called);
            }
            Pass::Forward
        });
        let proxy = Proxy { watch: Some(watch), ..Proxy::default() }.start(server.listening()[0].address);
        let mut held = hook.lock().unwrap_or_else(PoisonError::into_inner);
        let running = Running::flying(&format!("tcp://{proxy}"), &FLIGHT);
        let (process, noticed) = (running.child.id(), running.noticed.clone());
        *held = Some(Box::new(move || {
            send_signal(process, SIGTSTP);
            send_signal(process, SIGINT);
            noticed.wait();
        }));
        drop(held);
        let (status, _, errors) = running.wait();
        assert_eq!(status, Some(6), "{errors}");
        assert!(errors.contains("can't be suspended"), "{errors}");
        assert_safe(&server, &errors);
        requests
    };
    assert!(requests.after("UAV-FLY").contains(&"UAV-LAND".to_owned()));
}

/// The server disappears while the UAV is flying.
#[test]
fn the_last_line_names_uavs_that_may_still_fly() {
    let (server, _) = reference_server();
    let address = server.listening()[0].address;
    let (requests, server) = (Requests::default(), Mutex::new(Some(server)));
    let watch = recording(&requests, move |name| {
        if name == "UAV-HOVER" {
            drop(server.lock().unwrap_or_else(PoisonError::into_inner).take());
            return Pass::Cut;
        }
        Pass::Forward
    });
    let proxy = Proxy { watch: Some(watch), ..Proxy::default() }.start(address);
    let folder = tempfile::tempdir().expect("a folder");
    let (record, report) = outputs(folder.path());
    let target = format!("json={report}");
    let more = [
        "--landing-limit",
        "1",
        "--timeout",
        "1",
        "--allow-incomplete",
        "--record",
        &record,
        "--report",
        &target,
    ];
    let running = Running::flying(&format!("tcp://{proxy}"), &[&FLIGHT[..], &more].concat());
    let (status, printed, errors) = running.wait();
    let last = errors.lines().last().expect("a line");
    assert!(last.starts_with("\u{1b}[1m\u{1b}[31merror: UAV glider-2 may still be flying ("), "{errors:?}");
    assert!(matches!(status, Some(1 | 6)), "{status:?}: {errors}");
    assert!(printed.contains("UAV glider-2 may still be flying"), "{printed}");
    let report: Value = serde_json::from_slice(&std::fs::read(report).expect("a report")).expect("JSON");
    assert!(report["subjects"][0]["incomplete"].to_string().contains("may still be flying"), "{report}");
}
