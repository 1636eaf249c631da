//! `uavspec check`.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Instant;

use clap::{Args, ValueEnum};
use uavspec_codegen::msg::Dialect;
use uavspec_codegen::schema::MessageId;

use super::known::{KnownArgs, count_capture, count_unread};
use super::outcome::OutcomeArgs;
use super::outputs::{self, Inputs, Output};
use super::progress::Progress;
use super::report::ReportArgs;
use super::required::{RequireArgs, uncovered};
use super::{Status, outcome_statuses, print_unknown};
use crate::capture::input::{self, Files};
use crate::check::known::Scope;
use crate::check::{self, Checked, parallel};
use crate::definitions::{Definitions, Library};
use crate::model::{Reason, Rule};
use crate::report::{Action, CheckedCapture, Report, Settings, Subject, Totals, Unreadable};
use crate::text::terminal;

const EXAMPLES: &str = "Examples:
  uavspec check flight.ulg
  uavspec check --definitions px4@1.16 flight.ulg
  uavspec check --definitions ../px4_msgs/msg logs/
  uavspec check --format json flight.ulg > report.json
  uavspec check --report html=report.html,junit=report.xml flight.ulg
  uavspec check rosbridge.jsonl bag/bag_0.mcap
  uavspec check rosbag2_2026_11_23/
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
const FAILURE: &str = "an input can't be opened, or a report can't be written";

/// The meaning of exit status 6.
const INCOMPLETE: &str = "some data can't be read, or too little was checked";

/// Arguments of `check`.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES, after_long_help = format!("{EXAMPLES}\n\n{DETAILS}\n\n{}", outcome_statuses(FAILURE, Some(INCOMPLETE))))]
pub(super) struct CheckArgs {
    /// Files, folders or glob patterns; `-` means standard input.
    ///
    /// Inputs are PX4 logs (.ulg), bags (.mcap, or .db3 of rosbag2), JSON messages and recorded Flockwave sessions,
    /// optionally compressed with gzip or zstd. The file type is detected from the content. Folders are searched for
    /// .ulg, .ulge, .mcap, .db3, .json, .jsonl and .ndjson files. The folder of a rosbag2 bag is one input. Symbolic links are followed. Other files in folders are listed as not checked,
    /// unless they are hidden.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Definitions to check against (default: chosen for each capture).
    ///
    /// A release such as px4@1.16 or ros2@jazzy, a uavspec.toml file, a folder that contains one, or a folder of PX4
    /// messages or ROS 2 packages. By default, uavspec compares each capture with all releases of PX4 since 1.13 and of
    /// ROS 2's common interfaces, and checks it against the release that agrees best.
    #[arg(long, value_name = "PATH|RELEASE")]
    definitions: Option<PathBuf>,
    /// Dialect of the definitions in a folder (default: detected).
    #[arg(long, value_name = "DIALECT", requires = "definitions")]
    dialect: Option<DialectName>,
    /// Schemas for other Flockwave types (repeatable).
    ///
    /// All JSON Schemas (.json) in the folder and its subfolders are read. Types that have a definition are checked
    /// against the definition. A schema may have up to 100,000 inner schemas, counting each reference like a copy.
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
    #[command(flatten)]
    outcome: OutcomeArgs,
    /// Number of parallel checks (default: one per CPU).
    #[arg(long, value_name = "N")]
    jobs: Option<NonZeroUsize>,
    #[command(flatten)]
    known: KnownArgs,
    #[command(flatten)]
    report: ReportArgs,
}

/// The name of a dialect.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum DialectName {
    /// PX4's uORB messages
    Px4,
    /// ROS 2 interfaces
    Ros2,
}

impl From<DialectName> for Dialect {
    fn from(name: DialectName) -> Self {
        match name {
            DialectName::Px4 => Self::Px4,
            DialectName::Ros2 => Self::Ros2,
        }
    }
}

pub(super) fn check(args: &CheckArgs) -> Status {
    if let Some(problem) = args.report.problem() {
        terminal::error(problem, None);
        return Status::Usage;
    }
    let mut outputs = args.report.start(Action::Check, &args.known);
    let checked = match run(args, |subject| outputs.add(subject)) {
        Ok(checked) => checked,
        Err(status) => return status,
    };
    let (status, totals) = (checked.status, outputs.finish());
    outputs.deliver(&checked.report(totals)).max(status)
}

/// The report of a run that keeps all subjects, and the status of the lists of known failures.
#[cfg(test)]
pub(super) fn report(args: &CheckArgs) -> (Report, Status) {
    let mut subjects = Vec::new();
    let checked = run(args, |subject| subjects.push(subject)).expect("a report");
    let status = checked.status;
    let mut report = checked.report(Totals::of(&subjects));
    report.subjects = subjects;
    (report, status)
}

/// The results of a run, without the subjects.
struct Finished {
    definitions: String,
    required: Vec<&'static Rule>,
    unreadable: Vec<Unreadable>,
    not_checked: Vec<Unreadable>,
    /// The outdated entries in lists of known failures.
    stale: Vec<Reason>,
    /// The status of the lists of known failures.
    status: Status,
}

impl Finished {
    fn report(self, totals: Totals) -> Report {
        let (command, reasons) = (super::command(), uncovered(&self.required, &totals));
        Report::of_totals(Action::Check, command, &self.definitions, totals, self.unreadable, reasons)
            .with_not_checked(self.not_checked)
            .with_stale(self.stale)
    }
}

/// Checks all files. Passes each capture to `take` as soon as the captures before it are checked.
fn run(args: &CheckArgs, mut take: impl FnMut(Subject)) -> Result<Finished, Status> {
    let dialect = args.dialect.map(Dialect::from);
    let library = super::library(args.definitions.as_deref(), dialect, &args.schemas)?;
    let required = args.require.rules()?;
    let message_id = message_id(args, &library)?;
    let files = find_files(&args.files)?;
    check_outputs(args, &files)?;
    let mut known = args.known.read()?;
    let settings = settings(args);
    let mut unreadable = unfound(&files);
    let kept = Mutex::default();
    let check = |path: &Path, progress: &Progress| {
        let kept = kept.lock().map_or(None, |mut kept: MutexGuard<'_, Kept>| kept.remove(path));
        kept.unwrap_or_else(|| check_file(path, message_id, &library, progress))
    };
    let updated = if known.is_fixing() {
        let mut sums = known.lists.sums(Scope::Rules);
        for file in &unreadable {
            count_unread(&known.lists, &mut sums, &file.path);
        }
        check_all(&files, args.jobs, &check, |path, result, _| {
            match &result {
                Ok((found, _)) => count_capture(&known.lists, &mut sums, found),
                Err(_) => count_unread(&known.lists, &mut sums, &path.to_string_lossy()),
            }
            // Standard input and pipes can't be read again.
            if !(path.is_file() || path.is_dir())
                && let Ok(mut kept) = kept.lock()
            {
                kept.entry(path.to_owned()).or_insert(result);
            }
        });
        known.update(&sums)
    } else {
        Ok(())
    };
    let mut sums = known.lists.sums(Scope::Rules);
    for file in &unreadable {
        count_unread(&known.lists, &mut sums, &file.path);
    }
    check_all(&files, args.jobs, &check, |path, result, progress| match result {
        Ok((mut found, definitions)) => {
            count_capture(&known.lists, &mut sums, &found);
            known.excuse(&mut found);
            let subject = Subject::from_capture(found, &definitions, &settings);
            progress.pausing(|| take(subject));
        }
        Err(error) => {
            let path = path.to_string_lossy().into_owned();
            progress.pausing(|| terminal::error(format_args!("{path}: {error}"), None));
            count_unread(&known.lists, &mut sums, &path);
            unreadable.push(Unreadable { path, message: error.to_string() });
        }
    });
    let status = updated.map_or_else(|status| status, |()| known.finish(&sums));
    let not_checked = files.skipped.iter().map(|(path, reason)| unreadable_file(path, reason)).collect();
    Ok(Finished {
        definitions: library.name().to_owned(),
        required,
        unreadable,
        not_checked,
        stale: known.stale,
        status,
    })
}

/// The results of captures that can't be read again, by path.
type Kept = BTreeMap<PathBuf, CheckedFile>;

/// A checked capture, with the definitions against which it was checked. An error means that it can't be opened.
type CheckedFile = io::Result<(CheckedCapture, Arc<Definitions>)>;

/// Checks all captures in parallel, and passes the results to `take` in order.
fn check_all(
    files: &Files,
    jobs: Option<NonZeroUsize>,
    check: &(impl Fn(&Path, &Progress) -> CheckedFile + Sync),
    mut take: impl FnMut(&Path, CheckedFile, &Progress),
) {
    let sizes = files.captures.iter().filter_map(|path| Some(fs::metadata(path).ok()?.len()));
    let progress = Progress::bytes(sizes.sum());
    let captures = &files.captures;
    parallel::each(
        captures,
        jobs,
        |path| check(path, &progress),
        |path, result| take(path, result, &progress),
    );
}

/// Checks that no output replaces an input. Errors are printed.
fn check_outputs(args: &CheckArgs, files: &Files) -> Result<(), Status> {
    let outputs: Vec<Output<'_>> = args.report.outputs().chain(args.known.outputs()).collect();
    let captures = files.captures.iter().map(PathBuf::as_path);
    let inputs = Inputs {
        files: captures.chain(args.known.inputs()).collect(),
        definitions: args.definitions.as_deref(),
        schemas: &args.schemas,
    };
    outputs::check(&inputs, &outputs)
}

/// The type of all JSON messages, if it is given. Errors are printed.
fn message_id(args: &CheckArgs, library: &Library) -> Result<Option<MessageId>, Status> {
    let Some(name) = &args.message_type else { return Ok(None) };
    let definitions = library.base();
    definitions.message_of_type(name).map(Some).ok_or_else(|| {
        let messages = definitions.schema.packages.iter().flat_map(|package| {
            let named =
                move |id: &MessageId| format!("{}/{}", package.name, definitions.schema.message(*id).name);
            package.messages.iter().map(named)
        });
        let known: Vec<String> = messages.collect();
        let help = "name a message of the definitions, such as px4/FailsafeFlags";
        let problem = format!("--type {name}: no such message in the definitions");
        print_unknown(&problem, name, known.iter().map(String::as_str), help);
        Status::Usage
    })
}

/// The files to check. Errors are printed.
fn find_files(paths: &[PathBuf]) -> Result<Files, Status> {
    let files = input::files(paths).map_err(|(path, error)| {
        terminal::error(format_args!("{}: {error}", terminal::path(path)), None);
        Status::Usage
    })?;
    for (path, reason) in files.unreadable.iter().chain(&files.empty) {
        terminal::error(format_args!("{}: {reason}", terminal::path(path)), None);
    }
    Ok(files)
}

/// The paths that can't be read, and the folders and patterns that yield no captures. If there are no captures at all,
/// the latter aren't failures: the outcome is that nothing was checked.
fn unfound(files: &Files) -> Vec<Unreadable> {
    let empty = files.empty.iter().filter(|_| !files.captures.is_empty());
    files.unreadable.iter().chain(empty).map(|(path, reason)| unreadable_file(path, reason)).collect()
}

fn unreadable_file(path: &Path, reason: &str) -> Unreadable {
    Unreadable { path: path.to_string_lossy().into_owned(), message: reason.to_owned() }
}

/// The settings that affect reports.
fn settings(args: &CheckArgs) -> Settings {
    let mut arguments = Vec::new();
    if let Some(path) = &args.definitions {
        arguments.extend(["--definitions".to_owned(), path.to_string_lossy().into_owned()]);
    }
    if let Some(dialect) = args.dialect {
        arguments.extend(["--dialect".to_owned(), Dialect::from(dialect).name().to_owned()]);
    }
    for folder in &args.schemas {
        arguments.extend(["--schema".to_owned(), folder.to_string_lossy().into_owned()]);
    }
    if let Some(name) = &args.message_type {
        arguments.extend(["--type".to_owned(), name.clone()]);
    }
    if args.strict_formats {
        arguments.push("--strict-formats".to_owned());
    }
    let settings = args.outcome.settings();
    if settings.are_warnings_denied {
        arguments.extend(["--deny".to_owned(), "warning".to_owned()]);
    }
    Settings { are_formats_strict: args.strict_formats, arguments, ..settings }
}

fn check_file(
    path: &Path,
    message_id: Option<MessageId>,
    library: &Library,
    progress: &Progress,
) -> CheckedFile {
    let started = Instant::now();
    let Checked { result, definitions } =
        check::check_path(path, message_id, library, &|input| progress.reading(input))?;
    let capture = CheckedCapture {
        path: path.to_string_lossy().into_owned(),
        result,
        notes: Vec::new(),
        requests: Vec::new(),
        cut_short: Vec::new(),
        elapsed: started.elapsed().as_millis(),
    };
    Ok((capture, definitions))
}
