//! Parts of reports that wait until the run ends, in memory or in a temporary file.

use std::io::{self, BufRead, BufReader, BufWriter, Seek as _, Write};
use std::path::Path;

use tempfile::{SpooledTempFile, env, spooled_tempfile_in};

/// The maximum number of bytes that a spool keeps in memory.
const MAX_IN_MEMORY: usize = 2 << 20;

/// The size of the buffers for files, in bytes.
const BUFFER: usize = 1 << 17;

/// Parts that are written first, and read once later. The temporary file has no name, so it never outlives the program.
pub(super) struct Spool(BufWriter<SpooledTempFile>);

impl Spool {
    /// Creates a spool whose temporary file is in `folder`, or in the system's folder for temporary files.
    pub(super) fn new(folder: Option<&Path>) -> Self {
        let folder = folder.map_or_else(env::temp_dir, Path::to_path_buf);
        Self(BufWriter::with_capacity(BUFFER, spooled_tempfile_in(MAX_IN_MEMORY, folder)))
    }

    /// Adds a part.
    pub(super) fn push(&mut self, part: &str) -> io::Result<()> {
        self.0.write_all(part.as_bytes())
    }

    /// The parts, from the start.
    pub(super) fn into_reader(self) -> io::Result<impl BufRead> {
        let mut file = self.0.into_inner().map_err(io::IntoInnerError::into_error)?;
        file.rewind()?;
        Ok(BufReader::with_capacity(BUFFER, file))
    }
}

#[cfg(test)]
mod tests {
    use std::io::Read as _;

    use super::*;

    #[test]
    fn returns_all_bytes_from_memory_and_from_a_file() {
        for len in [0, 9, MAX_IN_MEMORY + 1, 3 * MAX_IN_MEMORY] {
            let part = "0123456789";
            let mut spool = Spool::new(None);
            (0..len).step_by(part.len()).for_each(|_| spool.push(part).expect("written"));
            let mut read = String::new();
            spool.into_reader().and_then(|mut parts| parts.read_to_string(&mut read)).expect("read");
            assert!(read == part.repeat(len.div_ceil(part.len())), "{len} bytes");
        }
    }

    #[test]
    fn a_missing_folder_is_an_error_and_loses_nothing_silently() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut spool = Spool::new(Some(&folder.path().join("absent")));
        let large = "x".repeat(2 * MAX_IN_MEMORY);
        assert!(spool.push(&large).is_err() || spool.into_reader().is_err());
    }
}
