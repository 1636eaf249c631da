//! Converts the messages of a capture to another release.

mod json;
mod mcap;
mod plan;
mod report;
mod topic;
mod ulog;

use std::io::{self, Write};
use std::path::Path;

pub use self::plan::Plan;
pub use self::report::{Action, ConversionReport, Loss, TopicReport};
use crate::Opened;

/// The settings of a conversion.
#[derive(Clone, Copy, Debug, Default)]
pub struct Settings {
    /// True if messages that can't be converted are copied unchanged. Otherwise, they are left out.
    pub keeps_unconverted: bool,
}

/// The reason why a capture isn't converted.
#[derive(Debug)]
pub enum Error {
    /// The capture can't be converted; contains the reason.
    Input(String),
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
    let Opened { kind, bytes, state, .. } = opened;
    let (topics, mut problems) = match kind {
        "JSON" => json::convert(bytes, plan, settings, output)?,
        "ULog" => ulog::convert(bytes, plan, settings, output)?,
        "MCAP" => mcap::convert(bytes, plan, settings, output)?,
        other => return Err(Error::format(other)),
    };
    if let Some(change) = state.and_then(|state| state.change(path)) {
        problems.add(change);
    }
    Ok(ConversionReport::new(path, plan, topics, problems))
}
