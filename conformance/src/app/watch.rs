//! `uavspec watch`.

mod vehicle;

use std::fmt::Display;
use std::io::{self, IsTerminal as _};
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use clap::Args;
use ratatui::DefaultTerminal;
use ratatui::crossterm::event;
use uavspec_capture::names::is_capture;
use uavspec_flockwave::transport::access::Access;
use uavspec_flockwave::transport::endpoint::Endpoint;
use uavspec_live::watch::codes::Codes;
use uavspec_live::watch::fleet::{Fleet, Link};
use uavspec_live::watch::list::table;
use uavspec_live::watch::screen::{Screen, Step};
use uavspec_live::watch::session::{self, Event};
use uavspec_live::watch::view::{Scene, Theme, draw};
use uavspec_model::clock::Clock;
use uavspec_rules::definitions::Definitions;

use self::vehicle::VehicleArgs;
use super::access::AccessArgs;
use super::outputs::{self, Inputs};
use super::report::print_result;
use super::target::Target;
use super::test::seconds;
use super::{Exit, Status};

/// The capacity of the input queue. While the queue is full, no messages are received.
const WAITING_LIMIT: usize = 16;

/// The minimum time between two frames.
const MIN_FRAME_TIME: Duration = Duration::from_millis(100);

/// The time that --once waits for the UAVs of a server.
const TIME: Duration = Duration::from_secs(5);

/// The maximum time between two frames. It ensures that the displayed ages increase even if there are no inputs.
const MAX_FRAME_TIME: Duration = Duration::from_millis(500);

const EXAMPLES: &str = "Examples:
  uavspec watch tcp://localhost:5001
  uavspec watch 'socketio://localhost:5000?protocol=4&transport=polling'
  uavspec watch http://localhost:5000/api/v1
  uavspec watch --once tcp://localhost:5001 | awk '$2 == \"fatal\" { print $1 }'
  uavspec watch --once --for 30 udp://localhost:5001
  uavspec watch dds://0
  uavspec watch zenoh://localhost:7447 --language uk
  uavspec watch flight.ulg
  uavspec watch --once --for 10 flight.mcap";

const STATUS: &str = "Exit status:
  0  normal exit
  2  invalid usage
  3  the terminal can't be used, the vehicle or capture can't be read, or some
     UAVs did not report within the --for time";

/// Arguments of `watch`.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES, after_long_help = format!("{EXAMPLES}\n\n{STATUS}"))]
pub(super) struct WatchArgs {
    /// URL of a Flockwave server (tcp, udp, http, socketio) or a PX4 vehicle (dds, zenoh, foxglove, rosbridge), or a
    /// capture.
    ///
    /// Servers: tcp://HOST:PORT, udp://HOST:PORT, http://HOST:PORT/PATH or socketio://HOST:PORT. Socket.IO URLs may end
    /// in ?protocol=4 or ?protocol=5 (default), and &transport=polling or &transport=websocket (default). With TLS:
    /// tcps, https or socketios.
    ///
    /// Vehicles: `dds://DOMAIN`, zenoh://HOST:PORT, foxglove://HOST:PORT or rosbridge://HOST:PORT. Zenoh URLs may end in
    /// ?domain=NUMBER. Vehicles require a program that was built with the feature `live`, or with the feature of the
    /// transport, such as `dds`.
    ///
    /// Captures: the path of a PX4 log, a bag, or a file with JSON messages. The capture is replayed.
    #[arg(value_name = "URL|FILE")]
    source: Source,
    #[command(flatten)]
    access: AccessArgs,
    /// Print the state once and exit.
    ///
    /// The table of a server is printed when all UAVs have reported their state. This is the default if the output is
    /// not a terminal.
    #[arg(long)]
    once: bool,
    /// Time that --once waits for messages [default: 5; for a capture: until its end].
    ///
    /// For a server, this is the maximum time: the table then shows the known states. For a capture, this is the time
    /// after its start.
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds)]
    time: Option<Duration>,
    #[command(flatten)]
    vehicle: VehicleArgs,
}

/// The source of the displayed state.
#[derive(Clone, Debug)]
enum Source {
    /// A server or a vehicle.
    Target(Target),
    /// A capture.
    Capture(PathBuf),
}

impl FromStr for Source {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let path = PathBuf::from(text);
        if path.exists() || !text.contains("://") && is_capture(&path) {
            return Ok(Self::Capture(path));
        }
        text.parse().map(Self::Target)
    }
}

/// An input of the screen.
enum Input {
    /// A connection event, with its time.
    Server(Event, Instant),
    /// A terminal event. No events follow an error.
    Terminal(io::Result<event::Event>),
    /// A request to quit.
    End,
}

pub(super) fn watch(args: &WatchArgs) -> Exit {
    let (given, noun) = match args.source {
        Source::Target(Target::Server(_)) => (args.vehicle.given(), "PX4 vehicles and captures"),
        Source::Target(Target::Vehicle(_)) | Source::Capture(_) => (args.access.given(), "Flockwave servers"),
    };
    if let Some(option) = given {
        return Err(Status::Usage.because(format_args!("{option} applies only to {noun}")));
    }
    match &args.source {
        Source::Target(Target::Server(endpoint)) => watch_server(args, endpoint),
        Source::Target(Target::Vehicle(address)) => vehicle::watch_vehicle(args, address),
        Source::Capture(path) => {
            // If the state were written to the capture itself, reading the capture would never end.
            let inputs = Inputs { files: vec![path], ..Inputs::default() };
            outputs::check(&inputs, &[])?;
            vehicle::watch_capture(args, path)
        }
    }
}

fn watch_server(args: &WatchArgs, endpoint: &Endpoint) -> Exit {
    let access = Access::new(args.access.login.clone(), args.access.trust()?);
    let codes = Codes::new(&Definitions::built_in());
    let (sender, inputs) = sync_channel(WAITING_LIMIT);
    let on_event = {
        let sender = sender.clone();
        move |event| sender.send(Input::Server(event, Clock::real().now())).is_ok()
    };
    session::start(endpoint.clone(), access, on_event);
    if args.once || !io::stdout().is_terminal() {
        watch_once(args.time.unwrap_or(TIME), endpoint, &codes, &inputs)
    } else {
        watch_live(endpoint, &codes, sender, &inputs).map(|()| Status::Conforms).map_err(unusable_terminal)
    }
}

/// Waits until all UAVs have reported their state, or until the time has passed. Then prints the table.
fn watch_once(time: Duration, endpoint: &Endpoint, codes: &Codes, inputs: &Receiver<Input>) -> Exit {
    let clock = Clock::real();
    let fleet = gather(&clock, time, inputs);
    if fleet.is_complete() || !fleet.is_empty() {
        print_result(&table(&fleet, codes, clock.now()))?;
    }
    if fleet.is_complete() {
        return Ok(Status::Conforms);
    }
    let (reason, seconds) = (missing(&fleet), time.as_secs_f64());
    Err(Status::Unreadable.because(format_args!("{endpoint}: {reason} (within {seconds} s)")))
}

/// Prints an error about the terminal.
fn unusable_terminal(error: impl Display) -> Status {
    Status::Unreadable.because(format_args!("can't use the terminal: {error}"))
}

/// Processes events until all UAVs have reported their state, or until the time has passed.
fn gather(clock: &Clock, time: Duration, inputs: &Receiver<Input>) -> Fleet {
    let until = clock.now() + time;
    let mut fleet = Fleet::default();
    while !fleet.is_complete() {
        let Ok(input) = clock.receive(inputs, until) else { break };
        if let Input::Server(event, now) = input {
            fleet.take(event, now);
        }
    }
    fleet
}

/// The reason why a fleet is incomplete.
fn missing(fleet: &Fleet) -> String {
    match (&fleet.link, &fleet.remark) {
        (Link::Lost { reason, .. }, _) => uavspec_model::text::shown(reason),
        (Link::Connecting, _) => "the server doesn't respond".to_owned(),
        (Link::Connected, Some(remark)) => remark.clone(),
        (Link::Connected, None) if fleet.is_empty() => "the server didn't send a list of its UAVs".to_owned(),
        (Link::Connected, None) => "some UAVs did not report their state".to_owned(),
    }
}

/// Restores the terminal when it is dropped.
struct Restore;

impl Drop for Restore {
    fn drop(&mut self) {
        ratatui::restore();
    }
}

/// Shows the fleet until the user quits.
fn watch_live(
    endpoint: &Endpoint,
    codes: &Codes,
    sender: SyncSender<Input>,
    inputs: &Receiver<Input>,
) -> io::Result<()> {
    let (url, theme) = (endpoint.to_string(), theme());
    let draw = |(fleet, screen): &mut (Fleet, Screen), terminal: &mut DefaultTerminal, now| {
        let scene = Scene { fleet, codes, url: &url, theme, now };
        terminal.draw(|frame| draw(frame, &scene, screen)).map(|_| Step::Stay)
    };
    let take = |(fleet, screen): &mut (Fleet, Screen), input| match input {
        Input::Server(event, now) => {
            fleet.take(event, now);
            Step::Stay
        }
        Input::Terminal(Ok(event::Event::Key(key))) => screen.press(key, fleet),
        Input::Terminal(_) => Step::Stay,
        Input::End => Step::Quit,
    };
    show(Default::default(), (sender, inputs), MAX_FRAME_TIME, draw, take)
}

/// Shows frames until the user quits. `draw` draws a frame, and `take` processes an input.
fn show<S>(
    mut state: S,
    (sender, inputs): (SyncSender<Input>, &Receiver<Input>),
    max_frame_time: Duration,
    draw: impl Fn(&mut S, &mut DefaultTerminal, Instant) -> io::Result<Step>,
    take: impl Fn(&mut S, Input) -> Step,
) -> io::Result<()> {
    install_end(&sender)?;
    let _restore = Restore;
    let mut terminal = ratatui::try_init()?;
    thread::spawn(move || forward_terminal_events(&sender));
    let clock = Clock::real();
    loop {
        let drawn = clock.now();
        let mut step = draw(&mut state, &mut terminal, drawn)?;
        let mut due = drawn + max_frame_time;
        while step == Step::Stay {
            step = match clock.receive(inputs, due) {
                Ok(Input::Terminal(Err(error))) => return Err(error),
                Ok(input) => take(&mut state, input),
                Err(RecvTimeoutError::Disconnected) => Step::Quit,
                Err(RecvTimeoutError::Timeout) => break,
            };
            due = drawn + MIN_FRAME_TIME;
            // A server that sends continuously must not delay the next frame.
            if clock.now() >= due {
                break;
            }
        }
        if step == Step::Quit {
            return Ok(());
        }
    }
}

/// Requests the end of the display when a signal that ends programs arrives.
fn install_end(sender: &SyncSender<Input>) -> io::Result<()> {
    let ending = sender.clone();
    let on_signal = move || {
        // The receiver may already be gone.
        let _ = ending.send(Input::End);
    };
    ctrlc::set_handler(on_signal).map_err(io::Error::other)
}

/// The styles, without colours if the environment disables them.
fn theme() -> Theme {
    Theme { is_coloured: std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty()) }
}

/// Forwards terminal events to the input queue.
fn forward_terminal_events(sender: &SyncSender<Input>) {
    loop {
        let event = event::read();
        let is_end = event.is_err();
        if sender.send(Input::Terminal(event)).is_err() || is_end {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use uavspec_live::watch::message::Message;

    use super::*;

    /// Sequences of connection events, each with the reason why the fleet remains incomplete.
    const INCOMPLETE: [(&[&str], &str); 4] = [
        (&[], "the server doesn't respond"),
        (&[r#"{"type":"SYS-VER"}"#], "the server didn't send a list of its UAVs"),
        (&[r#"{"type":"UAV-LIST","ids":["glider-1"]}"#], "some UAVs did not report their state"),
        (&[r#"{"type":"ACK-NAK","reason":"log in first"}"#], "the server refused a request: log in first"),
    ];

    #[test]
    fn waits_for_the_fleet_only_as_long_as_necessary() {
        let known =
            [r#"{"type":"UAV-LIST","ids":["glider-1"]}"#, r#"{"type":"UAV-INF","status":{"glider-1":{}}}"#];
        for (messages, reason) in INCOMPLETE.into_iter().chain([(&known[..], "")]) {
            let (clock, (sender, inputs)) = (Clock::simulated(), sync_channel(4));
            let start = clock.now();
            for text in messages {
                let event = Event::Received(Message::read(text.as_bytes()));
                sender.send(Input::Server(event, start)).expect("a receiver");
            }
            let fleet = gather(&clock, TIME, &inputs);
            assert_eq!(fleet.is_complete(), reason.is_empty(), "{messages:?}");
            assert_eq!(clock.now() - start, if reason.is_empty() { Duration::ZERO } else { TIME });
            if !reason.is_empty() {
                assert_eq!(missing(&fleet), reason);
            }
        }
    }
}
