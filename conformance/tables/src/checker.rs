//! Checks captures for other programs. Results are values and Arrow batches; nothing is printed.

use std::fmt;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::sync::Arc;

use arrow_array::RecordBatch;
use uavspec_capture::input::Input;
use uavspec_check::timeline::{Texts, Timeline as CaptureTimeline};
use uavspec_check::{Checked as CheckedInput, parallel};
use uavspec_model::clock::Clock;
use uavspec_model::text::shown_url;
use uavspec_report::timeline::{to_json, to_text};
use uavspec_report::{Action, CheckedCapture, Origin, Report, Settings, Subject, Unreadable};
use uavspec_rules::definitions::{EventMetadata, Library};
use uavspec_schema::Failure;

use super::messages::{self, Messages};
use super::rows::{Rows, TABLES, is_of_timeline};
use super::{events, failures, find, timeline};

/// The language of the labels in the text of a timeline.
const ENGLISH: &str = "en";

/// The options of a [`Checker`]. They match the options of `uavspec check`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// A release such as `px4@1.16`, or the path of definitions. By default, they are chosen for each capture.
    pub definitions: Option<PathBuf>,
    /// A file with event metadata, for captures that don't contain their own.
    pub events: Option<PathBuf>,
    /// The folders with JSON Schemas for other Flockwave types. They require the feature `schemas`.
    pub schemas: Vec<PathBuf>,
    /// True if formats that differ from the definitions count as violations.
    pub are_formats_strict: bool,
    /// True if violations of rules of level SHOULD count as failures.
    pub are_warnings_denied: bool,
    /// True if the tables contain the timeline.
    pub has_timeline: bool,
}

/// A capture.
#[derive(Clone, Debug)]
pub enum Capture {
    /// The path of a file or of a bag's folder, or the URL of an object.
    Named(String),
    /// The content of a file.
    Bytes {
        /// The name in reports and tables.
        name: String,
        /// The content, compressed or not.
        bytes: Arc<[u8]>,
    },
}

/// The reason why a capture can't be opened, or why options are invalid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem(String);

impl Problem {
    pub(super) fn new(text: impl Into<String>) -> Self {
        Self(text.into())
    }

    /// The problem with a capture.
    pub(super) fn of(name: &str, reason: impl fmt::Display) -> Self {
        Self(format!("{name}: {reason}"))
    }
}

impl From<Failure> for Problem {
    fn from(failure: Failure) -> Self {
        let text = failure.to_string();
        Self::new(text.strip_prefix("error: ").unwrap_or(&text))
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

impl std::error::Error for Problem {}

/// Tables with the results of captures. The page about tables in the guide describes them.
#[derive(Clone, Debug)]
pub struct Tables(Vec<(&'static str, RecordBatch)>);

impl Tables {
    /// The table with this name. `timeline` and `events` exist only if the options request the timeline.
    pub fn get(&self, name: &str) -> Option<&RecordBatch> {
        self.iter().find(|(known, _)| *known == name).map(|(_, batch)| batch)
    }

    /// The names and the rows of all tables.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, &RecordBatch)> {
        self.0.iter().map(|(name, batch)| (*name, batch))
    }

    fn new(mut rows: Rows, failures: &[Unreadable], has_timeline: bool) -> Result<Self, Problem> {
        rows.sort();
        let failed = |error: arrow_schema::ArrowError| Problem::new(error.to_string());
        let batches = TABLES.into_iter().zip(rows.batches().map_err(failed)?);
        let mut tables: Vec<_> = batches.filter(|(name, _)| has_timeline || !is_of_timeline(name)).collect();
        tables.push((failures::TABLE.name, failures::TABLE.batch(failures).map_err(failed)?));
        Ok(Self(tables))
    }
}

/// The result of checking a capture.
#[derive(Debug)]
pub struct Checked {
    /// The report, with a single subject.
    pub report: Report,
    /// The tables.
    pub tables: Tables,
}

/// The timeline of a capture, as in `uavspec explain`.
#[derive(Debug)]
pub struct Timeline {
    /// The text.
    pub text: String,
    /// The timeline in JSON.
    pub json: String,
    /// The table `timeline`.
    pub timeline: RecordBatch,
    /// The table `events`.
    pub events: RecordBatch,
}

/// Checks captures against definitions, which are read once.
///
/// ```
/// use uavspec_tables::{Capture, Checker, Options};
///
/// let checker = Checker::new(&Options::default())?;
/// let record = br#"{"type": "px4/ArmingCheckRequest", "message": {"request_id": 300}}"#;
/// let capture = Capture::Bytes { name: "request.jsonl".to_owned(), bytes: record[..].into() };
/// let checked = checker.check(&capture)?;
/// assert_eq!(checked.report.outcome.kind.name(), "does not conform");
/// assert_eq!(checked.tables.get("captures").unwrap().num_rows(), 1);
/// # Ok::<(), uavspec_tables::Problem>(())
/// ```
pub struct Checker {
    library: Library,
    texts: Option<Texts>,
    settings: Settings,
}

impl Checker {
    /// Reads the definitions.
    ///
    /// # Errors
    /// Reads the definitions and the other files in the options. Fails if one of them can't be read.
    pub fn new(options: &Options) -> Result<Self, Problem> {
        let path = options.definitions.as_deref();
        let library = path.map_or_else(|| Ok(Library::built_in()), |path| Library::load(path, None))?;
        let library =
            library.with_schemas(&options.schemas).map_err(|error| Problem::new(error.to_string()))?;
        let library = match &options.events {
            Some(path) => library.with_events(EventMetadata::load(path)?),
            None => library,
        };
        let texts = if options.has_timeline { Some(Texts::load(path)?) } else { None };
        let settings = Settings {
            are_formats_strict: options.are_formats_strict,
            are_warnings_denied: options.are_warnings_denied,
            ..Settings::default()
        };
        Ok(Self { library, texts, settings })
    }

    /// Checks a capture.
    ///
    /// # Errors
    /// Fails if the capture can't be opened, or if an object can't be read completely. If a part of the content can't
    /// be read, the report says so.
    pub fn check(&self, capture: &Capture) -> Result<Checked, Problem> {
        let (input, subject, timeline) = self.subject(capture).map_err(|reason| capture.problem(reason))?;
        let mut rows = Rows::default();
        rows.add(&subject, Origin::of(&input), timeline.as_ref());
        let tables = Tables::new(rows, &[], self.texts.is_some())?;
        let command = self.settings.command(&input.name());
        let report =
            Report::new(Action::Check, command, self.library.name(), vec![subject], Vec::new(), Vec::new());
        Ok(Checked { report, tables })
    }

    /// Checks captures in parallel; by default, with a thread for each processor. Captures that can't be opened are in the
    /// table `failures`.
    ///
    /// # Errors
    /// Fails if there are too many results for a table.
    pub fn check_all(&self, captures: &[Capture], jobs: Option<NonZeroUsize>) -> Result<Tables, Problem> {
        let (mut rows, mut failures) = (Rows::default(), Vec::new());
        let check = |capture: &Capture| self.subject(capture);
        parallel::each(captures, jobs, check, |capture, result| match result {
            Ok((input, subject, timeline)) => rows.add(&subject, Origin::of(&input), timeline.as_ref()),
            Err(message) => failures.push(Unreadable { path: shown_url(capture.name()), message }),
        });
        Tables::new(rows, &failures, self.texts.is_some())
    }

    /// Reads the messages of a topic. `topic` is the name in the capture, and `instance` is the instance of the topic
    /// in a PX4 log.
    ///
    /// # Errors
    /// Fails if the capture can't be read, if it doesn't contain the topic, or if the topic has no definition.
    pub fn read(&self, capture: &Capture, topic: &str, instance: u8) -> Result<Messages, Problem> {
        let input = capture.input().map_err(|reason| capture.problem(reason))?;
        messages::read(&input, topic, instance, &self.library).map_err(|reason| capture.problem(reason))
    }

    /// Explains a capture.
    ///
    /// # Errors
    /// Fails if the capture can't be read, or if the options don't request the timeline.
    pub fn explain(&self, capture: &Capture) -> Result<Timeline, Problem> {
        let texts =
            self.texts.as_ref().ok_or_else(|| Problem::new("the timeline is not enabled in the options"))?;
        let failed = |reason: &dyn fmt::Display| capture.problem(reason);
        let input = capture.input().map_err(|reason| failed(&reason))?;
        let (_, timeline) = CaptureTimeline::check(&input, None, &self.library, texts, &|bytes| bytes)
            .map_err(|error| failed(&error))?;
        let timeline = timeline.map_err(|reason| failed(&reason))?;
        let changes = timeline::TABLE.batch(&timeline::TimelineRow::of(&timeline).collect::<Vec<_>>());
        let events = events::TABLE.batch(&events::EventRow::of(&timeline).collect::<Vec<_>>());
        Ok(Timeline {
            text: to_text(&timeline, ENGLISH),
            json: to_json(&timeline),
            timeline: changes.map_err(|error| failed(&error))?,
            events: events.map_err(|error| failed(&error))?,
        })
    }

    /// The results of a capture, or the reason why it can't be read.
    fn subject(&self, capture: &Capture) -> Result<(Input, Subject, Option<CaptureTimeline>), String> {
        let (input, started) = (capture.input()?, Clock::real().now());
        let checked =
            CaptureTimeline::check_with(self.texts.as_ref(), &input, None, &self.library, &|bytes| bytes);
        let (CheckedInput { result, definitions }, timeline) = checked.map_err(|error| error.to_string())?;
        let found = CheckedCapture::new(input.name(), result, Clock::real().now() - started);
        Ok((input, Subject::from_capture(found, &definitions, &self.settings), timeline))
    }
}

impl Capture {
    /// The path, the URL, or the name that was given for the bytes.
    pub fn name(&self) -> &str {
        match self {
            Self::Named(name) | Self::Bytes { name, .. } => name,
        }
    }

    fn input(&self) -> Result<Input, String> {
        match self {
            Self::Named(name) => find::named(name),
            Self::Bytes { name, bytes } => Ok(Input::Bytes(shown_url(name), Arc::clone(bytes))),
        }
    }

    fn problem(&self, reason: impl fmt::Display) -> Problem {
        Problem::of(&shown_url(self.name()), reason)
    }
}
