//! Files to judge: which there are, and their bytes, unpacked where they are packed.

use std::fs::File;
use std::io::{self, Cursor, Read};
use std::path::{Path, PathBuf};

use flate2::read::MultiGzDecoder;
use ruzstd::decoding::StreamingDecoder;
use walkdir::WalkDir;

/// What stands for standard input.
pub const STANDARD_INPUT: &str = "-";

/// How gzip begins (RFC 1952).
const GZIP: [u8; 2] = [0x1f, 0x8b];

/// How zstd begins (RFC 8878).
pub(crate) const ZSTD: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

/// Extensions of files that are looked for in folders; behind them may stand those of packers.
const EXTENSIONS: [&str; 5] = ["ulg", "mcap", "json", "jsonl", "ndjson"];

/// Extensions of packed files; the last is that of rosbag2.
const PACKED: [&str; 3] = ["gz", "zst", "zstd"];

/// The files that `paths` name, in their order; of a folder those below it that can be judged, sorted.
///
/// An error names the folder that can't be read or has nothing to judge.
pub fn files(paths: &[PathBuf]) -> Result<Vec<PathBuf>, (PathBuf, io::Error)> {
    let mut files = Vec::new();
    for path in paths {
        // What isn't there is told when it is opened, so that all others are judged.
        if path.as_os_str() == STANDARD_INPUT || !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let before = files.len();
        for entry in WalkDir::new(path).sort_by_file_name() {
            let entry = entry.map_err(|error| (path.clone(), error.into()))?;
            if entry.file_type().is_file() && is_judged(entry.path()) {
                files.push(entry.into_path());
            }
        }
        if files.len() == before {
            let message = format!("nothing to judge in it: no .{}", EXTENSIONS.join(", ."));
            return Err((path.clone(), io::Error::new(io::ErrorKind::NotFound, message)));
        }
    }
    Ok(files)
}

/// Whether a file's name says that it can be judged.
fn is_judged(path: &Path) -> bool {
    let is = |path: &Path, extensions: &[&str]| {
        let extension = path.extension().and_then(|extension| extension.to_str());
        extension.is_some_and(|found| extensions.iter().any(|known| found.eq_ignore_ascii_case(known)))
    };
    let unpacked = if is(path, &PACKED) { path.with_extension("") } else { path.to_path_buf() };
    is(&unpacked, &EXTENSIONS)
}

/// The bytes of a file, or of standard input; unpacked where they begin like gzip or zstd.
pub fn open(path: &Path) -> io::Result<Box<dyn Read + Send>> {
    if path.as_os_str() == STANDARD_INPUT {
        return unpacked(io::stdin());
    }
    unpacked(File::open(path)?)
}

/// What `input` holds, unpacked where it begins like gzip or zstd. Nothing is read ahead but its first bytes.
pub fn unpacked(mut input: impl Read + Send + 'static) -> io::Result<Box<dyn Read + Send>> {
    let mut start = Vec::with_capacity(ZSTD.len());
    input.by_ref().take(ZSTD.len() as u64).read_to_end(&mut start)?;
    let is_gzip = start.starts_with(&GZIP);
    let is_zstd = start.starts_with(&ZSTD);
    let whole = Cursor::new(start).chain(input);
    Ok(if is_gzip {
        Box::new(MultiGzDecoder::new(whole))
    } else if is_zstd {
        Box::new(StreamingDecoder::new(whole).map_err(io::Error::other)?)
    } else {
        Box::new(whole)
    })
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::io::Write as _;

    use flate2::Compression;
    use flate2::write::GzEncoder;
    use ruzstd::encoding::{CompressionLevel, compress_to_vec};

    use super::*;

    fn read(bytes: Vec<u8>) -> io::Result<Vec<u8>> {
        let mut text = Vec::new();
        unpacked(Cursor::new(bytes))?.read_to_end(&mut text)?;
        Ok(text)
    }

    #[test]
    fn packed_bytes_are_unpacked_by_how_they_begin() {
        let text = b"ULog and more, ".repeat(1_000);
        let mut gzip = GzEncoder::new(Vec::new(), Compression::fast());
        gzip.write_all(&text).expect("memory");
        let gzip = gzip.finish().expect("memory");
        let zstd = compress_to_vec(&text[..], CompressionLevel::Fastest);
        for bytes in [text.clone(), gzip.clone(), zstd.clone()] {
            assert_eq!(read(bytes).expect("readable"), text);
        }
        assert_eq!(read([gzip.clone(), gzip.clone()].concat()).expect("readable"), text.repeat(2));
        for cut in [&gzip[..gzip.len() / 2], &zstd[..zstd.len() / 2]] {
            assert!(read(cut.to_vec()).is_err(), "what is cut off is told");
        }
        for short in [&b""[..], b"U", b"\x1f", b"\x28\xb5"] {
            assert_eq!(read(short.to_vec()).expect("readable"), short);
        }
    }

    #[test]
    fn folders_are_searched_for_what_can_be_judged() {
        let folder = tempfile::tempdir().expect("a folder");
        let below = folder.path().join("day/one");
        fs::create_dir_all(&below).expect("a folder");
        for name in ["b.ulg", "a.ULG.gz", "notes.txt", "c.jsonl.zst", "d.gz", "e.mcap", "f.mcap.zstd"] {
            fs::write(below.join(name), "").expect("a file");
        }
        let names = |files: Vec<PathBuf>| -> Vec<String> {
            let name = |file: &PathBuf| Some(file.file_name()?.to_string_lossy().into_owned());
            files.iter().filter_map(name).collect()
        };
        let found = files(&[folder.path().to_path_buf()]).expect("files");
        assert_eq!(names(found), ["a.ULG.gz", "b.ulg", "c.jsonl.zst", "e.mcap", "f.mcap.zstd"]);
        let given = files(&[below.join("notes.txt"), PathBuf::from("-")]).expect("files");
        assert_eq!(names(given), ["notes.txt", "-"], "what is named is taken as it is");
        let empty = tempfile::tempdir().expect("a folder");
        let (path, error) = files(&[empty.path().to_path_buf()]).expect_err("nothing");
        assert_eq!((path.as_path(), error.kind()), (empty.path(), io::ErrorKind::NotFound));
    }
}
