//! `uavspec explain`.

mod story;
mod word;

use std::path::{Path, PathBuf};

use clap::Args;

use self::story::{Page, story};
use self::word::explain_words;
use super::{Format, Status};
use crate::story::{MAX_ALL_CHANGES, MAX_CHANGES};
use crate::text::terminal;

/// The path that means standard input.
const STANDARD_INPUT: &str = "-";

const EXAMPLES: &str = "Examples:
  uavspec explain flight.ulg
  uavspec explain flight.ulg --report html=story.html
  uavspec explain session.jsonl --language uk
  uavspec explain 134
  uavspec explain LOWBAT
  uavspec explain vehicle_status.nav_state=17
  uavspec explain mode_req_mission=0x80
  uavspec explain VEHICLE_CMD_NAV_TAKEOFF --release px4@1.18
  uavspec explain sensor_msgs/msg/Imu --format json
  uavspec explain PX-RANGE-01";

/// Arguments of `explain`.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES, after_long_help = after_long_help())]
pub(super) struct ExplainArgs {
    /// A capture, or words to explain.
    ///
    /// A capture is a log, a bag, messages or a recorded session. A folder with a `metadata.yaml` is a bag. The path `-`
    /// means standard input.
    ///
    /// A word is an error code or its abbreviation, a topic, a message, a field, a value of a field, a constant, a
    /// uORB message hash, a ROS type hash, or a rule. A name that several messages use lists all of them. If a file has
    /// the name of a word, the file is explained.
    #[arg(required = true, value_name = "CAPTURE|WORD")]
    what: Vec<PathBuf>,
    /// Definitions for a capture (default: the release that it agrees with).
    ///
    /// A release such as px4@1.16, a `uavspec.toml`, a folder that contains one, or a folder with definitions.
    #[arg(long, value_name = "PATH|RELEASE")]
    definitions: Option<PathBuf>,
    /// Language of the labels in a story, such as uk (default: en).
    ///
    /// The languages are those of the catalogues that belong to the definitions. Labels without a translation stay in
    /// English. The HTML report contains all languages.
    #[arg(long, value_name = "LANGUAGE")]
    language: Option<String>,
    /// Explain words by one release only, such as px4@1.16 (default: all).
    #[arg(long, value_name = "RELEASE")]
    release: Option<String>,
    /// Output format: text or json.
    #[arg(long, value_name = "FORMAT", default_value = "text", hide_possible_values = true)]
    format: Format,
    /// Also write a page with a picture of the story: html=FILE.
    ///
    /// The page is a single file that needs no network. A report never replaces an input.
    #[arg(long, value_name = "html=FILE")]
    report: Option<Page>,
}

fn after_long_help() -> String {
    format!(
        "{EXAMPLES}

Limits: each lane of a story lists at most {MAX_CHANGES} changes, and the story at
most {MAX_ALL_CHANGES}. Further changes are counted, and the durations include them.

Exit status:
  0  success
  2  invalid usage, an unknown word, or unreadable definitions
  3  the capture can't be opened or has an unknown type, or an output can't be
     written
  5  the capture has no topics of the story that have a definition
  6  incomplete: some data can't be read"
    )
}

/// Runs `uavspec explain`. An existing path and `-` are captures, and all other arguments are words.
pub(super) fn explain(args: &ExplainArgs) -> Status {
    let is_capture = |path: &&PathBuf| *path == Path::new(STANDARD_INPUT) || path.exists();
    let Some(capture) = args.what.iter().find(is_capture) else {
        return match args.story_option() {
            None => explain_words(&args.what, args.release.as_deref(), args.format),
            Some(option) => refuse(&format!("{option} applies to captures, but no argument is a file")),
        };
    };
    if args.what.len() > 1 {
        return refuse(&format!("{} is a capture: explain it alone", terminal::path(capture)));
    }
    if args.release.is_some() {
        return refuse("--release applies to words: name the definitions of a capture with --definitions");
    }
    story(capture, args).unwrap_or_else(|status| status)
}

impl ExplainArgs {
    /// An option that applies only to captures.
    fn story_option(&self) -> Option<&'static str> {
        let options = [
            ("--definitions", self.definitions.is_some()),
            ("--language", self.language.is_some()),
            ("--report", self.report.is_some()),
        ];
        options.into_iter().find(|(_, is_given)| *is_given).map(|(name, _)| name)
    }
}

fn refuse(problem: &str) -> Status {
    terminal::error(problem, None);
    Status::Usage
}
