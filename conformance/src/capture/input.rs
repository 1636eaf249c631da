//! Finds capture files and opens them, decompressed if necessary.

pub(crate) mod zstd;

use std::fs::File;
use std::io::{self, BufReader, Cursor, Read};
use std::path::{Path, PathBuf};

use flate2::read::MultiGzDecoder;
use globset::{Glob, GlobBuilder};
use walkdir::WalkDir;

use self::zstd::Frames;

/// The path that denotes standard input.
pub(crate) const STANDARD_INPUT: &str = "-";

/// The first bytes of gzip data (RFC 1952).
const GZIP: [u8; 2] = [0x1f, 0x8b];

/// The number of bytes that are needed to detect a compression format.
const START: usize = 4;

/// The file extensions that identify captures in a folder. A compression extension may follow.
const EXTENSIONS: [&str; 6] = ["ulg", "ulge", "mcap", "json", "jsonl", "ndjson"];

/// The extensions of compressed files. rosbag2 uses `zstd`.
const PACKED: [&str; 3] = ["gz", "zst", "zstd"];

/// The characters that make a path a pattern.
const WILDCARDS: [char; 3] = ['*', '?', '['];

/// The files that paths denote.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Files {
    /// The files to check, in order.
    pub(crate) captures: Vec<PathBuf>,
    /// The other files in the folders. Hidden files aren't listed.
    pub(crate) others: Vec<PathBuf>,
    /// The folders and patterns that yield no captures, with the reason.
    pub(crate) empty: Vec<(PathBuf, String)>,
}

/// The files that `paths` denote. A folder denotes the captures in it and its subfolders. A pattern such as
/// `logs/**/*.ulg` denotes the files that match it. The files of a folder or pattern are sorted.
///
/// An unreadable folder is an error. An invalid pattern is an [`InvalidInput`](io::ErrorKind::InvalidInput) error.
pub(crate) fn files(paths: &[PathBuf]) -> Result<Files, (PathBuf, io::Error)> {
    let mut files = Files::default();
    for path in paths {
        let before = files.captures.len();
        let nothing = if path.as_os_str() == STANDARD_INPUT {
            files.captures.push(path.clone());
            String::new()
        } else if path.is_dir() {
            for file in walk(path).map_err(|error| (path.clone(), error))? {
                if is_capture(&file) {
                    files.captures.push(file);
                } else if !is_hidden(path, &file) {
                    files.others.push(file);
                }
            }
            let extensions = EXTENSIONS.join(", .");
            format!("no captures in this folder: expected files with the extension .{extensions}")
        } else if let (false, Some(pattern)) = (path.exists(), pattern(path)) {
            let pattern = pattern
                .map_err(|error| (path.clone(), io::Error::new(io::ErrorKind::InvalidInput, error)))?
                .compile_matcher();
            let found = walk(&folder_of(path)).map_err(|error| (path.clone(), error))?;
            files.captures.extend(found.into_iter().filter(|file| pattern.is_match(file)));
            "no file matches this pattern".to_owned()
        } else {
            // A missing file is only reported when it is opened, so the other files are still checked.
            files.captures.push(path.clone());
            String::new()
        };
        if files.captures.len() == before {
            files.empty.push((path.clone(), nothing));
        }
    }
    Ok(files)
}

/// The files in a folder and its subfolders, sorted.
fn walk(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in WalkDir::new(folder).sort_by_file_name() {
        let entry = entry?;
        // Paths found in `.` start with `./`, but users omit this prefix in patterns.
        let path = entry.path().strip_prefix(".").unwrap_or(entry.path());
        if entry.file_type().is_file() {
            files.push(path.to_owned());
        }
    }
    Ok(files)
}

/// True if the name of a file or of one of its parents below `folder` starts with a dot.
fn is_hidden(folder: &Path, file: &Path) -> bool {
    let below = file.strip_prefix(folder).unwrap_or(file);
    below.components().any(|part| part.as_os_str().to_string_lossy().starts_with('.'))
}

/// Parses a path with wildcards as a pattern. Returns `None` for a path without wildcards.
fn pattern(path: &Path) -> Option<Result<Glob, globset::Error>> {
    let text = path.to_str().filter(|text| text.contains(WILDCARDS))?;
    Some(GlobBuilder::new(text).literal_separator(true).build())
}

/// The folder that contains all possible matches of a pattern.
fn folder_of(pattern: &Path) -> PathBuf {
    let has_none = |part: &std::path::Component<'_>| !part.as_os_str().to_string_lossy().contains(WILDCARDS);
    let folder: PathBuf = pattern.components().take_while(has_none).collect();
    if folder.as_os_str().is_empty() { PathBuf::from(".") } else { folder }
}

/// True if the file name has a capture extension.
fn is_capture(path: &Path) -> bool {
    let is = |path: &Path, extensions: &[&str]| {
        let extension = path.extension().and_then(|extension| extension.to_str());
        extension.is_some_and(|found| extensions.iter().any(|known| found.eq_ignore_ascii_case(known)))
    };
    let unpacked = if is(path, &PACKED) { path.with_extension("") } else { path.to_path_buf() };
    is(&unpacked, &EXTENSIONS)
}

/// The raw bytes of a file or of standard input.
pub(crate) fn open(path: &Path) -> io::Result<Box<dyn Read + Send>> {
    if path.as_os_str() == STANDARD_INPUT {
        return Ok(Box::new(io::stdin()));
    }
    Ok(Box::new(File::open(path)?))
}

/// Decompresses `input` if it starts with the magic of gzip or zstd. Other input stays unchanged. Only the first bytes
/// are read in advance. The input may contain several consecutive gzip members or zstd frames. Reading fails if other
/// data follows them.
pub(crate) fn decompressed(mut input: impl Read + Send + 'static) -> io::Result<Box<dyn Read + Send>> {
    let mut start = Vec::with_capacity(START);
    input.by_ref().take(START as u64).read_to_end(&mut start)?;
    let (is_gzip, is_zstd) = (start.starts_with(&GZIP), zstd::is_frame(&start));
    let whole = Cursor::new(start).chain(input);
    Ok(if is_gzip {
        Box::new(MultiGzDecoder::new(whole))
    } else if is_zstd {
        Box::new(Frames::new(BufReader::new(whole)))
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
        decompressed(Cursor::new(bytes))?.read_to_end(&mut text)?;
        Ok(text)
    }

    #[test]
    fn detects_compression_from_the_first_bytes() {
        let text = b"ULog and more, ".repeat(1_000);
        let mut gzip = GzEncoder::new(Vec::new(), Compression::fast());
        gzip.write_all(&text).expect("memory");
        let gzip = gzip.finish().expect("memory");
        let zstd = compress_to_vec(&text[..], CompressionLevel::Fastest);
        for bytes in [text.clone(), gzip.clone(), zstd.clone()] {
            assert_eq!(read(bytes).expect("readable"), text);
        }
        for packed in [&gzip, &zstd] {
            let twice = [&packed[..], packed].concat();
            assert_eq!(read(twice.clone()).expect("readable"), text.repeat(2), "several members");
            assert!(read([&twice[..], b"neither this nor that"].concat()).is_err(), "trailing data");
        }
        let skipped = b"\x50\x2a\x4d\x18\x03\0\0\0abc";
        assert_eq!(read([&skipped[..], &zstd].concat()).expect("readable"), text, "as written by pzstd");
        for cut in [&gzip[..gzip.len() / 2], &zstd[..zstd.len() / 2]] {
            assert!(read(cut.to_vec()).is_err(), "truncated");
        }
        for short in [&b""[..], b"U", b"\x1f", b"\x28\xb5"] {
            assert_eq!(read(short.to_vec()).expect("readable"), short);
        }
    }

    #[test]
    fn searches_folders_for_captures() {
        let folder = tempfile::tempdir().expect("a folder");
        let below = folder.path().join("day/one");
        fs::create_dir_all(&below).expect("a folder");
        for name in ["b.ulg", "a.ULG.gz", "notes.txt", "c.jsonl.zst", "d.gz", "e.mcap", "f.mcap.zstd"] {
            fs::write(below.join(name), "").expect("a file");
        }
        fs::write(below.join(".hidden"), "").expect("a file");
        let names = |files: &[PathBuf]| -> Vec<String> {
            let name = |file: &PathBuf| Some(file.file_name()?.to_string_lossy().into_owned());
            files.iter().filter_map(name).collect()
        };
        let found = files(&[folder.path().to_path_buf()]).expect("files");
        assert_eq!(names(&found.captures), ["a.ULG.gz", "b.ulg", "c.jsonl.zst", "e.mcap", "f.mcap.zstd"]);
        assert_eq!(names(&found.others), ["d.gz", "notes.txt"], "hidden files are not listed");
        assert!(found.empty.is_empty(), "{found:?}");
        let given = files(&[below.join("notes.txt"), PathBuf::from("-")]).expect("files");
        assert_eq!(names(&given.captures), ["notes.txt", "-"], "explicit paths are accepted");
        assert!(given.others.is_empty(), "{given:?}");
        let matched = files(&[folder.path().join("**/*.ulg*"), below.join("[bc].*")]).expect("files");
        assert_eq!(names(&matched.captures), ["b.ulg", "b.ulg", "c.jsonl.zst"]);
        assert!(matched.others.is_empty(), "a pattern names its files: {matched:?}");
        let nothing = files(&[below.join("*.bag"), below.clone()]).expect("files");
        assert_eq!(nothing.empty, [(below.join("*.bag"), "no file matches this pattern".to_owned())]);
        assert_eq!(nothing.captures.len(), 5, "the other files are still found");
        let (path, error) = files(&[below.join("[a.ulg")]).expect_err("an unclosed class");
        assert_eq!((path, error.kind()), (below.join("[a.ulg"), io::ErrorKind::InvalidInput));
        let empty = tempfile::tempdir().expect("a folder");
        let found = files(&[empty.path().to_path_buf()]).expect("files");
        assert_eq!(
            (found.captures.len(), names(&[found.empty[0].0.clone()])),
            (0, names(&[empty.path().into()]))
        );
    }
}
