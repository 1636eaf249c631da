//! Reproducible archives.

use std::io::{Cursor, Write as _};

use flate2::{Compression, GzBuilder};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, System, ZipWriter};

use super::content::File;

/// The mode of all files: readable by all, writable by the owner.
const MODE: u32 = 0o644;

/// The compression level. Packages are built rarely and downloaded often.
const LEVEL: u32 = 9;

/// The modification time of all files in tar archives: 26 October 1985, 08:15, as in npm's archives. Archives with
/// times after 1980 can be converted to formats that don't support earlier times.
const TIME: u64 = 499_162_500;

/// The gzip header value for an unknown operating system.
const UNKNOWN_SYSTEM: u8 = 255;

/// Creates a compressed tar archive.
pub(super) fn tar_gz(files: &[File]) -> Result<Vec<u8>, String> {
    let compressed =
        GzBuilder::new().mtime(0).operating_system(UNKNOWN_SYSTEM).write(Vec::new(), Compression::new(LEVEL));
    let mut builder = tar::Builder::new(compressed);
    for file in files {
        let mut header = tar::Header::new_ustar();
        header.set_size(file.text.len() as u64);
        header.set_mode(MODE);
        header.set_uid(0);
        header.set_gid(0);
        header.set_mtime(TIME);
        header.set_entry_type(tar::EntryType::Regular);
        builder
            .append_data(&mut header, &file.path, file.text.as_bytes())
            .map_err(|error| format!("{}: {error}", file.path))?;
    }
    let compressed = builder.into_inner().map_err(|error| error.to_string())?;
    compressed.finish().map_err(|error| error.to_string())
}

/// Creates a zip archive. All files have the earliest possible time, in 1980.
pub(super) fn zip(files: &[File]) -> Result<Vec<u8>, String> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .compression_level(Some(LEVEL.into()))
        .last_modified_time(DateTime::default())
        .system(System::Unix)
        .unix_permissions(MODE);
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    for file in files {
        writer.start_file(&file.path, options).map_err(|error| format!("{}: {error}", file.path))?;
        writer.write_all(file.text.as_bytes()).map_err(|error| format!("{}: {error}", file.path))?;
    }
    Ok(writer.finish().map_err(|error| error.to_string())?.into_inner())
}
