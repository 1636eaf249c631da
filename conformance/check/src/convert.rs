//! Converts the messages of a capture to other definitions, or to another format.

mod bag;
mod bag_to_log;
mod folder;
mod information;
mod json;
mod log;
mod log_to_bag;
mod plan;
mod report;
mod ros;
mod topic;
mod ulog;

use std::io::{self, BufWriter, Seek as _, SeekFrom, Write};
use std::path::Path;

use serde::Serialize;
use tempfile::SpooledTempFile;
use uavspec_schema::Failure;

use self::bag::{Distribution, Source, Target, Unpacked};
pub use self::folder::{convert_folder, file_names};
use self::plan::Converters;
pub use self::plan::Plan;
use self::report::Problems;
pub use self::report::{Action, ConversionReport, Loss, TopicReport};
use crate::Opened;

/// A format of captures that can be converted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub enum Format {
    /// JSON messages.
    #[serde(rename = "JSON")]
    Json,
    /// A PX4 log.
    #[serde(rename = "ULog")]
    Log,
    /// An MCAP file.
    #[serde(rename = "MCAP")]
    Mcap,
    /// A `SQLite` file of rosbag2.
    #[serde(rename = "SQLite")]
    Sqlite,
}

impl Format {
    /// The format of an opened capture.
    pub fn of(opened: &Opened<'_>) -> Result<Self, Error> {
        match opened.kind {
            "JSON" => Ok(Self::Json),
            "ULog" => Ok(Self::Log),
            "MCAP" => Ok(Self::Mcap),
            "rosbag2" => Ok(Self::Sqlite),
            other => Err(Error::format(other)),
        }
    }

    /// The name of the format.
    pub fn name(self) -> &'static str {
        match self {
            Self::Json => "JSON",
            Self::Log => "ULog",
            Self::Mcap => "MCAP",
            Self::Sqlite => "SQLite",
        }
    }
}

/// The settings of a conversion.
#[derive(Clone, Copy, Debug, Default)]
pub struct Settings {
    /// The format of the output; `None` is the format of the capture.
    pub format: Option<Format>,
    /// True if messages that can't be converted are copied unchanged. Otherwise, they are left out.
    pub keeps_unconverted: bool,
}

/// The reason why a capture isn't converted.
#[derive(Debug)]
pub enum Error {
    /// The capture can't be converted; contains the reason.
    Input(String),
    /// A hint contains a mistake that only the schemas of the capture show.
    Hints(Failure),
    /// The output can't be written.
    Write(io::Error),
}

impl Error {
    /// The error for a format that can't be converted.
    fn format(name: &str) -> Self {
        Self::Input(format!(
            "captures in the format {name} can't be converted; expected MCAP, SQLite, ULog or JSON messages"
        ))
    }
}

impl From<Failure> for Error {
    fn from(failure: Failure) -> Self {
        Self::Hints(failure)
    }
}

impl From<io::Error> for Error {
    fn from(error: io::Error) -> Self {
        Self::Write(error)
    }
}

/// The place of a conversion's result.
pub enum Output<'o> {
    /// A stream, for all formats but `SQLite`.
    Stream(&'o mut dyn Write),
    /// An empty file that becomes a `SQLite` file.
    Sqlite(&'o Path),
    /// An empty folder that becomes a bag, with a file for each file of a folder that is converted.
    Folder(&'o Path),
}

/// Converts a capture, and writes the result to `output`.
pub fn convert(
    (path, opened): (&Path, Opened<'_>),
    plan: &Plan,
    settings: Settings,
    output: Output<'_>,
) -> Result<ConversionReport, Error> {
    let format = Format::of(&opened)?;
    let to = settings.format.unwrap_or(format);
    let Opened { bytes, database, state, .. } = opened;
    let shared = &plan.source().shared;
    let source = |bytes| Source { bytes, database: database.as_ref(), shared, encodings: None };
    let (topics, mut problems) = match (format, to, output) {
        (Format::Json, Format::Json, Output::Stream(output)) => json::convert(bytes, plan, settings, output)?,
        (Format::Log, Format::Log, Output::Stream(output)) => ulog::convert(bytes, plan, settings, output)?,
        (Format::Log, Format::Mcap | Format::Sqlite, output) => {
            let output = Target::new(output, Distribution::InRecords);
            log_to_bag::convert(bytes, plan, settings, output)?
        }
        (Format::Mcap | Format::Sqlite, Format::Log, Output::Stream(output)) => {
            bag_to_log::convert(source(bytes), plan, settings, output)?
        }
        (Format::Mcap | Format::Sqlite, Format::Mcap | Format::Sqlite, output) => {
            let is_copied = (format, to) == (Format::Mcap, Format::Mcap);
            let unpacked = if is_copied { Unpacked::None } else { Unpacked::Cdr };
            let mut converters = Converters::default();
            let mut target = Target::new(output, distribution(plan, is_copied));
            let mut problems = Problems::default();
            let settings = (plan, settings, unpacked);
            let topics = bag::convert(source(bytes), settings, &mut target, &mut converters, &mut problems)?;
            plan.check_hints(&converters, &mut problems)?;
            target.finish(&mut problems)?;
            (topics, problems)
        }
        (from, to, _) => {
            let reason = format!("{} can't be converted to {}", from.name(), to.name());
            return Err(Error::Input(reason));
        }
    };
    if let Some(change) = state.and_then(|state| state.change(path)) {
        problems.add(change);
    }
    Ok(ConversionReport::new(path, plan, (format, to), topics, problems))
}

/// The ROS distribution in the output. `is_copied` is true if the records of the input are copied.
fn distribution(plan: &Plan, is_copied: bool) -> Distribution {
    match plan.target_label().and_then(|label| label.strip_prefix("ros2@")) {
        Some(name) => Distribution::OfTarget(name.to_owned()),
        None if is_copied => Distribution::InRecords,
        None => Distribution::OfInput(String::new()),
    }
}

/// The data that was written to a temporary file, from its start.
fn rewound(data: BufWriter<SpooledTempFile>) -> io::Result<SpooledTempFile> {
    let mut data = data.into_inner().map_err(io::IntoInnerError::into_error)?;
    data.seek(SeekFrom::Start(0))?;
    Ok(data)
}
