//! `uavspec watch`.

use std::io::{self, IsTerminal as _};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use clap::Args;
use ratatui::crossterm::event;

use super::Status;
use super::report::print;
use super::test::seconds;
use crate::definitions::Definitions;
use crate::flockwave::transport::endpoint::Endpoint;
use crate::watch::codes::Codes;
use crate::watch::fleet::{Fleet, Link};
use crate::watch::list::table;
use crate::watch::screen::{Screen, Step};
use crate::watch::session::{Event, Session};
use crate::watch::view::{Scene, draw};

/// How many things that happened may wait. While so many do, no more is heard of the server.
const WAITING_LIMIT: usize = 16;

/// How long it takes at least from one picture to the next.
const MIN_FRAME_TIME: Duration = Duration::from_millis(100);

/// How long it takes at most: ages grow even if nothing happens.
const MAX_FRAME_TIME: Duration = Duration::from_millis(500);

/// Arguments of `watch`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  uavspec watch tcp://localhost:5001
  uavspec watch 'socketio://localhost:5000?protocol=4&transport=polling'
  uavspec watch http://localhost:5000/api/v1
  uavspec watch --once tcp://localhost:5001 | awk '$2 == \"fatal\" { print $1 }'
  uavspec watch --once --for 30 udp://localhost:5001

It asks which UAVs there are and how they are, and changes nothing. What the server tells by itself is shown as it
comes; what it doesn't tell is asked for every two seconds. When the server goes away, it is tried again, and what was
known stays on the screen.

The key ? tells all keys. Where the environment has NO_COLOR, there are no colours. Where the output is no terminal, a
table is printed once, as with --once.

Exit status: 0 it ended as it should, 2 wrong usage, 3 the terminal can't be used, or with --once not all UAVs have
told their state in time.")]
pub(super) struct WatchArgs {
    /// Where the server is: tcp://HOST:PORT, udp://HOST:PORT, http://HOST:PORT/PATH or socketio://HOST:PORT.
    #[arg(value_name = "URL")]
    endpoint: Endpoint,
    /// Print a table when all UAVs have told their state, and end.
    #[arg(long)]
    once: bool,
    /// How long --once waits for that; then the table has what is known.
    #[arg(long = "for", value_name = "SECONDS", default_value = "5", value_parser = seconds)]
    time: Duration,
}

/// What the screen has to do with.
enum Input {
    /// Something happened to the connection, and when.
    Server(Event, Instant),
    /// Somebody did something to the terminal; or nothing more will be known of it.
    Terminal(io::Result<event::Event>),
    /// It is to end.
    End,
}

pub(super) fn watch(args: &WatchArgs) -> Status {
    let codes = Codes::new(&Definitions::built_in());
    let (sender, inputs) = sync_channel(WAITING_LIMIT);
    let session = {
        let sender = sender.clone();
        let on_event = move |event| sender.send(Input::Server(event, Instant::now())).is_ok();
        Session::start(args.endpoint.clone(), on_event)
    };
    let status = if args.once || !io::stdout().is_terminal() {
        watch_once(args, &codes, &inputs)
    } else {
        watch_live(args, &codes, sender, &inputs).map_or_else(
            |error| {
                anstream::eprintln!("error: the terminal can't be used: {error}");
                Status::Unreadable
            },
            |()| Status::Conforms,
        )
    };
    drop(session);
    status
}

/// Waits for all UAVs to tell their state, and prints it.
fn watch_once(args: &WatchArgs, codes: &Codes, inputs: &Receiver<Input>) -> Status {
    let until = Instant::now() + args.time;
    let mut fleet = Fleet::default();
    while !fleet.is_complete() {
        let Ok(input) = inputs.recv_timeout(until.saturating_duration_since(Instant::now())) else { break };
        if let Input::Server(event, now) = input {
            fleet.take(event, now);
        }
    }
    if (fleet.is_complete() || !fleet.is_empty())
        && let Err(error) = print(&table(&fleet, codes, Instant::now()))
    {
        anstream::eprintln!("error: standard output: {error}");
        return Status::Unreadable;
    }
    if fleet.is_complete() {
        return Status::Conforms;
    }
    let reason = match (&fleet.link, &fleet.remark) {
        (Link::Lost { reason, .. }, _) => crate::text::shown(reason),
        (Link::Connecting, _) => "it doesn't answer".to_owned(),
        (Link::Connected, Some(remark)) => remark.clone(),
        (Link::Connected, None) if fleet.is_empty() => "it doesn't say which UAVs there are".to_owned(),
        (Link::Connected, None) => "not all of its UAVs have told their state".to_owned(),
    };
    anstream::eprintln!("error: {}: {reason} (within {} s)", args.endpoint, args.time.as_secs_f64());
    Status::Unreadable
}

/// Gives the terminal back as it was, however this ends.
struct Restore;

impl Drop for Restore {
    fn drop(&mut self) {
        ratatui::restore();
    }
}

/// Shows the fleet until somebody has seen enough.
fn watch_live(
    args: &WatchArgs,
    codes: &Codes,
    sender: SyncSender<Input>,
    inputs: &Receiver<Input>,
) -> io::Result<()> {
    let ending = sender.clone();
    ctrlc::set_handler(move || {
        // It may be over already.
        let _ = ending.send(Input::End);
    })
    .map_err(io::Error::other)?;
    let _restore = Restore;
    let mut terminal = ratatui::try_init()?;
    thread::spawn(move || forward_terminal_events(&sender));
    let url = args.endpoint.to_string();
    let is_coloured = std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
    let (mut fleet, mut screen) = (Fleet::default(), Screen::default());
    loop {
        let now = Instant::now();
        let scene = Scene { fleet: &fleet, codes, url: &url, is_coloured, now };
        terminal.draw(|frame| draw(frame, &scene, &mut screen))?;
        if take_all(inputs, now, &mut fleet, &mut screen)? == Step::Quit {
            return Ok(());
        }
    }
}

/// Takes what happens until the next picture is due, after the one that was drawn at a time.
fn take_all(
    inputs: &Receiver<Input>,
    drawn: Instant,
    fleet: &mut Fleet,
    screen: &mut Screen,
) -> io::Result<Step> {
    let mut due = drawn + MAX_FRAME_TIME;
    loop {
        match inputs.recv_timeout(due.saturating_duration_since(Instant::now())) {
            Ok(Input::Server(event, now)) => fleet.take(event, now),
            Ok(Input::Terminal(event)) => {
                if let event::Event::Key(key) = event?
                    && screen.press(key, fleet) == Step::Quit
                {
                    return Ok(Step::Quit);
                }
            }
            Ok(Input::End) | Err(RecvTimeoutError::Disconnected) => return Ok(Step::Quit),
            Err(RecvTimeoutError::Timeout) => return Ok(Step::Stay),
        }
        due = drawn + MIN_FRAME_TIME;
        // A server that never pauses doesn't keep the picture from being drawn.
        if Instant::now() >= due {
            return Ok(Step::Stay);
        }
    }
}

/// Hands on what somebody does to the terminal.
fn forward_terminal_events(sender: &SyncSender<Input>) {
    loop {
        let event = event::read();
        let is_end = event.is_err();
        if sender.send(Input::Terminal(event)).is_err() || is_end {
            return;
        }
    }
}
