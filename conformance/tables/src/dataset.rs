//! A folder with all tables, which grows during a run.
//!
//! ```text
//!  tables/topics/part-00000.parquet
//!  tables/findings/part-00000.parquet
//!  tables/rules/part-00000.parquet
//!  tables/captures/part-00000.parquet
//!  tables/failures/part-00000.parquet
//! ```
//!
//! A part contains the rows of some captures, in all tables. Each file appears only when it is complete, and the file
//! of the table `captures` appears last. If a run is killed, all listed captures are therefore complete, and another
//! run can continue. The failures of a run are written at its end.

use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use arrow_array::RecordBatch;
use arrow_ipc::writer::FileWriter;
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::file::properties::WriterProperties;
use uavspec_check::timeline::Timeline;
use uavspec_model::text::terminal;
use uavspec_report::{Origin, Subject, TableFormat, Unreadable};
use uavspec_schema::stage::{Stage, write_file};

use super::done::Done;
use super::rows::{Rows, TABLES, is_of_timeline};
use super::{captures, failures, timeline};

/// The maximum number of captures in a part. If a run is killed, the results of fewer captures are lost.
const MAX_CAPTURES: usize = 256;

/// The total number of rows in all tables above which a part is written.
const MAX_ROWS: usize = 100_000;

/// The maximum number of rows in a row group. A query uses statistics to skip row groups.
const ROW_GROUP: usize = 8_192;

/// The file that an engine writes last, in the folder of the table `captures`.
const SUCCESS: &str = "_SUCCESS";

/// The exclusive right of a run to write to a folder.
struct Claim {
    /// Dropped first, because the folder must be empty before it can be removed.
    stage: Stage,
    _new: Option<NewFolder>,
}

/// A folder that is removed if nothing has been written to it.
struct NewFolder(PathBuf);

/// The tables of a run.
pub struct Dataset {
    folder: PathBuf,
    _claim: Claim,
    format: TableFormat,
    /// True if the folder contains the timeline.
    has_timeline: bool,
    /// The rows for the next part.
    rows: Rows,
    /// The number of parts that have been written.
    parts: usize,
    failures: Vec<Unreadable>,
    /// The first error. After an error, nothing is written.
    error: Option<io::Error>,
}

impl Dataset {
    /// Starts the tables in a folder, which is created if necessary.
    ///
    /// # Errors
    /// Fails if the folder isn't empty, or if another run is writing to it.
    pub fn create(folder: &Path, format: TableFormat, has_timeline: bool) -> io::Result<Self> {
        let claim = Claim::of(folder)?;
        if let Some(other) = claim.others(folder)?.next() {
            return Err(not_empty(&other));
        }
        Ok(Self::new(folder, claim, format, has_timeline, 0))
    }

    /// Continues the Parquet files of an earlier run, or starts them if there are none. Also returns the captures that
    /// they contain.
    ///
    /// The files may have been written by an engine such as Spark.
    ///
    /// # Errors
    /// Fails if the files can't be read, if an engine didn't complete them, or if only one of the two runs has a
    /// timeline. Also fails if the folder contains other files but no tables, or if another run is writing to it.
    pub fn resume(folder: &Path, has_timeline: bool) -> io::Result<(Self, Done)> {
        let (format, mut done) = (TableFormat::Parquet, Done::default());
        let claim = Claim::of(folder)?;
        let is_table = |path: &PathBuf| TABLES.iter().any(|table| *path == folder.join(table));
        if !claim.others(folder)?.any(|path| is_table(&path))
            && let Some(other) = claim.others(folder)?.next()
        {
            return Err(not_empty(&other));
        }
        let captures = files(&folder.join(captures::TABLE.name))?;
        if !folder.join(captures::TABLE.name).join(SUCCESS).exists() {
            for table in TABLES {
                if let Some(file) = files(&folder.join(table))?.iter().find(|file| number(file).is_none()) {
                    let problem =
                        format!("{}: the engine that wrote this file did not finish", terminal::path(file));
                    return Err(io::Error::new(io::ErrorKind::InvalidData, problem));
                }
            }
        }
        for file in &captures {
            done.read(file).map_err(|error| {
                io::Error::new(error.kind(), format!("{}: {error}", terminal::path(file)))
            })?;
        }
        let parts =
            captures.iter().filter_map(|file| number(file)).map(|number| number + 1).max().unwrap_or(0);
        if !captures.is_empty() && has_timeline == files(&folder.join(timeline::TABLE.name))?.is_empty() {
            let problem =
                if has_timeline { "the tables have no timeline" } else { "the tables have a timeline" };
            return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
        }
        // A run that was killed may have written some of the files of the next part.
        for table in TABLES {
            for file in files(&folder.join(table))? {
                if number(&file).is_some_and(|number| number >= parts) {
                    fs::remove_file(file)?;
                }
            }
        }
        // The captures that failed in the earlier run are tried again.
        for file in files(&folder.join(failures::TABLE.name))? {
            fs::remove_file(file)?;
        }
        Ok((Self::new(folder, claim, format, has_timeline, parts), done))
    }

    fn new(folder: &Path, claim: Claim, format: TableFormat, has_timeline: bool, parts: usize) -> Self {
        let (folder, rows, failures) = (folder.to_owned(), Rows::default(), Vec::new());
        Self { folder, _claim: claim, format, has_timeline, rows, parts, failures, error: None }
    }

    /// The folder of the files.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Adds a capture.
    pub fn add(&mut self, subject: &Subject, origin: &Origin, timeline: Option<&Timeline>) {
        self.rows.add(subject, origin.clone(), timeline);
        self.write_if_full();
    }

    /// Adds a capture that can't be read.
    pub fn add_unreadable(&mut self, file: &Unreadable) {
        self.failures.push(file.clone());
    }

    /// Writes the last part. A run without captures has a part without rows.
    ///
    /// # Errors
    /// Fails if a part couldn't be written.
    pub fn finish(mut self) -> io::Result<()> {
        if let Some(error) = self.error.take() {
            return Err(error);
        }
        if self.parts == 0 || self.rows.num_captures() > 0 {
            self.write()?;
        }
        let failures = failures::TABLE.batch(&self.failures).map_err(io::Error::other)?;
        self.write_file(failures::TABLE.name, 0, &failures)
    }

    fn write_if_full(&mut self) {
        if self.rows.num_captures() >= MAX_CAPTURES || self.rows.num_rows() >= MAX_ROWS {
            // After an error, further rows are dropped.
            self.error = self.error.take().or_else(|| self.write().err());
            self.rows = Rows::default();
        }
    }

    /// Writes a part.
    fn write(&mut self) -> io::Result<()> {
        let mut rows = std::mem::take(&mut self.rows);
        rows.sort();
        for (table, batch) in TABLES.iter().zip(rows.batches().map_err(io::Error::other)?) {
            if is_of_timeline(table) && !self.has_timeline {
                continue;
            }
            self.write_file(table, self.parts, &batch)?;
        }
        self.parts += 1;
        Ok(())
    }

    fn write_file(&self, table: &str, part: usize, batch: &RecordBatch) -> io::Result<()> {
        let folder = self.folder.join(table);
        fs::create_dir_all(&folder)?;
        let bytes = encode(self.format, batch)?;
        write_file(&folder.join(format!("part-{part:05}.{}", self.format.name())), |file| {
            file.write_all(&bytes)
        })
    }
}

impl Claim {
    /// Claims a folder. Creates it if it doesn't exist.
    fn of(folder: &Path) -> io::Result<Self> {
        let is_new = !folder.exists();
        fs::create_dir_all(folder)?;
        let new = is_new.then(|| NewFolder(folder.to_owned()));
        Ok(Self { stage: Stage::claim(folder)?, _new: new })
    }

    /// The files and folders in the folder that this run didn't create.
    fn others(&self, folder: &Path) -> io::Result<impl Iterator<Item = PathBuf>> {
        let entries = fs::read_dir(folder)?.filter_map(Result::ok).map(|entry| entry.path());
        Ok(entries.filter(|path| path != self.stage.path()))
    }
}

impl Drop for NewFolder {
    fn drop(&mut self) {
        // Only an empty folder can be removed.
        let _ = fs::remove_dir(&self.0);
    }
}

/// The error for a folder that contains other files.
fn not_empty(other: &Path) -> io::Error {
    let name = other.file_name().unwrap_or_default();
    let problem = format!("the folder already contains `{}`", terminal::path(name));
    io::Error::new(io::ErrorKind::AlreadyExists, problem)
}

/// The files of a table, in order.
fn files(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries?,
    };
    let files: io::Result<Vec<PathBuf>> = entries.map(|entry| Ok(entry?.path())).collect();
    // A run that was killed may leave a hidden folder. Engines also write hidden files.
    let is_visible = |path: &Path| {
        path.file_name().is_some_and(|name| !matches!(name.as_encoded_bytes(), [b'.' | b'_', ..]))
    };
    let mut files: Vec<PathBuf> =
        files?.into_iter().filter(|path| path.is_file() && is_visible(path)).collect();
    files.sort();
    Ok(files)
}

/// The part number in the name of a file.
fn number(file: &Path) -> Option<usize> {
    file.file_stem()?.to_str()?.strip_prefix("part-")?.parse().ok()
}

/// The content of a file.
fn encode(format: TableFormat, batch: &RecordBatch) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    match format {
        TableFormat::Parquet => {
            let properties = WriterProperties::builder()
                .set_compression(Compression::SNAPPY)
                .set_max_row_group_row_count(Some(ROW_GROUP))
                .build();
            let writer = ArrowWriter::try_new(&mut bytes, batch.schema(), Some(properties));
            let mut writer = writer.map_err(io::Error::other)?;
            writer.write(batch).map_err(io::Error::other)?;
            writer.close().map_err(io::Error::other)?;
        }
        TableFormat::Arrow => {
            let mut writer = FileWriter::try_new(&mut bytes, &batch.schema()).map_err(io::Error::other)?;
            writer.write(batch).map_err(io::Error::other)?;
            writer.finish().map_err(io::Error::other)?;
        }
    }
    Ok(bytes)
}
