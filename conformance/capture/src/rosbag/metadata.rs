//! Reads the `metadata.yaml` in the folder of a bag.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{self, Read as _};
use std::mem;
use std::path::{Path, PathBuf};

use saphyr_parser::{Event, Parser};
use uavspec_model::text::shown;

use crate::limits::{MAX_BAG_FILES, MAX_BAG_TOPICS, MAX_METADATA, MAX_METADATA_DEPTH};
use crate::names::is_bag;

/// The name of the file.
pub const FILE_NAME: &str = "metadata.yaml";

/// The key of the only entry of the file.
pub(super) const ROOT: &str = "rosbag2_bagfile_information";

/// The key of the list of topics.
pub(super) const TOPICS: &str = "topics_with_message_count";

/// The texts that identify the metadata of a bag. At least one of them is expected, even if parts are corrupt.
const MARKS: [&str; 3] = [ROOT, TOPICS, FILES];

/// The key of the list of files.
pub(super) const FILES: &str = "relative_file_paths";

/// The maximum number of problems that are kept.
const MAX_PROBLEMS: usize = 10;

/// The content of `metadata.yaml` that matters for a check.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Metadata {
    /// The storage format: `sqlite3` or `mcap`.
    pub storage: String,
    /// The ROS distribution that recorded the bag; empty if unknown.
    pub distribution: String,
    /// True if each message is compressed separately.
    pub has_compressed_messages: bool,
    /// The names of the files, in order, without duplicates.
    pub files: Vec<String>,
    /// The number of messages in all files.
    pub message_count: Option<u64>,
    /// The number of messages in each file, if stated.
    pub file_counts: BTreeMap<String, u64>,
    /// The number of messages of each topic.
    pub topic_counts: BTreeMap<String, u64>,
    /// The encodings of the topics' messages. rosbag2 prefers them to the encodings in `SQLite` files.
    pub encodings: BTreeMap<String, String>,
    /// The parts that can't be read.
    pub problems: Vec<String>,
}

/// The entry of a list of topics or files at the current position.
#[derive(Default)]
struct Entry {
    name: String,
    encoding: Option<String>,
    count: Option<u64>,
}

/// The ROS distribution in the metadata that rosbag2 writes into the files of a bag. This metadata is a `metadata.yaml`
/// without its root key.
pub fn distribution(text: &str) -> Option<String> {
    let value = text.lines().find_map(|line| line.strip_prefix("ros_distro:"))?;
    Some(value.trim().trim_matches(['"', '\'']).to_owned())
}

/// The folder of a bag, if the path is a folder or its `metadata.yaml`.
pub fn folder_of(path: &Path) -> Option<&Path> {
    if path.is_dir() {
        return Some(path);
    }
    path.parent().filter(|_| path.file_name().is_some_and(|name| name == FILE_NAME))
}

/// The files that are read for a path: the metadata of a bag and the files that it lists, or only the path itself.
pub fn files_of(path: &Path) -> Vec<PathBuf> {
    let Some(folder) = folder_of(path) else { return vec![path.to_path_buf()] };
    let metadata = Metadata::read(folder).ok().flatten().unwrap_or_default();
    let names = std::iter::once(FILE_NAME.to_owned()).chain(metadata.files);
    names.map(|name| folder.join(name)).collect()
}

/// Opens a file of a bag. Fails if it is a pipe or a device, because opening a pipe waits for a writer.
pub fn open(path: &Path) -> io::Result<File> {
    if !fs::metadata(path)?.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is not a file"));
    }
    File::open(path)
}

impl Metadata {
    /// Reads the metadata of the bag in a folder. Returns `None` if the file isn't the metadata of a bag. If parts of
    /// the file can't be read, all bag files in the folder count as listed.
    pub fn read(folder: &Path) -> io::Result<Option<Self>> {
        let mut text = Vec::new();
        open(&folder.join(FILE_NAME))?.take(MAX_METADATA as u64 + 1).read_to_end(&mut text)?;
        let Some(mut found) = Self::parse(&text) else { return Ok(None) };
        if !found.problems.is_empty() {
            found.add_unlisted(folder)?;
        }
        Ok(Some(found))
    }

    /// Adds the bag files in the folder that aren't listed yet.
    fn add_unlisted(&mut self, folder: &Path) -> io::Result<()> {
        let mut names = Vec::new();
        for entry in fs::read_dir(folder)? {
            let path = entry?.path();
            names.extend(
                path.file_name().and_then(OsStr::to_str).filter(|_| is_bag(&path)).map(str::to_owned),
            );
        }
        names.sort();
        let known: BTreeSet<String> = self.files.iter().cloned().collect();
        self.files.extend(names.into_iter().filter(|name| !known.contains(name)));
        Ok(())
    }

    /// Parses the text of the file. Aliases aren't resolved, since rosbag2 writes none.
    pub fn parse(text: &[u8]) -> Option<Self> {
        let mut found = Self::default();
        if text.len() > MAX_METADATA {
            found.problem(format!("it is longer than {MAX_METADATA} bytes; the rest isn't read"));
        }
        let text = String::from_utf8_lossy(&text[..text.len().min(MAX_METADATA)]);
        if !MARKS.iter().any(|mark| text.contains(mark)) {
            return None;
        }
        if text.contains(char::REPLACEMENT_CHARACTER) {
            found.problem("it contains invalid UTF-8".to_owned());
        }
        if let Err(problem) = found.document(&text) {
            found.problem(problem);
        }
        if found.storage.is_empty() && found.problems.is_empty() {
            found.problem("it names no storage".to_owned());
        }
        // A file that is listed several times would be read several times.
        let mut known = BTreeSet::new();
        found.files.retain(|name| known.insert(name.clone()));
        Some(found)
    }

    fn document(&mut self, text: &str) -> Result<(), String> {
        let mut levels: Vec<Level> = Vec::new();
        let mut entry = Entry::default();
        for event in Parser::new_from_str(text) {
            let mut is_end_of_value = false;
            match event.map_err(|error| format!("invalid YAML: {error}"))?.0 {
                Event::MappingStart(..) => levels.push(Level { is_sequence: false, key: None }),
                Event::SequenceStart(..) => levels.push(Level { is_sequence: true, key: None }),
                Event::MappingEnd | Event::SequenceEnd => {
                    levels.pop();
                    self.end(&levels, &mut entry);
                    is_end_of_value = true;
                }
                Event::Scalar(value, ..) => {
                    if let Some(Level { is_sequence: false, key: key @ None }) = levels.last_mut() {
                        *key = Some(value.into_owned());
                    } else {
                        self.set(&levels, &value, &mut entry);
                        is_end_of_value = true;
                    }
                }
                Event::Alias(_) => is_end_of_value = true,
                _ => {}
            }
            if levels.len() > MAX_METADATA_DEPTH {
                return Err(format!("it has more than {MAX_METADATA_DEPTH} nested lists and mappings"));
            }
            if let (true, Some(level)) = (is_end_of_value, levels.last_mut()) {
                level.key = None;
            }
        }
        Ok(())
    }

    fn problem(&mut self, text: String) {
        if self.problems.len() < MAX_PROBLEMS {
            self.problems.push(text);
        }
    }

    /// Stores a value of the document.
    fn set(&mut self, levels: &[Level], value: &str, entry: &mut Entry) {
        match keys(levels)[..] {
            [ROOT, "storage_identifier"] => value.clone_into(&mut self.storage),
            [ROOT, "ros_distro"] => value.clone_into(&mut self.distribution),
            [ROOT, "compression_mode"] => {
                self.has_compressed_messages = value.eq_ignore_ascii_case("message");
            }
            [ROOT, "message_count"] => self.message_count = self.number(value),
            [ROOT, TOPICS, "", "topic_metadata", "name"] | [ROOT, "files", "", "path"] => {
                value.clone_into(&mut entry.name);
            }
            [ROOT, TOPICS, "", "topic_metadata", "serialization_format"] => {
                entry.encoding = Some(value.to_owned());
            }
            [ROOT, TOPICS | "files", "", "message_count"] => entry.count = self.number(value),
            [ROOT, FILES, ""] => match name_of(value) {
                Some(_) if self.files.len() >= MAX_BAG_FILES => {
                    self.problem(format!("it lists more than {MAX_BAG_FILES} files"));
                }
                Some(name) => self.files.push(name.to_owned()),
                None => self.problem(format!("`{}` is not the name of a file", shown(value))),
            },
            _ => {}
        }
    }

    /// Stores the entry that ends here, if it belongs to a list of topics or files.
    fn end(&mut self, levels: &[Level], entry: &mut Entry) {
        let is_topic = match keys(levels)[..] {
            [ROOT, TOPICS, ""] => true,
            [ROOT, "files", ""] => false,
            _ => return,
        };
        let Entry { name, encoding, count } = mem::take(entry);
        if self.topic_counts.len().max(self.encodings.len()) >= MAX_BAG_TOPICS {
            return self.problem(format!("it lists more than {MAX_BAG_TOPICS} topics"));
        }
        let name = if is_topic { name } else { name_of(&name).unwrap_or_default().to_owned() };
        if let Some(count) = count {
            let counts = if is_topic { &mut self.topic_counts } else { &mut self.file_counts };
            let sum = counts.entry(name.clone()).or_default();
            *sum = sum.saturating_add(count);
        }
        if let Some(encoding) = encoding {
            self.encodings.insert(name, encoding);
        }
    }

    /// Parses a number of messages.
    fn number(&mut self, value: &str) -> Option<u64> {
        let number = value.parse().ok();
        if number.is_none() {
            self.problem(format!("expected a number of messages, found `{}`", shown(value)));
        }
        number
    }
}

/// The keys of the current value. A level of a sequence has no key.
fn keys(levels: &[Level]) -> Vec<&str> {
    levels.iter().map(|level| level.key.as_deref().unwrap_or_default()).collect()
}

/// The file name at the end of a path. Old versions of rosbag2 write paths relative to the parent folder, although the
/// files are in the bag's folder.
fn name_of(path: &str) -> Option<&str> {
    path.rsplit(['/', '\\']).next().filter(|name| !matches!(*name, "" | "." | ".."))
}

/// A level of the document at the current position.
struct Level {
    is_sequence: bool,
    /// The key whose value comes next, in a mapping.
    key: Option<String>,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Option<Metadata> {
        Metadata::parse(text.as_bytes())
    }

    const TEXT: &str = "rosbag2_bagfile_information:\n  version: 7\n  storage_identifier: sqlite3\n  duration:\n    \
        nanoseconds: 151137181\n  message_count: 7\n  topics_with_message_count:\n    - topic_metadata:\n        \
        name: /array_topic\n        serialization_format: odd\n        storage_identifier: other\n      message_count: 4\n  compression_format: \
        \"\"\n  relative_file_paths:\n    - bag_0.db3\n    - old\\style\\bag_1.db3\n    - bag_0.db3\n    - ../../etc/passwd\n  \
        files:\n    - path: bag_0.db3\n      message_count: 7\n  custom_data: ~\n  ros_distro: jazzy\n";

    #[test]
    fn reads_the_metadata_of_a_bag() {
        let expected = Metadata {
            storage: "sqlite3".to_owned(),
            distribution: "jazzy".to_owned(),
            has_compressed_messages: false,
            files: ["bag_0.db3", "bag_1.db3", "passwd"].map(str::to_owned).to_vec(),
            message_count: Some(7),
            file_counts: [("bag_0.db3".to_owned(), 7)].into(),
            topic_counts: [("/array_topic".to_owned(), 4)].into(),
            encodings: [("/array_topic".to_owned(), "odd".to_owned())].into(),
            problems: Vec::new(),
        };
        assert_eq!(parse(TEXT), Some(expected));
    }

    #[test]
    fn names_the_parts_that_cannot_be_read() {
        let whole = parse(TEXT).expect("metadata");
        for (from, to, expected) in [
            ("  duration", " \tduration", "invalid YAML: "),
            ("message_count: 7", "message_count: -1", "expected a number of messages, found `-1`"),
            ("message_count: 4", "message_count: many", "expected a number of messages, found `many`"),
            ("- ../../etc/passwd", "- ..", "`..` is not the name of a file"),
            ("storage_identifier: sqlite3", "storage: sqlite3", "it names no storage"),
            ("rosbag2_bagfile_information", "rosbag2_bagfile_informatiom", "it names no storage"),
            ("custom_data: ~", "custom_data: \u{fffd}", "it contains invalid UTF-8"),
            (
                "custom_data: ~",
                &format!("custom_data:\n    {}a", "- ".repeat(40)),
                "it has more than 32 nested lists and mappings",
            ),
        ] {
            let changed = TEXT.replacen(from, to, 1);
            let found = parse(&changed).expect("metadata");
            assert!(found.problems.iter().any(|problem| problem.starts_with(expected)), "{to}: {found:?}");
            assert!(whole.problems.is_empty() && found != whole);
        }
        let long = format!("{TEXT}{}", "#".repeat(4 << 20));
        assert!(parse(&long).expect("metadata").problems[0].starts_with("it is longer than"));
    }

    /// Reading a document takes time and memory in proportion to its length, not to its depth.
    #[test]
    fn deep_documents_end_early() {
        for part in ["- ", "? ", "- ? "] {
            let text = format!("# {ROOT}\n{}", part.repeat(200_000));
            let found = parse(&text).expect("metadata");
            assert!(found.problems[0].contains("nested"), "{found:?}");
        }
    }

    #[test]
    fn other_yaml_is_not_the_metadata_of_a_bag() {
        let nested = "[".repeat(100_000);
        for text in ["", "a", "a: b", "[a, b]", "storage_identifier: x", "\t%", "&a [*a, *a]", &nested] {
            assert_eq!(parse(text), None, "{}", text.chars().take(40).collect::<String>());
        }
    }
}
