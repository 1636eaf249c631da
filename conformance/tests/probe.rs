//! Tests of the probe, with conforming servers and with faulty ones.
//!
//! No test depends on speed, but a probe may have a time limit.

#[cfg_attr(not(unix), allow(dead_code, unused_imports, reason = "only tests with signals use them"))]
mod flight;
mod landing;
mod proxied;
mod secrets;

use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::process::Command;
use std::sync::{Arc, LazyLock, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use uavspec_conformance::check::check_capture;
use uavspec_conformance::definitions::Definitions;
use uavspec_conformance::probe::{Options, Probed, RequestType, Selection, Stop, probe};
use uavspec_conformance::rules::flockwave;
use uavspec_conformance::serve::{self, Server, Transport};
use uavspec_conformance::transport::Endpoint;

static DEFINITIONS: LazyLock<Definitions> = LazyLock::new(Definitions::built_in);

/// The additional time that a probe may take beyond its time limit, to finish its last request and its report.
const SLACK: Duration = Duration::from_secs(20);

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
    let tape = Shared::default();
    let began = Instant::now();
    let probed = probe(&endpoint, options, &DEFINITIONS, Some(Box::new(tape.clone())), &|_, _| {});
    assert!(began.elapsed() < options.limit + options.observe + SLACK, "the probe exceeds its time limit");
    assert!(probed.unrecorded.is_none());
    let recording = tape.0.lock().unwrap_or_else(PoisonError::into_inner).clone();
    let replayed = check_capture(&*recording, None, &DEFINITIONS).expect("bytes can be read");
    let summary = |result: &uavspec_conformance::check::CaptureResult| -> Vec<String> {
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

/// Passes received segments to a function until it returns false.
fn segments(stream: &TcpStream, mut take: impl FnMut(&[u8]) -> bool) {
    let (mut stream, mut piece) = (stream, vec![0; 1 << 16]);
    while let Ok(length) = stream.read(&mut piece) {
        if length == 0 || !take(&piece[..length]) {
            return;
        }
    }
}

/// Answers HTTP POST requests with bare message bodies, without an envelope. A malformed message is taken for a ping.
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

/// Some trials send a message without an id before a request. Over HTTP, each message has a separate answer.
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
    let free = TcpListener::bind("127.0.0.1:0").expect("a free port").local_addr().expect("an address");
    let probed = probed(&format!("tcp://{free}"), &short_options());
    assert!(probed.failure.expect("a reason").starts_with("can't connect"));
    assert_eq!(probed.result.checked, 0);
}

#[test]
fn ends_in_time_with_a_silent_server() {
    let probed = probed(&serve(|stream, _| segments(&stream, |_| true)), &short_options());
    let failure = probed.failure.as_deref().expect("a reason");
    assert_eq!(failure, "this is not a Flockwave server: no answer to SYS-VER within 2 s");
    assert_eq!(violations(&probed), BTreeMap::new());
}

/// A proxy may close connections until the server behind it has started. The early requests then have no answer.
#[test]
fn waits_until_a_starting_server_answers() {
    let url = serve(|mut stream, number| {
        let mut reader = BufReader::new(stream.try_clone().expect("a stream"));
        let mut count = 0;
        if number < 3 {
            let _ = reader.read_line(&mut String::new());
            return;
        }
        for line in reader.lines().map_while(Result::ok) {
            let Some(answer) = answer(line.as_bytes(), &mut count) else { continue };
            if stream.write_all(answer.as_bytes()).is_err() {
                return;
            }
        }
    });
    let selection = Selection::default().without_trials();
    let probed = probed(&url, &Options { limit: Duration::from_secs(20), selection, ..short_options() });
    assert_eq!((probed.failure.as_deref(), probed.cut_short.as_deref()), (None, None));
    assert!(!rules(&probed).contains("FW-ENV-07"), "{:?}", trials(&probed));
}

/// Other protocols violate no Flockwave rule.
#[test]
fn recognises_servers_of_other_protocols() {
    let tls_alert: &[u8] = &[0x15, 3, 3, 0, 2, 2, 70, b'\n'];
    for (greeting, expected) in [
        (&b"HTTP/1.1 400 Bad Request\r\nConnection: close\r\n\r\n<html>\r\n"[..], "http://"),
        (tls_alert, "TLS"),
        (b"SSH-2.0-OpenSSH_9.6\r\n", "SSH-2.0"),
        (b"{\"jsonrpc\":\"2.0\",\"id\":\"probe-1\"}\n", "jsonrpc"),
    ] {
        let probed = probed(
            &serve(move |mut stream, _| {
                let _ = stream.write_all(greeting);
                segments(&stream, |_| true);
            }),
            &short_options(),
        );
        let failure = probed.failure.as_deref().expect("a reason");
        assert!(failure.starts_with("this is not a Flockwave server: "), "{failure}");
        assert!(failure.contains(expected), "{failure}");
        assert_eq!(violations(&probed), BTreeMap::new());
    }
}

#[test]
fn reports_garbage_and_ends_in_time() {
    let probed = probed(
        &serve(|mut stream, _| {
            while stream.write_all(b"\xff\xfe wind \x00\n{\"half\n[[[[\n").is_ok() {
                thread::sleep(Duration::from_millis(20));
            }
        }),
        &short_options(),
    );
    let failure = probed.failure.as_deref().expect("a reason");
    assert!(failure.starts_with("this is not a Flockwave server: it sent "), "{failure}");
    assert_eq!(rules(&probed), BTreeSet::new());
}

#[test]
fn ends_in_time_with_slow_bytes_and_an_endless_line() {
    for pause in [1_000, 0] {
        let probed = probed(
            &serve(move |mut stream, _| {
                let piece = if pause == 0 { vec![b'x'; 1 << 16] } else { vec![b'x'] };
                while stream.write_all(&piece).is_ok() {
                    thread::sleep(Duration::from_millis(pause));
                }
            }),
            &short_options(),
        );
        let failure = probed.failure.as_deref().expect("a reason");
        assert!(failure.starts_with("this is not a Flockwave server: "), "{failure}");
        assert_eq!(rules(&probed), BTreeSet::new());
    }
}

#[test]
fn ends_in_time_with_a_million_notifications() {
    let probed = probed(
        &serve(|mut stream, _| {
            let one = json!({
                "$fw.version": "1.0", "id": "same", "body": { "type": "SYS-MSG", "items": [{ "message": "gust" }] },
            });
            let many = format!("{one}\n").repeat(100);
            for _ in 0..10_000 {
                if stream.write_all(many.as_bytes()).is_err() {
                    return;
                }
            }
        }),
        &short_options(),
    );
    assert_eq!(rules(&probed), BTreeSet::from(["FW-ENV-04", "FW-ENV-07"]));
}

/// Answers each line after a delay.
fn serve_slowly(delay: impl Fn(u64) -> Duration + Clone + Send + 'static) -> String {
    serve(move |mut stream, _| {
        let reader = BufReader::new(stream.try_clone().expect("a stream"));
        let mut number = 0;
        for line in reader.lines().map_while(Result::ok) {
            let Some(answer) = answer(line.as_bytes(), &mut number) else { continue };
            thread::sleep(delay(number));
            if stream.write_all(answer.as_bytes()).is_err() {
                return;
            }
        }
    })
}

#[test]
fn a_slow_server_runs_out_of_time_without_a_finding() {
    let slow = serve_slowly(|_| Duration::from_millis(900));
    let probed = probed(&slow, &Options { limit: Duration::from_secs(4), ..short_options() });
    assert_eq!(probed.failure, None);
    let reason = probed.cut_short.as_deref().expect("a reason");
    assert!(reason.starts_with("out of time: "), "{reason}");
    let is_late = |entry: &&RequestType| entry.not_sent.as_deref() == Some("out of time");
    assert!(probed.requests.iter().filter(is_late).count() > 10);
    assert!(!rules(&probed).iter().any(|rule| ["FW-ENV-07", "FW-ENV-19", "FW-ENV-27"].contains(rule)));
}

#[test]
fn waits_for_late_answers() {
    // The tenth answer of each connection takes longer than the probe waits before its next request.
    let late = serve_slowly(|number| Duration::from_millis(if number == 10 { 3_000 } else { 0 }));
    let selection = Selection::default().without_trials();
    let (limit, timeout) = (Duration::from_secs(30), Duration::from_secs(5));
    let probed = probed(&late, &Options { limit, timeout, selection, ..short_options() });
    assert_eq!((probed.failure.as_deref(), probed.cut_short.as_deref()), (None, None));
    assert!(!rules(&probed).contains("FW-ENV-07"), "{:?}", trials(&probed));
}

/// Probes a server, but uses only these rules.
fn tried(url: &str, rules: &[&str]) -> Probed {
    let endpoint: Endpoint = url.parse().expect("an endpoint");
    let only = rules.iter().map(|rule| (*rule).to_owned()).collect();
    let selection = Selection::new(only, Vec::new(), &DEFINITIONS, &endpoint).expect("known rules");
    let options = Options { limit: Duration::from_secs(45), selection, ..short_options() };
    let probed = probe(&endpoint, &options, &DEFINITIONS, None, &|_, _| {});
    assert_eq!((probed.failure.as_deref(), probed.cut_short.as_deref()), (None, None));
    probed
}

/// A server may handle one request after the other. Each answer is in time, but not all answers are.
#[test]
fn waits_for_the_answers_to_requests_that_were_sent_together() {
    let url = serve(|mut stream, _| {
        let reader = BufReader::new(stream.try_clone().expect("a stream"));
        let mut number = 0;
        for line in reader.lines().map_while(Result::ok) {
            let Some(answer) = answer(line.as_bytes(), &mut number) else { continue };
            // The requests of trials have other ids.
            if !line.contains("\"probe-") {
                thread::sleep(Duration::from_millis(1_300));
            }
            if stream.write_all(answer.as_bytes()).is_err() {
                return;
            }
        }
    });
    let probed = tried(&url, &["FW-TCP-02", "FW-ENV-27"]);
    assert_eq!(rules(&probed), BTreeSet::new());
}

/// Answers each request until a line is not JSON. Afterwards, it answers nothing on the connection, and keeps the
/// connection open.
fn serve_until_confused(stream: &TcpStream) {
    let (mut number, mut is_confused) = (0, false);
    segments(stream, |segment| {
        if segment.starts_with(b"not a message") {
            is_confused = true;
            stream.set_read_timeout(None).expect("a timeout");
        }
        let answers = segment.split(|byte| *byte == b'\n').filter_map(|line| answer(line, &mut number));
        let answers: String = answers.collect();
        let mut stream = stream;
        is_confused || stream.write_all(answers.as_bytes()).is_ok()
    });
}

/// A server may close idle connections, also while a trial waits for its answer.
#[test]
fn the_end_of_an_idle_connection_is_no_effect_of_a_trial() {
    let url = serve(|stream, _| {
        stream.set_read_timeout(Some(Duration::from_secs(1))).expect("a timeout");
        serve_until_confused(&stream);
    });
    assert_eq!(rules(&tried(&url, &["FW-TCP-03", "FW-ENV-27"])), BTreeSet::from(["FW-TCP-03"]));
}

/// A server may serve only the latest connection.
#[test]
fn the_end_of_an_older_connection_is_no_effect_of_a_trial() {
    let latest: Arc<Mutex<Option<(usize, TcpStream)>>> = Arc::default();
    let url = serve(move |stream, number| {
        let mut latest = latest.lock().unwrap_or_else(PoisonError::into_inner);
        if latest.as_ref().is_some_and(|(later, _)| *later > number) {
            return;
        }
        let copy = stream.try_clone().expect("a stream");
        if let Some((_, older)) = latest.replace((number, copy)) {
            // The client may have closed it.
            let _ = older.shutdown(Shutdown::Both);
        }
        drop(latest);
        serve_until_confused(&stream);
    });
    assert_eq!(rules(&tried(&url, &["FW-TCP-03", "FW-ENV-27"])), BTreeSet::from(["FW-TCP-03"]));
}

/// The end of a connection closes all older connections. This looks neither like a server for one client nor like the
/// end of an idle connection.
#[test]
fn reports_a_server_that_closes_the_connections_of_other_clients() {
    let clients: Arc<Mutex<BTreeMap<usize, TcpStream>>> = Arc::default();
    let url = serve(move |stream, number| {
        let copy = stream.try_clone().expect("a stream");
        clients.lock().unwrap_or_else(PoisonError::into_inner).insert(number, copy);
        let mut count = 0;
        segments(&stream, |segment| {
            let answers = segment.split(|byte| *byte == b'\n').filter_map(|line| answer(line, &mut count));
            let answers: String = answers.collect();
            !segment.starts_with(b"not a message") && (&stream).write_all(answers.as_bytes()).is_ok()
        });
        let mut clients = clients.lock().unwrap_or_else(PoisonError::into_inner);
        let later = clients.split_off(&(number + 1));
        for client in std::mem::replace(&mut *clients, later).values() {
            // The client may have closed it.
            let _ = client.shutdown(Shutdown::Both);
        }
    });
    let found = rules(&tried(&url, &["FW-TCP-03", "FW-ENV-27"]));
    assert_eq!(found, BTreeSet::from(["FW-ENV-27", "FW-TCP-03"]));
}

/// If the probe is interrupted, it can't find out whether the server closes idle connections.
#[test]
fn an_interrupted_probe_reports_no_effect_of_a_trial() {
    let confused: Arc<Mutex<Option<usize>>> = Arc::default();
    let stop = Stop::default();
    let requested = stop.clone();
    let url = serve(move |stream, number| {
        let confused = || confused.lock().unwrap_or_else(PoisonError::into_inner);
        stream.set_read_timeout(Some(Duration::from_secs(1))).expect("a timeout");
        // The second connection after the trial is open while the probe waits for the end of the first one.
        if confused().is_some_and(|trial| number >= trial + 2) {
            requested.request();
        }
        let mut count = 0;
        segments(&stream, |segment| {
            if segment.starts_with(b"not a message") {
                confused().get_or_insert(number);
                stream.set_read_timeout(None).expect("a timeout");
            }
            let answers = segment.split(|byte| *byte == b'\n').filter_map(|line| answer(line, &mut count));
            let answers: String = answers.collect();
            *confused() == Some(number) || (&stream).write_all(answers.as_bytes()).is_ok()
        });
    });
    let endpoint: Endpoint = url.parse().expect("an endpoint");
    let only = vec!["FW-TCP-03".to_owned(), "FW-ENV-27".to_owned()];
    let selection = Selection::new(only, Vec::new(), &DEFINITIONS, &endpoint).expect("known rules");
    let limit = Duration::from_secs(45);
    let options = Options { limit, selection, stop: stop.clone(), ..short_options() };
    let probed = probe(&endpoint, &options, &DEFINITIONS, None, &|_, _| {});
    assert!(stop.is_requested() && probed.cut_short.is_some());
    assert!(!rules(&probed).contains("FW-ENV-27"), "{:?}", trials(&probed));
}

/// Serves a server that refuses all requests before the login, even AUTH-INF.
fn serve_after_login(is_accepted: bool) -> String {
    serve(move |mut stream, _| {
        let reader = BufReader::new(stream.try_clone().expect("a stream"));
        let (mut number, mut is_logged_in) = (0, false);
        for line in reader.lines().map_while(Result::ok) {
            let Some(text) = answer(line.as_bytes(), &mut number) else { continue };
            let mut message: Value = serde_json::from_str(&text).expect("JSON");
            if line.contains("AUTH-REQ") {
                is_logged_in = is_accepted;
                message["body"] = json!({ "type": "AUTH-RESP", "result": is_accepted, "user": "pilot" });
            } else if !is_logged_in {
                message["body"] = json!({ "type": "ACK-NAK", "reason": "log in first" });
            }
            if writeln!(stream, "{message}").is_err() {
                return;
            }
        }
    })
}

#[test]
fn logs_in_to_a_server_that_refuses_everything_else_before_the_login() {
    let login = Some(("pilot".to_owned(), "soar".to_owned()));
    let selection = Selection::default().without_trials();
    let options = Options { limit: Duration::from_secs(30), login, selection, ..short_options() };
    let accepted = probed(&serve_after_login(true), &options);
    assert_eq!((accepted.failure.as_deref(), accepted.cut_short.as_deref()), (None, None));
    assert!(!rules(&accepted).contains("FW-SYS-PING-01"), "{:?}", trials(&accepted));
    let refused = probed(&serve_after_login(false), &options);
    let failure = refused.failure.as_deref().expect("a reason");
    assert!(failure.starts_with("the server refused the login"), "{failure}");
    assert!(!rules(&refused).contains("FW-SYS-PING-01"), "{:?}", trials(&refused));
}

#[test]
fn reports_a_server_that_dies_during_the_probe() {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let url = format!("tcp://{}", listener.local_addr().expect("an address"));
    thread::spawn(move || {
        let (mut stream, _) = listener.accept().expect("a client");
        // No further connection is accepted.
        drop(listener);
        let reader = BufReader::new(stream.try_clone().expect("a stream"));
        let mut number = 0;
        for line in reader.lines().map_while(Result::ok) {
            let answer = answer(line.as_bytes(), &mut number).expect("a request");
            if number > 10 {
                return;
            }
            stream.write_all(answer.as_bytes()).expect("it is written");
        }
    });
    let probed = probed(&url, &short_options());
    assert!(probed.cut_short.expect("a reason").starts_with("can't reconnect"));
    let reported = probed.result.findings.groups().flat_map(|group| &group.examples);
    let lost = reported.filter(|(_, detail)| detail.message.ends_with("; the server closed the connection"));
    assert_eq!(lost.count(), 1, "a request without an answer");
}

#[test]
fn probes_a_server_that_closes_connections_to_the_end() {
    let probed = probed(
        &serve(|mut stream, number| {
            let reader = BufReader::new(stream.try_clone().expect("a stream"));
            let mut count = 0;
            // The first connections end early, between an answer and the next request.
            for line in reader.lines().map_while(Result::ok).take(if number < 3 { 12 } else { 1_000 }) {
                let Some(answer) = answer(line.as_bytes(), &mut count) else { continue };
                if stream.write_all(answer.as_bytes()).is_err() {
                    return;
                }
            }
        }),
        &Options { limit: Duration::from_secs(30), ..short_options() },
    );
    assert_eq!(probed.failure, None);
    let again = probed.notes.iter().filter(|note| note.contains("connected again")).count();
    assert_eq!(again, 3, "{:?}", probed.notes);
}

/// The rule, the trial and the number of violations of each finding.
fn trials(probed: &Probed) -> Vec<(&'static str, String, u64)> {
    let groups = probed.result.findings.groups();
    groups.map(|group| (group.rule.id, group.subject.clone(), group.count)).collect()
}

#[test]
fn reports_each_weakness_of_a_tcp_server_once() {
    // This server answers all lines of a segment together, in reverse order. If a line isn't JSON, it closes the
    // connection without an answer.
    let probed = probed(
        &serve(|stream, _| {
            let (mut rest, mut number) = (Vec::new(), 0);
            segments(&stream, |segment| {
                rest.extend_from_slice(segment);
                let Some(end) = rest.iter().rposition(|byte| *byte == b'\n') else { return true };
                let whole: Vec<u8> = rest.drain(..=end).collect();
                let lines: Vec<&[u8]> = whole[..end].split(|byte| *byte == b'\n').collect();
                if lines.iter().any(|line| serde_json::from_slice::<Value>(line).is_err()) {
                    return false;
                }
                let answers: Vec<String> =
                    lines.iter().filter_map(|line| answer(line, &mut number)).collect();
                let answers: String = answers.into_iter().rev().collect();
                (&stream).write_all(answers.as_bytes()).is_ok()
            });
        }),
        &Options { limit: Duration::from_secs(45), ..short_options() },
    );
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
    let is_dead = Arc::new(Mutex::new(false));
    let url = serve(move |stream, _| {
        let mut number = 0;
        segments(&stream, |segment| {
            let mut is_dead = is_dead.lock().unwrap_or_else(PoisonError::into_inner);
            *is_dead |= segment.starts_with(b"not a message");
            let answers = segment.split(|byte| *byte == b'\n').filter_map(|line| answer(line, &mut number));
            let answers: String = answers.collect();
            *is_dead || (&stream).write_all(answers.as_bytes()).is_ok()
        });
    });
    let probed = probed(&url, &Options { limit: Duration::from_secs(45), ..short_options() });
    let reason = probed.cut_short.as_deref().expect("a reason");
    assert_eq!(
        reason,
        "the server stopped serving after a trial: FW-TCP-03, after a line that is not JSON: words"
    );
    assert_eq!(violations(&probed)["FW-ENV-27"], 1);
    let of_trials = trials(&probed).into_iter().filter(|found| found.0.starts_with("FW-TCP"));
    // This server also requires a message to arrive in one segment.
    let rules: BTreeSet<&str> = of_trials.map(|found| found.0).collect();
    assert_eq!(rules, BTreeSet::from(["FW-TCP-02", "FW-TCP-03", "FW-TCP-04"]));
}

/// The server serves new connections, but forgets the connections that were open before a trial.
#[test]
fn reports_a_trial_that_affects_other_clients() {
    let forgotten = Arc::new(Mutex::new(0));
    let url = serve(move |stream, number| {
        let mut count = 0;
        segments(&stream, |segment| {
            let mut forgotten = forgotten.lock().unwrap_or_else(PoisonError::into_inner);
            if segment.starts_with(b"not a message") {
                *forgotten = number + 1;
            }
            let answers = segment.split(|byte| *byte == b'\n').filter_map(|line| answer(line, &mut count));
            let answers: String = answers.collect();
            number < *forgotten || (&stream).write_all(answers.as_bytes()).is_ok()
        });
    });
    let selection =
        Selection::new(vec!["FW-TCP-03".to_owned()], Vec::new(), &DEFINITIONS, &url.parse().expect("a URL"));
    let selection = selection.expect("a known rule");
    let options = Options { limit: Duration::from_secs(45), selection, ..short_options() };
    // The selection also selects the findings of the rule.
    let endpoint: Endpoint = url.parse().expect("an endpoint");
    let tape = Shared::default();
    let probed = probe(&endpoint, &options, &DEFINITIONS, Some(Box::new(tape.clone())), &|_, _| {});
    assert_eq!((probed.failure.as_deref(), probed.cut_short.as_deref()), (None, None));
    assert!(probed.notes.iter().any(|note| note.contains("other connections")), "{:?}", probed.notes);
    assert_eq!(rules(&probed), BTreeSet::from(["FW-TCP-03"]));
    let recording = tape.0.lock().unwrap_or_else(PoisonError::into_inner).clone();
    let replayed = check_capture(&*recording, None, &DEFINITIONS).expect("bytes can be read");
    let stopped = replayed.findings.groups().find(|group| group.rule.id == "FW-ENV-27").expect("a finding");
    assert_eq!(stopped.count, 1);
}

/// A reference server whose UAVs move fast, and its URL.
fn reference_server(login: Option<(String, String)>) -> (Server, String) {
    let options = serve::Options { speed: 10.0, login, ..serve::Options::default() };
    let free = SocketAddr::from(([127, 0, 0, 1], 0));
    let server = Server::start(options, &[(Transport::Tcp, free)]).expect("it starts");
    let url = server.listening()[0].to_string();
    (server, url)
}

/// The requests in a recorded session, in order: type and body.
fn requests(tape: &Shared) -> Vec<(String, Value)> {
    let recording = tape.0.lock().unwrap_or_else(PoisonError::into_inner).clone();
    let lines = recording.split(|byte| *byte == b'\n').filter(|line| !line.is_empty());
    // Trials send texts that some parsers refuse.
    let lines = lines.filter_map(|line| serde_json::from_slice::<Value>(line).ok());
    let sent = lines.filter(|line| line["dir"] == "out");
    sent.filter_map(|line| {
        Some((line["msg"]["body"]["type"].as_str()?.to_owned(), line["msg"]["body"].clone()))
    })
    .collect()
}

#[test]
fn commands_follow_the_order_of_a_flight_and_concern_only_named_uavs() {
    let (server, url) = reference_server(None);
    let options = Options::new(Duration::ZERO, None, vec!["glider-2".to_owned()]);
    let tape = Shared::default();
    let endpoint: Endpoint = url.parse().expect("an endpoint");
    let probed = probe(&endpoint, &options, &DEFINITIONS, Some(Box::new(tape.clone())), &|_, _| {});
    drop(server);
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
        "UAV-HALT",
        "UAV-RST",
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
        [("AUTH-REQ", "needs --login"), ("SHOW-CRTH-START", "could move UAVs that --uav doesn't name")];
    assert_eq!(not_sent, BTreeMap::from(expected));
}

#[test]
fn lands_uavs_whatever_is_selected() {
    let (server, url) = reference_server(None);
    let endpoint: Endpoint = url.parse().expect("an endpoint");
    let only = vec!["UAV-TAKEOFF".to_owned()];
    let selection = Selection::new(only, vec!["UAV-LAND".to_owned()], &DEFINITIONS, &endpoint);
    let selection = selection.expect("known types").without_trials();
    let options = Options::new(Duration::ZERO, None, vec!["glider-2".to_owned()]);
    let tape = Shared::default();
    let record = Some(Box::new(tape.clone()) as Box<dyn std::io::Write>);
    let probed = probe(&endpoint, &Options { selection, ..options }, &DEFINITIONS, record, &|_, _| {});
    drop(server);
    assert_eq!((probed.failure, probed.cut_short), (None, None));
    let sent: Vec<String> = requests(&tape).into_iter().map(|(name, _)| name).collect();
    let at = |name: &str| sent.iter().position(|sent| sent == name);
    assert!(at("UAV-TAKEOFF").is_some() && at("UAV-TAKEOFF") < at("UAV-LAND"), "{sent:?}");
    assert_eq!(at("UAV-HALT"), None);
}

#[test]
fn sends_every_request_type_or_says_why_not() {
    let login = ("pilot".to_owned(), "secret".to_owned());
    let (server, url) = reference_server(Some(login.clone()));
    let uavs = (1..=5).map(|number| format!("glider-{number}")).collect();
    let all = probed(&url, &Options::new(Duration::ZERO, Some(login.clone()), uavs));
    let not_sent: Vec<&RequestType> = all.requests.iter().filter(|entry| entry.not_sent.is_some()).collect();
    assert!(not_sent.is_empty(), "{not_sent:?}");
    assert!(all.requests.len() >= 72 && all.requests.iter().all(|entry| entry.sent > 0));
    let without = probed(&url, &Options::new(Duration::ZERO, Some(login), Vec::new()));
    drop(server);
    let reasons: BTreeSet<&str> =
        without.requests.iter().filter_map(|entry| entry.not_sent.as_deref()).collect();
    assert_eq!(reasons, BTreeSet::from(["needs --allow-commands"]));
}

#[test]
fn stops_after_a_refused_login() {
    let (server, url) = reference_server(Some(("pilot".to_owned(), "secret".to_owned())));
    let wrong = ("pilot".to_owned(), "wrong".to_owned());
    let probed = probed(&url, &Options::new(Duration::ZERO, Some(wrong), Vec::new()));
    drop(server);
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
    let options = serve::Options { bug, ..serve::Options::default() };
    let server = Server::start(options, &[(Transport::Tcp, location)]).expect("it starts");
    let url = server.listening()[0].to_string();
    let folder = tempfile::tempdir().expect("a folder");
    let (record, report) = (folder.path().join("run.jsonl"), folder.path().join("report.json"));
    let (record, report) = (record.to_str().expect("UTF-8"), report.to_str().expect("UTF-8"));
    let reported = format!("json={report}");
    let arguments = [
        "probe",
        "--observe",
        "0.1",
        "--record",
        record,
        "--report",
        &reported,
        "--require",
        "FW-TCP-02",
        &url,
    ];
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
