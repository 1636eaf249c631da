//! `uavspec probe`.

mod application;
mod vehicle;

use std::fs::File;
use std::io::{LineWriter, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;

use self::vehicle::VehicleArgs;
use super::access::AccessArgs;
use super::baseline::{BaselineArgs, Baselines, count_capture, count_unread};
use super::interrupt::{self, Danger};
use super::outcome::OutcomeArgs;
use super::outputs::{self, Inputs, Output};
use super::progress::Progress;
use super::report::{Outputs, ReportArgs};
use super::required::{RequireArgs, uncovered};
use super::target::Target;
use super::test::seconds;
use super::{Status, outcome_statuses};
use crate::check::known::Scope;
use crate::definitions::Definitions;
use crate::flockwave::transport::endpoint::Endpoint;
use crate::model::Rule;
use crate::probe::{Options, Probed, Selection, probe};
use crate::report::{Action, CheckedCapture, Report, Settings, Subject, Unreadable};
use crate::tables::Origin;
use crate::text::terminal;

const EXAMPLES: &str = "Examples:
  uavspec probe tcp://localhost:5001
  uavspec probe --observe 30 --record run.jsonl tcp://192.0.2.7:5001
  uavspec probe --report html=report.html http://localhost:5000/api/v1
  uavspec probe 'socketio://localhost:5000?protocol=4&transport=polling'
  uavspec probe --allow-commands --uav 00 --uav 01 tcp://localhost:5001
  uavspec probe --login pilot:secret udp://localhost:5001
  uavspec probe --record flight.mcap dds://0
  uavspec probe --for 60 --topics '/fmu/*' zenoh://localhost:7447
  uavspec probe --as component dds://0";

/// The default time to listen for notifications.
const OBSERVE: Duration = Duration::from_secs(3);

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
    /// Servers: tcp://HOST:PORT, udp://HOST:PORT, http://HOST:PORT/PATH or socketio://HOST:PORT. Socket.IO URLs may end
    /// in ?protocol=4 or ?protocol=5 (default), and &transport=polling or &transport=websocket (default). With TLS:
    /// tcps, https or socketios.
    ///
    /// Vehicles: dds://DOMAIN, zenoh://HOST:PORT, foxglove://HOST:PORT or rosbridge://HOST:PORT. Zenoh URLs may end in
    /// ?domain=NUMBER. Vehicles require a program that was built with the feature `live`, or with the feature of the
    /// transport, such as `dds`.
    #[allow(clippy::doc_markdown, reason = "the help would show the marks of a link")]
    #[arg(value_name = "URL")]
    target: Target,
    #[command(flatten)]
    vehicle: VehicleArgs,
    /// Time to listen for notifications (default: 3).
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    observe: Option<Duration>,
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
    /// Takes the names that --only takes. Findings of a skipped rule are not reported.
    #[arg(long, value_name = "NAME")]
    skip: Vec<String>,
    /// Run no trials: send no malformed messages and no unusual ones, apart from unknown ids and an unknown type.
    #[arg(long)]
    no_trials: bool,
    /// Time after which no further requests are sent, without --observe (default: 45, or 105 with --allow-commands).
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    limit: Option<Duration>,
    /// Time that a request may stay unanswered, from 1 to 60 (default: 5).
    ///
    /// The probe goes on with other requests meanwhile.
    #[arg(long, value_name = "SECONDS", value_parser = timeout)]
    timeout: Option<Duration>,
    /// Time to wait for the UAVs of --uav to appear (default: 30).
    ///
    /// If one of them doesn't appear, the probe is incomplete.
    #[arg(long, value_name = "SECONDS", value_parser = seconds, requires = "allow_commands")]
    uav_timeout: Option<Duration>,
    /// Time to land the UAVs, stop their motors and wake them after everything else (default: 120).
    ///
    /// The probe does this even if it is interrupted, the time limit is reached or the connection is lost. It connects
    /// again as often as necessary.
    #[arg(long, value_name = "SECONDS", value_parser = seconds, requires = "allow_commands")]
    landing_limit: Option<Duration>,
    /// Record the session to this file. The messages of a vehicle are recorded as a bag in MCAP.
    ///
    /// `uavspec check` reports the same findings for the recording.
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Definitions to check against (default: built-in; for a vehicle, the release that agrees best).
    ///
    /// A uavspec.toml file or a folder that contains one. For a vehicle, also a release such as px4@1.16.
    #[arg(long, value_name = "PATH|RELEASE")]
    definitions: Option<PathBuf>,
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

pub(super) fn run(args: &ProbeArgs) -> Status {
    let problem = args.report.problem().or_else(|| args.misplaced());
    if let Some(problem) = problem {
        terminal::error(problem, None);
        return Status::Usage;
    }
    let probed = match &args.target {
        Target::Server(endpoint) => probe_server(args, endpoint),
        Target::Vehicle(address) => vehicle::probe_vehicle(args, address),
    };
    match probed {
        Ok(status) | Err(status) => status,
    }
}

impl ProbeArgs {
    /// An error if an option doesn't apply to the target.
    fn misplaced(&self) -> Option<String> {
        let (given, noun) = match self.target {
            Target::Server(_) => (self.vehicle.given(), "PX4 vehicles"),
            Target::Vehicle(_) => (self.given_for_server(), "Flockwave servers"),
        };
        given.map(|option| format!("{option} applies only to {noun}"))
    }

    /// The first given option that applies only to Flockwave servers.
    fn given_for_server(&self) -> Option<&'static str> {
        let options = [
            ("--observe", self.observe.is_some()),
            ("--allow-commands", self.allow_commands),
            ("--only", !self.only.is_empty()),
            ("--skip", !self.skip.is_empty()),
            ("--no-trials", self.no_trials),
            ("--limit", self.limit.is_some()),
            ("--timeout", self.timeout.is_some()),
            ("--schema", !self.schemas.is_empty()),
        ];
        options
            .into_iter()
            .find(|(_, is_given)| *is_given)
            .map(|(name, _)| name)
            .or_else(|| self.access.given())
    }
}

fn probe_server(args: &ProbeArgs, endpoint: &Endpoint) -> Result<Status, Status> {
    let definitions = super::definitions_with(args.definitions.as_deref(), &args.schemas)?;
    let required = args.require.rules()?;
    let outputs = start_reports(args)?;
    let baselines = args.baseline.read()?;
    let options = options(args, endpoint, &definitions)?;
    let record = recording(args)?;
    interrupt::install(&options)?;
    // The last line, even if reporting fails.
    let mut danger = Danger::new(&options.stop);
    let progress = Progress::steps("steps");
    let started = Instant::now();
    let mut probed = probe(endpoint, &options, &definitions, record, &|done, all| progress.set(done, all));
    let elapsed = started.elapsed().as_millis();
    drop(progress);
    danger.known = probed.danger.take();
    let mut settings = args.outcome.settings();
    settings.allows_incomplete &= !options.stop.is_requested() && danger.known.is_none();
    Ok(report_server(args, outputs, probed, &definitions, &required, baselines, (settings, elapsed)))
}

/// Prints and writes the reports about a server.
fn report_server(
    args: &ProbeArgs,
    outputs: Outputs<'_>,
    probed: Probed,
    definitions: &Definitions,
    required: &[&'static Rule],
    baselines: Baselines,
    (settings, elapsed): (Settings, u128),
) -> Status {
    let path = args.target.to_string();
    let unreadable: Vec<Unreadable> =
        probed.failure.into_iter().map(|message| Unreadable { path: path.clone(), message }).collect();
    for unreadable in &unreadable {
        terminal::error(format_args!("{path}: {}", unreadable.message), None);
    }
    let cut_short = probed.cut_short.into_iter().chain(probed.left_out).collect();
    let (result, notes, requests) = (probed.result, probed.notes, probed.requests);
    // If nothing came from the server, the failure says everything.
    let is_silent = !unreadable.is_empty() && result.records == 0;
    let checked = CheckedCapture { path, result, notes, requests, cut_short, elapsed };
    let checked = (!is_silent).then_some(checked);
    let settings = Settings { is_unrecorded: args.record.is_none(), ..settings };
    let status = report(outputs, checked, unreadable, definitions, required, baselines, settings);
    match (probed.unrecorded, &args.record) {
        (Some(error), Some(path)) => {
            terminal::error(
                format_args!("{}: can't write the recording: {error}", terminal::path(path)),
                None,
            );
            status.max(Status::Unreadable)
        }
        _ => status,
    }
}

/// Prints and writes the reports.
fn report(
    mut outputs: Outputs<'_>,
    mut checked: Option<CheckedCapture>,
    unreadable: Vec<Unreadable>,
    definitions: &Definitions,
    required: &[&'static Rule],
    mut baselines: Baselines,
    settings: Settings,
) -> Status {
    let baseline_status = baselines.compare(Scope::Rules, |lists, sums| {
        for file in &unreadable {
            count_unread(lists, sums, &file.path);
        }
        if let Some(checked) = &checked {
            count_capture(lists, sums, checked);
        }
    });
    if let Some(checked) = &mut checked {
        baselines.excuse(checked);
    }
    let settings = Settings { command: Some(super::command()), ..settings };
    if let Some(checked) = checked {
        outputs.add(Subject::from_capture(checked, definitions, &settings), &Origin::default(), None);
    }
    let (totals, command) = (outputs.finish(), super::command());
    let reasons = uncovered(required, &totals);
    let report = Report::of_totals(Action::Probe, command, &definitions.name, totals, unreadable, reasons);
    outputs.deliver(&report.with_stale(baselines.stale)).max(baseline_status)
}

/// Starts the reports, and checks that no output replaces an input. Errors are printed.
fn start_reports(args: &ProbeArgs) -> Result<Outputs<'_>, Status> {
    let record = args.record.iter().map(|path| Output::new("--record", path));
    let outputs: Vec<Output<'_>> =
        record.chain(args.report.outputs()).chain(args.baseline.outputs()).collect();
    let inputs = Inputs {
        files: args.baseline.inputs().chain(args.access.inputs()).collect(),
        definitions: args.definitions.iter().chain(&args.vehicle.application).map(PathBuf::as_path).collect(),
        schemas: &args.schemas,
    };
    outputs::check(&inputs, &outputs)?;
    args.report.start(Action::Probe, &args.baseline, false)
}

/// The options of the probe. Unknown names are printed as errors.
fn options(args: &ProbeArgs, endpoint: &Endpoint, definitions: &Definitions) -> Result<Options, Status> {
    let selection = Selection::new(args.only.clone(), args.skip.clone(), definitions, endpoint);
    let selection = selection.map_err(|problem| {
        terminal::error(problem, None);
        Status::Usage
    })?;
    let selection = if args.no_trials { selection.without_trials() } else { selection };
    let trust = args.access.trust()?;
    let observe = args.observe.unwrap_or(OBSERVE);
    let options = Options::new(observe, args.access.login.clone(), args.uav.clone());
    Ok(Options {
        limit: args.limit.unwrap_or(options.limit),
        timeout: args.timeout.unwrap_or(options.timeout),
        uav_timeout: args.uav_timeout.unwrap_or(options.uav_timeout),
        landing_limit: args.landing_limit.unwrap_or(options.landing_limit),
        trust,
        selection,
        warn: interrupt::print_later,
        ..options
    })
}

/// A time that a request may stay unanswered. A shorter time would cause false findings.
fn timeout(text: &str) -> Result<Duration, String> {
    let time = seconds(text)?;
    let is_sensible = (Duration::from_secs(1)..=Duration::from_secs(60)).contains(&time);
    is_sensible.then_some(time).ok_or_else(|| "expected a number from 1 to 60".to_owned())
}

/// Creates the `--record` file. Errors are printed.
fn recording(args: &ProbeArgs) -> Result<Option<Box<dyn Write>>, Status> {
    let Some(path) = &args.record else { return Ok(None) };
    let file = File::create(path).map_err(|error| {
        terminal::error(format_args!("{}: can't write the recording: {error}", terminal::path(path)), None);
        Status::Unreadable
    })?;
    // Each line is written immediately, in case the probe is killed.
    Ok(Some(Box::new(LineWriter::new(file))))
}
