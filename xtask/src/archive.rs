//! Reproducible archives: the order, times, owners and modes of files are fixed.

use std::io::{Cursor, Write as _};

use flate2::{Compression, GzBuilder};
use tar::EntryType;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, System, ZipWriter};

/// The mode of documents: readable by all, writable by the owner.
const DOCUMENT: u32 = 0o644;

/// The mode of programs and folders, which are also executable.
const EXECUTABLE: u32 = 0o755;

/// The compression level. Packages are built rarely and downloaded often.
const LEVEL: u32 = 9;

/// The gzip header value for an unknown operating system.
const UNKNOWN_SYSTEM: u8 = 255;

/// A file in an archive.
#[derive(Clone, Debug)]
pub(crate) struct File {
    /// The path in the archive. The path of a folder ends with a slash.
    pub(crate) path: String,
    pub(crate) bytes: Vec<u8>,
    mode: u32,
}

impl File {
    /// Creates a text file with LF line endings, even if the checkout has others.
    pub(crate) fn new(path: impl Into<String>, text: &str) -> Self {
        Self::binary(path, text.replace("\r\n", "\n").into_bytes())
    }

    /// Creates a file with these bytes.
    pub(crate) fn binary(path: impl Into<String>, bytes: Vec<u8>) -> Self {
        Self { path: path.into(), bytes, mode: DOCUMENT }
    }

    /// Makes the file executable.
    pub(crate) fn executable(self) -> Self {
        Self { mode: EXECUTABLE, ..self }
    }

    /// Creates a folder. Only packages that dpkg unpacks require entries for folders.
    pub(crate) fn folder(path: impl Into<String>) -> Self {
        Self::binary(path, Vec::new()).executable()
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

/// Compresses bytes with gzip.
pub(crate) fn gzip(bytes: &[u8]) -> Result<Vec<u8>, String> {
    let mut writer =
        GzBuilder::new().mtime(0).operating_system(UNKNOWN_SYSTEM).write(Vec::new(), Compression::new(LEVEL));
    writer.write_all(bytes).map_err(|error| error.to_string())?;
    writer.finish().map_err(|error| error.to_string())
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
        let is_folder = file.path.ends_with('/');
        header.set_entry_type(if is_folder { EntryType::Directory } else { EntryType::Regular });
        builder
            .append_data(&mut header, &file.path, file.bytes.as_slice())
            .map_err(|error| format!("{}: {error}", file.path))?;
    }
    gzip(&builder.into_inner().map_err(|error| error.to_string())?)
}

/// Creates a zip archive. All files have the earliest possible time, in 1980.
pub(crate) fn zip(files: &[File]) -> Result<Vec<u8>, String> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .compression_level(Some(LEVEL.into()))
        .last_modified_time(DateTime::default())
        .system(System::Unix);
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    for file in files {
        writer
            .start_file(&file.path, options.unix_permissions(file.mode))
            .map_err(|error| format!("{}: {error}", file.path))?;
        writer.write_all(&file.bytes).map_err(|error| format!("{}: {error}", file.path))?;
    }
    Ok(writer.finish().map_err(|error| error.to_string())?.into_inner())
}
