//! `uavspec serve`.

mod bug;
mod vehicle;

use std::io::{self, Read as _};
use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;

use clap::Args;
use serde_json::json;
use uavspec_live::bus::Address;
use uavspec_live::vehicle::Namespace;
use uavspec_model::clock::Clock;
use uavspec_model::text::terminal;
use uavspec_serve::{Options, Server, Transport, error, loss};

use self::bug::ServedBug;
use super::test::seconds;
use super::{Exit, Status, uninterruptible};

/// The default address, with the port that Flockwave clients try first.
const DEFAULT_ADDRESS: &str = "127.0.0.1:5001";

/// The interval between checks of whether the server has failed.
const FAILURE_CHECK: Duration = Duration::from_millis(100);

const EXAMPLES: &str = "Examples:
  uavspec serve
  uavspec serve --tcp 127.0.0.1:5001 --udp 127.0.0.1:5001
  uavspec serve --http 127.0.0.1:5002 --socketio 127.0.0.1:5000
  uavspec serve --uavs 20 --battery 35 --speed 10
  uavspec serve --error glider-2=193 --login pilot:secret
  uavspec serve --lose glider-3@20 --stay 60
  uavspec serve --appear glider-2@9 --null-result UAV-LAND
  uavspec serve --tcp 127.0.0.1:0 --for 60 --format json
  uavspec serve --bug FW-UST-HEADING
  uavspec serve --px4 dds://0
  uavspec serve --px4 dds://0 --component --bug PX-EXT-03
  uavspec serve --list-bugs";

const LIMITS: &str = "Limits:
  connections       256; fewer if the process may open fewer files
  Socket.IO         256 sessions; 5 seconds until a new one is used
  UDP               256 clients; 4 MiB of notifications per received datagram
  requests          1 MiB, 30 seconds to send one, 10,000 elements per list
  memory            4 MiB per client and 32 MiB in all of messages to send,
                    16 MiB in all of incomplete requests
  operations        1000 pending per client, 5000 in all
  subscriptions     10,000 per client, 50,000 paths in all

If the server is full, new clients replace clients that never sent a request,
then clients that were idle for 10 seconds. Clients that don't read for 10
seconds are disconnected.";

const STATUS: &str = "Exit status:
  0  normal exit
  2  invalid usage
  3  an address can't be used, or the server failed";

/// Arguments of `serve`.
#[derive(Args, Debug)]
#[allow(clippy::struct_excessive_bools)] // options of a command line
#[command(after_help = EXAMPLES, after_long_help = format!("{EXAMPLES}\n\n{LIMITS}\n\n{STATUS}"))]
pub(super) struct ServeArgs {
    /// Serve TCP: one message per line.
    ///
    /// 127.0.0.1:5001 is used if no address is given for any transport.
    #[arg(long, value_name = "ADDRESS:PORT")]
    tcp: Vec<SocketAddr>,
    /// Serve UDP: one message per datagram.
    #[arg(long, value_name = "ADDRESS:PORT")]
    udp: Vec<SocketAddr>,
    /// Serve HTTP: POST one message to /api/v1.
    #[arg(long, value_name = "ADDRESS:PORT")]
    http: Vec<SocketAddr>,
    /// Serve Socket.IO: events named fw.
    ///
    /// Protocol revisions 4 and 5 are served, over WebSocket and long polling.
    #[arg(long, value_name = "ADDRESS:PORT")]
    socketio: Vec<SocketAddr>,
    /// Serve the arming checks of a PX4 flight controller on this bus, instead of a Flockwave server.
    ///
    /// The URLs are the same as for `uavspec probe`, such as `dds://0`. Don't use the bus of a real vehicle.
    #[arg(long, value_name = "URL", conflicts_with_all = ["tcp", "udp", "http", "socketio"])]
    px4: Option<Address>,
    /// Run a reference external component instead of a flight controller.
    #[arg(long, requires = "px4")]
    component: bool,
    /// Namespace of the vehicle, such as alpha for topics in /alpha/fmu [default: none].
    #[arg(long, value_name = "NAMESPACE", requires = "px4", default_value = "", hide_default_value = true)]
    namespace: Namespace,
    /// IP address of a computer that multicast doesn't reach (DDS, repeatable).
    ///
    /// With 127.0.0.1, only programs on this computer are found.
    #[arg(long, value_name = "ADDRESS", requires = "px4")]
    peer: Vec<IpAddr>,
    /// Definitions of the messages on the bus: a PX4 release such as px4@1.16, or a path [default: the newest release].
    #[arg(long, value_name = "PATH|RELEASE", requires = "px4")]
    definitions: Option<PathBuf>,
    /// Number of UAVs.
    ///
    /// Their ids are glider-1, glider-2 and so on.
    #[arg(long, value_name = "N", default_value = "5", value_parser = clap::value_parser!(u16).range(..=1000))]
    uavs: u16,
    /// Seed of the simulation.
    #[arg(long, value_name = "NUMBER", default_value = "0")]
    seed: u64,
    /// Simulation speed.
    ///
    /// 2 runs twice as fast as real time. Timestamps still follow the system clock.
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = |text: &str| number(text, 0.01, 100.0))]
    speed: f64,
    /// Status reports per second.
    ///
    /// 0 disables them.
    #[arg(long, value_name = "HERTZ", default_value = "2", value_parser = |text: &str| number(text, 0.0, 50.0))]
    rate: f64,
    /// Initial charge of the batteries.
    ///
    /// A UAV reports error code 66 below 30 percent, 134 below 20 percent and 199 below 10 percent.
    #[arg(long, value_name = "PERCENT", default_value = "100", value_parser = clap::value_parser!(u8).range(..=100))]
    battery: u8,
    /// Set an error code of a UAV (repeatable).
    #[arg(long = "error", value_name = "UAV=CODE", value_parser = error)]
    errors: Vec<(String, u16)>,
    /// Lose contact with a UAV (repeatable).
    ///
    /// SECONDS is the time since the first connection.
    #[arg(long = "lose", value_name = "UAV@SECONDS", value_parser = loss)]
    losses: Vec<(String, Duration)>,
    /// Let a UAV appear late (repeatable).
    ///
    /// SECONDS is the time since the first connection.
    #[arg(long = "appear", value_name = "UAV@SECONDS", value_parser = loss)]
    appearances: Vec<(String, Duration)>,
    /// Answer a command with null instead of true (repeatable).
    #[arg(long = "null-result", value_name = "TYPE")]
    null_results: Vec<String>,
    /// Disconnect clients after this time.
    ///
    /// The server first sends SYS-CLOSE.
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    stay: Option<Duration>,
    /// Require a login with AUTH-REQ, method basic.
    #[arg(long, value_name = "NAME:PASSWORD", value_parser = login)]
    login: Option<(String, String)>,
    /// Answer as Skybrush Live expects, where this differs from the specification.
    ///
    /// The response to UAV-PREFLT also has a field result, which equals status. Types may begin with X-, as in
    /// X-RTK-SOURCE. An RTK-SURVEY with settings is answered with ACK-ACK.
    #[arg(long)]
    skybrush: bool,
    /// Violate this rule on purpose.
    ///
    /// --list-bugs shows which other rules each bug violates.
    #[arg(long, value_name = "RULE", value_parser = ServedBug::find)]
    bug: Option<ServedBug>,
    /// List the rules for --bug, with a description of each bug.
    #[arg(long, conflicts_with_all = ["bug", "tcp", "udp", "http", "socketio", "px4"])]
    list_bugs: bool,
    /// Exit after this time.
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds)]
    time: Option<Duration>,
    /// Exit when standard input is closed.
    ///
    /// Useful for programs that start the server as a child process.
    #[arg(long)]
    until_stdin_closes: bool,
    /// Output format: text or json.
    #[arg(long, default_value = "text", hide_possible_values = true)]
    format: super::Format,
}

pub(super) fn serve(args: &ServeArgs) -> Exit {
    if args.list_bugs {
        bug::list(args.format);
        return Ok(Status::Conforms);
    }
    if let Some(problem) = bug::misplaced(args) {
        return Err(Status::Usage.because(problem));
    }
    if let Some(address) = &args.px4 {
        return vehicle::serve_vehicle(args, address);
    }
    let named = args.errors.iter().map(|(id, _)| ("error", id));
    let named = named.chain(args.losses.iter().map(|(id, _)| ("lose", id)));
    let named = named.chain(args.appearances.iter().map(|(id, _)| ("appear", id)));
    if let Some((option, id)) = named.into_iter().find(|(_, id)| !has_uav(args.uavs, id)) {
        let problem = format!("--{option} {id}: the fleet consists of glider-1 to glider-{}", args.uavs);
        return Err(Status::Usage.because(problem));
    }
    let server = Server::start(options(args), &addresses(args));
    let server = server.map_err(|error| Status::Unreadable.because(error))?;
    let (sender, ending) = channel();
    end_on_request(args, sender)?;
    for listening in server.listening() {
        match args.format {
            super::Format::Text => terminal::println!("{listening}"),
            super::Format::Json => {
                let (transport, address) = (listening.transport.name(), listening.address);
                terminal::println!(
                    "{}",
                    json!({ "transport": transport, "address": address, "port": address.port() })
                );
            }
        }
    }
    bug::announce(args.bug.as_ref());
    wait(&server, &ending, args.time);
    if server.has_failed() {
        return Err(Status::Unreadable.because("the server stopped because of an internal error"));
    }
    for (reason, count) in server.end() {
        terminal::eprintln!("{count} × {reason}");
    }
    Ok(Status::Conforms)
}

/// Waits until the end is requested, the time has passed, or the server has failed.
fn wait(server: &Server, ending: &Receiver<()>, time: Option<Duration>) {
    let started = Clock::real().now();
    while !server.has_failed() {
        let left = time.map_or(Duration::MAX, |time| time.saturating_sub(Clock::real().now() - started));
        let is_requested = ending.recv_timeout(left.min(FAILURE_CHECK)) != Err(RecvTimeoutError::Timeout);
        if is_requested || left <= FAILURE_CHECK {
            return;
        }
    }
}

fn options(args: &ServeArgs) -> Options {
    Options {
        uavs: args.uavs.into(),
        seed: args.seed,
        speed: args.speed,
        rate: args.rate,
        charge: args.battery.into(),
        errors: args.errors.clone(),
        losses: args.losses.clone(),
        appearances: args.appearances.clone(),
        null_results: args.null_results.clone(),
        stay: args.stay,
        login: args.login.clone(),
        is_for_skybrush: args.skybrush,
        bug: args.bug.as_ref().and_then(|bug| bug.of_server),
        ..Options::default()
    }
}

fn addresses(args: &ServeArgs) -> Vec<(Transport, SocketAddr)> {
    let options = [
        (Transport::Tcp, &args.tcp),
        (Transport::Udp, &args.udp),
        (Transport::Http, &args.http),
        (Transport::SocketIo, &args.socketio),
    ];
    let given = options
        .into_iter()
        .flat_map(|(transport, list)| list.iter().map(move |address| (transport, *address)));
    let mut given: Vec<_> = given.collect();
    if given.is_empty() {
        given.extend(DEFAULT_ADDRESS.parse().ok().map(|address| (Transport::Tcp, address)));
    }
    given
}

/// Sends a message when the user presses Ctrl-C or, if requested, when standard input is closed. Prints errors.
fn end_on_request(args: &ServeArgs, sender: Sender<()>) -> Result<(), Status> {
    if args.until_stdin_closes {
        let sender = sender.clone();
        thread::spawn(move || {
            let mut input = io::stdin().lock();
            let mut buffer = [0; 1024];
            while !matches!(input.read(&mut buffer), Ok(0) | Err(_)) {}
            // The server may already have ended.
            let _ = sender.send(());
        });
    }
    ctrlc::set_handler(move || {
        let _ = sender.send(());
    })
    .map_err(uninterruptible)
}

fn has_uav(count: u16, id: &str) -> bool {
    (1..=count).any(|number| id == format!("glider-{number}"))
}

pub(super) fn login(text: &str) -> Result<(String, String), String> {
    let (name, password) = text.split_once(':').ok_or("expected NAME:PASSWORD")?;
    if name.is_empty() {
        Err("the name is empty".to_owned())
    } else {
        Ok((name.to_owned(), password.to_owned()))
    }
}

fn number(text: &str, min: f64, max: f64) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if (min..=max).contains(&number) { Ok(number) } else { Err(format!("expected {min} to {max}")) }
}
