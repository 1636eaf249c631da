//! The origin of a capture.

use uavspec_capture::input::Input;

/// Facts about the origin of a capture that aren't in a report.
#[derive(Clone, Debug, Default)]
pub struct Origin {
    /// The size in bytes, before decompression.
    pub size: Option<u64>,
    /// The version that the object store reports.
    pub etag: Option<String>,
}

impl Origin {
    /// The facts about an input.
    pub fn of(input: &Input) -> Self {
        Self { size: input.size(), etag: input.etag().map(str::to_owned) }
    }
}
