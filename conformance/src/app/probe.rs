//! `uavspec probe`.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;

use super::known::KnownArgs;
use super::progress::Progress;
use super::report::ReportArgs;
use super::required::{RequireArgs, idle};
use super::serve::login;
use super::test::seconds;
use super::{Status, deliver};
use crate::flockwave::transport::endpoint::Endpoint;
use crate::probe::{Options, probe};
use crate::report::{Action, CheckedCapture, Report, Settings, Subject, Unreadable};

/// Arguments of `probe`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  uavspec probe tcp://localhost:5001
  uavspec probe --observe 30 --record run.jsonl tcp://192.0.2.7:5001
  uavspec probe --report html=report.html,junit=report.xml http://localhost:5000/api/v1
  uavspec probe 'socketio://localhost:5000?protocol=4&transport=polling'
  uavspec probe --allow-commands --uav 00 --uav 01 tcp://localhost:5001
  uavspec probe --login pilot:secret udp://localhost:5001

It asks only for what changes nothing, listens, and then tries what a server has to bear: messages in pieces, lines that
are no JSON, some thirty malformed requests, each on a connection of its own. That may bring a server down that doesn't
bear it: probe none that is flying something. With --allow-commands the UAVs that are named take off, fly to a place
10 m above them, go home and land; they are tested, calibrated, put to sleep and woken, and the server's clock is put
forward by nothing.

--record writes all that goes over the wire; `uavspec check` finds the same in it.

Exit status: 0 conforms, 1 does not, 2 wrong usage, definitions or list, 3 the server can't be reached, answers nothing
or broke off, or a report or recording can't be written, 4 a list of known failures no longer holds true, 5 nothing was
checked.")]
pub(super) struct ProbeArgs {
    /// The server: tcp://HOST:PORT, udp://HOST:PORT, http://HOST:PORT/PATH for one-shots, or
    /// socketio://HOST:PORT?protocol=4|5&transport=websocket|polling (5 and websocket, where nothing is said).
    #[arg(value_name = "URL")]
    endpoint: Endpoint,
    /// How long to listen for what comes by itself.
    #[arg(long, value_name = "SECONDS", default_value = "3", value_parser = seconds)]
    observe: Duration,
    /// Log in so (AUTH-REQ, method basic).
    #[arg(long, value_name = "NAME:PASSWORD", value_parser = login)]
    login: Option<(String, String)>,
    /// Also send commands, to the UAVs that are named with --uav and to no others.
    #[arg(long, requires = "uav")]
    allow_commands: bool,
    /// A UAV that commands may be sent to; may be given several times.
    #[arg(long, value_name = "ID", requires = "allow_commands")]
    uav: Vec<String>,
    /// Write all that goes over the wire to this file.
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// What to judge by: a uavspec.toml, or a folder with one; the definitions of this program, where nothing is said.
    #[arg(long, value_name = "PATH")]
    definitions: Option<PathBuf>,
    /// A folder of JSON Schemas for bodies whose types the definitions don't have, as `check` takes them.
    #[arg(long = "schema", value_name = "DIR")]
    schemas: Vec<PathBuf>,
    #[command(flatten)]
    require: RequireArgs,
    #[command(flatten)]
    known: KnownArgs,
    #[command(flatten)]
    report: ReportArgs,
}

pub(super) fn run(args: &ProbeArgs) -> Status {
    match prepared(args) {
        Ok(status) | Err(status) => status,
    }
}

fn prepared(args: &ProbeArgs) -> Result<Status, Status> {
    if let Some(problem) = args.report.problem() {
        anstream::eprintln!("error: {problem}");
        return Err(Status::Usage);
    }
    let definitions = super::definitions_with(args.definitions.as_deref(), &args.schemas)?;
    let required = args.require.rules()?;
    let mut known = args.known.read()?;
    let record = recording(args)?;
    let options = Options::new(args.observe, args.login.clone(), args.uav.clone());
    let path = args.endpoint.to_string();
    let progress = Progress::steps("steps");
    let started = Instant::now();
    let probed = probe(&args.endpoint, &options, &definitions, record, &|done, all| progress.set(done, all));
    drop(progress);
    let unreadable: Vec<Unreadable> =
        probed.failure.into_iter().map(|message| Unreadable { path: path.clone(), message }).collect();
    for unreadable in &unreadable {
        anstream::eprintln!("error: {path}: {}", unreadable.message);
    }
    let (result, elapsed) = (probed.result, started.elapsed().as_millis());
    let mut checked = [CheckedCapture { path, result, notes: probed.notes, elapsed }];
    let settled = known.settle_sources(&mut checked, &unreadable);
    let settings = Settings { command: Some(super::command()), ..Settings::default() };
    let subjects: Vec<Subject> =
        checked.into_iter().map(|checked| Subject::from_capture(checked, &definitions, &settings)).collect();
    for subject in &subjects {
        args.report.print_subject(subject);
    }
    let reasons = idle(&required, &subjects);
    let report = Report::new(Action::Probe, super::command(), &definitions, subjects, unreadable, reasons);
    let status = deliver(&args.report, &report.with_stale(known.stale)).max(settled);
    match (probed.unrecorded, &args.record) {
        (Some(error), Some(path)) => {
            anstream::eprintln!("error: {}: the recording can't be written: {error}", path.display());
            Ok(status.max(Status::Unreadable))
        }
        _ => Ok(status),
    }
}

/// The file of the recording.
fn recording(args: &ProbeArgs) -> Result<Option<Box<dyn Write>>, Status> {
    let Some(path) = &args.record else { return Ok(None) };
    let file = File::create(path).map_err(|error| {
        anstream::eprintln!("error: {}: the recording can't be written: {error}", path.display());
        Status::Unreadable
    })?;
    Ok(Some(Box::new(BufWriter::new(file))))
}
