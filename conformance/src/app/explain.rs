//! `uavspec explain`.

mod word;

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use uavspec_capture::input::Input;
use uavspec_capture::names::is_capture;
use uavspec_check::limits::{MAX_ALL_CHANGES, MAX_CHANGES};
use uavspec_check::timeline::{Part, Texts, Timeline, TopicStatus};
use uavspec_model::Extent;
use uavspec_model::text::{plural, shown, terminal};
use uavspec_report::timeline::{WhyNotArm, to_html, to_json, to_text};
use uavspec_schema::json_text;
use uavspec_schema::stage::write_file;

use super::events::EventsArgs;
use super::outputs::{self, Inputs, Output};
use super::progress::Progress;
use super::report::print;
use super::{Exit, Format, Status, unreadable};

/// The path that means standard input.
const STANDARD_INPUT: &str = "-";

/// The language of the definitions.
const ENGLISH: &str = "en";

const EXAMPLES: &str = "Examples, with the files of `uavspec sample`:
  uavspec explain flight.ulg
  uavspec explain flight.ulg --report html=flight.html
  uavspec explain flight.ulg --why-not-arm 0:05 --mode mission
  uavspec explain flight.mcap --format json
  uavspec explain session.jsonl --language uk

Without files:
  uavspec explain 134
  uavspec explain vehicle_status.nav_state=17
  uavspec explain mode_req_mission=0x80 --release px4@1.18
  uavspec explain VEHICLE_CMD_NAV_TAKEOFF
  uavspec explain sensor_msgs/msg/Imu --format json";

/// Arguments of `explain`.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES, after_long_help = after_long_help())]
pub(super) struct ExplainArgs {
    /// Capture or word to explain.
    ///
    /// A capture is a log, a bag, messages or a recorded session. A folder with a `metadata.yaml` is a bag. The path `-`
    /// means standard input.
    ///
    /// A word is an error code or its abbreviation, a topic, a message, a field, a value of a field, a constant, a
    /// uORB message hash, a ROS type hash, or a rule. The path of an existing file is always a capture.
    #[arg(value_name = "WHAT")]
    what: PathBuf,
    /// Release in which a word is explained, such as px4@1.16 [default: all releases].
    #[arg(long, value_name = "RELEASE", conflicts_with_all = ["definitions", "language", "report"])]
    release: Option<String>,
    /// Definitions to use [default: the release that matches the capture best].
    ///
    /// A release such as px4@1.16, a uavspec.toml file, a folder that contains one, a PX4 message file, or a folder of
    /// PX4 messages or ROS 2 packages.
    #[arg(long, value_name = "PATH")]
    definitions: Option<PathBuf>,
    #[command(flatten)]
    events: EventsArgs,
    /// Language of the labels, such as uk [default: en].
    ///
    /// Each translation catalogue of the definitions adds a language. Labels without a translation stay in English. The
    /// HTML report contains all languages.
    #[arg(long, value_name = "LANGUAGE")]
    language: Option<String>,
    /// Print only why the vehicle couldn't arm, at a time such as 75 or 1:15 [default: at any time].
    ///
    /// The answer comes from the health and arming reports in the events of PX4. It covers the modes that the vehicle was
    /// in. --mode selects another mode.
    #[arg(long, value_name = "TIME", num_args = 0..=1, value_parser = time)]
    #[allow(clippy::option_option)] // the option may have no value
    why_not_arm: Option<Option<i64>>,
    /// Mode for --why-not-arm, such as posctl or Loiter.
    #[arg(long, value_name = "NAME", requires = "why_not_arm")]
    mode: Option<String>,
    /// Output format: text or json.
    #[arg(long, value_name = "FORMAT", default_value = "text", hide_possible_values = true)]
    format: Format,
    /// Also write the timeline to a file, as an HTML page with a picture: html=FILE.
    ///
    /// The page is a single file that works offline. A report never replaces an input.
    #[arg(long, value_name = "html=FILE", value_parser = page)]
    report: Option<PathBuf>,
}

fn after_long_help() -> String {
    format!(
        "{EXAMPLES}

Limits: each lane lists at most {MAX_CHANGES} changes, and the timeline at
most {MAX_ALL_CHANGES}. Further changes are counted, and the durations include them.

Exit status:
  0  success
  2  invalid usage, unreadable definitions, or an unknown word
  3  the capture can't be opened or has an unknown type, or a report can't be
     written
  5  the capture has no timeline topics with a definition
  6  incomplete: some data can't be read"
    )
}

/// Parses a time as seconds, or as minutes and seconds. Returns µs.
fn time(text: &str) -> Result<i64, &'static str> {
    let (minutes, seconds) = text.split_once(':').unwrap_or(("0", text));
    let minutes = minutes.parse::<u32>().ok();
    let seconds = seconds.parse::<f64>().ok().filter(|seconds| (0.0..1e9).contains(seconds));
    let (minutes, seconds) =
        minutes.zip(seconds).ok_or("expected seconds, or minutes and seconds such as 1:15")?;
    #[allow(clippy::cast_possible_truncation)] // at most 1e15
    Ok(i64::from(minutes) * 60_000_000 + (seconds * 1e6) as i64)
}

/// Parses the path of the HTML page.
fn page(text: &str) -> Result<PathBuf, &'static str> {
    let path = text.strip_prefix("html=").filter(|path| !path.is_empty());
    path.map(PathBuf::from).ok_or("expected html=FILE, such as html=timeline.html")
}

/// Runs `uavspec explain`. An existing path and `-` denote captures.
pub(super) fn explain(args: &ExplainArgs) -> Exit {
    if args.what == Path::new(STANDARD_INPUT) || args.what.exists() {
        let Some(release) = &args.release else { return timeline(args) };
        let help = format!("use `--definitions {release}` for a capture");
        return Err(Status::Usage.with_help("--release applies to words only", &help));
    }
    let has_options = args.definitions.is_some()
        || args.events.events.is_some()
        || args.language.is_some()
        || args.report.is_some()
        || args.why_not_arm.is_some();
    if has_options || is_capture(&args.what) {
        let problem = format!("{}: no such file or folder", terminal::path(&args.what));
        let help = "specify a log, a bag, a file with messages or a recorded session";
        return Err(Status::Unreadable.with_help(problem, help));
    }
    word::explain_word(&args.what.to_string_lossy(), args.release.as_deref(), args.format)
}

/// Prints the timeline of a capture. Prints errors.
fn timeline(args: &ExplainArgs) -> Exit {
    let library = args.events.add_to(super::library(args.definitions.as_deref(), None, &[])?)?;
    let texts = texts(args.definitions.as_deref())?;
    let language = language(args.language.as_deref(), &texts.languages())?;
    check_outputs(args)?;
    let progress = Progress::bytes(std::fs::metadata(&args.what).map_or(0, |metadata| metadata.len()));
    let input = Input::Path(args.what.clone());
    let checked = Timeline::check(&input, None, &library, &texts, &|input| progress.reading(input));
    drop(progress);
    let (_, timeline) = checked.map_err(|error| unreadable(&args.what, error))?;
    let timeline = timeline.map_err(|reason| unreadable(&args.what, reason))?;
    if let Some(time_us) = args.why_not_arm {
        return why_not_arm(args, &timeline, &WhyNotArm { time_us, mode: args.mode.clone() }, &language);
    }
    write(args, &timeline, &language)?;
    Ok(status(&timeline))
}

/// Prints why the vehicle couldn't arm.
fn why_not_arm(args: &ExplainArgs, timeline: &Timeline, question: &WhyNotArm, language: &str) -> Exit {
    let Some(overview) = timeline.overview.as_ref().filter(|overview| !overview.modes.is_empty()) else {
        let help = "PX4 reports the reasons in events, which logs of PX4 1.14 and later contain";
        let problem =
            "the capture lacks `vehicle_status` or health and arming reports, or contains several vehicles";
        return Err(Status::Nothing.with_help(problem, help));
    };
    check_mode(question.mode.as_deref(), &overview.modes)?;
    if let Some(time) = question.time_us.filter(|time| time.unsigned_abs() > timeline.duration_us) {
        let problem = format!("the capture ends before {} s", time / 1_000_000);
        return Err(Status::Usage.with_help(problem, "specify an earlier time"));
    }
    let text = match args.format {
        Format::Text => {
            let metadata = timeline.event_metadata.as_deref().unwrap_or_default();
            format!("{}Events explained by {}.\n", question.answer(overview, language), shown(metadata))
        }
        Format::Json => json_text::pretty(&question.refusals(overview)),
    };
    print(&text).map_err(|error| Status::Unreadable.because(format_args!("standard output: {error}")))?;
    Ok(Status::Conforms)
}

/// Fails if no report contains this mode.
pub(super) fn check_mode(mode: Option<&str>, known: &[Part]) -> Result<(), Status> {
    let Some(mode) = mode.filter(|mode| !known.iter().any(|known| known.is_named(mode))) else {
        return Ok(());
    };
    let known: Vec<String> = known.iter().map(|mode| shown(&mode.name)).collect();
    let help = format!("the modes are {}", known.join(", "));
    Err(Status::Usage.with_help(format_args!("there is no mode `{}`", shown(mode)), &help))
}

/// The exit status of a timeline.
fn status(timeline: &Timeline) -> Status {
    if timeline.extent != Extent::Whole {
        let count = plural(timeline.corruption.len(), "part");
        return Status::Incomplete.because(format_args!("incomplete: {count} of the capture can't be read"));
    }
    if timeline.lanes.is_empty() {
        let undefined: Vec<&str> = timeline.topics(TopicStatus::Undefined).collect();
        let help = match (undefined.as_slice(), timeline.unreadable_messages) {
            ([], 0) => "the capture contains no topics of the timeline".to_owned(),
            ([], count) => format!(
                "{} can't be read or violate a rule: `uavspec check` reports the reasons",
                plural(count, "message")
            ),
            _ => format!("specify the definitions of {} with --definitions", undefined.join(", ")),
        };
        return Status::Nothing.with_help("nothing to explain", &help);
    }
    Status::Conforms
}

/// Prints the timeline, and writes the page. Prints errors.
fn write(args: &ExplainArgs, timeline: &Timeline, language: &str) -> Result<(), Status> {
    let text = match args.format {
        Format::Text => to_text(timeline, language),
        Format::Json => to_json(timeline),
    };
    let printed = print(&text).map_err(|error| format!("standard output: {error}"));
    let written = args.report.as_ref().map_or(Ok(()), |path| {
        let page = to_html(timeline, language, &super::command());
        write_file(path, |file| file.write_all(page.as_bytes()))
            .map_err(|error| format!("{}: can't write the report: {error}", terminal::path(path)))
    });
    let failures = [printed, written].into_iter().filter_map(Result::err);
    let failures = failures.inspect(|failure| terminal::error(failure, None)).count();
    if failures == 0 { Ok(()) } else { Err(Status::Unreadable) }
}

/// Checks that the page doesn't replace an input. Prints errors.
fn check_outputs(args: &ExplainArgs) -> Result<(), Status> {
    let inputs = Inputs {
        files: vec![&args.what],
        definitions: args.definitions.as_deref().into_iter().collect(),
        ..Inputs::default()
    };
    let outputs: Vec<Output<'_>> =
        args.report.iter().map(|path| Output::new("--report html", path)).collect();
    outputs::check(&inputs, &outputs)
}

/// The texts of the definitions at a path, or of the built-in definitions. Prints errors.
pub(super) fn texts(path: Option<&Path>) -> Result<Texts, Status> {
    Texts::load(path).map_err(|failure| Status::Usage.failed(&failure))
}

/// The tag of the language of the labels. Prints errors.
pub(super) fn language(wanted: Option<&str>, languages: &BTreeMap<String, String>) -> Result<String, Status> {
    let wanted = wanted.unwrap_or(ENGLISH);
    let known = std::iter::once(ENGLISH).chain(languages.keys().map(String::as_str));
    if let Some(tag) = known.clone().find(|tag| tag.eq_ignore_ascii_case(wanted)) {
        return Ok(tag.to_owned());
    }
    let help = format!("expected one of {}", known.collect::<Vec<_>>().join(", "));
    let problem = format!("--language {}: no such language", terminal::shown(wanted));
    Err(Status::Usage.with_help(problem, &help))
}
