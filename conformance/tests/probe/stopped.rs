//! Tests of probes of servers that stop serving, and of servers over HTTP.

use uavspec_test_support::{LIMIT, wait_for};

use super::*;

/// Options with long limits, for a server that the operating system may delay. All answers or failures arrive, so the
/// limits cost no time.
fn patient() -> Options {
    Options { limit: LIMIT, timeout: Duration::from_secs(60), ..short_options() }
}

/// Options of a probe without a survey that uses only these rules, trials or types.
fn selected(url: &str, only: &[&str]) -> Options {
    let endpoint: Endpoint = url.parse().expect("an endpoint");
    let only = only.iter().map(|name| (*name).to_owned()).collect();
    let selection = Selection::new(only, Vec::new(), &DEFINITIONS, &endpoint).expect("known names");
    Options { selection, ..patient() }
}

/// Starts a reference server with this bug. Also returns its URL.
fn buggy(transport: Transport, rule: &str, login: Option<(String, String)>) -> (Server, String) {
    let bug = flockwave::rule(rule);
    assert_eq!(bug.is_none(), rule.is_empty());
    let options = uavspec_serve::Options { bug, login, ..uavspec_serve::Options::default() };
    let free = SocketAddr::from(([127, 0, 0, 1], 0));
    let server = Server::start(options, &[(transport, free)]).expect("it starts");
    let url = server.listening()[0].to_string();
    (server, url)
}

/// The messages of the findings of a rule.
fn messages(probed: &Probed, rule: &str) -> Vec<String> {
    let groups = probed.result.findings.groups().filter(|group| group.rule.id == rule);
    groups.flat_map(|group| &group.examples).map(|(_, detail)| detail.to_string()).collect()
}

#[test]
fn names_the_datagram_that_ended_the_service() {
    // After a later datagram, the operating system reports that the port has no server.
    assert_names_datagram(&ended_by_a_datagram(Line::refuse));
}

/// A firewall may drop the operating system's report that the port has no server.
#[test]
fn names_the_datagram_after_which_nothing_is_answered() {
    assert_names_datagram(&ended_by_a_datagram(|_| {}));
}

/// Probes a server that stops serving after a datagram that isn't JSON. `refuse` handles all later datagrams.
fn ended_by_a_datagram(refuse: impl Fn(&Line) + 'static) -> Probed {
    let (url, is_dead) = ("udp://memory:5001", Cell::new(false));
    let script = move |line: &mut Line, segment: &[u8]| {
        if is_dead.get() && !segment.is_empty() {
            return refuse(line);
        }
        is_dead.set(is_dead.get() || is_confusing(segment));
        if !is_dead.get() {
            answer_all(line, segment);
        }
    };
    let clock = Clock::simulated();
    let options = selected(url, &["FW-UDP", "FW-ENV-22", "FW-ENV-27"]);
    let options = Options { clock: clock.clone(), ..options };
    let (server, endpoint) = (Scripted::new(&clock, script), url.parse().expect("an endpoint"));
    compared(|tape| probe_on(&server, &endpoint, &options, &DEFINITIONS, Some(tape)))
}

/// A script of a server that stops serving when it reads a fatal line. It serves again from the `restart`-th connection
/// after that. The arguments of `is_fatal` are the number of the line in its segment, and the rest of the segment,
/// starting with this line.
fn mortal(restart: usize, is_fatal: impl Fn(usize, &str) -> bool) -> impl Fn(&mut Line, &[u8]) {
    let dead_connections = Cell::new(None);
    move |line, segment| {
        if segment.is_empty() {
            dead_connections
                .set(dead_connections.get().map(|count| count + 1).filter(|count| *count < restart));
        }
        let lines = line.lines(segment);
        let mut rest = &*String::from_utf8_lossy(&lines);
        for (number, text) in String::from_utf8_lossy(&lines).split_inclusive('\n').enumerate() {
            if is_fatal(number, rest) {
                dead_connections.set(Some(0));
            }
            if dead_connections.get().is_none() {
                answer_all(line, text.as_bytes());
            }
            rest = rest.get(text.len()..).unwrap_or_default();
        }
    }
}

/// The trial that sends several requests together.
const TOGETHER: [&str; 2] = ["FW-ENV-25", "FW-ENV-27"];

/// The end of a finding if the server reads none of the requests of this trial, so that all of them are suspects.
const UNCLEAR: &str = "or one of the 5 messages after it";

#[test]
fn sends_several_suspects_alone_to_name_the_message_that_ended_the_service() {
    let probed = tried(&TOGETHER, mortal(2, |_, rest| rest.contains("CONN-LIST")));
    let found = messages(&probed, "FW-ENV-27");
    assert_eq!(violations(&probed)["FW-ENV-27"], 1, "{found:?}");
    assert!(found[0].contains("(FW-ENV-25, sent alone); the service ended after `"), "{found:?}");
    assert!(found[0].contains("CONN-LIST") && !found[0].contains("or one of"), "{found:?}");
    let again = probed.notes.iter().filter(|note| note.contains("it resumed")).count();
    assert_eq!(again, 2, "{:?}", probed.notes);
}

#[test]
fn a_service_that_ends_only_once_has_several_suspects() {
    let is_over = Cell::new(false);
    let is_fatal = move |_, rest: &str| rest.contains("CONN-LIST") && !is_over.replace(true);
    let found = messages(&tried(&TOGETHER, mortal(2, is_fatal)), "FW-ENV-27");
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(
        found[0].contains(&format!("{UNCLEAR}; sent alone, none of them ended the service")),
        "{found:?}"
    );
}

/// Messages aren't sent again if the server doesn't return, or after an interruption.
#[test]
fn suspects_stay_unclear_without_a_server_or_after_an_interruption() {
    for restart in [usize::MAX, 2] {
        let stop = Stop::default();
        let requested = stop.clone();
        let sent_alone = Rc::new(Cell::new(0));
        let count = Rc::clone(&sent_alone);
        let is_fatal = move |number, rest: &str| {
            if number == 0 && rest.contains("together-") && rest.lines().count() == 1 {
                count.set(count.get() + 1);
                requested.request();
            }
            rest.contains("CONN-LIST")
        };
        let probed = scripted(Options { stop, ..trying(&TOGETHER) }, mortal(restart, is_fatal));
        assert!(probed.cut_short.is_some());
        assert_eq!(sent_alone.get(), usize::from(restart == 2));
        let found = messages(&probed, "FW-ENV-27");
        assert!(found.len() == 1 && found[0].ends_with(UNCLEAR), "{found:?}");
    }
}

/// If the last message of a trial can't be answered, the probe asks whether the server still serves.
#[test]
fn names_a_message_without_an_answer_at_the_end_of_a_trial() {
    let is_fatal = |number: usize, rest: &str| number > 0 && rest.starts_with("not a message");
    let found = messages(&tried(&["FW-TCP-03", "FW-ENV-27"], mortal(2, is_fatal)), "FW-ENV-27");
    assert_eq!(found.len(), 1, "{found:?}");
    let expected = "a segment with a message and a non-JSON line); the service ended after `not a message`";
    assert!(found[0].contains(expected), "{found:?}");
}

fn assert_names_datagram(probed: &Probed) {
    let found = messages(probed, "FW-ENV-27");
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].contains("the service ended after `not a message`"), "{found:?}");
    let reason = probed.cut_short.as_deref().expect("a reason");
    let expected = "the server stopped serving after a trial: FW-UDP-03, after a datagram that is not JSON: words: \
                    0 requests and ";
    assert!(reason.starts_with(expected), "{reason}");
}

/// Instead of answering, the server closes its only connection.
#[test]
fn names_the_request_that_ended_the_service() {
    let script = |line: &mut Line, segment: &[u8]| {
        if String::from_utf8_lossy(segment).contains("OBJ-LIST") {
            return line.end(line.number);
        }
        answer_all(line, segment);
    };
    let probed = simulated(short_options(), |clock| Scripted::new(clock, script).accepting(1));
    let found = messages(&probed, "FW-ENV-27");
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].contains("OBJ-LIST"), "{found:?}");
    let group = probed.result.findings.groups().find(|group| group.rule.id == "FW-ENV-27");
    assert_eq!(group.expect("a group").examples[0].1.only, "OBJ-LIST");
    let reason = probed.cut_short.expect("a reason");
    assert!(reason.starts_with("the server stopped serving after a request: OBJ-LIST: "), "{reason}");
}

/// If a server is shut down, no message ended its service. The server accepts a last connection, and then closes it.
#[test]
fn a_server_that_is_shut_down_violates_nothing() {
    let count = Cell::new(0);
    let script = move |line: &mut Line, segment: &[u8]| {
        if segment.is_empty() {
            return;
        }
        if count.replace(count.get() + 1) < 10 {
            answer_all(line, segment);
        }
        if count.get() >= 10 {
            line.end(line.number);
        }
    };
    let probed = simulated(short_options(), |clock| Scripted::new(clock, script).accepting(2));
    // While the server was serving, it refused AUTH-INF like a request of an unknown type.
    assert_eq!(trials(&probed), [("FW-ENV-24", "AUTH".to_owned(), 1)]);
    let reason = probed.cut_short.expect("a reason");
    assert!(reason.starts_with("the server stopped serving by itself"), "{reason}");
}

/// Like the protocol's reference server, this server then refuses AUTH-REQ, because the client is already logged in.
#[test]
fn http_basic_is_a_login() {
    let login = ("pilot".to_owned(), "soar".to_owned());
    let (server, url) = buggy(Transport::Http, "", Some(login.clone()));
    let with =
        |login: Option<(String, String)>| probed(&url, &Options { login, ..selected(&url, &["UAV-LIST"]) });
    let right = with(Some(login.clone()));
    assert_eq!((right.failure.as_deref(), right.cut_short.as_deref()), (None, None));
    assert_eq!(rules(&right), BTreeSet::new());
    let without = with(None);
    let failure = without.failure.as_deref().expect("a reason");
    assert!(failure.contains("--login"), "{failure}");
    let wrong = with(Some((login.0, "sink".to_owned())));
    let failure = wrong.failure.as_deref().expect("a reason");
    assert!(failure.contains("the server refused the login"), "{failure}");
    drop(server);
}

#[test]
fn a_refused_login_has_the_reason_of_the_server() {
    let (server, url) = buggy(Transport::Tcp, "", Some(("pilot".to_owned(), "soar".to_owned())));
    let login = Some(("pilot".to_owned(), "sink".to_owned()));
    let probed = probed(&url, &Options { login, ..patient() });
    drop(server);
    let failure = probed.failure.as_deref().expect("a reason");
    let expected =
        "the server refused the login: wrong name or password; check the name and password of --login";
    assert_eq!(failure, expected);
}

/// Each HTTP request has its own response, so no answer can be lost.
#[test]
fn a_missing_answer_over_http_is_a_violation() {
    let (server, url) = buggy(Transport::Http, "FW-ENV-07", None);
    let probed = probed(&url, &patient());
    drop(server);
    // There is a finding for each type that the server doesn't know.
    let found = messages(&probed, "FW-ENV-07");
    assert!(found.iter().any(|text| text.contains("PROBE-NONE")), "{found:?}");
    assert!(found.iter().all(|text| text.contains("HTTP status 500")), "{found:?}");
    // A malformed request whose type is unknown gets no answer either.
    assert_eq!(rules(&probed), BTreeSet::from(["FW-ENV-07", "FW-ENV-22"]));
}

#[test]
fn a_malformed_message_that_fails_over_http_is_reported() {
    let (server, url) = buggy(Transport::Http, "FW-ENV-22", None);
    let probed = probed(&url, &selected(&url, &["FW-ENV-22"]));
    drop(server);
    let found = messages(&probed, "FW-ENV-22");
    assert!(!found.is_empty() && found.iter().all(|text| text.contains("HTTP status 500")), "{found:?}");
}

/// A command restarts the server, and the probe continues.
#[cfg(unix)]
#[test]
fn a_command_restarts_the_server() {
    let folder = tempfile::tempdir().expect("a folder");
    let mark = folder.path().join("restarted");
    let on_crash = Some(format!("touch '{}'", mark.display()));
    // The server stops serving after the first text that isn't JSON. The probe then opens a connection to confirm this,
    // and starts the command. The next connection after the restart succeeds.
    let dead_connections = Cell::new(None);
    let script = move |line: &mut Line, segment: &[u8]| {
        match dead_connections.get() {
            None if is_confusing(segment) && !mark.exists() => dead_connections.set(Some(0)),
            Some(0) if segment.is_empty() => dead_connections.set(Some(1)),
            Some(1) if segment.is_empty() => {
                wait_for("the command runs", || mark.exists().then_some(()));
                dead_connections.set(None);
            }
            _ => {}
        }
        if dead_connections.get().is_none() {
            answer_all(line, segment);
        }
    };
    let only = ["FW-TCP-03", "FW-TCP-04", "FW-ENV-27"];
    let options = Options { on_crash, ..trying(&only) };
    let probed = simulated(options, |clock| Scripted::new(clock, script));
    assert_eq!((probed.failure.as_deref(), probed.cut_short.as_deref()), (None, None), "{:?}", probed.notes);
    let found = messages(&probed, "FW-ENV-27");
    assert!(found.len() == 1 && found[0].contains("not a message"), "{found:?}");
    assert!(probed.notes.iter().any(|note| note.contains("it resumed")), "{:?}", probed.notes);
}

#[test]
fn several_servers_have_one_report_with_the_shortest_commands() {
    let (first, one) = buggy(Transport::Tcp, "FW-SYS-VER-02", None);
    let (second, other) = buggy(Transport::Tcp, "", None);
    let folder = tempfile::tempdir().expect("a folder");
    let report = folder.path().join("report.json");
    let reported = format!("json={}", report.display());
    let arguments = ["probe", "--for", "0.1", "--no-trials", "--report", &reported, &one, &other];
    let (status, printed, errors) = uavspec(&arguments);
    drop((first, second));
    assert_eq!((status, errors.as_str()), (Some(1), ""), "{printed}");
    let report: Value = serde_json::from_slice(&std::fs::read(report).expect("a report")).expect("JSON");
    let paths: Vec<&Value> =
        report["subjects"].as_array().expect("a list").iter().map(|subject| &subject["path"]).collect();
    assert_eq!(paths, [&json!(one), &json!(other)]);
    let finding = &report["subjects"][0]["findings"][0];
    assert_eq!(finding["reproduce"], format!("uavspec probe --for 0.1 --only SYS-VER {one}"));
    let page = "https://doc.collmot.com/public/skybrush-protocol-spec/latest/messages/sys.html";
    assert_eq!(finding["specification"], page);
    let text = report["outcome"]["text"].as_str().expect("a text");
    assert!(text.contains("1 of 2 servers"), "{text}");
}
