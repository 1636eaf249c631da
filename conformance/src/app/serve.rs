//! `uavspec serve`.

use std::io::{self, Read as _};
use std::net::SocketAddr;
use std::sync::mpsc::{Sender, channel};
use std::thread;
use std::time::Duration;

use clap::Args;
use serde_json::json;

use super::Status;
use super::test::seconds;
use crate::rules::flockwave::{self, FlockwaveRule};
use crate::serve::{Options, Server, Transport, error, loss};

/// Where the server listens where nothing is said: the port that clients of the protocol try first.
const DEFAULT_ADDRESS: &str = "127.0.0.1:5001";

/// Arguments of `serve`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  uavspec serve
  uavspec serve --tcp 127.0.0.1:5001 --udp 127.0.0.1:5001 --http 127.0.0.1:5002 --socketio 127.0.0.1:5000
  uavspec serve --uavs 20 --battery 35 --speed 10
  uavspec serve --error glider-2=193 --login pilot:secret
  uavspec serve --lose glider-3@20 --stay 60
  uavspec serve --tcp 127.0.0.1:0 --for 60 --format json
  uavspec serve --bug FW-UST-HEADING
  uavspec serve --list-bugs

It prints where it listens, a line for each transport; port 0 finds a free port. It takes commands of clients for
UAVs that are simulated, and OBJ-CMD with the commands error (args: codes; none clears them), battery (args: the
charge in percent) and lose (nothing is heard of the UAV any more).

HTTP and Socket.IO are both served at the addresses of either, as they mostly have one port.

Whoever can reach an address can use the server: without a need, let it listen at this machine only.

Exit status: 0 it ended as it should, 2 wrong usage, 3 an address can't be listened at.")]
pub(super) struct ServeArgs {
    /// Serve TCP at this address: a message a line. It is 127.0.0.1:5001 where no address is given at all.
    #[arg(long, value_name = "ADDRESS:PORT")]
    tcp: Vec<SocketAddr>,
    /// Serve UDP: a message a datagram.
    #[arg(long, value_name = "ADDRESS:PORT")]
    udp: Vec<SocketAddr>,
    /// Serve HTTP: a message in the body of a POST to /api/v1, the answer in the response.
    #[arg(long, value_name = "ADDRESS:PORT")]
    http: Vec<SocketAddr>,
    /// Serve Socket.IO, protocol revisions 4 and 5, over a WebSocket and by long polling: events fw.
    #[arg(long, value_name = "ADDRESS:PORT")]
    socketio: Vec<SocketAddr>,
    /// How many UAVs there are: glider-1, glider-2 and so on.
    #[arg(long, value_name = "N", default_value = "5", value_parser = clap::value_parser!(u16).range(..=1000))]
    uavs: u16,
    /// What the small variations of the simulation depend on.
    #[arg(long, value_name = "NUMBER", default_value = "0")]
    seed: u64,
    /// How many times as fast as life the simulation goes. Time stamps stay those of the clock.
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = speed)]
    speed: f64,
    /// How often clients are told of the fleet, a second; 0 for never.
    #[arg(long, value_name = "HERTZ", default_value = "2", value_parser = rate)]
    rate: f64,
    /// The charge of the batteries at the start, in percent. They have the error codes 66 below 30, 134 below 20 and
    /// 199 below 10.
    #[arg(long, value_name = "PERCENT", default_value = "100", value_parser = clap::value_parser!(u8).range(..=100))]
    battery: u8,
    /// Give a UAV an error code; may be given several times.
    #[arg(long = "error", value_name = "UAV=CODE", value_parser = error)]
    errors: Vec<(String, u16)>,
    /// Let a UAV get lost some seconds after the start; may be given several times.
    #[arg(long = "lose", value_name = "UAV@SECONDS", value_parser = loss)]
    losses: Vec<(String, Duration)>,
    /// Say farewell to each client some seconds after it came (SYS-CLOSE), and end its connection.
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    stay: Option<Duration>,
    /// Serve only those who log in so (AUTH-REQ, method basic).
    #[arg(long, value_name = "NAME:PASSWORD", value_parser = login)]
    login: Option<(String, String)>,
    /// Break this rule, and as far as can be no other.
    #[arg(long, value_name = "RULE", value_parser = known_bug)]
    bug: Option<&'static FlockwaveRule>,
    /// List the rules that can be broken, and how that is done.
    #[arg(long, conflicts_with_all = ["bug", "tcp", "udp", "http", "socketio"])]
    list_bugs: bool,
    /// End after some seconds.
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds)]
    time: Option<Duration>,
    /// End with the standard input, as programs do that another one starts.
    #[arg(long)]
    until_stdin_closes: bool,
    /// How to print where it listens, and lists.
    #[arg(long, default_value = "text")]
    format: super::Format,
}

pub(super) fn serve(args: &ServeArgs) -> Status {
    if args.list_bugs {
        return list(args.format);
    }
    let named = args.errors.iter().map(|(id, _)| ("error", id));
    let named = named.chain(args.losses.iter().map(|(id, _)| ("lose", id)));
    if let Some((option, id)) = named.into_iter().find(|(_, id)| !has_uav(args.uavs, id)) {
        anstream::eprintln!("error: --{option} {id}: the fleet has glider-1 to glider-{}", args.uavs);
        return Status::Usage;
    }
    let server = match Server::start(options(args), &addresses(args)) {
        Ok(server) => server,
        Err(error) => {
            anstream::eprintln!("error: {error}");
            return Status::Unreadable;
        }
    };
    let (sender, ending) = channel();
    if let Err(error) = watch(args, sender) {
        anstream::eprintln!("error: {error}");
        return Status::Unreadable;
    }
    for listening in server.listening() {
        match args.format {
            super::Format::Text => anstream::println!("{listening}"),
            super::Format::Json => {
                let (transport, address) = (listening.transport.name(), listening.address);
                anstream::println!(
                    "{}",
                    json!({ "transport": transport, "address": address, "port": address.port() })
                );
            }
        }
    }
    if let Some(FlockwaveRule { rule, bug, .. }) = args.bug {
        anstream::eprintln!("bug {}: {}", rule.id, bug.description);
    }
    // Where nobody is left who could say that it is to end, it ends as well.
    let _ = match args.time {
        Some(time) => ending.recv_timeout(time).ok(),
        None => ending.recv().ok(),
    };
    server.end();
    Status::Conforms
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
        stay: args.stay,
        login: args.login.clone(),
        bug: args.bug,
        ..Options::default()
    }
}

fn addresses(args: &ServeArgs) -> Vec<(Transport, SocketAddr)> {
    let location = [
        (Transport::Tcp, &args.tcp),
        (Transport::Udp, &args.udp),
        (Transport::Http, &args.http),
        (Transport::SocketIo, &args.socketio),
    ];
    let given = location
        .into_iter()
        .flat_map(|(transport, list)| list.iter().map(move |location| (transport, *location)));
    let mut given: Vec<_> = given.collect();
    if given.is_empty() {
        given.extend(DEFAULT_ADDRESS.parse().ok().map(|location| (Transport::Tcp, location)));
    }
    given
}

/// Lets a message come when somebody wants the server to end.
fn watch(args: &ServeArgs, sender: Sender<()>) -> Result<(), String> {
    if args.until_stdin_closes {
        let sender = sender.clone();
        thread::spawn(move || {
            let mut input = io::stdin().lock();
            let mut piece = [0; 1024];
            while !matches!(input.read(&mut piece), Ok(0) | Err(_)) {}
            // The server may have ended already.
            let _ = sender.send(());
        });
    }
    ctrlc::set_handler(move || {
        let _ = sender.send(());
    })
    .map_err(|error| format!("signals can't be waited for: {error}"))
}

fn list(format: super::Format) -> Status {
    for FlockwaveRule { rule, bug, .. } in flockwave::RULES {
        let also: Vec<&str> = bug.also.iter().map(|rule| rule.id).collect();
        match format {
            super::Format::Text => {
                let also = if also.is_empty() {
                    String::new()
                } else {
                    format!(" Breaks {} as well.", also.join(", "))
                };
                anstream::println!("{:<18} {}{also}", rule.id, bug.description);
            }
            super::Format::Json => {
                anstream::println!("{}", json!({ "rule": rule.id, "what": bug.description, "also": also }));
            }
        }
    }
    Status::Conforms
}

fn has_uav(count: u16, id: &str) -> bool {
    (1..=count).any(|number| id == format!("glider-{number}"))
}

fn known_bug(rule: &str) -> Result<&'static FlockwaveRule, String> {
    flockwave::rule(rule).ok_or_else(|| "no bug breaks this rule: --list-bugs lists all".to_owned())
}

pub(super) fn login(text: &str) -> Result<(String, String), String> {
    let (name, password) = text.split_once(':').ok_or("write NAME:PASSWORD")?;
    if name.is_empty() {
        Err("the name is missing".to_owned())
    } else {
        Ok((name.to_owned(), password.to_owned()))
    }
}

fn speed(text: &str) -> Result<f64, String> {
    number(text, 0.01, 100.0)
}

fn rate(text: &str) -> Result<f64, String> {
    number(text, 0.0, 50.0)
}

fn number(text: &str, least: f64, most: f64) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "no number".to_owned())?;
    if (least..=most).contains(&number) { Ok(number) } else { Err(format!("not from {least} to {most}")) }
}
