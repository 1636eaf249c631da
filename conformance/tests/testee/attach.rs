//! Testees that listen. A server here starts one for every connection, as inetd does.

use std::collections::BTreeSet;
use std::io::{BufRead as _, BufReader, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Barrier, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use uavspec_conformance::testee::{Options, Verdict, check, run};

use super::lint::{assert_good, caught, manners};
use super::{Target, ask, culprit, everything, failures, impatient, options, some, suite, testee};

/// How a server serves.
#[derive(Clone)]
struct Service {
    /// Of the testee that is started.
    arguments: Vec<String>,
    /// Passed by every connection before its first question.
    gate: Option<Arc<Barrier>>,
    /// What was started. All are killed in the end, as those that hang don't end by themselves.
    children: Arc<Mutex<Vec<Child>>>,
}

/// A server. Dropping it ends what it started.
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
        command.args(&self.arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().expect("the testee starts");
        let (mut input, output) = (child.stdin.take().expect("a pipe"), child.stdout.take().expect("a pipe"));
        self.children.lock().unwrap_or_else(PoisonError::into_inner).push(child);
        let questions = stream.try_clone().expect("a handle");
        let gate = self.gate.clone();
        thread::spawn(move || {
            let mut questions = BufReader::new(questions);
            let mut hello = Vec::new();
            // Whatever fails here is what the other side sees, too.
            let _ = questions.read_until(b'\n', &mut hello).and_then(|_| input.write_all(&hello));
            let _ = questions.fill_buf();
            if let Some(gate) = gate {
                gate.wait();
            }
            pump(questions, input);
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

/// Hands on what comes until either side ends. Not by `io::copy`, which lets the system move the bytes: that keeps the
/// pipe locked while it waits for more of them, so that its reader waits too.
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
fn a_testee_that_listens_passes_everything() {
    let server = Server::listen(&[], None);
    let outcome = ask(&everything(), &Options { jobs: 2, ..attached(&server.address(), options(&[])) });
    assert_eq!(failures(&outcome), BTreeSet::new());
    assert!(outcome.protocol_remarks.is_empty(), "{:?}", outcome.protocol_remarks);
    assert_eq!((outcome.counts().passed, outcome.restarts), (suite().cases.len(), 0));
}

#[test]
fn as_many_connections_are_open_as_there_are_jobs() {
    // None is let through to its first question before all three are there.
    let server = Server::listen(&[], Some(Arc::new(Barrier::new(3))));
    let selected = everything();
    let options = Options { jobs: 3, window: 4, ..attached(&server.address(), options(&[])) };
    let outcome = ask(&selected[..60], &options);
    assert_eq!((outcome.counts().passed, outcome.restarts), (60, 0));
}

#[test]
fn names_and_addresses_of_ipv6_are_found() {
    let server = Server::listen(&[], None);
    let outcome = ask(&some(), &attached(&format!("localhost:{}", server.port), options(&[])));
    assert_eq!(outcome.counts().passed, 8);
    let Ok(listener) = TcpListener::bind("[::1]:0") else {
        eprintln!("left out: this machine has no IPv6");
        return;
    };
    let server = Server::on(&listener, &[], None);
    let outcome = ask(&some(), &attached(&format!("[::1]:{}", server.port), options(&[])));
    assert_eq!(outcome.counts().passed, 8);
}

#[test]
fn a_lost_connection_has_a_culprit() {
    // The server lives on, so that the next connection is a new start.
    let guilty = some()[4].to_string();
    let server = Server::listen(&["crash", &guilty], None);
    let (verdict, outcome) = culprit("crash", |_| attached(&server.address(), options(&[])));
    let Verdict::Crashed { how, stderr } = verdict else { panic!("{verdict:?}") };
    assert!(how.contains("connection") || how.contains("reading"), "{how}");
    assert_eq!(stderr, "", "there is none over a connection");
    assert!((2..=3).contains(&outcome.restarts), "{}", outcome.restarts);
}

#[test]
fn a_hang_over_a_connection_has_a_culprit() {
    let guilty = some()[4].to_string();
    let server = Server::listen(&["hang", &guilty], None);
    let (verdict, _) = culprit("hang", |_| attached(&server.address(), impatient(&[])));
    assert!(matches!(verdict, Verdict::TimedOut { .. }), "{verdict:?}");
}

#[test]
fn a_testee_that_takes_a_moment_to_be_there_again_is_waited_for() {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address");
    let arguments = vec!["crash".to_owned(), some()[4].to_string()];
    let service = Service { arguments, gate: None, children: Arc::default() };
    let own = service.clone();
    thread::spawn(move || {
        let mut listener = Some(listener);
        loop {
            // Nobody listens while a testee is served, nor for a while after that.
            let here = listener.take().unwrap_or_else(|| TcpListener::bind(address).expect("the port again"));
            let (stream, _) = here.accept().expect("a connection");
            drop(here);
            own.serve(&stream);
            thread::sleep(Duration::from_millis(200));
        }
    });
    let (verdict, _) = culprit("crash", |_| attached(&address.to_string(), options(&[])));
    assert!(matches!(verdict, Verdict::Crashed { .. }), "{verdict:?}");
    service.kill();
}

#[test]
fn a_testee_that_never_comes_back_ends_the_run() {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address").to_string();
    let arguments = vec!["crash".to_owned(), some()[4].to_string()];
    let service = Service { arguments, gate: None, children: Arc::default() };
    thread::spawn(move || {
        let (stream, _) = listener.accept().expect("a connection");
        drop(listener);
        service.serve(&stream);
    });
    let options = Options { start_timeout: Duration::from_secs(10), ..attached(&address, options(&[])) };
    let outcome = ask(&some(), &options);
    let why = outcome.gave_up.as_ref().expect("it gave up");
    assert!(why.starts_with(&format!("can't connect to {address}: ")), "{why}");
    assert!(why.contains("; before, "), "{why}");
    assert!(outcome.counts().not_run > 0, "{:?}", outcome.counts());
}

#[test]
fn reports_a_refused_connection_immediately() {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address").to_string();
    drop(listener);
    let suite = suite();
    let options = attached(&address, options(&[]));
    let output =
        run(&suite.cases, &some(), &suite.types, &options, &|_, _| {}).map(|_| ()).expect_err("nobody");
    assert!(output.starts_with(&format!("can't connect to {address}: ")), "{output}");
    assert!(output.contains("\n  help: nobody listens there"), "{output}");
    // A name that there never is (RFC 2606).
    let unknown = attached("gliders.invalid:7700", options.clone());
    let output =
        run(&suite.cases, &some(), &suite.types, &unknown, &|_, _| {}).map(|_| ()).expect_err("nobody");
    assert!(output.contains("\n  help: look for a mistake in the name"), "{output}");
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
fn manners_are_tried_over_connections() {
    let server = Server::listen(&[], None);
    assert_good(&manners(&attached(&server.address(), options(&[])), &[]));
    for (mode, expected) in
        [("stays", "ends-by-itself"), ("crash-not-json", "not-json"), ("chatty", "only-answers")]
    {
        let server = Server::listen(&[mode], None);
        let only = [check(expected).expect("a check"), check("not-json").expect("a check")];
        let found = manners(&attached(&server.address(), impatient(&[])), &only);
        assert_eq!(caught(&found), BTreeSet::from([expected]), "{mode}");
    }
}
