//! Parts of reports that wait until the run ends, in memory or in a temporary file.

use std::fmt;
use std::io::{self, BufReader, BufWriter, Read, Seek as _, Write};
use std::path::Path;

use tempfile::{SpooledTempFile, env, spooled_tempfile_in};

/// The maximum number of bytes that a spool keeps in memory.
const MAX_IN_MEMORY: usize = 2 << 20;

/// The size of the buffers for files, in bytes.
const BUFFER: usize = 1 << 17;

/// Bytes that are written first and read once later. The temporary file has no name, so it never outlives the program.
pub(super) struct Spool(BufWriter<SpooledTempFile>);

impl Spool {
    /// Creates a spool whose temporary file is in `folder`, or in the system's folder for temporary files.
    pub(super) fn new(folder: Option<&Path>) -> Self {
        Self::with_limit(MAX_IN_MEMORY, &folder.map_or_else(env::temp_dir, Path::to_path_buf))
    }

    /// Creates a spool without a temporary file. Writing to it can't fail.
    pub(super) fn in_memory() -> Self {
        Self::with_limit(usize::MAX, &env::temp_dir())
    }

    fn with_limit(max: usize, folder: &Path) -> Self {
        Self(BufWriter::with_capacity(BUFFER, spooled_tempfile_in(max, folder)))
    }

    /// The bytes, from the start.
    pub(super) fn into_reader(self) -> io::Result<BufReader<impl Read>> {
        let mut file = self.0.into_inner().map_err(io::IntoInnerError::into_error)?;
        file.rewind()?;
        Ok(BufReader::with_capacity(BUFFER, file))
    }

    /// Copies all bytes to a writer.
    pub(super) fn copy_to(self, mut to: &mut dyn Write) -> io::Result<()> {
        io::copy(&mut self.into_reader()?, &mut to).map(|_| ())
    }
}

impl Write for Spool {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

impl fmt::Debug for Spool {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("Spool")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn returns_all_bytes_from_memory_and_from_a_file() {
        for len in [0, 9, MAX_IN_MEMORY + 1, 3 * MAX_IN_MEMORY] {
            let bytes: Vec<u8> = (0..len).map(|at| u8::try_from(at % 251).expect("a byte")).collect();
            let mut spool = Spool::new(None);
            for part in bytes.chunks(100_000) {
                spool.write_all(part).expect("written");
            }
            let mut read = Vec::new();
            spool.copy_to(&mut read).expect("read");
            assert!(read == bytes, "{len} bytes");
        }
    }

    #[test]
    fn a_missing_folder_is_an_error_and_loses_nothing_silently() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut spool = Spool::new(Some(&folder.path().join("absent")));
        let large = vec![b'x'; 2 * MAX_IN_MEMORY];
        assert!(spool.write_all(&large).is_err() || spool.copy_to(&mut Vec::new()).is_err());
    }
}
