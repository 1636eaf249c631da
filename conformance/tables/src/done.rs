//! The captures that the tables of an earlier run contain.

use std::collections::HashSet;
use std::fs::File;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::io;
use std::path::Path;

use arrow_array::cast::AsArray as _;
use arrow_array::types::Int64Type;
use arrow_array::{Array as _, RecordBatch};
use arrow_schema::Schema;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use uavspec_report::Origin;

use super::captures;
use super::column::{TABLES_KEY, VERSION};

/// The columns that identify a version of a capture.
const COLUMNS: [&str; 3] = ["capture", "etag", "size"];

/// The captures of an earlier run, as hashes. A capture is done if its version is the same. The version is the one that
/// the object store states, or otherwise the size. A capture that has neither, such as standard input, is never done.
#[derive(Debug, Default)]
pub struct Done(HashSet<u64>);

impl Done {
    /// True if the tables contain this version of a capture.
    pub fn contains(&self, capture: &str, origin: &Origin) -> bool {
        let Origin { size, etag } = origin;
        let has_version = size.is_some() || etag.is_some();
        has_version && self.0.contains(&hash(capture, etag.as_deref(), *size))
    }

    /// Adds the captures in a file of the table `captures`.
    pub(super) fn read(&mut self, file: &Path) -> io::Result<()> {
        let builder =
            ParquetRecordBatchReaderBuilder::try_new(File::open(file)?).map_err(io::Error::other)?;
        if !is_current(builder.schema()) {
            return Err(io::Error::other("these tables were not written by this version of uavspec"));
        }
        let mask = ProjectionMask::columns(builder.parquet_schema(), COLUMNS);
        let reader = builder.with_projection(mask).build().map_err(io::Error::other)?;
        for batch in reader {
            self.add(&batch.map_err(io::Error::other)?)?;
        }
        Ok(())
    }

    fn add(&mut self, batch: &RecordBatch) -> io::Result<()> {
        let column = |name: &str| {
            batch.column_by_name(name).ok_or_else(|| io::Error::other(format!("there is no column `{name}`")))
        };
        let missing = || io::Error::other("a column has a different type");
        let [captures, etags] =
            [column("capture")?, column("etag")?].map(|column| column.as_string_opt::<i32>());
        let (captures, etags) = captures.zip(etags).ok_or_else(missing)?;
        let sizes = column("size")?.as_primitive_opt::<Int64Type>().ok_or_else(missing)?;
        for row in 0..batch.num_rows() {
            let etag = etags.is_valid(row).then(|| etags.value(row));
            let size = sizes.is_valid(row).then(|| sizes.value(row)).and_then(|size| size.try_into().ok());
            self.0.insert(hash(captures.value(row), etag, size));
        }
        Ok(())
    }
}

/// True if a file of the table `captures` has the current version. If an engine wrote the file, it has no version, so
/// the columns must be the same.
fn is_current(schema: &Schema) -> bool {
    if let Some(version) = schema.metadata().get(TABLES_KEY) {
        return *version == VERSION.to_string();
    }
    let names = schema.fields().iter().map(|field| field.name().as_str());
    names.eq(captures::TABLE.columns.iter().map(|column| column.name))
}

fn hash(capture: &str, etag: Option<&str>, size: Option<u64>) -> u64 {
    let mut hasher = DefaultHasher::new();
    let size = if etag.is_some() { None } else { size };
    (capture, etag, size).hash(&mut hasher);
    hasher.finish()
}
