//! Tests of the probe, with conforming and faulty servers. Most servers are in memory and in simulated time, so the
//! speed of the computer doesn't matter.

#[cfg_attr(not(unix), allow(dead_code, unused_imports, reason = "only tests with signals use them"))]
mod flight;
mod landing;
mod proxied;
mod secrets;
mod stopped;

use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::process::Command;
use std::rc::Rc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use serde_json::{Value, json};
use uavspec_check::check_capture;
use uavspec_flockwave::transport::{Endpoint, Network};
use uavspec_model::clock::Clock;
use uavspec_probe::{Options, Probed, RequestType, Selection, Stop, probe, probe_on};
use uavspec_rules::definitions::Definitions;
use uavspec_rules::flockwave;
use uavspec_serve::{self, InMemory, Server, Transport};
use uavspec_test_server::memory::{Line, Scripted};

static DEFINITIONS: LazyLock<Definitions> = LazyLock::new(Definitions::built_in);

/// The URL of every server in memory.
static ENDPOINT: LazyLock<Endpoint> = LazyLock::new(|| "tcp://memory:5001".parse().expect("an endpoint"));

/// The time by which a probe may exceed its time limit, to finish its last requests.
const SLACK: Duration = Duration::from_secs(15);

/// Options of a short probe.
fn short_options() -> Options {
    Options {
        limit: Duration::from_secs(8),
        timeout: Duration::from_secs(2),
        ..Options::new(Duration::from_millis(200), None, Vec::new())
    }
}

/// A shared buffer.
#[derive(Clone, Default)]
struct Shared(Arc<Mutex<Vec<u8>>>);

impl std::io::Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// Probes a server, and asserts that a check of the recording has the same findings.
fn probed(url: &str, options: &Options) -> Probed {
    let endpoint: Endpoint = url.parse().expect("an endpoint");
    compared(|tape| probe(&endpoint, options, &DEFINITIONS, Some(tape), &|_, _| {}))
}

/// Probes a server in simulated time, and asserts that the probe ends in time.
fn simulated<N: Network>(options: Options, network: impl FnOnce(&Clock) -> N) -> Probed {
    let clock = Clock::simulated();
    let (network, began) = (network(&clock), clock.now());
    let options = Options { clock: clock.clone(), ..options };
    let probed = compared(|tape| probe_on(&network, &ENDPOINT, &options, &DEFINITIONS, Some(tape)));
    assert!(
        clock.now() - began < options.limit + options.observe + SLACK,
        "the probe exceeds its time limit"
    );
    probed
}

/// Probes a server that handles clients with a script.
fn scripted(options: Options, script: impl Fn(&mut Line, &[u8]) + 'static) -> Probed {
    simulated(options, |clock| Scripted::new(clock, script))
}

/// Probes a reference server. The recording is also written to `copy`.
fn referenced(options: Options, served: uavspec_serve::Options, copy: &Shared) -> Probed {
    let clock = Clock::simulated();
    let network = InMemory::new(served, &clock);
    let copy: Box<dyn std::io::Write> = Box::new(copy.clone());
    probe_on(&network, &ENDPOINT, &Options { clock, ..options }, &DEFINITIONS, Some(copy))
}

/// Runs a probe, and asserts that a check of the recording has the same findings.
fn compared(probe: impl FnOnce(Box<dyn std::io::Write>) -> Probed) -> Probed {
    let tape = Shared::default();
    let probed = probe(Box::new(tape.clone()));
    assert!(probed.unrecorded.is_none());
    let recording = tape.0.lock().unwrap_or_else(PoisonError::into_inner).clone();
    let replayed = check_capture(&*recording, None, &DEFINITIONS).expect("bytes can be read");
    let summary = |result: &uavspec_check::CaptureResult| -> Vec<String> {
        result.findings.groups().map(|group| format!("{group:?}")).collect()
    };
    assert_eq!(summary(&replayed), summary(&probed.result));
    assert_eq!(probed.result.corruption, vec![], "the recording is readable");
    probed
}

/// The number of violations per rule.
fn violations(probed: &Probed) -> BTreeMap<&'static str, u64> {
    let mut counts = BTreeMap::new();
    for group in probed.result.findings.groups() {
        *counts.entry(group.rule.id).or_default() += group.count;
    }
    counts
}

/// The violated rules.
fn rules(probed: &Probed) -> BTreeSet<&'static str> {
    violations(probed).into_keys().collect()
}

/// Serves each TCP connection in a separate thread, and returns the URL.
fn serve(serve: impl Fn(TcpStream, usize) + Clone + Send + 'static) -> String {
    let listener = TcpListener::bind(SocketAddr::from(([127, 0, 0, 1], 0))).expect("a free port");
    let address = listener.local_addr().expect("an address");
    thread::spawn(move || {
        for (number, stream) in listener.incoming().enumerate() {
            let (Ok(stream), serve) = (stream, serve.clone()) else { return };
            thread::spawn(move || serve(stream, number));
        }
    });
    format!("tcp://{address}")
}

/// The answer of a minimal server, which rejects most requests.
fn answer(line: &[u8], number: &mut u64) -> Option<String> {
    let message: Value = serde_json::from_slice(line).ok()?;
    *number += 1;
    let id = message["id"].as_str()?;
    let body = match message["body"]["type"].as_str() {
        Some("SYS-PING") => json!({ "type": "ACK-ACK" }),
        Some("SYS-VER") => json!({ "type": "SYS-VER", "software": "Lull", "version": "1.0" }),
        Some("UAV-LIST" | "OBJ-LIST" | "CONN-LIST" | "CLK-LIST") => {
            json!({ "type": message["body"]["type"], "ids": [] })
        }
        _ => json!({ "type": "ACK-NAK", "reason": "too calm" }),
    };
    let answer = json!({ "$fw.version": "1.0", "id": format!("calm-{number}"), "refs": id, "body": body });
    Some(format!("{answer}\n"))
}

/// Answers each line of a segment.
fn answer_all(line: &Line, segment: &[u8]) {
    for answer in answers(segment) {
        line.send(answer);
    }
}

/// The answers to the lines of a segment.
fn answers(segment: &[u8]) -> Vec<String> {
    static NUMBER: AtomicU64 = AtomicU64::new(0);
    let mut number = NUMBER.fetch_add(100, Ordering::Relaxed);
    segment.split(|byte| *byte == b'\n').filter_map(|line| answer(line, &mut number)).collect()
}

/// Answers HTTP POST requests with message bodies that have no envelope. Treats a malformed message as a ping.
fn post_bare(stream: &TcpStream) -> Option<()> {
    let (mut reader, mut writer) = (BufReader::new(stream), stream);
    loop {
        let mut length = 0;
        for line in reader.by_ref().lines() {
            let line = line.ok()?.to_ascii_lowercase();
            if let Some(value) = line.strip_prefix("content-length:") {
                length = value.trim().parse().ok()?;
            }
            if line.is_empty() {
                break;
            }
        }
        let mut content = vec![0; length];
        reader.read_exact(&mut content).ok()?;
        let body = answer(&content, &mut 0).map_or(json!({ "type": "ACK-ACK" }), |text| {
            let answer: Value = serde_json::from_str(&text).expect("JSON");
            answer["body"].clone()
        });
        let body = body.to_string();
        write!(writer, "HTTP/1.1 200 OK\r\nContent-Length: {}\r\n\r\n{body}", body.len()).ok()?;
    }
}

/// Some trials send a message without an id before a request. Over HTTP, each message gets a separate answer.
#[test]
fn matches_http_answers_without_envelopes_to_their_requests() {
    let url = serve(|stream, _| {
        let _ = post_bare(&stream);
    })
    .replace("tcp://", "http://");
    let probed = probed(&url, &Options { limit: Duration::from_secs(60), ..short_options() });
    assert_eq!(probed.failure, None);
    let found = rules(&probed);
    assert!(!found.contains("FW-ENV-16"), "{found:?}");
}

#[test]
fn reports_a_refused_connection() {
    let probed = simulated(short_options(), |clock| Scripted::new(clock, |_, _| {}).accepting(0));
    assert!(probed.failure.expect("a reason").starts_with("can't connect"));
    assert_eq!(probed.result.checked, 0);
}

#[test]
fn ends_in_time_with_a_silent_server() {
    let probed = scripted(short_options(), |_, _| {});
    let failure = probed.failure.as_deref().expect("a reason");
    assert_eq!(failure, "this is not a Flockwave server: no answer to SYS-VER within 2 s");
    assert_eq!(violations(&probed), BTreeMap::new());
}

/// A proxy may close connections until the server behind it has started. Early requests then get no answer.
#[test]
fn waits_until_a_starting_server_answers() {
    let selection = Selection::default().without_trials();
    let options = Options { limit: Duration::from_secs(20), selection, ..short_options() };
    let probed = scripted(options, |line, segment| match segment {
        b"" => {}
        _ if line.number < 3 => line.end(line.number),
        _ => answer_all(line, segment),
    });
    assert_eq!((probed.failure.as_deref(), probed.cut_short.as_deref()), (None, None));
    assert!(!rules(&probed).contains("FW-ENV-07"), "{:?}", trials(&probed));
}

/// Servers that use other protocols violate no Flockwave rule.
#[test]
fn recognises_servers_of_other_protocols() {
    let tls_alert: &[u8] = &[0x15, 3, 3, 0, 2, 2, 70, b'\n'];
    for (greeting, expected) in [
        (&b"HTTP/1.1 400 Bad Request\r\nConnection: close\r\n\r\n<html>\r\n"[..], "http://"),
        (tls_alert, "TLS"),
        (b"SSH-2.0-OpenSSH_9.6\r\n", "SSH-2.0"),
        (b"{\"jsonrpc\":\"2.0\",\"id\":\"probe-1\"}\n", "jsonrpc"),
    ] {
        let probed = scripted(short_options(), move |line, segment| {
            if segment.is_empty() {
                line.send(greeting);
            }
        });
        let failure = probed.failure.as_deref().expect("a reason");
        assert!(failure.starts_with("this is not a Flockwave server: "), "{failure}");
        assert!(failure.contains(expected), "{failure}");
        assert_eq!(violations(&probed), BTreeMap::new());
    }
}

/// A script that sends the same bytes `count` times, with pauses.
fn repeated(bytes: &'static [u8], pause: Duration, count: usize) -> impl Fn(&mut Line, &[u8]) {
    move |line, segment| {
        for _ in 0..if segment.is_empty() { count } else { 0 } {
            line.send_after(pause, bytes);
        }
    }
}

#[test]
fn reports_garbage_and_ends_in_time() {
    let garbage = b"\xff\xfe wind \x00\n{\"half\n[[[[\n";
    let probed = scripted(short_options(), repeated(garbage, Duration::from_millis(20), 3_000));
    let failure = probed.failure.as_deref().expect("a reason");
    assert!(failure.starts_with("this is not a Flockwave server: it sent "), "{failure}");
    assert_eq!(rules(&probed), BTreeSet::new());
}

#[test]
fn ends_in_time_with_slow_bytes() {
    let probed = scripted(short_options(), repeated(b"x", Duration::from_secs(1), 60));
    let failure = probed.failure.as_deref().expect("a reason");
    assert!(failure.starts_with("this is not a Flockwave server: "), "{failure}");
    assert_eq!(rules(&probed), BTreeSet::new());
}

#[test]
fn ends_in_time_with_an_endless_line() {
    let piece = vec![b'x'; 1 << 16];
    let url = serve(move |mut stream, _| while stream.write_all(&piece).is_ok() {});
    let probed = probed(&url, &short_options());
    let failure = probed.failure.as_deref().expect("a reason");
    assert!(failure.starts_with("this is not a Flockwave server: "), "{failure}");
    assert_eq!(rules(&probed), BTreeSet::new());
}

#[test]
fn ends_in_time_with_many_notifications() {
    let one = br#"{"$fw.version":"1.0","id":"same","body":{"type":"SYS-MSG","items":[{"message":"gust"}]}}
"#;
    let probed = scripted(short_options(), repeated(one, Duration::from_millis(2), 30_000));
    assert_eq!(rules(&probed), BTreeSet::from(["FW-ENV-04", "FW-ENV-07"]));
}

#[test]
fn a_slow_server_runs_out_of_time_without_a_finding() {
    let options = Options { limit: Duration::from_secs(4), ..short_options() };
    let probed = scripted(options, |line, segment| {
        for answer in answers(segment) {
            line.send_after(Duration::from_millis(900), answer);
        }
    });
    assert_eq!(probed.failure, None);
    let reason = probed.cut_short.as_deref().expect("a reason");
    assert!(reason.starts_with("out of time: "), "{reason}");
    let is_late = |entry: &&RequestType| entry.not_sent.as_deref() == Some("out of time");
    assert!(probed.requests.iter().filter(is_late).count() > 10);
    assert!(!rules(&probed).iter().any(|rule| ["FW-ENV-07", "FW-ENV-19", "FW-ENV-27"].contains(rule)));
}

#[test]
fn waits_for_late_answers() {
    let selection = Selection::default().without_trials();
    let (limit, timeout) = (Duration::from_secs(30), Duration::from_secs(5));
    let count = Cell::new(0);
    // One answer takes longer than the time after which the probe sends its next request.
    let probed = scripted(Options { limit, timeout, selection, ..short_options() }, move |line, segment| {
        for answer in answers(segment) {
            let number = count.replace(count.get() + 1);
            line.send_after(Duration::from_secs(if number == 10 { 3 } else { 0 }), answer);
        }
    });
    assert_eq!((probed.failure.as_deref(), probed.cut_short.as_deref()), (None, None));
    assert!(!rules(&probed).contains("FW-ENV-07"), "{:?}", trials(&probed));
}

/// Probes a scripted server, with only these rules.
fn tried(rules: &[&str], script: impl Fn(&mut Line, &[u8]) + 'static) -> Probed {
    let probed = scripted(trying(rules), script);
    assert_eq!((probed.failure.as_deref(), probed.cut_short.as_deref()), (None, None));
    probed
}

/// Options that select only these rules.
fn trying(rules: &[&str]) -> Options {
    let only = rules.iter().map(|rule| (*rule).to_owned()).collect();
    let selection = Selection::new(only, Vec::new(), &DEFINITIONS, &ENDPOINT).expect("known rules");
    Options { limit: Duration::from_secs(45), selection, ..short_options() }
}

/// A server may handle requests one after the other. Each answer is in time, but not all of them together.
#[test]
fn waits_for_the_answers_to_requests_that_were_sent_together() {
    let probed = tried(&["FW-TCP-02", "FW-ENV-27"], |line, segment| {
        // The requests of trials have different ids.
        let is_trial = !String::from_utf8_lossy(segment).contains("\"probe-");
        for answer in answers(&line.lines(segment)) {
            line.send_after(Duration::from_millis(if is_trial { 1_300 } else { 0 }), answer);
        }
    });
    assert_eq!(rules(&probed), BTreeSet::new());
}

/// True if a segment is the first one in the trials that send lines which aren't JSON.
fn is_confusing(segment: &[u8]) -> bool {
    segment.starts_with(b"not a message")
}

/// Answers each request until a line isn't JSON. Afterwards, the connection stays open, but nothing is answered on it.
fn answer_until_confused(line: &mut Line, confused: &RefCell<BTreeSet<usize>>, segment: &[u8]) {
    if is_confusing(segment) {
        confused.borrow_mut().insert(line.number);
        line.idle_limit = None;
    }
    if !confused.borrow().contains(&line.number) {
        answer_all(line, segment);
    }
}

/// A server may close idle connections, even while a trial waits for its answer.
#[test]
fn the_end_of_an_idle_connection_is_no_effect_of_a_trial() {
    let confused = RefCell::default();
    let probed = tried(&["FW-TCP-03", "FW-ENV-27"], move |line, segment| {
        if segment.is_empty() {
            line.idle_limit = Some(Duration::from_secs(1));
        }
        answer_until_confused(line, &confused, segment);
    });
    assert_eq!(rules(&probed), BTreeSet::from(["FW-TCP-03"]));
}

/// A server may serve only the latest connection.
#[test]
fn the_end_of_an_older_connection_is_no_effect_of_a_trial() {
    let confused = RefCell::default();
    let probed = tried(&["FW-TCP-03", "FW-ENV-27"], move |line, segment| {
        if segment.is_empty() {
            (0..line.number).for_each(|older| line.end(older));
        }
        answer_until_confused(line, &confused, segment);
    });
    assert_eq!(rules(&probed), BTreeSet::from(["FW-TCP-03"]));
}

/// The end of a connection closes all older connections. The server must not be mistaken for one that serves a single
/// client, or that closes idle connections.
#[test]
fn reports_a_server_that_closes_the_connections_of_other_clients() {
    let found = rules(&tried(&["FW-TCP-03", "FW-ENV-27"], |line, segment| {
        if is_confusing(segment) {
            (0..=line.number).for_each(|older| line.end(older));
        }
        answer_all(line, segment);
    }));
    assert_eq!(found, BTreeSet::from(["FW-ENV-27", "FW-TCP-03"]));
}

/// An interrupted probe can't find out whether the server closes idle connections.
#[test]
fn an_interrupted_probe_reports_no_effect_of_a_trial() {
    let stop = Stop::default();
    let requested = stop.clone();
    let confused: RefCell<BTreeSet<usize>> = RefCell::default();
    let options = Options { stop: stop.clone(), ..trying(&["FW-TCP-03", "FW-ENV-27"]) };
    let probed = scripted(options, move |line, segment| {
        if segment.is_empty() {
            line.idle_limit = Some(Duration::from_secs(1));
            // The second connection after the trial is open while the probe waits for the end of the first connection.
            if confused.borrow().first().is_some_and(|trial| line.number >= trial + 2) {
                requested.request();
            }
        }
        answer_until_confused(line, &confused, segment);
    });
    assert!(stop.is_requested() && probed.cut_short.is_some());
    assert!(!rules(&probed).contains("FW-ENV-27"), "{:?}", trials(&probed));
}

/// A script of a server that refuses all requests before the login, even AUTH-INF. `is_accepted` is true if the login
/// succeeds.
fn answer_after_login(is_accepted: bool) -> impl Fn(&mut Line, &[u8]) {
    let logged_in: RefCell<BTreeSet<usize>> = RefCell::default();
    move |line, segment| {
        for text in answers(segment) {
            let mut message: Value = serde_json::from_str(&text).expect("JSON");
            if String::from_utf8_lossy(segment).contains("AUTH-REQ") {
                logged_in.borrow_mut().extend(is_accepted.then_some(line.number));
                message["body"] = json!({ "type": "AUTH-RESP", "result": is_accepted, "user": "pilot" });
            } else if !logged_in.borrow().contains(&line.number) {
                message["body"] = json!({ "type": "ACK-NAK", "reason": "log in first" });
            }
            line.send(format!("{message}\n"));
        }
    }
}

#[test]
fn logs_in_to_a_server_that_refuses_everything_else_before_the_login() {
    let login = Some(("pilot".to_owned(), "soar".to_owned()));
    let selection = Selection::default().without_trials();
    let options = Options { limit: Duration::from_secs(30), login, selection, ..short_options() };
    let accepted = scripted(options.clone(), answer_after_login(true));
    assert_eq!((accepted.failure.as_deref(), accepted.cut_short.as_deref()), (None, None));
    assert!(!rules(&accepted).contains("FW-SYS-PING-01"), "{:?}", trials(&accepted));
    let refused = scripted(options, answer_after_login(false));
    let failure = refused.failure.as_deref().expect("a reason");
    assert!(failure.starts_with("the server refused the login"), "{failure}");
    assert!(!rules(&refused).contains("FW-SYS-PING-01"), "{:?}", trials(&refused));
}

#[test]
fn reports_a_server_that_dies_during_the_probe() {
    let count = Cell::new(0);
    let script = move |line: &mut Line, segment: &[u8]| {
        if count.replace(count.get() + 1) > 10 {
            line.end(line.number);
        }
        answer_all(line, segment);
    };
    let probed = simulated(short_options(), |clock| Scripted::new(clock, script).accepting(1));
    let reason = probed.cut_short.as_deref().expect("a reason");
    assert!(reason.starts_with("the server stopped serving after a request: UAV-LIST"), "{reason}");
    let reported = probed.result.findings.groups().flat_map(|group| &group.examples);
    let lost = reported.filter(|(_, detail)| detail.message.ends_with("; the server closed the connection"));
    assert_eq!(lost.count(), 1, "a request without an answer");
}

#[test]
fn probes_a_server_that_closes_connections_to_the_end() {
    let counts: RefCell<BTreeMap<usize, usize>> = RefCell::default();
    let probed =
        scripted(Options { limit: Duration::from_secs(30), ..short_options() }, move |line, segment| {
            answer_all(line, segment);
            let mut counts = counts.borrow_mut();
            let count = counts.entry(line.number).or_default();
            *count += 1;
            // The first connections end early, between an answer and the next request.
            if *count > 12 && line.number < 3 {
                line.end(line.number);
            }
        });
    assert_eq!(probed.failure, None);
    let again = probed.notes.iter().filter(|note| note.contains("connected again")).count();
    assert_eq!(again, 3, "{:?}", probed.notes);
}

/// The findings: the rule, the trial and the number of violations.
fn trials(probed: &Probed) -> Vec<(&'static str, String, u64)> {
    let groups = probed.result.findings.groups();
    groups.map(|group| (group.rule.id, group.subject.clone(), group.count)).collect()
}

#[test]
fn reports_each_weakness_of_a_tcp_server_once() {
    // This server answers all lines of a segment together, in reverse order. If a line isn't JSON, the server closes
    // the connection without an answer.
    let rest: RefCell<BTreeMap<usize, Vec<u8>>> = RefCell::default();
    let probed =
        scripted(Options { limit: Duration::from_secs(45), ..short_options() }, move |line, segment| {
            let mut rest = rest.borrow_mut();
            let rest = rest.entry(line.number).or_default();
            rest.extend_from_slice(segment);
            let Some(end) = rest.iter().rposition(|byte| *byte == b'\n') else { return };
            let whole: Vec<u8> = rest.drain(..=end).collect();
            if whole[..end]
                .split(|byte| *byte == b'\n')
                .any(|line| serde_json::from_slice::<Value>(line).is_err())
            {
                return line.end(line.number);
            }
            for answer in answers(&whole).into_iter().rev() {
                line.send(answer);
            }
        });
    assert_eq!(probed.failure, None);
    let found = trials(&probed);
    let findings_of = |rule: &str| -> Vec<(&str, u64)> {
        found.iter().filter(|found| found.0 == rule).map(|found| (found.1.as_str(), found.2)).collect()
    };
    let after_noise = ("after a line that is not JSON", 4);
    let together = ("a segment with a message and a non-JSON line", 1);
    assert_eq!(findings_of("FW-TCP-03"), [together, after_noise]);
    assert_eq!(findings_of("FW-TCP-02"), []);
    assert_eq!(findings_of("FW-ENV-25").len(), 1);
    assert_eq!(findings_of("FW-TCP-04"), []);
}

#[test]
fn reports_only_the_trial_that_stops_the_server() {
    let is_dead = Cell::new(false);
    let probed =
        scripted(Options { limit: Duration::from_secs(45), ..short_options() }, move |line, segment| {
            is_dead.set(is_dead.get() || is_confusing(segment));
            if is_dead.get() && !segment.is_empty() {
                return;
            }
            answer_all(line, segment);
        });
    let reason = probed.cut_short.as_deref().expect("a reason");
    let expected = "the server stopped serving after a trial: FW-TCP-03, after a line that is not JSON: words: 0 \
                    requests and ";
    assert!(reason.starts_with(expected), "{reason}");
    assert_eq!(violations(&probed)["FW-ENV-27"], 1);
    let of_trials = trials(&probed).into_iter().filter(|found| found.0.starts_with("FW-TCP"));
    // In addition, this server requires each message to arrive in one segment.
    let rules: BTreeSet<&str> = of_trials.map(|found| found.0).collect();
    assert_eq!(rules, BTreeSet::from(["FW-TCP-02", "FW-TCP-03", "FW-TCP-04"]));
}

/// The server serves new connections, but no longer serves the connections that were open before a trial.
#[test]
fn reports_a_trial_that_affects_other_clients() {
    let forgotten = Cell::new(0);
    let clock = Clock::simulated();
    let server = Scripted::new(&clock, move |line: &mut Line, segment: &[u8]| {
        if is_confusing(segment) {
            forgotten.set(line.number + 1);
        }
        if line.number >= forgotten.get() {
            answer_all(line, segment);
        }
    });
    // The selection also applies to the findings of the rule.
    let options = Options { clock, ..trying(&["FW-TCP-03"]) };
    let tape = Shared::default();
    let probed = probe_on(&server, &ENDPOINT, &options, &DEFINITIONS, Some(Box::new(tape.clone())));
    assert_eq!((probed.failure.as_deref(), probed.cut_short.as_deref()), (None, None));
    assert!(probed.notes.iter().any(|note| note.contains("other connections")), "{:?}", probed.notes);
    assert_eq!(rules(&probed), BTreeSet::from(["FW-TCP-03"]));
    let recording = tape.0.lock().unwrap_or_else(PoisonError::into_inner).clone();
    let replayed = check_capture(&*recording, None, &DEFINITIONS).expect("bytes can be read");
    let stopped = replayed.findings.groups().find(|group| group.rule.id == "FW-ENV-27").expect("a finding");
    assert_eq!(stopped.count, 1);
}

/// Starts a reference server whose UAVs move fast. Also returns its URL.
fn reference_server() -> (Server, String) {
    let options = uavspec_serve::Options { speed: 10.0, ..uavspec_serve::Options::default() };
    let free = SocketAddr::from(([127, 0, 0, 1], 0));
    let server = Server::start(options, &[(Transport::Tcp, free)]).expect("it starts");
    let url = server.listening()[0].to_string();
    (server, url)
}

/// The requests in a recorded session, in order. Each has a type and a body.
fn requests(tape: &Shared) -> Vec<(String, Value)> {
    let recording = tape.0.lock().unwrap_or_else(PoisonError::into_inner).clone();
    let lines = recording.split(|byte| *byte == b'\n').filter(|line| !line.is_empty());
    // Trials send texts that some parsers reject.
    let lines = lines.filter_map(|line| serde_json::from_slice::<Value>(line).ok());
    let sent = lines.filter(|line| line["dir"] == "out");
    sent.filter_map(|line| {
        Some((line["msg"]["body"]["type"].as_str()?.to_owned(), line["msg"]["body"].clone()))
    })
    .collect()
}

#[test]
fn commands_follow_the_order_of_a_flight_and_concern_only_named_uavs() {
    let options = Options::new(Duration::ZERO, None, vec!["glider-2".to_owned()]);
    let tape = Shared::default();
    let probed = referenced(options, uavspec_serve::Options::default(), &tape);
    assert_eq!((probed.failure, probed.cut_short), (None, None));
    assert_eq!(probed.result.findings.groups().count(), 0);
    let requests = requests(&tape);
    let at = |name: &str| requests.iter().position(|(type_name, _)| type_name == name).expect(name);
    let flight = [
        "UAV-SLEEP",
        "UAV-WAKEUP",
        "UAV-TEST",
        "UAV-MOTOR",
        "UAV-TAKEOFF",
        "UAV-HOVER",
        "UAV-FLY",
        "UAV-RTH",
        "UAV-LAND",
        "UAV-RST",
        "UAV-HALT",
    ];
    assert!(flight.is_sorted_by_key(|name| at(name)), "{requests:?}");
    let queries = ["UAV-INF", "UAV-LIST", "UAV-PREFLT", "UAV-VER"];
    for (name, body) in requests.iter().filter(|(name, _)| name.starts_with("UAV-")) {
        let ids = body["ids"].as_array().into_iter().flatten();
        let others: Vec<&Value> = ids.filter(|id| *id != "glider-2" && *id != "unknown-id").collect();
        assert!(others.is_empty() || queries.contains(&name.as_str()), "{name}: {others:?}");
    }
    let not_sent: BTreeMap<&str, &str> = probed
        .requests
        .iter()
        .filter_map(|entry| Some((entry.name.as_str(), entry.not_sent.as_deref()?)))
        .collect();
    let expected =
        [("AUTH-REQ", "needs --login"), ("SHOW-CRTH-START", "could move UAVs that are not given with --uav")];
    assert_eq!(not_sent, BTreeMap::from(expected));
}

#[test]
fn lands_uavs_whatever_is_selected() {
    let only = vec!["UAV-TAKEOFF".to_owned()];
    let selection = Selection::new(only, vec!["UAV-LAND".to_owned()], &DEFINITIONS, &ENDPOINT);
    let selection = selection.expect("known types").without_trials();
    let options = Options::new(Duration::ZERO, None, vec!["glider-2".to_owned()]);
    let tape = Shared::default();
    let probed = referenced(Options { selection, ..options }, uavspec_serve::Options::default(), &tape);
    assert_eq!((probed.failure, probed.cut_short), (None, None));
    let sent: Vec<String> = requests(&tape).into_iter().map(|(name, _)| name).collect();
    let at = |name: &str| sent.iter().position(|sent| sent == name);
    assert!(at("UAV-TAKEOFF").is_some() && at("UAV-TAKEOFF") < at("UAV-LAND"), "{sent:?}");
    assert_eq!(at("UAV-HALT"), None);
}

#[test]
fn sends_every_request_type_or_says_why_not() {
    let login = ("pilot".to_owned(), "secret".to_owned());
    let served = uavspec_serve::Options { login: Some(login.clone()), ..uavspec_serve::Options::default() };
    let probed = |options| simulated(options, |clock| InMemory::new(served.clone(), clock));
    let uavs = (1..=5).map(|number| format!("glider-{number}")).collect();
    let all = probed(Options::new(Duration::ZERO, Some(login.clone()), uavs));
    let not_sent: Vec<&RequestType> = all.requests.iter().filter(|entry| entry.not_sent.is_some()).collect();
    assert!(not_sent.is_empty(), "{not_sent:?}");
    assert!(all.requests.len() >= 72 && all.requests.iter().all(|entry| entry.sent > 0));
    let without = probed(Options::new(Duration::ZERO, Some(login), Vec::new()));
    let reasons: BTreeSet<&str> =
        without.requests.iter().filter_map(|entry| entry.not_sent.as_deref()).collect();
    assert_eq!(reasons, BTreeSet::from(["needs --allow-commands"]));
}

#[test]
fn stops_after_a_refused_login() {
    let login = Some(("pilot".to_owned(), "secret".to_owned()));
    let served = uavspec_serve::Options { login, ..uavspec_serve::Options::default() };
    let wrong = ("pilot".to_owned(), "wrong".to_owned());
    let options = Options::new(Duration::ZERO, Some(wrong), Vec::new());
    let probed = simulated(options, |clock| InMemory::new(served, clock));
    let failure = probed.failure.as_deref().expect("a reason");
    assert!(failure.starts_with("the server refused the login"), "{failure}");
    let logins = probed.requests.iter().find(|entry| entry.name == "AUTH-REQ").expect("a type");
    assert_eq!(logins.sent, 1);
    assert_eq!(violations(&probed), BTreeMap::new());
}

/// Runs the program. Returns the exit status, standard output and standard error.
fn uavspec(arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_uavspec")).args(arguments).output().expect("it runs");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[test]
fn probe_prints_its_outcome_and_records_the_session() {
    let location = SocketAddr::from(([127, 0, 0, 1], 0));
    let bug = flockwave::rule("FW-SYS-VER-02");
    let options = uavspec_serve::Options { bug, ..uavspec_serve::Options::default() };
    let server = Server::start(options, &[(Transport::Tcp, location)]).expect("it starts");
    let url = server.listening()[0].to_string();
    let folder = tempfile::tempdir().expect("a folder");
    let (record, report) = (folder.path().join("run.jsonl"), folder.path().join("report.json"));
    let (record, report) = (record.to_str().expect("UTF-8"), report.to_str().expect("UTF-8"));
    let reported = format!("json={report}");
    let arguments =
        ["probe", "--for", "0.1", "--record", record, "--report", &reported, "--require", "FW-TCP-02", &url];
    let (status, printed, output) = uavspec(&arguments);
    assert_eq!((status, output.as_str()), (Some(1), ""), "{printed}");
    assert!(printed.contains("fail    FW-SYS-VER-02"), "{printed}");
    let report: Value = serde_json::from_slice(&std::fs::read(report).expect("a report")).expect("JSON");
    assert_eq!((&report["action"], &report["outcome"]["status"]), (&json!("probe"), &json!(1)));
    let again = report["subjects"][0]["findings"][0]["reproduce"].as_str().expect("a command");
    assert!(again.starts_with("uavspec probe") && again.ends_with(&url), "{again}");
    let (status, printed, _) = uavspec(&["check", record]);
    assert_eq!(status, Some(1));
    assert!(printed.contains("fail    FW-SYS-VER-02"), "{printed}");
}

#[test]
fn reports_invalid_usage() {
    for (arguments, status, wanted) in [
        (&["probe", "localhost:5001"][..], 2, "tcp://localhost:5001"),
        (&["probe", "--uav", "00", "tcp://localhost:5001"], 2, "--allow-commands"),
        (&["probe", "--allow-commands", "tcp://localhost:5001"], 2, "--uav"),
        (&["probe", "--require", "FW-NONE-01", "tcp://localhost:5001"], 2, "no such rule"),
        (
            &["probe", "--record", "/no/such/folder/run.jsonl", "tcp://localhost:5001"],
            3,
            "can't write the recording",
        ),
    ] {
        let (found, printed, output) = uavspec(arguments);
        assert_eq!((found, printed.as_str()), (Some(status), ""), "{output}");
        assert!(output.contains(wanted), "{output}");
    }
}
