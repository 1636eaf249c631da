//! Tests of testees that listen on a port. The server in these tests starts a testee for each connection, like inetd.

use std::collections::BTreeSet;
use std::io::{BufRead as _, BufReader, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Barrier, Mutex, PoisonError};
use std::thread;

use uavspec_model::clock::Clock;
use uavspec_probe::testee::{Options, Verdict, check, run};
use uavspec_test_support::free_address;

use super::lint::{assert_good, failed_checks, lint_testee};
use super::{
    DEFINITIONS, Target, all_cases, culprit, failures, impatient, options, patiently, run_cases, some_cases,
    suite, testee,
};

/// Options of a server.
#[derive(Clone)]
struct Service {
    /// The arguments of the testee.
    arguments: Vec<String>,
    /// A barrier at which each connection waits before its first request.
    gate: Option<Arc<Barrier>>,
    /// The processes that have been started. They are killed at the end, because some of them hang.
    children: Arc<Mutex<Vec<Child>>>,
}

/// A server. Dropping it kills the testees that it started.
struct Server {
    port: u16,
    service: Service,
}

impl Server {
    fn listen(arguments: &[&str], gate: Option<Arc<Barrier>>) -> Self {
        Self::on(&TcpListener::bind("127.0.0.1:0").expect("a port"), arguments, gate)
    }

    fn on(listener: &TcpListener, arguments: &[&str], gate: Option<Arc<Barrier>>) -> Self {
        let arguments = arguments.iter().map(|argument| (*argument).to_owned()).collect();
        let service = Service { arguments, gate, children: Arc::default() };
        let port = listener.local_addr().expect("an address").port();
        let (own, listener) = (service.clone(), listener.try_clone().expect("a handle"));
        thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let service = own.clone();
                thread::spawn(move || service.serve(&stream));
            }
        });
        Self { port, service }
    }

    fn address(&self) -> String {
        format!("127.0.0.1:{}", self.port)
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.service.kill();
    }
}

impl Service {
    fn serve(&self, stream: &TcpStream) {
        let mut command = Command::new(testee());
        command
            .args(["--definitions", DEFINITIONS])
            .args(&self.arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null());
        let mut child = command.spawn().expect("the testee starts");
        let (mut input, output) = (child.stdin.take().expect("a pipe"), child.stdout.take().expect("a pipe"));
        self.children.lock().unwrap_or_else(PoisonError::into_inner).push(child);
        let requests = stream.try_clone().expect("a handle");
        let gate = self.gate.clone();
        thread::spawn(move || {
            let mut requests = BufReader::new(requests);
            let mut hello = Vec::new();
            // The peer also observes errors.
            let _ = requests.read_until(b'\n', &mut hello).and_then(|_| input.write_all(&hello));
            let _ = requests.fill_buf();
            if let Some(gate) = gate {
                gate.wait();
            }
            pump(requests, input);
        });
        pump(output, stream);
        let _ = stream.shutdown(Shutdown::Both);
    }

    fn kill(&self) {
        for child in self.children.lock().unwrap_or_else(PoisonError::into_inner).iter_mut() {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// Copies data until either side ends. Doesn't use `io::copy`, in which the kernel would lock the pipe while it waits
/// for data, which would block the reader.
fn pump(mut from: impl Read, mut to: impl Write) {
    let mut buffer = [0; 4096];
    while let Ok(count @ 1..) = from.read(&mut buffer) {
        if to.write_all(&buffer[..count]).is_err() {
            return;
        }
    }
}

fn attached(address: &str, mut options: Options) -> Options {
    options.target = Target::Address(address.parse().expect("an address"));
    options
}

#[test]
fn a_listening_testee_passes_all_cases() {
    let server = Server::listen(&[], None);
    let outcome = run_cases(&all_cases(), &Options { jobs: 2, ..attached(&server.address(), options(&[])) });
    assert_eq!(failures(&outcome), BTreeSet::new());
    assert!(outcome.protocol_remarks.is_empty(), "{:?}", outcome.protocol_remarks);
    assert_eq!((outcome.counts().passed, outcome.restarts), (suite().cases.len() as u64, 0));
}

#[test]
fn opens_one_connection_per_job() {
    // No connection sends its first request before all three connections are open.
    let server = Server::listen(&[], Some(Arc::new(Barrier::new(3))));
    let selected = all_cases();
    let options = Options { jobs: 3, window: 4, ..attached(&server.address(), options(&[])) };
    let outcome = run_cases(&selected[..60], &options);
    assert_eq!((outcome.counts().passed, outcome.restarts), (60, 0));
}

#[test]
fn connects_to_host_names_and_ipv6_addresses() {
    let server = Server::listen(&[], None);
    let outcome = run_cases(&some_cases(), &attached(&format!("localhost:{}", server.port), options(&[])));
    assert_eq!(outcome.counts().passed, 8);
    let Ok(listener) = TcpListener::bind("[::1]:0") else {
        eprintln!("skipped: this machine has no IPv6");
        return;
    };
    let server = Server::on(&listener, &[], None);
    let outcome = run_cases(&some_cases(), &attached(&format!("[::1]:{}", server.port), options(&[])));
    assert_eq!(outcome.counts().passed, 8);
}

#[test]
fn reports_the_case_that_closes_the_connection() {
    // The server keeps running, so a new connection counts as a restart.
    let id = some_cases()[4].to_string();
    let server = Server::listen(&["crash", &id], None);
    let (verdict, outcome) = culprit("crash", |_| attached(&server.address(), options(&[])));
    let Verdict::Crashed { how, stderr } = verdict else { panic!("{verdict:?}") };
    assert!(how.contains("connection") || how.contains("reading"), "{how}");
    assert_eq!(stderr, "", "a connection has no standard error");
    assert!((2..=3).contains(&outcome.restarts), "{}", outcome.restarts);
}

#[test]
fn reports_the_case_that_hangs_over_a_connection() {
    let id = some_cases()[4].to_string();
    let server = Server::listen(&["hang", &id], None);
    let attached = |clock: &Clock| attached(&server.address(), impatient(&[], clock));
    let (verdict, _) = patiently(|clock| culprit("hang", |_| attached(clock)));
    assert!(matches!(verdict, Verdict::TimedOut { .. }), "{verdict:?}");
}

#[test]
fn waits_for_a_restarting_testee() {
    let address = free_address();
    let listener = TcpListener::bind(address).expect("a port");
    let arguments = vec!["crash".to_owned(), some_cases()[4].to_string()];
    let service = Service { arguments, gate: None, children: Arc::default() };
    let own = service.clone();
    thread::spawn(move || {
        let mut listener = Some(listener);
        loop {
            // The port is closed while a testee is running.
            let here = listener.take().unwrap_or_else(|| TcpListener::bind(address).expect("the port again"));
            let (stream, _) = here.accept().expect("a connection");
            drop(here);
            own.serve(&stream);
        }
    });
    let (verdict, _) = culprit("crash", |_| attached(&address.to_string(), options(&[])));
    assert!(matches!(verdict, Verdict::Crashed { .. }), "{verdict:?}");
    service.kill();
}

#[test]
fn gives_up_if_the_testee_does_not_come_back() {
    let address = free_address().to_string();
    let listener = TcpListener::bind(&address).expect("a port");
    let arguments = vec!["crash".to_owned(), some_cases()[4].to_string()];
    let service = Service { arguments, gate: None, children: Arc::default() };
    thread::spawn(move || {
        let (stream, _) = listener.accept().expect("a connection");
        drop(listener);
        service.serve(&stream);
    });
    let options = Options { clock: Clock::simulated(), ..attached(&address, options(&[])) };
    let outcome = run_cases(&some_cases(), &options);
    let why = outcome.gave_up.as_ref().expect("a reason");
    assert!(why.starts_with(&format!("can't connect to {address}: ")), "{why}");
    assert!(why.contains("\n  note: before that, "), "{why}");
    assert!(outcome.counts().not_run > 0, "{:?}", outcome.counts());
}

#[test]
fn reports_a_refused_connection_immediately() {
    let address = free_address().to_string();
    let suite = suite();
    let options = attached(&address, options(&[]));
    let output = run(&suite.cases, &some_cases(), &suite.types, &options, &|_, _| {})
        .map(|_| ())
        .expect_err("an error");
    assert!(output.starts_with(&format!("can't connect to {address}: ")), "{output}");
    assert!(output.contains("\n  help: nothing listens on this port"), "{output}");
    // A reserved name that never exists (RFC 2606).
    let unknown = attached("gliders.invalid:7700", options.clone());
    let output = run(&suite.cases, &some_cases(), &suite.types, &unknown, &|_, _| {})
        .map(|_| ())
        .expect_err("an error");
    assert!(output.contains("\n  help: check the host name"), "{output}");
    for (arguments, status) in [
        (vec!["test", "--attach", &address], 3),
        (vec!["testee", "lint", "--attach", &address], 3),
        (vec!["test", "--attach", "2001:db8::7:7700"], 2),
        (vec!["test", "--attach", &address, "--", "testee"], 2),
    ] {
        let run =
            Command::new(env!("CARGO_BIN_EXE_uavspec")).args(&arguments).output().expect("uavspec runs");
        assert_eq!(run.status.code(), Some(status), "{arguments:?}");
    }
}

#[test]
fn lints_testees_over_connections() {
    let server = Server::listen(&[], None);
    assert_good(&lint_testee(&attached(&server.address(), options(&[])), &[]));
    for (mode, expected) in
        [("stays", "ends-by-itself"), ("crash-not-json", "not-json"), ("chatty", "only-answers")]
    {
        let server = Server::listen(&[mode], None);
        let only = [check(expected).expect("a check"), check("not-json").expect("a check")];
        let lint = |clock: &Clock| lint_testee(&attached(&server.address(), impatient(&[], clock)), &only);
        let found = patiently(lint);
        assert_eq!(failed_checks(&found), BTreeSet::from([expected]), "{mode}");
    }
}
