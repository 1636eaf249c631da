//! `uavspec check`.

use std::fs;
use std::io;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use uavspec_codegen::schema::MessageId;

use super::known::KnownArgs;
use super::progress::Progress;
use super::report::ReportArgs;
use super::required::{RequireArgs, idle};
use super::{Status, deliver};
use crate::capture::input;
use crate::check::{self, parallel};
use crate::definitions::Definitions;
use crate::report::{Action, CheckedCapture, Report, Settings, Subject, Unreadable};

/// Arguments of `check`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  uavspec check flight.ulg
  uavspec check --definitions ../px4_msgs/msg logs/*.ulg
  uavspec check --format json flight.ulg > report.json
  uavspec check --report html=report.html,junit=report.xml flight.ulg
  uavspec check rosbridge.jsonl bag/bag_0.mcap
  zcat flight.ulg.gz | uavspec check - archive/
  uavspec check --type px4/FailsafeFlags flags.jsonl
  uavspec check --known known.toml archive/
  uavspec check server.jsonl
  uavspec check --schema schemas/ server.jsonl

JSON is an object a line, or an array of objects. Without --type each says what it is:
  {\"type\": \"px4/FailsafeFlags\", \"message\": {…}}
  {\"op\": \"publish\", \"topic\": \"/fmu/out/failsafe_flags\", \"msg\": {…}}   (rosbridge)
Conversations of Flockwave are recorded so, seen from the client, or are bare messages:
  {\"t\": 1790000000.25, \"conn\": \"tcp#1\", \"dir\": \"in\", \"msg\": {…}}   (or \"out\"; \"raw\" for no JSON)
  {\"t\": 1790000000.20, \"conn\": \"tcp#1\", \"dir\": \"event\", \"event\": \"connect\"}   (or \"closed\")

JSON Schemas say what bodies of further types of Flockwave have to be. Files `*.json` are searched for, also in
subfolders. A schema is of the type that stands in it as `properties.type.const`, or as one in
`properties.type.enum`; or else that its name holds, between dots or underscores: SOAR-INF.json. With request,
response or notification in its name, as response_SOAR-INF.json, it is of that direction alone. Others are there to
be referred to. Types that the definitions have are judged by those.

A list of known failures is TOML:
  [[known]]                       # or [[flaky]]: it may also pass
  rule = \"PX-RANGE-01\"
  subject = \"battery_status.*\"    # which may be absent, as all but the reason
  file = \"archive/2019-*.ulg\"
  message = \"0 is out of range\"   # how the message begins
  reason = \"firmware 1.11 leaves it 0\"
  link = \"https://example.org/issues/7\"
  expires = 2027-06-30

Exit status: 0 conforms, 1 does not, 2 wrong usage, definitions or list, 3 a file can't be read to its end
or a report can't be written, 4 a list of known failures no longer holds true, 5 nothing was checked.")]
pub(super) struct CheckArgs {
    /// Logs of PX4 in the format `ULog`, MCAP, messages as JSON or JSON Lines, or conversations of Flockwave, also packed with gzip or zstd;
    /// which, is seen by the content. Folders are searched; `-` is standard input.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// What to judge by: a uavspec.toml, a folder with one, or a folder of .msg files; those of this program,
    /// where nothing is said.
    #[arg(long, value_name = "PATH")]
    definitions: Option<PathBuf>,
    /// A folder of JSON Schemas for bodies of Flockwave whose types the definitions don't have; see below.
    #[arg(long = "schema", value_name = "DIR")]
    schemas: Vec<PathBuf>,
    /// The type of all messages as JSON, which then have nothing around them.
    #[arg(long = "type", value_name = "PACKAGE/NAME")]
    message_type: Option<String>,
    /// Let formats that differ from the definitions count as breaches (PX-FMT-01).
    #[arg(long)]
    strict_formats: bool,
    #[command(flatten)]
    require: RequireArgs,
    /// How many files are read at the same time; as many as there are processors, where nothing is said.
    #[arg(long, value_name = "N")]
    jobs: Option<NonZeroUsize>,
    #[command(flatten)]
    known: KnownArgs,
    #[command(flatten)]
    report: ReportArgs,
}

pub(super) fn check(args: &CheckArgs) -> Status {
    if let Some(problem) = args.report.problem() {
        anstream::eprintln!("error: {problem}");
        return Status::Usage;
    }
    let definitions = match super::definitions_with(args.definitions.as_deref(), &args.schemas) {
        Ok(definitions) => definitions,
        Err(status) => return status,
    };
    let required = match args.require.rules() {
        Ok(rules) => rules,
        Err(status) => return status,
    };
    let message_id = args.message_type.as_deref().map(|name| (name, definitions.message_of_type(name)));
    if let Some((name, None)) = message_id {
        anstream::eprintln!("error: --type {name}: the definitions have no such message");
        return Status::Usage;
    }
    let message_id = message_id.and_then(|(_, id)| id);
    let files = match input::files(&args.files) {
        Ok(files) => files,
        Err((path, error)) => {
            anstream::eprintln!("error: {}: {error}", path.display());
            let is_mistake = error.kind() == io::ErrorKind::InvalidInput;
            return if is_mistake { Status::Usage } else { Status::Unreadable };
        }
    };
    let mut known = match args.known.read() {
        Ok(known) => known,
        Err(status) => return status,
    };
    let settings = settings(args);
    let (mut checked, mut subjects, mut unreadable) = (Vec::new(), Vec::new(), Vec::new());
    let mut take = |found: CheckedCapture| {
        let subject = Subject::from_capture(found, &definitions, &settings);
        args.report.print_subject(&subject);
        subjects.push(subject);
    };
    let sizes = files.iter().filter_map(|path| Some(fs::metadata(path).ok()?.len()));
    let progress = Progress::bytes(sizes.sum());
    parallel::each(
        &files,
        args.jobs,
        |path| check_file(path, message_id, &definitions, &progress),
        |path, result| match result {
            Ok(found) if known.lists.is_empty() => progress.pausing(|| take(found)),
            // With lists it takes all files to tell which findings count.
            Ok(found) => checked.push(found),
            Err(error) => {
                let path = path.display().to_string();
                progress.pausing(|| anstream::eprintln!("error: {path}: {error}"));
                unreadable.push(Unreadable { path, message: error.to_string() });
            }
        },
    );
    drop(progress);
    let settled = known.settle_sources(&mut checked, &unreadable);
    checked.into_iter().for_each(take);
    let reasons = idle(&required, &subjects);
    let report = Report::new(Action::Check, super::command(), &definitions, subjects, unreadable, reasons);
    deliver(&args.report, &report.with_stale(known.stale)).max(settled)
}

/// How sources are to be judged.
fn settings(args: &CheckArgs) -> Settings {
    let mut arguments = Vec::new();
    if let Some(path) = &args.definitions {
        arguments.extend(["--definitions".to_owned(), path.display().to_string()]);
    }
    for folder in &args.schemas {
        arguments.extend(["--schema".to_owned(), folder.display().to_string()]);
    }
    if let Some(name) = &args.message_type {
        arguments.extend(["--type".to_owned(), name.clone()]);
    }
    if args.strict_formats {
        arguments.push("--strict-formats".to_owned());
    }
    Settings { are_formats_strict: args.strict_formats, arguments, command: None }
}

fn check_file(
    path: &Path,
    message_id: Option<MessageId>,
    definitions: &Definitions,
    progress: &Progress,
) -> io::Result<CheckedCapture> {
    let started = Instant::now();
    let source = input::decompressed(progress.reading(input::open(path)?))?;
    let result = check::check_capture(source, message_id, definitions)?;
    Ok(CheckedCapture {
        path: path.display().to_string(),
        result,
        notes: Vec::new(),
        elapsed: started.elapsed().as_millis(),
    })
}
