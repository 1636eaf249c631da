//! Converts the messages of a capture to other definitions, or to another format.

mod bag_to_log;
mod information;
mod json;
mod log;
mod log_to_bag;
mod mcap;
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

pub use self::plan::Plan;
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
    Bag,
}

impl Format {
    /// The format of an opened capture.
    pub fn of(opened: &Opened<'_>) -> Result<Self, Error> {
        match opened.kind {
            "JSON" => Ok(Self::Json),
            "ULog" => Ok(Self::Log),
            "MCAP" => Ok(Self::Bag),
            other => Err(Error::format(other)),
        }
    }

    /// The name of the format.
    pub fn name(self) -> &'static str {
        match self {
            Self::Json => "JSON",
            Self::Log => "ULog",
            Self::Bag => "MCAP",
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
    /// A hint contains a mistake, or is never used.
    Hints(Failure),
    /// The output can't be written.
    Write(io::Error),
}

impl Error {
    /// The error for a format that can't be converted.
    fn format(name: &str) -> Self {
        Self::Input(format!(
            "captures in the format {name} can't be converted; expected MCAP, ULog or JSON messages"
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

/// Converts a capture, and writes the result to `output`.
pub fn convert(
    (path, opened): (&Path, Opened<'_>),
    plan: &Plan,
    settings: Settings,
    output: &mut dyn Write,
) -> Result<ConversionReport, Error> {
    let format = Format::of(&opened)?;
    let to = settings.format.unwrap_or(format);
    let Opened { bytes, state, .. } = opened;
    let (topics, mut problems) = match (format, to) {
        (Format::Json, Format::Json) => json::convert(bytes, plan, settings, output)?,
        (Format::Log, Format::Log) => ulog::convert(bytes, plan, settings, output)?,
        (Format::Bag, Format::Bag) => mcap::convert(bytes, plan, settings, output)?,
        (Format::Log, Format::Bag) => log_to_bag::convert(bytes, plan, settings, output)?,
        (Format::Bag, Format::Log) => bag_to_log::convert(bytes, plan, settings, output)?,
        (from, to) => {
            let reason = format!("{} can't be converted to {}", from.name(), to.name());
            return Err(Error::Input(reason));
        }
    };
    if let Some(change) = state.and_then(|state| state.change(path)) {
        problems.add(change);
    }
    Ok(ConversionReport::new(path, plan, (format, to), topics, problems))
}

/// The data that was written to a temporary file, from its start.
fn rewound(data: BufWriter<SpooledTempFile>) -> io::Result<SpooledTempFile> {
    let mut data = data.into_inner().map_err(io::IntoInnerError::into_error)?;
    data.seek(SeekFrom::Start(0))?;
    Ok(data)
}
