//! The option `--events`.

use std::path::PathBuf;

use clap::Args;
use uavspec_rules::definitions::{EventMetadata, Library};

use super::Status;

/// The event metadata of the vehicle.
#[derive(Args, Debug)]
pub(super) struct EventsArgs {
    /// Event metadata of the firmware, for captures or vehicles without event metadata.
    ///
    /// The file `all_events.json` or `all_events.json.xz` that PX4's build writes. It is not used for logs and MCAP
    /// files that contain event metadata. A file from another build may result in wrong texts and wrong argument
    /// values.
    #[arg(long, value_name = "FILE")]
    pub(super) events: Option<PathBuf>,
}

impl EventsArgs {
    /// Adds the event metadata to definitions. Prints errors.
    pub(super) fn add_to(&self, library: Library) -> Result<Library, Status> {
        let Some(path) = &self.events else { return Ok(library) };
        let events = EventMetadata::load(path).map_err(|failure| Status::Usage.failed(&failure))?;
        Ok(library.with_events(events))
    }
}
