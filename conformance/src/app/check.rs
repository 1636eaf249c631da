//! `uavspec check`.

use std::collections::BTreeMap;
use std::io;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard};

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use uavspec_capture::input::Input;
use uavspec_check::baseline::{excuse_findings, is_rule};
use uavspec_check::timeline::{Texts, Timeline};
use uavspec_check::{Checked, parallel};
use uavspec_model::Reason;
use uavspec_model::clock::Clock;
use uavspec_model::text::terminal;
use uavspec_report::{Action, CheckedCapture, Origin, Report, Settings, Subject, Totals, Unreadable};
use uavspec_rules::definitions::{Definitions, Library};
use uavspec_schema::MessageId;
use uavspec_schema::msg::Dialect;

use super::baseline::{self, BaselineArgs, count_capture, count_unread};
use super::events::EventsArgs;
use super::explain::texts;
use super::inputs::Found;
use super::outcome::OutcomeArgs;
use super::outputs::{self, Inputs, Output};
use super::progress::Progress;
use super::report::ReportArgs;
use super::required::{RequireArgs, uncovered};
use super::{Exit, Status, outcome_statuses, unknown};

const EXAMPLES: &str = "Examples, with the files of `uavspec sample`:
  uavspec check flight.ulg
  uavspec check flight.mcap session.jsonl
  uavspec check --definitions px4@1.16 flight.ulg
  uavspec check --format json flight.ulg > report.json
  uavspec check --report html=report.html,junit=report.xml flight.ulg
  uavspec check --write-baseline baseline.toml flight.ulg
  uavspec check --baseline baseline.toml flight.ulg
  cat flight.ulg | uavspec check -

With your own files:
  uavspec check --definitions ../px4_msgs/msg logs/
  uavspec check --report parquet=tables --timeline archive/
  uavspec check --resume tables s3://flights/2026/
  uavspec check rosbag2_2026_11_23/
  uavspec check --type px4/FailsafeFlags flags.jsonl
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

A baseline is a TOML file with a list of known failures. Only rule and reason are required:
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
    /// .ulg, .ulge, .mcap, .db3, .json, .jsonl and .ndjson files. The folder of a rosbag2 bag is one input. Symbolic links
    /// are followed. Other files in folders are listed as not checked, unless they are hidden.
    ///
    /// URLs are s3://BUCKET/FOLDER, gs://BUCKET/FOLDER, az://CONTAINER/FOLDER, and https://HOST/PATH: a capture, or a list
    /// with one URL per line. Credentials come from the environment or, in a cloud, from the machine. URLs require a
    /// program that was built with the feature `stores`.
    #[allow(clippy::doc_markdown, reason = "the help would show the marks of links")]
    #[arg(required = true, value_name = "FILE|URL")]
    files: Vec<PathBuf>,
    /// Definitions to check against [default: chosen for each capture].
    ///
    /// A release such as px4@1.16 or ros2@jazzy, a uavspec.toml file, a folder that contains one, or a folder of PX4
    /// messages or ROS 2 packages. By default, uavspec compares each capture with all releases of PX4 since 1.13 and of
    /// ROS 2's common interfaces, and checks it against the release that matches best.
    #[arg(long, value_name = "PATH|RELEASE")]
    definitions: Option<PathBuf>,
    #[command(flatten)]
    events: EventsArgs,
    /// Language of the definitions in a folder that --definitions names [default: detected].
    #[arg(long, value_name = "DIALECT", requires = "definitions", value_parser = dialects())]
    dialect: Option<Dialect>,
    /// Folder with JSON Schemas for Flockwave message types that uavspec doesn't define (repeatable).
    ///
    /// All .json files in the folder and its subfolders are read. Types that have a definition are checked against the
    /// definition. Requires a program that was built with the feature `schemas`.
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
    /// Number of parallel checks [default: one per CPU].
    #[arg(long, value_name = "N")]
    jobs: Option<NonZeroUsize>,
    #[command(flatten)]
    baseline: BaselineArgs,
    #[command(flatten)]
    report: ReportArgs,
    /// Write tables to this folder, like --report parquet=DIR, and skip the captures that it contains.
    ///
    /// Continues a run that was interrupted, or adds new captures. A capture is skipped if it hasn't changed: if an
    /// object has the same version as before, or a file the same size. Captures that couldn't be read are tried again.
    /// Requires a program that was built with the feature `tables`.
    #[arg(long, value_name = "DIR")]
    resume: Option<PathBuf>,
    /// Also write the changes of failsafe flags, error codes, modes and arming checks, and the events of PX4, as tables.
    ///
    /// Requires --report parquet=DIR, --report arrow=DIR or --resume DIR.
    #[arg(long)]
    timeline: bool,
}

/// The names of the dialects.
fn dialects() -> impl TypedValueParser<Value = Dialect> {
    let known = [(Dialect::Px4, "PX4 uORB messages"), (Dialect::Ros2, "ROS 2 interfaces")];
    let names = known.map(|(dialect, help)| PossibleValue::new(dialect.name()).help(help));
    PossibleValuesParser::new(names)
        .map(|name| if name == Dialect::Px4.name() { Dialect::Px4 } else { Dialect::Ros2 })
}

pub(super) fn check(args: &CheckArgs) -> Exit {
    let has_tables = args.resume.is_some() || args.report.has_tables();
    let missing = || "--timeline requires tables, such as --report parquet=tables".to_owned();
    let problem = (args.timeline && !has_tables).then(missing);
    if let Some(problem) = args.report.problem().or(problem) {
        return Err(Status::Usage.because(problem));
    }
    // The outputs are checked before the folders of tables are created. Folders that exist aren't compared.
    outputs::check(&Inputs::default(), &outputs_of(args))?;
    let mut outputs = args.report.start(Action::Check, args.timeline)?;
    let done = args.resume.as_deref().map(|folder| outputs.resume(folder, args.timeline)).transpose()?;
    let library = super::library(args.definitions.as_deref(), args.dialect, &args.schemas)?;
    let library = args.events.add_to(library)?;
    let required = args.require.rules()?;
    let message_id = message_id(args, &library)?;
    let texts = if args.timeline { Some(texts(args.definitions.as_deref())?) } else { None };
    let mut found = Found::new(&args.files)?;
    check_outputs(args, &found.captures)?;
    let has_nothing_new = done.is_some_and(|done| found.skip(&done)) && found.unreadable.is_empty();
    let mut baselines = baseline::read(&args.baseline)?;
    if has_nothing_new {
        // The baselines and the required rules concern captures that an earlier run has checked.
        let status = baseline::write(&baselines, Ok(false));
        let report = report(&library, outputs.finish(), Vec::new(), Vec::new());
        let report = report.with_not_checked(found.skipped).with_nothing_new();
        return Ok(outputs.deliver(&report).max(status));
    }
    let settings = settings(args);
    let mut unreadable = std::mem::take(&mut found.unreadable);
    for file in &unreadable {
        outputs.add_unreadable(file);
    }
    let kept = Mutex::default();
    let check = |input: &Input, progress: &Progress| {
        let kept = kept.lock().map_or(None, |mut kept: MutexGuard<'_, Kept>| kept.remove(&input.name()));
        kept.unwrap_or_else(|| check_input(input, message_id, &library, texts.as_ref(), progress))
    };
    let updated = if baselines.is_updated() {
        let mut sums = baselines.lists.sums(&is_rule);
        for file in &unreadable {
            count_unread(&baselines.lists, &mut sums, &file.path);
        }
        check_all(&found.captures, args.jobs, &check, |input, result, _| {
            match &result {
                Ok(found) => count_capture(&baselines.lists, &mut sums, &found.capture),
                Err(_) => count_unread(&baselines.lists, &mut sums, &input.name()),
            }
            // Standard input and pipes can't be read again.
            if input.path().is_some_and(|path| !(path.is_file() || path.is_dir()))
                && let Ok(mut kept) = kept.lock()
            {
                kept.entry(input.name()).or_insert(result);
            }
        });
        baselines.update(&sums)
    } else {
        Ok(())
    };
    let mut sums = baselines.lists.sums(&is_rule);
    for file in &unreadable {
        count_unread(&baselines.lists, &mut sums, &file.path);
    }
    check_all(&found.captures, args.jobs, &check, |input, result, progress| match result {
        Ok(CheckedFile { capture: mut found, definitions, timeline }) => {
            count_capture(&baselines.lists, &mut sums, &found);
            excuse_findings(&mut baselines.lists, &found.path, &mut found.result.findings);
            let subject = Subject::from_capture(found, &definitions, &settings);
            progress.pausing(|| outputs.add(&subject, &Origin::of(input), timeline.as_ref()));
        }
        Err(error) => {
            let path = input.name();
            progress.pausing(|| terminal::error(format_args!("{path}: {error}"), None));
            count_unread(&baselines.lists, &mut sums, &path);
            let file = Unreadable { path, message: error.to_string() };
            outputs.add_unreadable(&file);
            unreadable.push(file);
        }
    });
    let is_outdated = updated.map(|()| baselines.finish(&sums));
    let status = baseline::write(&baselines, is_outdated);
    let totals = outputs.finish();
    let reasons = uncovered(&required, &totals);
    let report = report(&library, totals, unreadable, reasons).with_not_checked(found.skipped);
    Ok(outputs.deliver(&report.with_stale(baseline::reasons(&baselines))).max(status))
}

/// The report of a run.
fn report(library: &Library, totals: Totals, unreadable: Vec<Unreadable>, reasons: Vec<Reason>) -> Report {
    Report::of_totals(Action::Check, super::command(), library.name(), totals, unreadable, reasons)
}

/// The results of captures that can't be read a second time, by name.
type Kept = BTreeMap<String, io::Result<CheckedFile>>;

/// A checked capture.
struct CheckedFile {
    capture: CheckedCapture,
    /// The definitions against which the capture was checked.
    definitions: Arc<Definitions>,
    /// The timeline, if the user requested it and the capture can be read.
    timeline: Option<Timeline>,
}

/// Checks all captures in parallel, and passes the results to `take` in order.
fn check_all(
    captures: &[Input],
    jobs: Option<NonZeroUsize>,
    check: &(impl Fn(&Input, &Progress) -> io::Result<CheckedFile> + Sync),
    mut take: impl FnMut(&Input, io::Result<CheckedFile>, &Progress),
) {
    let progress = Progress::bytes(captures.iter().filter_map(Input::size).sum());
    parallel::each(
        captures,
        jobs,
        |input| check(input, &progress),
        |input, result| take(input, result, &progress),
    );
}

/// Checks that no output replaces an input. Prints errors.
fn check_outputs(args: &CheckArgs, captures: &[Input]) -> Result<(), Status> {
    let captures = captures.iter().filter_map(Input::path);
    let inputs = Inputs {
        files: captures.chain(args.baseline.inputs()).collect(),
        definitions: args.definitions.as_deref().into_iter().collect(),
        schemas: &args.schemas,
    };
    outputs::check(&inputs, &outputs_of(args))
}

/// The files that a run writes.
fn outputs_of(args: &CheckArgs) -> Vec<Output<'_>> {
    args.report.outputs().chain(baseline::outputs(&args.baseline)).collect()
}

/// The type of all JSON messages, if the user specified it. Prints errors.
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
        let help = "specify a message from the definitions, such as px4/FailsafeFlags";
        let problem = format!("--type {name}: no such message in the definitions");
        unknown(&problem, name, known.iter().map(String::as_str), help)
    })
}

/// The settings that affect reports.
fn settings(args: &CheckArgs) -> Settings {
    let mut arguments = Vec::new();
    if let Some(path) = &args.definitions {
        arguments.extend(["--definitions".to_owned(), path.to_string_lossy().into_owned()]);
    }
    if let Some(path) = &args.events.events {
        arguments.extend(["--events".to_owned(), path.to_string_lossy().into_owned()]);
    }
    if let Some(dialect) = args.dialect {
        arguments.extend(["--dialect".to_owned(), dialect.name().to_owned()]);
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

fn check_input(
    input: &Input,
    message_id: Option<MessageId>,
    library: &Library,
    texts: Option<&Texts>,
    progress: &Progress,
) -> io::Result<CheckedFile> {
    let (started, reading) = (Clock::real().now(), &|input| progress.reading(input));
    let (checked, timeline) = Timeline::check_with(texts, input, message_id, library, reading)?;
    let Checked { result, definitions } = checked;
    let capture = CheckedCapture::new(input.name(), result, Clock::real().now() - started);
    Ok(CheckedFile { capture, definitions, timeline })
}
