//! Tests of probes in simulated time that are interrupted, run out of time, or lose their connection or a flying UAV.
//! Also tests of servers with wrong answers.

use std::rc::Rc;

use uavspec_flockwave::transport::Received;
use uavspec_test_server::memory::Watched;
use uavspec_test_server::proxy::Pass;
use uavspec_test_support::extent;

use super::flight::{FLIGHT, GROUND, MOTORS, Requests, SLEEP, UAV};
use super::*;

/// A reference server in simulated time.
struct Sky {
    clock: Clock,
    server: InMemory,
    requests: Requests,
}

impl Sky {
    fn new(options: uavspec_serve::Options) -> Self {
        let clock = Clock::simulated();
        Self { server: InMemory::new(options, &clock), clock, requests: Requests::default() }
    }

    fn with_bug(rule: &str) -> Self {
        Self::new(uavspec_serve::Options { bug: flockwave::rule(rule), ..uavspec_serve::Options::default() })
    }

    fn with_nulls() -> Self {
        let null_results = ["UAV-LAND", "UAV-MOTOR", "UAV-WAKEUP"].map(str::to_owned).into();
        Self::new(uavspec_serve::Options { null_results, ..uavspec_serve::Options::default() })
    }

    /// A network to the server that calls a function with the type of each request.
    fn watched(&self, at: impl Fn(&str) -> Pass + 'static) -> Watched<InMemory> {
        let requests = self.requests.clone();
        Watched::new(self.server.clone(), move |bytes| {
            let types = requests.take(bytes);
            types.first().map_or(Pass::Forward, |name| at(name))
        })
    }

    /// Options for a short probe with a flight.
    fn options(&self) -> Options {
        let only =
            FLIGHT.iter().filter(|name| name.starts_with("UAV")).map(|name| (*name).to_owned()).collect();
        let selection = Selection::new(only, Vec::new(), &DEFINITIONS, &ENDPOINT).expect("known types");
        Options { selection: selection.without_trials(), ..self.all_options() }
    }

    /// Options for a probe that sends all commands.
    fn all_options(&self) -> Options {
        Options { clock: self.clock.clone(), ..Options::new(Duration::ZERO, None, vec![UAV.to_owned()]) }
    }

    /// Runs a probe, and calls a function with the type of each request.
    fn flown(&self, at: impl Fn(&str) -> Pass + 'static, change: impl FnOnce(Options) -> Options) -> Probed {
        probed_over(&self.watched(at), &change(self.options()))
    }

    /// The height of the UAV above home in mm, and its error codes. Sends the request `before` first, if there is one.
    fn state(&self, before: Option<Value>) -> (i64, Vec<u64>) {
        let mut client = self.server.connect(&ENDPOINT).expect("a connection");
        let body = json!({ "type": "UAV-INF", "ids": [UAV] });
        for (id, body) in before.map(|body| ("before", body)).into_iter().chain([("state", body)]) {
            let request = json!({ "$fw.version": "1.0", "id": id, "body": body });
            client.send(request.to_string().as_bytes()).expect("sent");
        }
        loop {
            let Ok(Received::Message(text)) = client.receive(self.clock.now()) else { panic!("no answer") };
            let message: Value = serde_json::from_slice(&text).expect("JSON");
            if message["refs"] == "state" {
                let status = &message["body"]["status"][UAV];
                let codes = status["errors"].as_array().into_iter().flatten().filter_map(Value::as_u64);
                return (status["position"][3].as_i64().expect("an altitude"), codes.collect());
            }
        }
    }

    /// Asserts that the UAV is awake and on the ground, and that its motors are stopped.
    fn assert_safe(&self, context: &str) {
        let (height, codes) = self.state(None);
        let context = format!("{context}: {codes:?}, {:?}", self.requests.types());
        assert_eq!((height, codes.contains(&GROUND)), (0, true), "{context}");
        assert!(!codes.contains(&MOTORS) && !codes.contains(&SLEEP), "{context}");
    }

    /// The number of requests of a type.
    fn count(&self, type_name: &str) -> usize {
        self.requests.types().iter().filter(|name| *name == type_name).count()
    }
}

fn probed_over(network: &dyn Network, options: &Options) -> Probed {
    probe_on(network, &ENDPOINT, options, &DEFINITIONS, None)
}

#[test]
fn lands_uavs_on_a_new_connection_and_logs_in_again() {
    let login = ("pilot".to_owned(), "secret".to_owned());
    for points in [&["UAV-HOVER"][..], &["UAV-RTH", "UAV-LAND"], &["UAV-LAND"]] {
        let sky = Sky::new(uavspec_serve::Options {
            login: Some(login.clone()),
            ..uavspec_serve::Options::default()
        });
        let left = RefCell::new(points.to_vec());
        let at = move |name: &str| {
            let mut left = left.borrow_mut();
            let Some(at) = left.iter().position(|point| *point == name) else { return Pass::Forward };
            left.remove(at);
            Pass::Cut
        };
        let probed = sky.flown(at, |options| Options { login: Some(login.clone()), ..options });
        assert_eq!(probed.danger, None, "{points:?}: {:?}", sky.requests.types());
        let after = sky.requests.after(points[0]);
        let position = |name: &str| after.iter().position(|sent| sent == name).expect(name);
        assert!(
            position("AUTH-REQ") < position("UAV-LAND") || points == ["UAV-LAND"],
            "{points:?}: {after:?}"
        );
        let login = json!({ "type": "AUTH-REQ", "method": "basic", "data": "cGlsb3Q6c2VjcmV0" });
        let (height, codes) = sky.state(Some(login));
        assert_eq!((height, codes.contains(&GROUND)), (0, true), "{points:?}: {after:?}");
    }
}

#[test]
fn lands_uavs_on_connections_that_are_shorter_than_a_landing() {
    let stay = Some(Duration::from_millis(1_500));
    let sky = Sky::new(uavspec_serve::Options { stay, speed: 10.0, ..uavspec_serve::Options::default() });
    let limit = Duration::from_secs(30);
    let probed = sky.flown(|_| Pass::Forward, |options| Options { landing_limit: limit, ..options });
    assert_eq!(probed.danger, None, "{:?}", sky.requests.types());
    assert!(sky.count("UAV-TAKEOFF") > 0);
    sky.assert_safe("after short connections");
}

#[test]
fn lands_uavs_after_the_time_limit() {
    let sky = Sky::new(uavspec_serve::Options::default());
    let (clock, limit) = (sky.clock.clone(), Duration::from_secs(9));
    let at = move |name: &str| {
        if name == "UAV-HOVER" {
            clock.sleep(limit);
        }
        Pass::Forward
    };
    let probed = sky.flown(at, |options| Options { limit, ..options });
    assert_eq!(probed.danger, None);
    assert!(probed.cut_short.expect("a reason").starts_with("out of time"));
    assert!(sky.requests.after("UAV-HOVER").contains(&"UAV-LAND".to_owned()));
    assert_eq!(sky.count("UAV-FLY"), 0);
    sky.assert_safe("after the time limit");
}

/// A writer that panics when a specific text is recorded.
struct Panicking {
    left: Vec<&'static str>,
    tape: Shared,
}

impl std::io::Write for Panicking {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let text = String::from_utf8_lossy(bytes);
        if let Some(at) = self.left.iter().position(|point| text.contains(point)) {
            self.left.remove(at);
            panic!("expected by this test");
        }
        self.tape.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn lands_uavs_after_a_panic() {
    for points in [&["UAV-TAKEOFF"][..], &["UAV-HOVER"], &["UAV-LAND"], &["UAV-FLY", "UAV-LAND", "UAV-INF"]] {
        let sky = Sky::new(uavspec_serve::Options::default());
        let record = Panicking { left: points.to_vec(), tape: Shared::default() };
        let record: Box<dyn std::io::Write> = Box::new(record);
        let probed = probe_on(&sky.server, &ENDPOINT, &sky.options(), &DEFINITIONS, Some(record));
        assert_eq!(probed.danger, None, "{points:?}");
        assert_eq!(probed.failure.as_deref(), Some("internal error of uavspec: expected by this test"));
        sky.assert_safe(points[0]);
    }
}

/// A writer that fails once the first command is recorded, as if the file had reached its size limit.
struct Full(bool);

impl std::io::Write for Full {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0 |= String::from_utf8_lossy(bytes).contains("UAV-TAKEOFF");
        if self.0 { Err(std::io::ErrorKind::FileTooLarge.into()) } else { Ok(bytes.len()) }
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_full_recording_ends_no_flight() {
    let sky = Sky::new(uavspec_serve::Options::default());
    let network = sky.watched(|_| Pass::Forward);
    let probed = probe_on(&network, &ENDPOINT, &sky.options(), &DEFINITIONS, Some(Box::new(Full(false))));
    assert_eq!((probed.danger, probed.cut_short), (None, None));
    assert!(probed.unrecorded.is_some() && sky.count("UAV-LAND") > 0);
    sky.assert_safe("without a recording");
}

/// If the altitude of a UAV is unknown, the UAV can't be confirmed to be safe.
#[test]
fn a_uav_that_is_lost_in_flight_is_not_safe() {
    let losses = vec![(UAV.to_owned(), Duration::from_secs(5))];
    let sky = Sky::new(uavspec_serve::Options { losses, ..uavspec_serve::Options::default() });
    let limit = Duration::from_secs(20);
    let probed = sky.flown(|_| Pass::Forward, |options| Options { landing_limit: limit, ..options });
    let danger = probed.danger.expect("a UAV");
    assert!(danger.starts_with("UAV glider-2 may still be flying (its altitude is unknown"), "{danger}");
    assert_eq!((sky.count("UAV-HALT"), sky.count("UAV-RTH") <= 1), (0, true));
    assert!(sky.count("UAV-LAND") > 3, "it may come back");
}

/// A null result says neither that the command was refused nor that it was obeyed.
#[test]
fn null_results_neither_delay_a_landing_nor_make_a_uav_return() {
    let sky = Sky::with_nulls();
    let began = sky.clock.now();
    let probed = sky.flown(|_| Pass::Forward, |options| options);
    assert_eq!((&probed.danger, &probed.cut_short), (&None, &None));
    assert_eq!(rules(&probed), BTreeSet::from(["FW-ASY-22"]));
    // The only request to return is part of the survey.
    assert_eq!((sky.count("UAV-RTH"), sky.count("UAV-LAND")), (1, 1), "{:?}", sky.requests.types());
    assert!(!sky.requests.after("UAV-LAND").contains(&"UAV-RTH".to_owned()));
    assert!(sky.clock.now() - began < Duration::from_secs(30));
    sky.assert_safe("after null results");
}

#[test]
fn null_results_of_commands_to_motors_lose_no_flight() {
    let sky = Sky::with_nulls();
    let probed = probed_over(&sky.watched(|_| Pass::Forward), &sky.all_options());
    assert_eq!((&probed.danger, &probed.cut_short), (&None, &None));
    assert_eq!(rules(&probed), BTreeSet::from(["FW-ASY-22"]));
    assert_eq!(sky.count("UAV-MOTOR"), 2, "{:?}", sky.requests.types());
    assert!(sky.count("UAV-TAKEOFF") == 1 && sky.count("UAV-HALT") == 1, "{:?}", sky.requests.types());
    sky.assert_safe("after null results");
}

/// The answers to these requests are lost, but the UAVs obey.
#[test]
fn a_landing_needs_no_answer() {
    for lost in [&["UAV-LAND"][..], &["UAV-TAKEOFF", "UAV-LAND"], &["UAV-RTH", "UAV-LAND"]] {
        let sky = Sky::new(uavspec_serve::Options::default());
        let network = Watched {
            hears: Rc::new(move |bytes| {
                let message: Value = serde_json::from_slice(bytes).expect("JSON");
                !lost.iter().any(|name| message["body"]["type"] == *name)
            }),
            ..sky.watched(|_| Pass::Forward)
        };
        let probed = probed_over(&network, &sky.options());
        assert_eq!(probed.danger, None, "{lost:?}: {:?}", sky.requests.types());
        sky.assert_safe(lost[0]);
    }
}

/// The server reports no states after the takeoff.
#[test]
fn a_uav_whose_state_is_not_reported_is_told_to_land_again_and_again() {
    let sky = Sky::new(uavspec_serve::Options::default());
    let has_taken_off = Rc::new(Cell::new(false));
    let (at, heard) = (Rc::clone(&has_taken_off), has_taken_off);
    let network = Watched {
        hears: Rc::new(move |bytes| !heard.get() || !String::from_utf8_lossy(bytes).contains("UAV-INF")),
        ..sky.watched(move |name| {
            at.set(at.get() || name == "UAV-TAKEOFF");
            Pass::Forward
        })
    };
    let options = Options { landing_limit: Duration::from_secs(60), ..sky.options() };
    let probed = probed_over(&network, &options);
    let danger = probed.danger.expect("a UAV");
    assert!(danger.contains("didn't answer UAV-INF"), "{danger}");
    assert!(sky.count("UAV-LAND") >= 5, "{:?}", sky.requests.types());
    sky.assert_safe("although the probe can't know that");
}

/// The server accepts the first command to land, but the UAV continues to climb.
#[test]
fn an_ignored_command_to_land_is_sent_again_soon_and_is_a_finding() {
    for point in ["UAV-TAKEOFF", "UAV-HOVER", "UAV-FLY"] {
        let sky = Sky::with_bug("FW-UAV-LAND-01");
        let (stop, clock, stopped_at) = (Stop::default(), sky.clock.clone(), Rc::new(Cell::new(None)));
        let (interrupt, at) = (stop.clone(), Rc::clone(&stopped_at));
        let watch = move |name: &str| {
            if name == point && interrupt.request() {
                at.set(Some(clock.now()));
            }
            Pass::Forward
        };
        let probed = sky.flown(watch, |options| Options { stop, ..options });
        assert_eq!(probed.danger, None, "{point}");
        let time = sky.clock.now() - stopped_at.get().expect("a time");
        assert!(time < Duration::from_secs(18), "{point}: {time:?}");
        let expected = if point == "UAV-TAKEOFF" { 1..=2 } else { 2..=2 };
        assert!(expected.contains(&sky.count("UAV-LAND")), "{point}: {:?}", sky.requests.types());
        if sky.count("UAV-LAND") == 2 {
            assert_eq!(rules(&probed), BTreeSet::from(["FW-UAV-LAND-01"]), "{point}");
        }
        sky.assert_safe(point);
    }
}

/// The number of requests in a flight that isn't interrupted.
fn number_of_requests() -> usize {
    let sky = Sky::new(uavspec_serve::Options::default());
    let probed = probed_over(&sky.watched(|_| Pass::Forward), &sky.all_options());
    assert_eq!((probed.danger, probed.cut_short), (None, None));
    sky.requests.types().len()
}

#[test]
fn an_interrupt_at_any_request_leaves_safe_uavs_and_right_reasons() {
    let all = number_of_requests();
    assert!(all > 100, "{all}");
    for number in (0..all).step_by(extent(1, 4)) {
        let sky = Sky::new(uavspec_serve::Options::default());
        let (stop, count) = (Stop::default(), Cell::new(0));
        let interrupt = stop.clone();
        let watch = move |_: &str| {
            if count.replace(count.get() + 1) == number {
                interrupt.request();
            }
            Pass::Forward
        };
        let options = Options { stop: stop.clone(), ..sky.all_options() };
        let probed = probed_over(&sky.watched(watch), &options);
        let context = format!("request {number} of {all}");
        assert_eq!((&probed.danger, stop.at_risk()), (&None, None), "{context}");
        assert_eq!(rules(&probed), BTreeSet::new(), "{context}");
        assert!(stop.is_requested() && probed.cut_short.is_some_and(|why| why.starts_with("interrupted")));
        let reasons: BTreeSet<&str> =
            probed.requests.iter().filter_map(|entry| entry.not_sent.as_deref()).collect();
        let right = ["interrupted", "needs --login", "could move UAVs that are not given with --uav"];
        assert!(reasons.iter().all(|reason| right.contains(reason)), "{context}: {reasons:?}");
        sky.assert_safe(&context);
    }
}

#[test]
fn what_the_user_left_out_is_not_interrupted() {
    let sky = Sky::new(uavspec_serve::Options::default());
    let stop = Stop::default();
    let interrupt = stop.clone();
    let watch = move |name: &str| {
        if name == "UAV-LIST" {
            interrupt.request();
        }
        Pass::Forward
    };
    let probed = sky.flown(watch, |options| Options { stop, uavs: Vec::new(), ..options });
    let reason = |name: &str| {
        let found = probed.requests.iter().find(|entry| entry.name == name).expect(name);
        found.not_sent.clone().unwrap_or_default()
    };
    assert_eq!(reason("UAV-INF"), "interrupted");
    assert_eq!(reason("UAV-FLY"), "needs --allow-commands");
    assert_eq!(reason("WTH-LIST"), "not selected");
}

#[test]
fn waits_for_named_uavs_that_appear_late() {
    let late = |seconds| {
        let appearances = vec![(UAV.to_owned(), Duration::from_secs(seconds))];
        let sky = Sky::new(uavspec_serve::Options { appearances, ..uavspec_serve::Options::default() });
        let probed = probed_over(&sky.watched(|_| Pass::Forward), &sky.all_options());
        assert_eq!((&probed.danger, &probed.cut_short), (&None, &None));
        (sky, probed)
    };
    let (sky, probed) = late(9);
    assert_eq!(probed.left_out, None);
    assert_eq!((sky.count("UAV-RST"), sky.count("UAV-HALT")), (1, 1), "{:?}", sky.requests.types());
    let (sky, probed) = late(90);
    let why = "no commands were sent to glider-2: no such UAV appeared within 30 s";
    assert_eq!(probed.left_out.as_deref(), Some(why));
    assert_eq!(sky.count("UAV-TAKEOFF"), 0);
}

/// A writer that requests the end of the probe when a specific request is recorded.
struct Interrupting {
    stop: Stop,
    point: &'static str,
}

impl std::io::Write for Interrupting {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        if String::from_utf8_lossy(bytes).contains(self.point) {
            self.stop.request();
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// Interrupts a flight over a transport after the UAV has taken off.
fn interrupt_flight(transport: Transport, scheme: &str, query: &str, is_encrypted: bool) {
    use uavspec_flockwave::transport::Trust;
    use uavspec_test_server::proxy::{Proxy, certified};

    use super::flight::assert_safe;
    let options = uavspec_serve::Options { speed: 10.0, ..uavspec_serve::Options::default() };
    let free = SocketAddr::from(([127, 0, 0, 1], 0));
    let server = Server::start(options, &[(Transport::Tcp, free), (transport, free)]).expect("it starts");
    let mut address = server.listening()[1].address;
    let folder = tempfile::tempdir().expect("a folder");
    let mut trust = Trust::default();
    if is_encrypted {
        let (pem, config) = certified(&["127.0.0.1"]);
        let path = folder.path().join("ca.pem");
        std::fs::write(&path, pem).expect("a file");
        trust = Trust::new(Some(&path), false).expect("a certificate");
        address = Proxy { tls: Some(config), ..Proxy::default() }.start(address);
    }
    let endpoint: Endpoint = format!("{scheme}://{address}{query}").parse().expect("an endpoint");
    let stop = Stop::default();
    let options = Options {
        trust,
        stop: stop.clone(),
        clock: Clock::real(),
        ..Sky::new(uavspec_serve::Options::default()).options()
    };
    let record = Interrupting { stop: stop.clone(), point: "UAV-FLY" };
    let probed = probe(&endpoint, &options, &DEFINITIONS, Some(Box::new(record)), &|_, _| {});
    assert!(stop.is_requested(), "{endpoint}");
    assert_eq!((&probed.danger, &probed.failure), (&None, &None), "{endpoint}");
    let reason = probed.cut_short.as_deref().expect("a reason");
    assert!(reason.starts_with("interrupted"), "{endpoint}: {reason}");
    assert_eq!(rules(&probed), BTreeSet::new(), "{endpoint}");
    assert_eq!(stop.at_risk(), None);
    assert_safe(&server, &endpoint.to_string());
}

#[test]
fn lands_uavs_over_each_transport() {
    thread::scope(|scope| {
        for (transport, scheme, query, is_encrypted) in [
            (Transport::Tcp, "tcp", "", false),
            (Transport::Tcp, "tcps", "", true),
            (Transport::Udp, "udp", "", false),
            (Transport::Http, "http", "/api/v1", false),
            (Transport::Http, "https", "/api/v1", true),
            (Transport::SocketIo, "socketio", "", false),
            (Transport::SocketIo, "socketio", "?protocol=4&transport=polling", false),
        ] {
            scope.spawn(move || interrupt_flight(transport, scheme, query, is_encrypted));
        }
    });
}
