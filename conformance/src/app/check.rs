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
use super::required::{RequireArgs, uncovered};
use super::{Status, deliver, outcome_statuses};
use crate::capture::input;
use crate::check::{self, parallel};
use crate::definitions::Definitions;
use crate::report::{Action, CheckedCapture, Report, Settings, Subject, Unreadable};

const EXAMPLES: &str = "Examples:
  uavspec check flight.ulg
  uavspec check --definitions ../px4_msgs/msg logs/
  uavspec check --format json flight.ulg > report.json
  uavspec check --report html=report.html,junit=report.xml flight.ulg
  uavspec check rosbridge.jsonl bag/bag_0.mcap
  ssh drone cat flight.ulg | uavspec check -
  uavspec check --type px4/FailsafeFlags flags.jsonl
  uavspec check --known known.toml archive/
  uavspec check --schema schemas/ session.jsonl";

const DETAILS: &str = "\
JSON input is one object per line, or an array of objects. Without --type, each object must name its type or topic:
  {\"type\": \"px4/FailsafeFlags\", \"message\": {…}}
  {\"op\": \"publish\", \"topic\": \"/fmu/out/failsafe_flags\", \"msg\": {…}}

A recorded Flockwave session has one JSON object per line. \"in\" and \"out\" are from the client's point of view. A \
line may also be just a message. If a message is not JSON, its text is in \"raw\". For example:
  {\"t\": 1790000000.20, \"conn\": \"tcp#1\", \"dir\": \"event\", \"event\": \"connect\"}
  {\"t\": 1790000000.25, \"conn\": \"tcp#1\", \"dir\": \"in\", \"msg\": {…}}
  {\"t\": 1790000000.30, \"conn\": \"tcp#1\", \"dir\": \"out\", \"msg\": {…}}
  {\"t\": 1790000009.00, \"conn\": \"tcp#1\", \"dir\": \"event\", \"event\": \"closed\"}

The Flockwave type of a --schema file comes from properties.type.const or properties.type.enum in the JSON Schema. \
Without these, the type comes from the file name, such as SOAR-INF.json. If the file name also contains request, \
response or notification, as in response_SOAR-INF.json, the schema applies only to messages of this kind.

A list of known failures is a TOML file. Only rule and reason are required:
  [[known]]                       # use [[flaky]] if it sometimes passes
  rule = \"PX-RANGE-01\"
  subject = \"battery_status.*\"
  file = \"archive/2019-*.ulg\"
  message = \"0 is outside the\"    # start of the message
  reason = \"firmware 1.11 leaves it 0\"
  link = \"https://example.org/issues/7\"
  expires = 2027-06-30";

/// The meaning of exit status 3.
const FAILURE: &str = "an input can't be read completely, or a report can't be written";

/// Arguments of `check`.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES, after_long_help = format!("{EXAMPLES}\n\n{DETAILS}\n\n{}", outcome_statuses(FAILURE)))]
pub(super) struct CheckArgs {
    /// Files, folders or glob patterns; `-` means standard input.
    ///
    /// Inputs are PX4 logs (.ulg), MCAP files, JSON messages and recorded Flockwave sessions, optionally compressed
    /// with gzip or zstd. The file type is detected from the content. Folders are searched for .ulg, .mcap, .json,
    /// .jsonl and .ndjson files.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Definitions to check against (default: built-in).
    ///
    /// A uavspec.toml file, a folder that contains one, or a folder of .msg files.
    #[arg(long, value_name = "PATH")]
    definitions: Option<PathBuf>,
    /// Schemas for other Flockwave types (repeatable).
    ///
    /// All JSON Schemas (.json) in the folder and its subfolders are read. Types that have a definition are checked
    /// against the definition.
    #[arg(long = "schema", value_name = "DIR")]
    schemas: Vec<PathBuf>,
    /// Type of all JSON messages in the input.
    #[arg(long = "type", value_name = "PACKAGE/NAME")]
    message_type: Option<String>,
    /// Fail if a format differs from its definition.
    ///
    /// Each difference is then a violation of PX-FMT-01.
    #[arg(long)]
    strict_formats: bool,
    #[command(flatten)]
    require: RequireArgs,
    /// Number of parallel checks (default: one per CPU).
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
        anstream::eprintln!("error: --type {name}: no such message in the definitions");
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
            // The lists apply to all files, so findings are printed after the last file is checked.
            Ok(found) => checked.push(found),
            Err(error) => {
                let path = path.display().to_string();
                progress.pausing(|| anstream::eprintln!("error: {path}: {error}"));
                unreadable.push(Unreadable { path, message: error.to_string() });
            }
        },
    );
    drop(progress);
    let known_status = known.finish_captures(&mut checked, &unreadable);
    checked.into_iter().for_each(take);
    let reasons = uncovered(&required, &subjects);
    let report = Report::new(Action::Check, super::command(), &definitions, subjects, unreadable, reasons);
    let report = report.with_stale(known.stale);
    deliver(&args.report, &report).max(known_status).max(args.known.init(&report))
}

/// The settings that affect reports.
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
