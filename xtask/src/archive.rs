//! Reproducible archives: the order, times, owners and modes of files are fixed.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::{fs, io};

use flate2::{Compression, GzBuilder};
use tar::EntryType;

/// The mode of documents: readable by all, writable by the owner.
const DOCUMENT: u32 = 0o644;

/// The mode of programs, which are also executable.
const EXECUTABLE: u32 = 0o755;

/// The compression level. Packages are built rarely and downloaded often.
const LEVEL: u32 = 9;

/// The gzip header value for an unknown operating system.
const UNKNOWN_SYSTEM: u8 = 255;

/// A file in an archive.
#[derive(Clone, Debug)]
pub(crate) struct File {
    /// The path in the archive.
    pub(crate) path: String,
    pub(crate) bytes: Vec<u8>,
    mode: u32,
}

impl File {
    /// Creates a text file with LF line endings, even if the checkout has other line endings.
    pub(crate) fn new(path: impl Into<String>, text: &str) -> Self {
        Self::binary(path, text.replace("\r\n", "\n").into_bytes())
    }

    /// Creates a file with these bytes.
    pub(crate) fn binary(path: impl Into<String>, bytes: Vec<u8>) -> Self {
        Self { path: path.into(), bytes, mode: DOCUMENT }
    }

    /// Reads a file. In an archive, the path of the file is only its name.
    pub(crate) fn read(path: &Path) -> Result<Self, String> {
        let bytes = fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(Self::binary(path.file_name().unwrap_or_default().to_string_lossy(), bytes))
    }

    /// Reads the files in a folder, sorted by name.
    pub(crate) fn read_all(folder: &Path) -> Result<Vec<Self>, String> {
        let failed = |error: io::Error| format!("{}: {error}", folder.display());
        let entries: io::Result<Vec<fs::DirEntry>> = fs::read_dir(folder).and_then(Iterator::collect);
        let mut paths: Vec<PathBuf> = entries.map_err(failed)?.iter().map(fs::DirEntry::path).collect();
        paths.sort();
        paths.iter().map(|path| Self::read(path)).collect()
    }

    /// Writes the file below a folder.
    pub(crate) fn write(&self, folder: &Path) -> Result<(), String> {
        let path = folder.join(&self.path);
        let failed = |error: io::Error| format!("{}: {error}", path.display());
        path.parent().map_or(Ok(()), fs::create_dir_all).map_err(failed)?;
        fs::write(&path, &self.bytes).map_err(failed)
    }

    /// Makes the file executable.
    pub(crate) fn executable(self) -> Self {
        Self { mode: EXECUTABLE, ..self }
    }

    /// A copy with another path.
    pub(crate) fn at(&self, path: impl Into<String>) -> Self {
        Self { path: path.into(), ..self.clone() }
    }

    /// A copy in a folder.
    pub(crate) fn below(&self, folder: &str) -> Self {
        self.at(format!("{folder}/{}", self.path))
    }
}

/// Creates a compressed tar archive. All files have the modification time `time`, in seconds since 1970.
pub(crate) fn tar_gz(files: &[File], time: u64) -> Result<Vec<u8>, String> {
    let mut builder = tar::Builder::new(Vec::new());
    for file in files {
        let mut header = tar::Header::new_ustar();
        header.set_size(file.bytes.len() as u64);
        header.set_mode(file.mode);
        header.set_uid(0);
        header.set_gid(0);
        header.set_mtime(time);
        header.set_entry_type(EntryType::Regular);
        builder
            .append_data(&mut header, &file.path, file.bytes.as_slice())
            .map_err(|error| format!("{}: {error}", file.path))?;
    }
    let tape = builder.into_inner().map_err(|error| error.to_string())?;
    let mut writer =
        GzBuilder::new().mtime(0).operating_system(UNKNOWN_SYSTEM).write(Vec::new(), Compression::new(LEVEL));
    writer.write_all(&tape).map_err(|error| error.to_string())?;
    writer.finish().map_err(|error| error.to_string())
}
