//! `uavspec probe`.

mod application;
mod vehicle;

use std::fs::File;
use std::io::{self, LineWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use uavspec_check::baseline::{excuse_findings, is_rule};
use uavspec_flockwave::transport::endpoint::Endpoint;
use uavspec_model::Rule;
use uavspec_model::clock::Clock;
use uavspec_model::text::terminal;
use uavspec_probe::{Options, Probed, Selection, probe};
use uavspec_report::{Action, CheckedCapture, Origin, Report, Settings, Subject, Unreadable};
use uavspec_rules::definitions::Definitions;

use self::vehicle::VehicleArgs;
use super::access::AccessArgs;
use super::baseline::{self, BaselineArgs, Baselines, count_capture, count_unread};
use super::events::EventsArgs;
use super::interrupt::{self, Danger};
use super::outcome::OutcomeArgs;
use super::outputs::{self, Inputs, Output};
use super::progress::Progress;
use super::report::{Outputs, ReportArgs};
use super::required::{RequireArgs, uncovered};
use super::target::Target;
use super::test::seconds;
use super::{Exit, Status, first_given, outcome_statuses, unreadable};

const EXAMPLES: &str = "Examples:
  uavspec probe tcp://localhost:5001
  uavspec probe --for 30 --record run.jsonl tcp://192.0.2.7:5001
  uavspec probe --report html=report.html http://localhost:5000/api/v1
  uavspec probe 'socketio://localhost:5000?protocol=4&transport=polling'
  uavspec probe --allow-commands --uav 00 --uav 01 tcp://localhost:5001
  uavspec probe --login pilot:secret udp://localhost:5001
  uavspec probe --record flight.mcap dds://0
  uavspec probe --for 60 --topics '/fmu/*' zenoh://localhost:7447
  uavspec probe --as component dds://0";

/// The default time to listen for notifications.
const TIME: Duration = Duration::from_secs(3);

/// The meaning of exit status 3.
const FAILURE: &str = "the server doesn't respond, or a file can't be written";

/// The meaning of exit status 6.
const INCOMPLETE: &str = "the probe was cut short or interrupted, or too little was
     checked
130  interrupted twice";

/// Arguments of `probe`.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES, after_long_help = format!("{EXAMPLES}\n\n{}", outcome_statuses(FAILURE, Some(INCOMPLETE))))]
pub(super) struct ProbeArgs {
    /// URL of a Flockwave server (tcp, udp, http, socketio), or of a PX4 vehicle (dds, zenoh, foxglove, rosbridge).
    ///
    /// Several URLs of Flockwave servers are probed one after the other, and share one report.
    ///
    /// Servers: tcp://HOST:PORT, udp://HOST:PORT, http://HOST:PORT/PATH or socketio://HOST:PORT. Socket.IO URLs may end
    /// in ?protocol=4 or ?protocol=5 (default), and &transport=polling or &transport=websocket (default). With TLS:
    /// tcps, https or socketios.
    ///
    /// Vehicles: dds://DOMAIN, zenoh://HOST:PORT, foxglove://HOST:PORT or rosbridge://HOST:PORT. Zenoh URLs may end in
    /// ?domain=NUMBER. Vehicles require a program that was built with the feature `live`, or with the feature of the
    /// transport, such as `dds`.
    #[allow(clippy::doc_markdown, reason = "the help would show the marks of a link")]
    #[arg(value_name = "URL", required = true)]
    targets: Vec<Target>,
    #[command(flatten)]
    vehicle: VehicleArgs,
    /// Time to listen: to a vehicle [default: 20], or for notifications of a server [default: 3].
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds)]
    time: Option<Duration>,
    #[command(flatten)]
    access: AccessArgs,
    /// Also send commands to the UAVs given with --uav.
    #[arg(long, requires = "uav")]
    allow_commands: bool,
    /// UAV that may receive commands (repeatable).
    #[arg(long, value_name = "ID", requires = "allow_commands")]
    uav: Vec<String>,
    /// Use only this rule, trial, message type or family (repeatable).
    ///
    /// A rule (FW-TCP-03), a family of rules (FW-TCP), a message type (UAV-INF), a family of message types (UAV), or the
    /// description of a trial. The probe always sends SYS-VER, AUTH-INF and UAV-LIST.
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    /// Skip this rule, trial, message type or family (repeatable).
    ///
    /// The names are the same as for --only. Findings of a skipped rule are not reported.
    #[arg(long, value_name = "NAME")]
    skip: Vec<String>,
    /// Run no trials: send no malformed messages and no unusual ones, apart from unknown ids and an unknown type.
    #[arg(long)]
    no_trials: bool,
    /// Time in which requests are sent, in addition to --for [default: 45, or 105 with --allow-commands].
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    limit: Option<Duration>,
    /// Time to wait for the response to a request, from 1 to 60 [default: 5].
    ///
    /// Meanwhile, the probe continues with other requests.
    #[arg(long, value_name = "SECONDS", value_parser = timeout)]
    timeout: Option<Duration>,
    /// Shell command that restarts the server after it has stopped serving.
    ///
    /// The probe waits until the server serves again, and continues. Without this option, the probe ends if the server
    /// doesn't recover by itself, and the outcome says how many requests were not sent.
    #[arg(long, value_name = "COMMAND")]
    on_crash: Option<String>,
    /// Time to wait for the UAVs given with --uav to appear [default: 30].
    ///
    /// If one of them doesn't appear, the probe is incomplete.
    #[arg(long, value_name = "SECONDS", value_parser = seconds, requires = "allow_commands")]
    uav_timeout: Option<Duration>,
    /// Maximum time for the clean-up at the end of the probe: to land UAVs, stop their motors and wake sleeping UAVs
    /// [default: 120].
    ///
    /// The probe does this even if it is interrupted, the time limit is reached or the connection is lost. It
    /// reconnects as often as necessary.
    #[arg(long, value_name = "SECONDS", value_parser = seconds, requires = "allow_commands")]
    landing_limit: Option<Duration>,
    /// Record the session to this file. The messages of a vehicle are recorded as a bag in MCAP.
    ///
    /// `uavspec check` reports the same findings for the recording.
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Definitions to check against [default: built-in; for a vehicle, the release that matches best].
    ///
    /// A uavspec.toml file or a folder that contains one. For a vehicle, also a release such as px4@1.16.
    #[arg(long, value_name = "PATH|RELEASE")]
    definitions: Option<PathBuf>,
    #[command(flatten)]
    events: EventsArgs,
    /// Schemas for other Flockwave types (repeatable).
    ///
    /// All JSON Schemas (.json) in the folder and its subfolders are read, as in `uavspec check`. Schemas require a
    /// program that was built with the feature `schemas`.
    #[arg(long = "schema", value_name = "DIR")]
    schemas: Vec<PathBuf>,
    #[command(flatten)]
    require: RequireArgs,
    #[command(flatten)]
    outcome: OutcomeArgs,
    #[command(flatten)]
    baseline: BaselineArgs,
    #[command(flatten)]
    report: ReportArgs,
}

pub(super) fn run(args: &ProbeArgs) -> Exit {
    if let Some(problem) = args.report.problem().or_else(|| args.misplaced()) {
        return Err(Status::Usage.because(problem));
    }
    let vehicle = args.targets.iter().find_map(|target| match target {
        Target::Server(_) => None,
        Target::Vehicle(address) => Some(address),
    });
    vehicle.map_or_else(|| probe_servers(args), |address| vehicle::probe_vehicle(args, address))
}

impl ProbeArgs {
    /// The error for an option that doesn't apply to the target, if there is one.
    fn misplaced(&self) -> Option<String> {
        if self.targets.len() > 1 {
            let is_vehicle = |target: &Target| matches!(target, Target::Vehicle(_));
            let problem = if self.targets.iter().any(is_vehicle) {
                Some("several URLs: all must be URLs of Flockwave servers")
            } else if self.record.is_some() {
                Some("--record: probe one URL at a time, because a recording can contain only one server")
            } else {
                None
            };
            if let Some(problem) = problem {
                return Some(problem.to_owned());
            }
        }
        let (given, noun) = match self.targets.first() {
            Some(Target::Vehicle(_)) => (self.given_for_server(), "Flockwave servers"),
            _ => (self.vehicle.given(), "PX4 vehicles"),
        };
        given.map(|option| format!("{option} applies only to {noun}"))
    }

    /// The Flockwave servers.
    fn endpoints(&self) -> Vec<&Endpoint> {
        let servers = self.targets.iter().filter_map(|target| match target {
            Target::Server(endpoint) => Some(endpoint),
            Target::Vehicle(_) => None,
        });
        servers.collect()
    }

    /// The first given option that applies only to Flockwave servers.
    fn given_for_server(&self) -> Option<&'static str> {
        let given = first_given(&[
            ("--allow-commands", self.allow_commands),
            ("--only", !self.only.is_empty()),
            ("--skip", !self.skip.is_empty()),
            ("--no-trials", self.no_trials),
            ("--limit", self.limit.is_some()),
            ("--timeout", self.timeout.is_some()),
            ("--on-crash", self.on_crash.is_some()),
            ("--schema", !self.schemas.is_empty()),
        ]);
        given.or_else(|| self.access.given())
    }
}

fn probe_servers(args: &ProbeArgs) -> Exit {
    let definitions = super::definitions(args.definitions.as_deref())?.with_schemas(&args.schemas);
    let definitions = definitions.map_err(|error| Status::Usage.with_details(error))?;
    let required = args.require.rules()?;
    let outputs = start_reports(args)?;
    let baselines = baseline::read(&args.baseline)?;
    let options = options(args, &definitions)?;
    let mut record = recording(args)?;
    interrupt::install(&options)?;
    // This is the last line, even if reporting fails.
    let mut danger = Danger::new(&options.stop);
    let (mut all, mut failed, mut unrecorded) = (Vec::new(), Vec::new(), None);
    let mut endpoints = args.endpoints().into_iter();
    for endpoint in endpoints.by_ref() {
        let path = endpoint.to_string();
        let progress = Progress::steps("steps");
        let started = Clock::real().now();
        let probed =
            probe(endpoint, &options, &definitions, record.take(), &|done, all| progress.set(done, all));
        let elapsed = (Clock::real().now() - started).as_millis();
        drop(progress);
        let Probed { result, requests, notes, failure, cut_short, left_out, .. } = probed;
        danger.known = probed.danger;
        unrecorded = unrecorded.or(probed.unrecorded);
        // If the server sent nothing, the failure alone is sufficient.
        let is_silent = failure.is_some() && result.records == 0;
        if let Some(message) = &failure {
            terminal::error(format_args!("{path}: {message}"), None);
            failed.push(Unreadable { path: path.clone(), message: message.clone() });
        }
        if !is_silent {
            // If the probe failed, the part that was checked says little.
            let cut_short = cut_short.or(failure).into_iter().chain(left_out).collect();
            all.push(CheckedCapture { path, result, notes, requests, cut_short, elapsed });
        }
        if danger.known.is_some() || options.stop.is_requested() {
            break;
        }
    }
    let mut settings = args.outcome.settings();
    settings.allows_incomplete &= !options.stop.is_requested() && danger.known.is_none();
    settings.is_unrecorded = args.record.is_none();
    settings.probe = Some(reproducing_words());
    let message = "not probed: the run ended early".to_owned();
    let not_probed =
        |endpoint: &Endpoint| Unreadable { path: endpoint.to_string(), message: message.clone() };
    let unreadable = endpoints.map(not_probed).chain(failed).collect();
    let status = report(outputs, all, unreadable, &definitions, &required, baselines, settings);
    Ok(match (unrecorded, &args.record) {
        (Some(error), Some(path)) => status.max(unrecorded_at(path, &error)),
        _ => status,
    })
}

/// Prints and writes the reports.
fn report(
    mut outputs: Outputs<'_>,
    mut all: Vec<CheckedCapture>,
    unreadable: Vec<Unreadable>,
    definitions: &Definitions,
    required: &[&'static Rule],
    mut baselines: Baselines,
    settings: Settings,
) -> Status {
    let is_outdated = baselines.compare(&is_rule, |lists, sums| {
        for file in &unreadable {
            count_unread(lists, sums, &file.path);
        }
        for checked in &all {
            count_capture(lists, sums, checked);
        }
    });
    for checked in &mut all {
        excuse_findings(&mut baselines.lists, &checked.path, &mut checked.result.findings);
    }
    let baseline_status = baseline::write(&baselines, is_outdated);
    let settings = Settings { command: Some(super::command()), ..settings };
    for checked in all {
        outputs.add(&Subject::from_capture(checked, definitions, &settings), &Origin::default(), None);
    }
    let (totals, command) = (outputs.finish(), super::command());
    let reasons = uncovered(required, &totals);
    let report = Report::of_totals(Action::Probe, command, &definitions.name, totals, unreadable, reasons);
    outputs.deliver(&report.with_stale(baseline::reasons(&baselines))).max(baseline_status)
}

/// Starts the reports, and checks that no output replaces an input. Prints errors.
fn start_reports(args: &ProbeArgs) -> Result<Outputs<'_>, Status> {
    let record = args.record.iter().map(|path| Output::new("--record", path));
    let outputs: Vec<Output<'_>> =
        record.chain(args.report.outputs()).chain(baseline::outputs(&args.baseline)).collect();
    let inputs = Inputs {
        files: args.baseline.inputs().chain(args.access.inputs()).collect(),
        definitions: args.definitions.iter().chain(&args.vehicle.application).map(PathBuf::as_path).collect(),
        schemas: &args.schemas,
    };
    outputs::check(&inputs, &outputs)?;
    args.report.start(Action::Probe, false)
}

/// The options of the probe. Prints an error if a name is unknown.
fn options(args: &ProbeArgs, definitions: &Definitions) -> Result<Options, Status> {
    // The trials depend on the transport, so a name must be known for at least one of the servers.
    let mut selection = Ok(Selection::default());
    for endpoint in args.endpoints() {
        selection = Selection::new(args.only.clone(), args.skip.clone(), definitions, endpoint);
        if selection.is_ok() {
            break;
        }
    }
    let selection = selection.map_err(|problem| Status::Usage.because(problem))?;
    let selection = if args.no_trials { selection.without_trials() } else { selection };
    let trust = args.access.trust()?;
    let time = args.time.unwrap_or(TIME);
    let options = Options::new(time, args.access.login.clone(), args.uav.clone());
    Ok(Options {
        limit: args.limit.unwrap_or(options.limit),
        timeout: args.timeout.unwrap_or(options.timeout),
        on_crash: args.on_crash.clone(),
        uav_timeout: args.uav_timeout.unwrap_or(options.uav_timeout),
        landing_limit: args.landing_limit.unwrap_or(options.landing_limit),
        trust,
        selection,
        warn: interrupt::print_later,
        ..options
    })
}

/// The options that select parts of the probe or affect only its outputs. The flag is true if the option has a value.
const NOT_REPRODUCING: [(&str, bool); 15] = [
    ("--allow-incomplete", false),
    ("--baseline", true),
    ("--deny", true),
    ("--fix-baseline", false),
    ("--format", true),
    ("--min-coverage", true),
    ("--no-trials", false),
    ("--on-crash", true),
    ("--only", true),
    ("--record", true),
    ("--report", true),
    ("--require", true),
    ("--skip", true),
    ("--write-baseline", true),
    ("--limit", true),
];

/// The words of the command line that are needed to reproduce a finding, without the URLs.
fn reproducing_words() -> Vec<String> {
    let mut words = super::words().into_iter();
    let mut kept = vec!["uavspec".to_owned()];
    while let Some(word) = words.next() {
        let name = word.split('=').next().unwrap_or_default();
        let dropped = NOT_REPRODUCING.iter().find(|(option, _)| *option == name);
        match dropped {
            Some((_, true)) if name == word => _ = words.next(),
            Some(_) => {}
            None if word.parse::<Target>().is_ok() => {}
            None => kept.push(word),
        }
    }
    kept
}

/// Parses the time for which a request may remain unanswered. A shorter time would cause false findings.
fn timeout(text: &str) -> Result<Duration, String> {
    let time = seconds(text)?;
    let is_sensible = (Duration::from_secs(1)..=Duration::from_secs(60)).contains(&time);
    is_sensible.then_some(time).ok_or_else(|| "expected a number from 1 to 60".to_owned())
}

/// Prints an error about the `--record` file.
fn unrecorded_at(path: &Path, error: &io::Error) -> Status {
    unreadable(path, format_args!("can't write the recording: {error}"))
}

/// Creates the `--record` file. Prints errors.
fn recording(args: &ProbeArgs) -> Result<Option<Box<dyn Write>>, Status> {
    let Some(path) = &args.record else { return Ok(None) };
    let file = File::create(path).map_err(|error| unrecorded_at(path, &error))?;
    // Each line is written immediately, in case the probe is killed.
    Ok(Some(Box::new(LineWriter::new(file))))
}
