//! Opens a capture for programs that read its records themselves.

use std::io::{self, Cursor, Read};
use std::path::Path;
use std::sync::Arc;

use uavspec_capture::ENCRYPTED_MAGIC;
use uavspec_capture::input::{self, FileState};
use uavspec_rules::definitions::{Definitions, Library};

use super::log::ENCRYPTED_TEXT;
use super::{KINDS, Reading, choose, read_start, unknown_type};

/// A capture with the definitions of the release that it matches.
pub struct Opened<'b> {
    /// The name of the format, such as `MCAP`.
    pub kind: &'static str,
    /// The definitions.
    pub definitions: Arc<Definitions>,
    /// All bytes, decompressed.
    pub bytes: Box<dyn Read + Send + 'b>,
    /// The state of the file before the file was opened, if the capture is a file.
    pub state: Option<FileState>,
}

/// Opens a capture. The inner error is the reason why it can't be read.
pub fn open_path(
    path: &Path,
    library: &Library,
    reading: Reading<'_>,
) -> io::Result<Result<Opened<'static>, String>> {
    let state = FileState::of(path);
    let (mut bytes, is_plain) = input::decompressed(reading(input::open(path)?))?;
    let file = state.filter(|_| is_plain).map(|_| path);
    let start = read_start(&mut bytes)?;
    let Some(kind) = KINDS.iter().find(|kind| (kind.detect)(&start)) else {
        return Ok(Err(unknown_type(&start)));
    };
    if start.starts_with(&ENCRYPTED_MAGIC) {
        return Ok(Err(ENCRYPTED_TEXT.to_owned()));
    }
    let mut whole = Cursor::new(start).chain(bytes);
    let (definitions, ahead) = choose(kind, &mut whole, file, library);
    let bytes = Box::new(Cursor::new(ahead).chain(whole));
    Ok(Ok(Opened { kind: kind.name, definitions, bytes, state }))
}
