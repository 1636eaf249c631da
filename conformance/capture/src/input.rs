//! Finds capture files and opens them, decompressed if necessary.

mod bags;
mod gzip;
mod object;
mod padding;
mod search;
mod unpack;
pub mod zstd;

use std::fs::{self, File, Metadata};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use globset::{Glob, GlobBuilder, GlobMatcher};
use uavspec_model::text::thousands;

pub use self::object::{Failure, Listed, Object};
use self::search::{DANGLING, Found, search};
pub use self::unpack::{UpToError, decompressed};
use crate::names::{EXTENSIONS, NOT_A_CAPTURE, ROS1_EXTENSION, has_extension, is_capture};
use crate::rosbag::CONVERT_ROS1;

/// The path that denotes standard input.
pub(crate) const STANDARD_INPUT: &str = "-";

/// The characters that make a path a pattern.
const WILDCARDS: [char; 3] = ['*', '?', '['];

/// A capture to check.
#[derive(Clone, Debug)]
pub enum Input {
    /// A file, the folder of a bag, or standard input.
    Path(PathBuf),
    /// An object in an object store.
    Object(Arc<dyn Object>),
    /// A name, and the content of a file.
    Bytes(String, Arc<[u8]>),
}

impl Input {
    /// The path as given, or the URL.
    pub fn name(&self) -> String {
        match self {
            Self::Path(path) => path.to_string_lossy().into_owned(),
            Self::Object(object) => object.url().to_owned(),
            Self::Bytes(name, _) => name.clone(),
        }
    }

    /// The path, if there is one.
    pub fn path(&self) -> Option<&Path> {
        match self {
            Self::Path(path) => Some(path),
            Self::Object(_) | Self::Bytes(..) => None,
        }
    }

    /// The size in bytes, before decompression, if it is known. The size of a folder is the total size of its files.
    pub fn size(&self) -> Option<u64> {
        match self {
            Self::Path(path) if path.is_dir() => size_of_folder(path).ok(),
            Self::Path(path) => fs::metadata(path).ok().filter(Metadata::is_file).map(|file| file.len()),
            Self::Object(object) => object.size(),
            Self::Bytes(_, bytes) => Some(bytes.len() as u64),
        }
    }

    /// The version that the object store reports.
    pub fn etag(&self) -> Option<&str> {
        match self {
            Self::Object(object) => object.etag(),
            Self::Path(_) | Self::Bytes(..) => None,
        }
    }
}

/// The files that paths denote.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Files {
    /// The files to check, in order.
    pub captures: Vec<PathBuf>,
    /// The other files in the folders, with the reason for skipping each of them. Hidden files aren't listed.
    pub skipped: Vec<(PathBuf, &'static str)>,
    /// The subfolders and links that can't be read, with the reason.
    pub unreadable: Vec<(PathBuf, String)>,
    /// The folders and patterns that yield no captures, with the reason.
    pub empty: Vec<(PathBuf, String)>,
}

/// The files that `paths` denote. A folder denotes the captures in it and its subfolders. A folder with the
/// `metadata.yaml` of a bag is one capture. A pattern such as
/// `logs/**/*.ulg` denotes the files that match it. The files of a folder or pattern are sorted.
///
/// Symbolic links are followed. An unreadable folder doesn't end the search. Pipes, sockets and devices are captures
/// only if `paths` contains them. Fails with the pattern and its error if a pattern is invalid.
pub fn files(paths: &[PathBuf]) -> Result<Files, (PathBuf, String)> {
    let mut files = Files::default();
    for path in paths {
        let before = files.captures.len() + files.unreadable.len();
        let nothing = if path.as_os_str() == STANDARD_INPUT {
            files.captures.push(path.clone());
            String::new()
        } else if path.is_dir() {
            let first = files.captures.len();
            search(path, usize::MAX, |found| files.take_from_folder(path, found));
            bags::group(&mut files, first);
            let extensions = EXTENSIONS.join(", .");
            format!("no captures in this folder: expected files with the extension .{extensions}")
        } else if let (false, Some(pattern)) = (path.exists(), pattern(path)) {
            let pattern = pattern.map_err(|error| (path.clone(), error.to_string()))?.compile_matcher();
            let folder = folder_of(path);
            search(&folder, depth_of(path, &folder), |found| files.take_matching(&pattern, found));
            "no file matches this pattern".to_owned()
        } else {
            // A missing file is only reported when it is opened, so the other files are still checked.
            files.captures.push(path.clone());
            String::new()
        };
        if files.captures.len() + files.unreadable.len() == before {
            files.empty.push((path.clone(), nothing));
        }
    }
    Ok(files)
}

impl Files {
    /// Adds something that was found in a folder.
    fn take_from_folder(&mut self, folder: &Path, found: Found) {
        let (path, reason) = match found {
            Found::File(path) if is_capture(&path) => return self.captures.push(path),
            Found::File(path) if has_extension(&path, &[ROS1_EXTENSION]) => (path, CONVERT_ROS1),
            Found::File(path) => (path, NOT_A_CAPTURE),
            Found::Dangling(path) if is_capture(&path) => {
                return self.unreadable.push((path, DANGLING.to_owned()));
            }
            Found::Dangling(path) => (path, DANGLING),
            Found::Skipped(path, reason) => (path, reason),
            Found::Unreadable(path, reason) => return self.unreadable.push((path, reason)),
        };
        if !is_hidden(folder, &path) {
            self.skipped.push((path, reason));
        }
    }

    /// Adds something that may match a pattern.
    fn take_matching(&mut self, pattern: &GlobMatcher, found: Found) {
        match found {
            Found::File(path) if pattern.is_match(&path) => self.captures.push(path),
            Found::Dangling(path) if pattern.is_match(&path) => {
                self.unreadable.push((path, DANGLING.to_owned()));
            }
            Found::Skipped(path, reason) if pattern.is_match(&path) => self.skipped.push((path, reason)),
            // The folder may contain files that match.
            Found::Unreadable(path, reason) => self.unreadable.push((path, reason)),
            Found::File(_) | Found::Dangling(_) | Found::Skipped(..) => {}
        }
    }
}

/// The total size of the files in a folder, without subfolders.
fn size_of_folder(folder: &Path) -> io::Result<u64> {
    let size = |entry: io::Result<fs::DirEntry>| -> io::Result<u64> {
        let file = fs::metadata(entry?.path())?;
        Ok(if file.is_file() { file.len() } else { 0 })
    };
    fs::read_dir(folder)?.map(size).sum()
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

/// The number of levels below `folder` in which files can match a pattern.
fn depth_of(pattern: &Path, folder: &Path) -> usize {
    let is_any_depth = pattern.components().any(|part| part.as_os_str().to_string_lossy().contains("**"));
    let levels = pattern.strip_prefix(folder).unwrap_or(pattern).components().count();
    if is_any_depth { usize::MAX } else { levels }
}

/// The raw bytes of a file or of standard input.
pub fn open(path: &Path) -> io::Result<Box<dyn Read + Send>> {
    if path.as_os_str() == STANDARD_INPUT {
        return Ok(Box::new(io::stdin()));
    }
    Ok(Box::new(up_to_end(File::open(path)?)?))
}

/// The bytes of a file up to its current end. Otherwise, reading a file that always grows would never end.
pub fn up_to_end(file: File) -> io::Result<io::Take<File>> {
    let metadata = file.metadata()?;
    // Pipes, devices and files of `/proc` report no size.
    let size = Some(metadata.len()).filter(|size| metadata.is_file() && *size > 0);
    Ok(file.take(size.unwrap_or(u64::MAX)))
}

/// The state of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileState {
    size: u64,
    /// The time of the last change, if the file system reports it.
    changed: Option<SystemTime>,
}

impl FileState {
    /// The current state. `None` for standard input, and for a path that isn't a file.
    pub fn of(path: &Path) -> Option<Self> {
        if path.as_os_str() == STANDARD_INPUT {
            return None;
        }
        let metadata = fs::metadata(path).ok().filter(Metadata::is_file)?;
        Some(Self { size: metadata.len(), changed: metadata.modified().ok() })
    }

    /// The change since this state, as a sentence. `None` if there is none, or if the file is gone: an open file stays
    /// readable.
    pub fn change(self, path: &Path) -> Option<String> {
        let now = Self::of(path).filter(|now| *now != self)?;
        Some(if now.size > self.size {
            format!(
                "the file grew from {} to {} bytes while it was read; the new part may not have been read",
                thousands(self.size),
                thousands(now.size)
            )
        } else {
            "the file changed while it was read".to_owned()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The names of files.
    fn names(files: &[PathBuf]) -> Vec<String> {
        let name = |file: &PathBuf| Some(file.file_name()?.to_string_lossy().into_owned());
        files.iter().filter_map(name).collect()
    }

    /// The names of the skipped files.
    fn skipped(files: &Files) -> Vec<String> {
        files.skipped.iter().flat_map(|(path, _)| names(std::slice::from_ref(path))).collect()
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
        let found = files(&[folder.path().to_path_buf()]).expect("files");
        assert_eq!(names(&found.captures), ["a.ULG.gz", "b.ulg", "c.jsonl.zst", "e.mcap", "f.mcap.zstd"]);
        assert_eq!(skipped(&found), ["d.gz", "notes.txt"], "hidden files are not listed");
        assert!(found.empty.is_empty(), "{found:?}");
        let given = files(&[below.join("notes.txt"), PathBuf::from("-")]).expect("files");
        assert_eq!(names(&given.captures), ["notes.txt", "-"], "explicit paths are accepted");
        assert!(given.skipped.is_empty(), "{given:?}");
        let matched = files(&[folder.path().join("**/*.ulg*"), below.join("[bc].*")]).expect("files");
        assert_eq!(names(&matched.captures), ["b.ulg", "b.ulg", "c.jsonl.zst"]);
        assert!(matched.skipped.is_empty(), "a pattern names its files: {matched:?}");
        let nothing = files(&[below.join("*.bag"), below.clone()]).expect("files");
        assert_eq!(nothing.empty, [(below.join("*.bag"), "no file matches this pattern".to_owned())]);
        assert_eq!(nothing.captures.len(), 5, "the other files are still found");
        let (path, _) = files(&[below.join("[a.ulg")]).expect_err("an unclosed class");
        assert_eq!(path, below.join("[a.ulg"));
        let empty = tempfile::tempdir().expect("a folder");
        let found = files(&[empty.path().to_path_buf()]).expect("files");
        assert_eq!(
            (found.captures.len(), names(&[found.empty[0].0.clone()])),
            (0, names(&[empty.path().into()]))
        );
    }

    #[test]
    fn the_size_of_a_folder_is_that_of_its_files() {
        let folder = tempfile::tempdir().expect("a folder");
        fs::create_dir(folder.path().join("other")).expect("a folder");
        for (name, size) in [("a.mcap", 5), ("metadata.yaml", 7), ("other/b.mcap", 9)] {
            fs::write(folder.path().join(name), vec![0; size]).expect("a file");
        }
        let size = |path: PathBuf| Input::Path(path).size();
        assert_eq!(size(folder.path().to_owned()), Some(12));
        assert_eq!(size(folder.path().join("a.mcap")), Some(5));
        assert_eq!(size(folder.path().join("absent")), None);
        assert_eq!(size(STANDARD_INPUT.into()), None);
    }

    #[cfg(unix)]
    mod links {
        use std::os::unix::fs::symlink;
        use std::os::unix::net::UnixListener;

        use uavspec_test_support::extent;

        use super::super::search::CYCLE;
        use super::*;

        /// The paths relative to `folder`, with `/` as the separator.
        fn below(folder: &Path, paths: &[PathBuf]) -> Vec<String> {
            let below =
                |path: &PathBuf| path.strip_prefix(folder).expect("below").to_string_lossy().into_owned();
            paths.iter().map(below).collect()
        }

        #[test]
        fn follows_links_to_files_and_folders() {
            let (outside, folder) =
                (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
            fs::write(outside.path().join("a.ulg"), "").expect("a file");
            symlink(outside.path(), folder.path().join("flights")).expect("a link");
            symlink(outside.path().join("a.ulg"), folder.path().join("latest.ulg")).expect("a link");
            symlink(folder.path(), outside.path().join("back")).expect("a link");
            let found = files(&[folder.path().to_path_buf()]).expect("files");
            assert_eq!(below(folder.path(), &found.captures), ["flights/a.ulg", "latest.ulg"]);
            assert_eq!(found.skipped, [(folder.path().join("flights/back"), CYCLE)]);
            assert!(found.unreadable.is_empty(), "{found:?}");
            let matched = files(&[folder.path().join("**/*.ulg")]).expect("files");
            assert_eq!(matched.captures, found.captures);
        }

        #[test]
        fn names_everything_that_is_skipped() {
            let folder = tempfile::tempdir().expect("a folder");
            let path = |name: &str| folder.path().join(name);
            symlink("nowhere", path("gone.txt")).expect("a link");
            symlink("nowhere", path("gone.ulg")).expect("a link");
            symlink("self.mcap", path("self.mcap")).expect("a link");
            let made = std::process::Command::new("mkfifo").arg(path("pipe.json")).status();
            assert!(made.expect("mkfifo runs").success(), "a pipe");
            let _listener = UnixListener::bind(path("socket.json")).expect("a socket");
            symlink("/dev/null", path("zero.jsonl")).expect("a link");
            let found = files(&[folder.path().to_path_buf()]).expect("files");
            assert!(found.captures.is_empty(), "opening a pipe would block: {found:?}");
            assert_eq!(
                found.skipped,
                [
                    (path("gone.txt"), DANGLING),
                    (path("pipe.json"), "a named pipe"),
                    (path("socket.json"), "a socket"),
                    (path("zero.jsonl"), "a device"),
                ]
            );
            let dangling = ["gone.ulg", "self.mcap"].map(|name| (path(name), DANGLING.to_owned()));
            assert_eq!(found.unreadable, dangling, "these may be captures");
            let matched = files(&[path("*.json"), path("gone.*")]).expect("files");
            assert_eq!(skipped(&matched), ["pipe.json", "socket.json"]);
            assert_eq!(matched.unreadable.len(), 2, "{matched:?}");
            let given = files(&[path("pipe.json")]).expect("files");
            assert_eq!(names(&given.captures), ["pipe.json"], "explicit paths are accepted");
        }

        #[test]
        fn an_unreadable_folder_does_not_end_the_search() {
            let folder = tempfile::tempdir().expect("a folder");
            let path = |name: &str| folder.path().join(name);
            // Permissions don't apply to the superuser, but the maximum length of a path does.
            let long = |name: &str| path(name).join(vec!["d".repeat(200); 12].join("/"));
            for name in ["b", "moved"] {
                fs::create_dir_all(long(name)).expect("a folder");
            }
            fs::rename(path("moved"), long("b").join("moved")).expect("a folder");
            for name in ["a.ulg", "b/x.ulg", "c.ulg"] {
                fs::write(path(name), "").expect("a file");
            }
            let found = files(&[folder.path().to_path_buf()]).expect("files");
            assert_eq!(below(folder.path(), &found.captures), ["a.ulg", "b/x.ulg", "c.ulg"]);
            assert_eq!(found.unreadable.len(), 1, "{:?}", found.unreadable);
            assert!(found.unreadable[0].0.starts_with(path("b")));
            let direct = files(&[path("*.ulg")]).expect("files");
            assert_eq!(below(folder.path(), &direct.captures), ["a.ulg", "c.ulg"]);
            assert!(direct.unreadable.is_empty(), "nothing in the folder can match: {:?}", direct.unreadable);
        }

        #[test]
        fn folders_that_link_to_each_other_in_several_ways_are_bounded() {
            let (root, folder) =
                (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
            // Links across 13 levels already exceed the limit.
            let levels = extent(30, 13);
            let level = |number: u32| root.path().join(number.to_string());
            for number in 0..levels {
                fs::create_dir(level(number)).expect("a folder");
                for name in ["left", "right"] {
                    symlink(level(number + 1), level(number).join(name)).expect("a link");
                }
            }
            fs::create_dir(level(levels)).expect("a folder");
            symlink(level(0), folder.path().join("start")).expect("a link");
            let found = files(&[folder.path().to_path_buf()]).expect("files");
            assert!(!found.unreadable.is_empty(), "2^{levels} paths are too many");
            assert!(found.unreadable[0].1.contains("more than 10000 links"), "{:?}", found.unreadable[0]);
        }
    }
}
