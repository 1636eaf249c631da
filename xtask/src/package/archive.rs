//! Archives that depend on nothing but their content.

use std::io::{Cursor, Write as _};

use flate2::{Compression, GzBuilder};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, System, ZipWriter};

use super::content::File;

/// Everybody may read, the owner may write.
const MODE: u32 = 0o644;

/// How hard to try: packages are made rarely and loaded often.
const LEVEL: u32 = 9;

/// The moment that all files of tape archives are of: the one that npm gives them, 26 October 1985, 08:15. Archives of
/// other forms, which are made from these, know no time before 1980.
const TIME: u64 = 499_162_500;

/// What gzip writes for a system that it doesn't know.
const UNKNOWN_SYSTEM: u8 = 255;

/// A compressed tape archive.
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

/// A zip archive. All files are of 1980, which is where its calendar begins.
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
