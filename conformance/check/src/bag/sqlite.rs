//! Reads a `SQLite` file of rosbag2, and names ROS 1 bags.

mod reading;

pub(crate) use self::reading::definitions_of;

use std::fs;
use std::io::{self, Read};
use std::path::Path;
use std::sync::Arc;

use tempfile::{NamedTempFile, env};
use uavspec_capture::rosbag::{CONVERT_ROS1, ROS1_MAGIC, SQLITE_MAGIC};
use uavspec_model::{Extent, Location};
use uavspec_schema::stage::Stage;

use super::{BagContent, BagFile, BagSummary, Channels};
use crate::limits::MAX_UNPACKED;
use crate::{CaptureResult, CheckRun, Kind, Source, Summary, has_magic};

pub(crate) const SQLITE: Kind = Kind {
    name: "rosbag2",
    detect: |start| has_magic(start, &SQLITE_MAGIC),
    choose: |source, library| library.choose(&super::clues::sqlite(source, library.shared())),
    check: |source, _, run| check_sqlite(source, run),
};

/// The bags of ROS 1, which aren't supported.
pub(crate) const ROS1: Kind = Kind {
    name: "rosbag2",
    detect: |start| has_magic(start, &ROS1_MAGIC),
    choose: |_, library| Arc::clone(library.base()),
    check: |_, _, _| CaptureResult::unknown(CONVERT_ROS1),
};

/// Checks the readable part of a `SQLite` file.
fn check_sqlite(mut source: Source<'_>, run: CheckRun<'_>) -> CaptureResult {
    let mut bag = Channels::new(run);
    let (bytes, distribution) = read_source(&mut source, &mut bag, BagFile::default());
    let summary =
        BagSummary { storage: "sqlite3".to_owned(), distribution, num_files: 1, ..Default::default() };
    bag.finish(bytes, |BagContent { channels, dialects, releases, .. }| {
        Summary::Bag(BagSummary { channels, dialects, releases, ..summary })
    })
}

/// Checks the readable part of a `SQLite` file. Returns the size of the file, and the ROS distribution that the file
/// names.
pub(super) fn read_source(
    source: &mut Source<'_>,
    bag: &mut Channels<'_>,
    file: BagFile<'_>,
) -> (u64, String) {
    if let Some(path) = source.file {
        return read(path, &|| source.copy.iter().for_each(|copy| copy.hide()), bag, file);
    }
    let (copy, problem) = copy(source);
    if let Some((location, text)) = problem {
        bag.corruption(file.name, location, &text, Extent::Unreadable);
    }
    copy.map(|copy| read(copy.path(), &|| copy.hide(), bag, file)).unwrap_or_default()
}

/// A temporary copy of a file. If the run is killed, the next run removes the copy.
pub(crate) struct CopiedFile {
    /// Dropped before the temporary folder that contains it.
    file: NamedTempFile,
    _stage: Stage,
}

impl CopiedFile {
    fn new() -> io::Result<Self> {
        let stage = Stage::new(&env::temp_dir())?;
        Ok(Self { file: stage.file(None)?, _stage: stage })
    }

    /// The path of the file. The path is valid until the copy is dropped or hidden.
    pub(crate) fn path(&self) -> &Path {
        self.file.path()
    }

    /// Removes the name of the open file, so that no file remains if the run is killed.
    pub(crate) fn hide(&self) {
        // On other systems, open files can't be removed. The error is ignored.
        if cfg!(unix) {
            let _ = fs::remove_file(self.path());
        }
    }
}

/// Copies a `SQLite` file to a temporary file, because it isn't read from start to end. Also returns the problem that
/// ended the copy, if any.
pub(crate) fn copy(source: &mut dyn Read) -> (Option<CopiedFile>, Option<(Location, String)>) {
    let unreadable = |error: io::Error| (Location::Byte(0), format!("the rest is unreadable: {error}"));
    let mut copy = match CopiedFile::new() {
        Ok(copy) => copy,
        Err(error) => return (None, Some(unreadable(error))),
    };
    if let Err(error) = io::copy(&mut source.take(MAX_UNPACKED), &mut copy.file) {
        return (Some(copy), Some(unreadable(error)));
    }
    if source.read(&mut [0]).is_ok_and(|read| read > 0) {
        let text = format!("the bag has more than {MAX_UNPACKED} bytes: decompress it first");
        return (None, Some((Location::Byte(MAX_UNPACKED), text)));
    }
    (Some(copy), None)
}

/// Reads a file, and calls `on_open` once the file is open. Returns the size of the file, and the ROS distribution that
/// the file names.
fn read(path: &Path, on_open: &dyn Fn(), bag: &mut Channels<'_>, file: BagFile<'_>) -> (u64, String) {
    let mut distribution = String::new();
    let size = fs::metadata(path).map_or(0, |metadata| metadata.len());
    let mut reading = reading::SqliteFile::new(bag, file);
    match uavspec_capture::rosbag::sqlite::Bag::open(path) {
        Ok((database, problems)) => {
            on_open();
            for problem in problems {
                reading.report(Err(problem));
            }
            distribution = database.distribution();
            reading.read(&database);
        }
        Err(problem) => reading.report(Err(problem)),
    }
    (size, distribution)
}

#[cfg(all(test, unix))]
mod tests {
    use rusqlite::Connection;
    use uavspec_capture::rosbag::sqlite::Bag;

    use super::*;

    /// A table with only the columns that are read.
    const TOPICS: &str = "CREATE TABLE topics(id INTEGER, name TEXT, type TEXT, serialization_format TEXT)";

    /// If the copy had a name, a run that is killed would leave up to 16 GiB on the disk.
    #[test]
    fn a_copy_has_no_name_while_it_is_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("bag.db3");
        Connection::open(&path).expect("a database").execute_batch(TOPICS).expect("a table");
        let bytes = fs::read(path).expect("a file");
        let (copy, problem) = copy(&mut &bytes[..]);
        assert_eq!(problem, None);
        let copy = copy.expect("a copy");
        let (bag, _) = Bag::open(copy.path()).expect("a bag");
        copy.hide();
        assert!(!copy.path().exists());
        assert_eq!(bag.topics(|_| {}), Ok(()));
        let folder = copy.path().parent().expect("a folder").to_owned();
        drop(copy);
        assert!(!folder.exists());
    }
}
