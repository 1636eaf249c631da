//! `uavspec watch` for PX4 vehicles and captures.

use std::io::{self, IsTerminal as _};
use std::net::IpAddr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::sync_channel;
use std::thread;
use std::time::Duration;

use clap::Args;
use ratatui::DefaultTerminal;
use ratatui::crossterm::event;
use uavspec_check::timeline::Texts;
use uavspec_live::bus::{self, Address};
use uavspec_live::vehicle::remove_recordings;
use uavspec_live::watch::screen::{Pages, Step};
use uavspec_live::watch::vehicle::playback::{Kind, Playback, Watcher};
use uavspec_live::watch::vehicle::source::{replay, watch_live};
use uavspec_live::watch::view::Theme;
use uavspec_live::watch::view::vehicle::{Scene, draw, text, why_not_arm};
use uavspec_model::clock::Clock;
use uavspec_model::text::terminal;
use uavspec_rules::definitions::Library;

use super::{Input, MAX_FRAME_TIME, WAITING_LIMIT, WatchArgs, show, theme, unusable_terminal};
use crate::app::events::EventsArgs;
use crate::app::report::print_result;
use crate::app::{Exit, Status, explain, first_given, interrupt, library};

/// The time after which --once prints the state of a live vehicle.
const TIME: Duration = Duration::from_secs(5);

/// The maximum time that the program waits for the receiver of a live vehicle to stop.
const STOP_TIME: Duration = Duration::from_millis(500);

/// Set to true when the display has ended.
static IS_STOPPED: AtomicBool = AtomicBool::new(false);

/// Arguments for PX4 vehicles.
#[derive(Args, Debug)]
#[command(next_help_heading = "Options for PX4 vehicles")]
pub(super) struct VehicleArgs {
    /// Definitions that explain the messages [default: the release that matches best].
    ///
    /// A release such as px4@1.16, a uavspec.toml file, or a folder that contains one.
    #[arg(long, value_name = "PATH|RELEASE")]
    definitions: Option<PathBuf>,
    #[command(flatten)]
    events: EventsArgs,
    /// Language of the labels, such as uk [default: en].
    #[arg(long, value_name = "LANGUAGE")]
    language: Option<String>,
    /// Print only why the vehicle can't arm, and exit.
    ///
    /// The answer comes from the health and arming reports on the topic `event`.
    #[arg(long)]
    why_not_arm: bool,
    /// Mode for --why-not-arm, such as posctl [default: all modes].
    #[arg(long, value_name = "NAME", requires = "why_not_arm")]
    mode: Option<String>,
    /// IP address of a computer that multicast doesn't reach (DDS, repeatable).
    #[arg(long, value_name = "ADDRESS")]
    peer: Vec<IpAddr>,
}

impl VehicleArgs {
    /// The first of these options that is given.
    pub(super) fn given(&self) -> Option<&'static str> {
        first_given(&[
            ("--definitions", self.definitions.is_some()),
            ("--events", self.events.events.is_some()),
            ("--language", self.language.is_some()),
            ("--why-not-arm", self.why_not_arm),
            ("--peer", !self.peer.is_empty()),
        ])
    }
}

/// The texts that the display needs.
struct Labels {
    source: String,
    language: String,
}

/// Shows a live vehicle.
pub(super) fn watch_vehicle(args: &WatchArgs, address: &Address) -> Exit {
    let (library, texts, labels) = prepare(args, address.to_string())?;
    let (address, peers) = (address.clone(), args.vehicle.peer.clone());
    let playback = Playback::new(Kind::Live, Clock::real());
    let receiving = Arc::clone(&playback);
    let receiver = thread::spawn(move || {
        let connect = || bus::connect(&address, &peers, &[]);
        let is_stopped = || IS_STOPPED.load(Ordering::Relaxed);
        let watcher = Watcher { playback: &receiving, texts: &texts, clock: Clock::real() };
        watch_live(&connect, is_stopped, &library, watcher);
    });
    let status = show_or_print(args, &playback, &labels);
    IS_STOPPED.store(true, Ordering::Relaxed);
    // The receiver removes its temporary file if it stops in time.
    let clock = Clock::real();
    let is_finished = || receiver.is_finished().then_some(());
    let _ = clock.poll(clock.now() + STOP_TIME, Duration::from_millis(5), is_finished);
    remove_recordings();
    status
}

/// Shows the state of a live vehicle, or prints it.
fn show_or_print(args: &WatchArgs, playback: &Playback, labels: &Labels) -> Exit {
    let clock = Clock::real();
    let started = clock.now();
    if is_once(args) {
        remove_on_signal(labels)?;
    }
    playback.wait_for_start().map_err(|problem| failed(labels, &problem))?;
    if is_once(args) {
        clock.sleep_until(started + args.time.unwrap_or(TIME));
        return print_once(args, playback, labels);
    }
    show_vehicle(playback, labels)
}

/// Removes the temporary recording if a signal ends the program.
fn remove_on_signal(labels: &Labels) -> Result<(), Status> {
    ctrlc::set_handler(|| {
        remove_recordings();
        std::process::exit(interrupt::INTERRUPTED);
    })
    .map_err(|error| failed(labels, &format!("can't handle signals: {error}")))
}

/// Replays a capture.
pub(super) fn watch_capture(args: &WatchArgs, path: &Path) -> Exit {
    let (library, texts, labels) = prepare(args, path.to_string_lossy().into_owned())?;
    let is_once = is_once(args);
    let kind = if is_once { Kind::State(args.time.unwrap_or(Duration::MAX)) } else { Kind::Replay };
    let playback = Playback::new(kind, Clock::real());
    let (reading, path) = (Arc::clone(&playback), path.to_owned());
    thread::spawn(move || {
        let watcher = Watcher { playback: &reading, texts: &texts, clock: Clock::real() };
        replay(&path, &library, watcher);
    });
    if is_once {
        playback.wait_for_start().map_err(|problem| failed(&labels, &problem))?;
        return print_once(args, &playback, &labels);
    }
    show_vehicle(&playback, &labels)
}

/// Loads the definitions and texts. Prints errors.
fn prepare(args: &WatchArgs, source: String) -> Result<(Library, Texts, Labels), Status> {
    let definitions = args.vehicle.definitions.as_deref();
    let library = args.vehicle.events.add_to(library(definitions, None, &[])?)?;
    let texts = explain::texts(definitions)?;
    let language = explain::language(args.vehicle.language.as_deref(), &texts.languages())?;
    Ok((library, texts, Labels { source, language }))
}

fn is_once(args: &WatchArgs) -> bool {
    args.once || args.vehicle.why_not_arm || !io::stdout().is_terminal()
}

fn failed(labels: &Labels, problem: &str) -> Status {
    let source = terminal::shown(&labels.source);
    Status::Unreadable.because(format_args!("{source}: {}", terminal::shown(problem)))
}

/// Prints the state as text.
fn print_once(args: &WatchArgs, playback: &Playback, labels: &Labels) -> Exit {
    let question = &args.vehicle;
    let mode = question.mode.as_deref();
    let (text, modes, is_empty, ambiguous) = playback.show(|shown| {
        let scene = Scene {
            shown,
            source: &labels.source,
            language: &labels.language,
            theme: Theme { is_coloured: false },
            now: Clock::real().now(),
        };
        let text = if question.why_not_arm { why_not_arm(&scene, mode) } else { Some(text(&scene)) };
        (text, shown.vehicle.modes(), !shown.vehicle.has_state(), shown.vehicle.ambiguous)
    });
    if let Some(topic) = ambiguous.filter(|_| question.why_not_arm) {
        let problem = format!("several vehicles publish `{topic}`: their reports are mixed");
        return Err(failed(labels, &problem));
    }
    let Some(text) = text else {
        return Err(failed(labels, "no health and arming report was received on the topic `event`"));
    };
    explain::check_mode(mode, &modes)?;
    print_result(&text)?;
    if is_empty {
        return Err(failed(labels, "no message was received on the displayed topics"));
    }
    Ok(Status::Conforms)
}

/// Shows the vehicle until the user quits, or until the source proves to be unreadable.
fn show_vehicle(playback: &Playback, labels: &Labels) -> Exit {
    let (sender, inputs) = sync_channel(WAITING_LIMIT);
    let theme = theme();
    let draw = |pages: &mut Pages, terminal: &mut DefaultTerminal, now| {
        playback.show(|shown| {
            let Labels { source, language } = labels;
            let scene = Scene { shown, source, language, theme, now };
            terminal.draw(|frame| draw(frame, &scene, pages)).map(drop)
        })?;
        Ok(if playback.problem().is_some() { Step::Quit } else { Step::Stay })
    };
    let take = |pages: &mut Pages, input| match input {
        Input::Terminal(Ok(event::Event::Key(key))) => playback.press(pages, key),
        Input::Terminal(_) | Input::Server(..) => Step::Stay,
        Input::End => Step::Quit,
    };
    let shown = show(Pages::default(), (sender, &inputs), MAX_FRAME_TIME / 2, draw, take);
    shown.map_err(unusable_terminal)?;
    playback.problem().map_or(Ok(Status::Conforms), |problem| Err(failed(labels, &problem)))
}
