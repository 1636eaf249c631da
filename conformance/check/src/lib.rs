//! Checks captures: logs, bags, recorded sessions and lists of messages. The results are findings, a summary and a
//! [`timeline`]. Each record is checked by the rules and by the check plan of its format. [`convert`] converts the
//! messages of a capture to another release.
//!
//! ```
//! use uavspec_check::check_capture;
//! use uavspec_rules::definitions::Definitions;
//!
//! let definitions = Definitions::built_in();
//! let message_id = definitions.message_of_type("px4/ArmingCheckRequest");
//! let record = r#"{"timestamp": 7, "request_id": 300, "valid_registrations_mask": 1}"#;
//! let result = check_capture(record.as_bytes(), message_id, &definitions)?;
//! assert_eq!((result.records, result.checked), (1, 1));
//! let group = result.findings.groups().next().unwrap();
//! assert_eq!((group.rule.id, group.subject.as_str()), ("PX-JSON-02", "ArmingCheckRequest.request_id"));
//! let (place, detail) = &group.examples[0];
//! assert_eq!((place.to_string(), detail.actual.as_str()), ("line 1".to_owned(), "300"));
//! # Ok::<(), std::io::Error>(())
//! ```

#![cfg_attr(not(test), warn(clippy::disallowed_macros, clippy::disallowed_methods))]

pub mod convert;
pub mod limits;
pub mod timeline;

mod bag;
pub mod baseline;
mod clock;
mod coverage;
mod flockwave;
pub(crate) mod json;
mod log;
mod observer;
mod open;
#[doc(hidden)]
pub mod parallel;
mod release;
mod run;
mod summary;
mod topic;

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::sync::Arc;

use serde::Serialize;
use uavspec_capture::foreign;
use uavspec_capture::input::{self, Failure, FileState, Input};
use uavspec_capture::rosbag::metadata;
use uavspec_model::{Extent, Findings, Location};
use uavspec_rules::definitions::{Clues, Definitions, Library};
use uavspec_schema::MessageId;

pub use self::bag::{
    BagChannel, BagSummary, Basis, BusEndpoint, BusTopic, ChannelResult, CheckStatus, HASH, LiveBag,
    McapSummary, StatedType, check_mcap, decompressed, digest, stated_type,
};
pub(crate) use self::bag::{DISTRIBUTION, definitions_of, stated_distribution};
pub use self::clock::Clock;
use self::coverage::Parts;
pub use self::coverage::{Coverage, Part, PartResult, Share, Unit};
#[doc(hidden)]
pub use self::flockwave::FlockwaveChecker;
pub(crate) use self::flockwave::is_flockwave;
pub use self::flockwave::{FlockwaveSummary, TypeCount, UnreadTimes};
pub use self::json::{JsonSummary, check_json};
pub use self::log::{Format, FormatResult, LogSummary, check_ulog};
pub use self::observer::Observer;
pub use self::open::{Database, Opened, OpenedFolder, open_folder, open_path};
use self::release::Ahead;
pub use self::release::{OtherRelease, ReleaseMatch};
use self::run::{CheckRun, Logged, microseconds};
pub use self::summary::{Describe, Line, List, MAX_LISTED, Totals, names};
pub use self::topic::{confirms, definition_of, definition_of_json, is_guess, shows_type, topic_of};

/// The number of bytes at the start of a capture that are used to detect its kind. They also identify files that aren't
/// captures.
const START: usize = foreign::START;

/// The number of bytes that the error message for an unknown file shows.
const SHOWN: usize = 8;

/// The minimum number of magic bytes that identify a capture truncated within its magic.
const MIN_MAGIC: usize = 4;

/// A kind of capture.
struct Kind {
    /// The name of the format.
    name: &'static str,
    /// True if a capture of this kind can start with these bytes.
    detect: fn(&[u8]) -> bool,
    /// Chooses the definitions of a capture. Reads only as much of the capture as necessary.
    choose: fn(&mut Source<'_>, &Library) -> Arc<Definitions>,
    /// Checks the readable part of a capture of this kind.
    check: fn(Source<'_>, Option<MessageId>, CheckRun<'_>) -> CaptureResult,
}

/// The bytes of a capture.
struct Source<'s> {
    bytes: &'s mut dyn Read,
    /// The file that contains these bytes, if there is one. Some formats aren't read from start to end.
    file: Option<&'s Path>,
    /// The temporary copy of the file, if there is one. Its name can be removed while it is open.
    copy: Option<&'s bag::CopiedFile>,
}

impl Read for Source<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        self.bytes.read(out)
    }
}

/// Chooses the definitions for a recording that is still being written.
pub fn choose_for_recording(path: &Path, library: &Library) -> io::Result<Arc<Definitions>> {
    Ok(if library.depends_on_capture() {
        library.choose(&bag::recording_clues(path, library.shared())?)
    } else {
        Arc::clone(library.base())
    })
}

/// Chooses the definitions for a file, like [`check_path`].
pub fn choose_for_path(path: &Path, library: &Library) -> io::Result<Arc<Definitions>> {
    let opened = open_path(path, library, &|input| input)?;
    Ok(opened.map_or_else(|_| Arc::clone(library.base()), |opened| opened.definitions))
}

/// Wraps an input before it is read, for example to show progress.
pub type Reading<'r> = &'r dyn Fn(Box<dyn Read + Send>) -> Box<dyn Read + Send>;

/// All kinds of captures, in the order of detection.
static KINDS: [Kind; 6] = [log::ENCRYPTED, log::KIND, bag::MCAP, bag::SQLITE, bag::ROS1, json::KIND];

/// The summary of a capture, with a variant for each kind.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum Summary {
    /// A PX4 log.
    #[serde(rename = "ulog")]
    Log(LogSummary),
    /// JSON messages.
    Json(JsonSummary),
    /// An MCAP file.
    Mcap(McapSummary),
    /// A rosbag2 bag: a `SQLite` file, or a folder with `metadata.yaml`.
    #[serde(rename = "rosbag2")]
    Bag(BagSummary),
    /// A recorded Flockwave session. Only messages from the server are counted.
    Flockwave(FlockwaveSummary),
    /// A file that isn't a capture, or a capture that can't be read.
    Unknown(UnknownSummary),
}

/// The summary of a file of which nothing can be read.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
#[schemars(rename = "Unknown")]
pub struct UnknownSummary {
    /// The reason.
    pub reason: String,
}

impl Describe for UnknownSummary {
    fn facts(&self, _: Totals) -> Vec<String> {
        vec!["not a readable capture".to_owned()]
    }

    fn lines(&self) -> Vec<Line> {
        Vec::new()
    }
}

impl Summary {
    /// The releases that the capture was compared with.
    pub fn releases(&self) -> &[ReleaseMatch] {
        match self {
            Self::Log(summary) => &summary.releases,
            Self::Mcap(summary) => &summary.releases,
            Self::Bag(summary) => &summary.releases,
            Self::Json(summary) => &summary.releases,
            Self::Flockwave(_) | Self::Unknown(_) => &[],
        }
    }

    /// The parts of the summary that human-readable reports print.
    pub fn describe(&self) -> &dyn Describe {
        match self {
            Self::Log(summary) => summary,
            Self::Json(summary) => summary,
            Self::Mcap(summary) => summary,
            Self::Bag(summary) => summary,
            Self::Flockwave(summary) => summary,
            Self::Unknown(summary) => summary,
        }
    }
}

/// The result of checking a capture.
#[derive(Debug)]
pub struct CaptureResult {
    /// The summary of the capture.
    pub summary: Summary,
    /// The number of bytes read.
    pub bytes: u64,
    /// The time from the first to the last timestamp, in µs. In a PX4 log, timestamps before the start of logging don't
    /// count.
    pub duration: u64,
    /// The last timestamp that counts for the duration; 0 if there is none.
    pub end: u64,
    /// The number of messages.
    pub records: u64,
    /// The number of checked messages. Messages are checked if their type is known and they can be decoded.
    pub checked: u64,
    /// The distinct corrupt parts in order of appearance, each with its first location.
    pub corruption: Vec<(Location, String)>,
    /// The number of additional corrupt parts that aren't listed.
    pub more_corruption: u64,
    /// Notable events in the recording of a live vehicle, in order.
    pub notes: Vec<String>,
    /// The reasons why the capture is incomplete although it can be read: the recording of a live vehicle was cut
    /// short, or a file changed while it was read.
    pub cut_short: Vec<String>,
    /// The extent to which the capture could be read.
    pub extent: Extent,
    /// The clock that the times in the findings refer to.
    pub clock: Clock,
    /// The topics or types, with the extent to which each was checked.
    pub coverage: Coverage,
    /// The event metadata that explains the events, if there are any.
    pub event_metadata: Option<String>,
    /// All violations.
    pub findings: Findings,
}

impl CaptureResult {
    /// The result for a file that can't be read at all.
    pub fn unknown(reason: impl Into<String>) -> Self {
        Self {
            summary: Summary::Unknown(UnknownSummary { reason: reason.into() }),
            bytes: 0,
            duration: 0,
            end: 0,
            records: 0,
            checked: 0,
            corruption: Vec::new(),
            more_corruption: 0,
            notes: Vec::new(),
            cut_short: Vec::new(),
            extent: Extent::Unreadable,
            clock: Clock::default(),
            coverage: Parts::default().finish(Unit::default(), 0),
            event_metadata: None,
            findings: Findings::default(),
        }
    }
}

/// Checks a capture of any kind. The kind is detected from the first bytes. If `message_id` is set, JSON input
/// consists of bare messages of that type.
///
/// # Errors
/// Fails if the first bytes can't be read. Later problems, including an early end and an unknown kind, are part of the
/// result.
pub fn check_capture(
    mut input: impl Read,
    message_id: Option<MessageId>,
    definitions: &Definitions,
) -> io::Result<CaptureResult> {
    let source = Source { bytes: &mut input, file: None, copy: None };
    let check =
        &mut |kind: &Kind, source: Source<'_>| (kind.check)(source, message_id, CheckRun::new(definitions));
    check_source(source, message_id, check)
}

/// Like [`check_capture`], and also passes the records to an observer.
pub fn observe_capture(
    mut input: impl Read,
    definitions: &Definitions,
    observer: &mut dyn Observer,
) -> io::Result<CaptureResult> {
    let source = Source { bytes: &mut input, file: None, copy: None };
    let check = &mut |kind: &Kind, source: Source<'_>| {
        (kind.check)(source, None, CheckRun::observed_by(definitions, Some(observer)))
    };
    check_source(source, None, check)
}

/// The result of checking a capture, with the definitions against which it was checked.
pub struct Checked {
    /// The result.
    pub result: CaptureResult,
    /// The definitions.
    pub definitions: Arc<Definitions>,
}

/// Like [`check_capture`], for a file, a folder of a bag or standard input. The library chooses the definitions. Fails if
/// the path can't be opened.
pub fn check_path(
    path: &Path,
    message_id: Option<MessageId>,
    library: &Library,
    reading: Reading<'_>,
) -> io::Result<Checked> {
    check_path_with(path, message_id, library, None, reading)
}

/// Like [`check_path`], for any input, and also passes the records to an observer.
///
/// # Errors
/// Fails if an object in an object store can't be read completely.
pub fn check_input(
    input: &Input,
    message_id: Option<MessageId>,
    library: &Library,
    observer: Option<&mut dyn Observer>,
    reading: Reading<'_>,
) -> io::Result<Checked> {
    match input {
        Input::Path(path) => check_path_with(path, message_id, library, observer, reading),
        Input::Object(object) => {
            let failure = Failure::default();
            let input = reading(object.open(&failure)?);
            let checked = check_stream(input, None, message_id, library, observer);
            failure.take().map_or(Ok(checked), |problem| Err(io::Error::other(problem)))
        }
        Input::Bytes(_, bytes) => {
            let bytes = reading(Box::new(io::Cursor::new(Arc::clone(bytes))));
            Ok(check_stream(bytes, None, message_id, library, observer))
        }
    }
}

fn check_path_with(
    path: &Path,
    message_id: Option<MessageId>,
    library: &Library,
    observer: Option<&mut dyn Observer>,
    reading: Reading<'_>,
) -> io::Result<Checked> {
    if let Some(folder) = metadata::folder_of(path) {
        let clues = || bag::folder_clues(folder, library.shared());
        let clues = library.depends_on_capture().then(clues).unwrap_or_default();
        let definitions = library.choose(&clues);
        let result = bag::check_folder(folder, CheckRun::observed_by(&definitions, observer), reading)?;
        return Ok(Checked { result, definitions });
    }
    let state = FileState::of(path);
    let input = reading(input::open(path)?);
    let mut checked = check_stream(input, state.map(|_| path), message_id, library, observer);
    checked.result.cut_short.extend(state.and_then(|state| state.change(path)));
    Ok(checked)
}

/// Checks a copy of a `SQLite` file. The copy is needed to find the release, because a stream can't be read in any
/// order.
fn check_copy(
    bytes: &mut dyn Read,
    library: &Library,
    observer: Option<&mut dyn Observer>,
) -> io::Result<Checked> {
    let (copy, problem) = bag::copy(bytes);
    let mut checked = match &copy {
        Some(copy) => {
            let path = copy.path();
            let source = Source { bytes: &mut File::open(path)?, file: Some(path), copy: Some(copy) };
            check_with(source, None, library, observer)?
        }
        None => Checked { result: CaptureResult::unknown(""), definitions: Arc::clone(library.base()) },
    };
    if let Some((location, text)) = problem {
        if copy.is_none() {
            checked.result = CaptureResult::unknown(text.clone());
        }
        checked.result.corruption.push((location, text));
        checked.result.extent = Extent::Unreadable;
    }
    Ok(checked)
}

/// Checks the bytes of a capture. `file` is the file that contains these bytes.
fn check_stream(
    input: Box<dyn Read + Send>,
    file: Option<&Path>,
    message_id: Option<MessageId>,
    library: &Library,
    observer: Option<&mut dyn Observer>,
) -> Checked {
    let checked = input::decompressed(input).and_then(|(mut bytes, is_plain)| {
        let (file, start) = (file.filter(|_| is_plain), read_start(&mut bytes)?);
        let is_copied = file.is_none() && (bag::SQLITE.detect)(&start);
        let whole = &mut io::Cursor::new(start).chain(bytes);
        if is_copied {
            return check_copy(whole, library, observer);
        }
        check_with(Source { bytes: whole, file, copy: None }, message_id, library, observer)
    });
    checked.unwrap_or_else(|error| {
        let result = CaptureResult::unknown(format!("the file can't be read: {error}"));
        Checked { result, definitions: Arc::clone(library.base()) }
    })
}

/// Like [`check_capture`], with the definitions that the library chooses.
pub fn check_bytes(mut bytes: &[u8], library: &Library) -> io::Result<Checked> {
    check_with(Source { bytes: &mut bytes, file: None, copy: None }, None, library, None)
}

/// Chooses the definitions of a capture from its start, and checks the readable part.
fn check_with(
    source: Source<'_>,
    message_id: Option<MessageId>,
    library: &Library,
    mut observer: Option<&mut dyn Observer>,
) -> io::Result<Checked> {
    let mut definitions = None;
    let result = check_source(source, message_id, &mut |kind, source| {
        let (chosen, start) = choose(kind, source.bytes, source.file, library);
        let whole = &mut io::Cursor::new(start).chain(source.bytes);
        let run = CheckRun::observed_by(definitions.insert(chosen), observer.as_deref_mut());
        (kind.check)(Source { bytes: whole, file: source.file, copy: source.copy }, message_id, run)
    })?;
    let definitions = definitions.unwrap_or_else(|| Arc::clone(library.base()));
    Ok(Checked { result, definitions })
}

/// Chooses the definitions of a capture. Returns them, and the bytes that were read for this purpose.
fn choose(
    kind: &Kind,
    bytes: &mut dyn Read,
    file: Option<&Path>,
    library: &Library,
) -> (Arc<Definitions>, Vec<u8>) {
    if !library.depends_on_capture() {
        return (library.choose(&Clues::default()), Vec::new());
    }
    let mut ahead = Ahead::new(bytes);
    let definitions = (kind.choose)(&mut Source { bytes: &mut ahead, file, copy: None }, library);
    (definitions, ahead.bytes)
}

/// Checks the readable part of a capture. Detects the kind, and calls `check` with the kind and the whole capture.
fn check_source(
    mut input: Source<'_>,
    message_id: Option<MessageId>,
    check: &mut dyn FnMut(&Kind, Source<'_>) -> CaptureResult,
) -> io::Result<CaptureResult> {
    let start = read_start(&mut input)?;
    if start.is_empty() {
        return Ok(CaptureResult::unknown("the file is empty"));
    }
    let Some(kind) = KINDS.iter().find(|kind| (kind.detect)(&start)) else {
        return Ok(CaptureResult::unknown(unknown_type(&start)));
    };
    let bytes = &mut io::Cursor::new(&start).chain(input.bytes);
    let source = Source { bytes, file: input.file, copy: input.copy };
    let result = check(kind, source);
    // Other text looks like corrupt JSON up to its end.
    let is_text = matches!(&result.summary, Summary::Json(summary) if !summary.has_objects)
        && !json::starts_like_json(&start);
    Ok(if is_text && message_id.is_none() { CaptureResult::unknown(unknown_type(&start)) } else { result })
}

/// Reads the bytes that indicate the kind of a capture.
fn read_start(input: &mut impl Read) -> io::Result<Vec<u8>> {
    let mut start = Vec::new();
    input.take(START as u64).read_to_end(&mut start)?;
    Ok(start)
}

/// The error for a file of an unknown type that starts with these bytes.
fn unknown_type(start: &[u8]) -> String {
    if let Some(text) = foreign::describe(start) {
        return text.to_owned();
    }
    let start = &start[..start.len().min(SHOWN)];
    let mut names: Vec<&str> = KINDS.iter().map(|kind| kind.name).collect();
    names.dedup();
    let last = names.pop().unwrap_or_default();
    let is_text = start.iter().all(|byte| matches!(byte, b' '..=b'~' | b'\t' | b'\r' | b'\n'));
    let found = if is_text {
        format!("`{}`", start.escape_ascii())
    } else {
        let bytes: Vec<String> = start.iter().map(|byte| format!("{byte:02x}")).collect();
        format!("the bytes {}", bytes.join(" "))
    };
    format!("unknown file type: expected {} or {last}, found {found}", names.join(", "))
}

/// True if a capture starts with the magic, or was truncated within the magic after at least [`MIN_MAGIC`] bytes.
fn has_magic(start: &[u8], magic: &[u8]) -> bool {
    start.starts_with(magic) || start.len() >= MIN_MAGIC && magic.starts_with(start)
}
