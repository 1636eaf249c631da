//! Opens a capture for programs that read its records themselves.

use std::io::{self, Cursor, Read};
use std::path::Path;
use std::sync::Arc;

use uavspec_capture::ENCRYPTED_MAGIC;
use uavspec_capture::input::{self, FileState};
use uavspec_capture::rosbag::CONVERT_ROS1;
use uavspec_capture::rosbag::metadata::{self, FILE_NAME, Metadata};
use uavspec_capture::rosbag::sqlite::Bag;
use uavspec_rules::definitions::{Definitions, Library};

use super::bag::{CopiedFile, ROS1, SQLITE, copy, folder_clues};
use super::log::ENCRYPTED_TEXT;
use super::{KINDS, Kind, Reading, choose, read_start, unknown_type};

/// A capture with the definitions of the release that it matches.
pub struct Opened<'b> {
    /// The name of the format, such as `MCAP`.
    pub kind: &'static str,
    /// The definitions.
    pub definitions: Arc<Definitions>,
    /// All bytes, decompressed.
    pub bytes: Box<dyn Read + Send + 'b>,
    /// The `SQLite` file that contains these bytes, because such a file isn't read from start to end. `None` for other
    /// formats.
    pub database: Option<Database>,
    /// The state of the file before the file was opened, if the capture is a file.
    pub state: Option<FileState>,
}

/// The folder of a bag, with the definitions of the release that it matches.
pub struct OpenedFolder {
    /// The definitions.
    pub definitions: Arc<Definitions>,
    pub(crate) metadata: Metadata,
}

/// Opens the folder of a bag. The inner error is the reason why it can't be read.
pub fn open_folder(folder: &Path, library: &Library) -> io::Result<Result<OpenedFolder, String>> {
    let metadata = match Metadata::read(folder) {
        Ok(Some(metadata)) => metadata,
        Ok(None) => return Ok(Err(format!("its {FILE_NAME} isn't the metadata of a rosbag2 bag"))),
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            return Ok(Err(format!(
                "a folder without a {FILE_NAME}: specify a file, or the folder of a bag"
            )));
        }
        Err(error) => return Err(error),
    };
    let clues = || folder_clues(folder, library.shared());
    let definitions = library.choose(&library.depends_on_capture().then(clues).unwrap_or_default());
    Ok(Ok(OpenedFolder { definitions, metadata }))
}

impl OpenedFolder {
    /// Opens a file of the bag. The inner error is the reason why it can't be read.
    pub(crate) fn open(
        &self,
        path: &Path,
        reading: Reading<'_>,
    ) -> io::Result<Result<Opened<'static>, String>> {
        let state = FileState::of(path);
        let file = input::up_to_end(metadata::open(path)?)?;
        open_file((path, state, Box::new(file)), reading, |_, _, _| {
            (Arc::clone(&self.definitions), Vec::new())
        })
    }
}

/// A `SQLite` file that is open.
pub struct Database {
    pub(crate) bag: Bag,
    /// The parts that can't be read.
    pub(crate) problems: Vec<String>,
    /// The copy of a compressed file, or of a pipe. Dropped after the file is closed.
    _copy: Option<CopiedFile>,
}

impl Database {
    /// Opens a file. The error is the reason why it can't be read.
    fn open(path: &Path, copy: Option<(CopiedFile, Option<String>)>) -> Result<Self, String> {
        let (bag, problems) = Bag::open(path).map_err(|problem| problem.text)?;
        let (copy, problem) = copy.unzip();
        // If the run is killed, no copy remains.
        if let Some(copy) = &copy {
            copy.hide();
        }
        let problems = problems.into_iter().map(|problem| problem.text).chain(problem.flatten()).collect();
        Ok(Self { bag, problems, _copy: copy })
    }
}

/// Opens a capture. The inner error is the reason why it can't be read.
pub fn open_path(
    path: &Path,
    library: &Library,
    reading: Reading<'_>,
) -> io::Result<Result<Opened<'static>, String>> {
    let state = FileState::of(path);
    open_file((path, state, input::open(path)?), reading, |kind, bytes, file| {
        choose(kind, bytes, file, library)
    })
}

/// Opens a file. `choose` returns the definitions, and the bytes that it reads.
fn open_file(
    (path, state, file): (&Path, Option<FileState>, Box<dyn Read + Send>),
    reading: Reading<'_>,
    choose: impl FnOnce(&Kind, &mut dyn Read, Option<&Path>) -> (Arc<Definitions>, Vec<u8>),
) -> io::Result<Result<Opened<'static>, String>> {
    let (mut bytes, is_plain) = input::decompressed(reading(file))?;
    let file = state.filter(|_| is_plain).map(|_| path);
    let start = read_start(&mut bytes)?;
    let Some(kind) = KINDS.iter().find(|kind| (kind.detect)(&start)) else {
        return Ok(Err(unknown_type(&start)));
    };
    if start.starts_with(&ENCRYPTED_MAGIC) {
        return Ok(Err(ENCRYPTED_TEXT.to_owned()));
    }
    if (ROS1.detect)(&start) {
        return Ok(Err(CONVERT_ROS1.to_owned()));
    }
    let is_database = (SQLITE.detect)(&start);
    let mut whole = Cursor::new(start).chain(bytes);
    let mut copied = None;
    if is_database && file.is_none() {
        copied = match copy(&mut whole) {
            (Some(copied), problem) => Some((copied, problem.map(|(_, text)| text))),
            (None, problem) => return Ok(Err(problem.map(|(_, text)| text).unwrap_or_default())),
        };
    }
    let place = copied.as_ref().map(|(copy, _)| copy.path().to_path_buf());
    let file = place.as_deref().or(file);
    let (definitions, ahead) = choose(kind, &mut whole, file);
    let database = file.filter(|_| is_database).map(|file| Database::open(file, copied)).transpose();
    let database = match database {
        Ok(database) => database,
        Err(problem) => return Ok(Err(problem)),
    };
    let bytes = Box::new(Cursor::new(ahead).chain(whole));
    Ok(Ok(Opened { kind: kind.name, definitions, bytes, database, state }))
}
