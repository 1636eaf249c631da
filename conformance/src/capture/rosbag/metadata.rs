//! Reads the `metadata.yaml` in the folder of a bag.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::{self, Read as _};
use std::mem;
use std::path::{Path, PathBuf};

use saphyr_parser::{Event, Parser};

/// The name of the file.
pub(crate) const FILE_NAME: &str = "metadata.yaml";

/// The key of the only entry of the file.
const ROOT: &str = "rosbag2_bagfile_information";

/// The key of the list of topics.
const TOPICS: &str = "topics_with_message_count";

/// The maximum size of the file, in bytes. The topics of a large robot take up a tenth of this space.
const MAX_SIZE: u64 = 4 << 20;

/// The maximum number of files in a bag.
const MAX_FILES: usize = 10_000;

/// The maximum number of topics in a bag.
const MAX_TOPICS: usize = 1 << 16;

/// The content of `metadata.yaml` that matters for a check.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Metadata {
    /// The storage format: `sqlite3` or `mcap`.
    pub(crate) storage: String,
    /// The ROS distribution that recorded the bag; empty if unknown.
    pub(crate) distribution: String,
    /// The names of the files, in order, without duplicates.
    pub(crate) files: Vec<String>,
    /// The number of messages in all files.
    pub(crate) message_count: Option<u64>,
    /// The encodings of the topics' messages. rosbag2 prefers them to those in `SQLite` files.
    pub(crate) encodings: BTreeMap<String, String>,
}

/// The ROS distribution in the metadata that rosbag2 writes into the files of a bag. They have the form of
/// `metadata.yaml`, without its only entry.
pub(crate) fn distribution(text: &str) -> Option<String> {
    let value = text.lines().find_map(|line| line.strip_prefix("ros_distro:"))?;
    Some(value.trim().trim_matches(['"', '\'']).to_owned())
}

/// The folder of a bag, if the path is a folder or its `metadata.yaml`.
pub(crate) fn folder_of(path: &Path) -> Option<&Path> {
    if path.is_dir() {
        return Some(path);
    }
    path.parent().filter(|_| path.file_name().is_some_and(|name| name == FILE_NAME))
}

/// The files that are read for a path: the metadata of a bag and the files that it lists, or only the path itself.
pub(crate) fn files_of(path: &Path) -> Vec<PathBuf> {
    let Some(folder) = folder_of(path) else { return vec![path.to_path_buf()] };
    let metadata = Metadata::read(folder).ok().flatten().unwrap_or_default();
    let names = std::iter::once(FILE_NAME.to_owned()).chain(metadata.files);
    names.map(|name| folder.join(name)).collect()
}

/// Opens a file of a bag. Fails if it is a pipe or a device, because opening a pipe waits for a writer.
pub(crate) fn open(path: &Path) -> io::Result<File> {
    if !fs::metadata(path)?.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is not a file"));
    }
    File::open(path)
}

impl Metadata {
    /// Reads the metadata of the bag in a folder. Returns `None` if the file isn't the metadata of a bag.
    pub(crate) fn read(folder: &Path) -> io::Result<Option<Self>> {
        let mut text = String::new();
        open(&folder.join(FILE_NAME))?.take(MAX_SIZE).read_to_string(&mut text)?;
        Ok(Self::parse(&text))
    }

    /// Parses the text of the file. Aliases aren't resolved, since rosbag2 writes none.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let mut found = Self::default();
        let mut levels: Vec<Level> = Vec::new();
        let mut topic = String::new();
        for event in Parser::new_from_str(text) {
            let mut is_end_of_value = false;
            match event.ok()?.0 {
                Event::MappingStart(..) => levels.push(Level { is_sequence: false, key: None }),
                Event::SequenceStart(..) => levels.push(Level { is_sequence: true, key: None }),
                Event::MappingEnd | Event::SequenceEnd => {
                    levels.pop();
                    is_end_of_value = true;
                }
                Event::Scalar(value, ..) => {
                    if let Some(Level { is_sequence: false, key: key @ None }) = levels.last_mut() {
                        *key = Some(value.into_owned());
                    } else {
                        found.set(&levels, &value, &mut topic);
                        is_end_of_value = true;
                    }
                }
                Event::Alias(_) => is_end_of_value = true,
                _ => {}
            }
            if let (true, Some(level)) = (is_end_of_value, levels.last_mut()) {
                level.key = None;
            }
        }
        // A file that is listed several times would be read several times.
        let mut known = BTreeSet::new();
        found.files.retain(|name| known.insert(name.clone()));
        (!found.storage.is_empty()).then_some(found)
    }

    /// Takes a value of the document. `topic` is the name of the current topic.
    fn set(&mut self, levels: &[Level], value: &str, topic: &mut String) {
        // A level of a sequence has no key.
        let keys: Vec<&str> = levels.iter().map(|level| level.key.as_deref().unwrap_or_default()).collect();
        match keys[..] {
            [ROOT, "storage_identifier"] => value.clone_into(&mut self.storage),
            [ROOT, "ros_distro"] => value.clone_into(&mut self.distribution),
            [ROOT, "message_count"] => self.message_count = value.parse().ok(),
            [ROOT, TOPICS, "", "topic_metadata", "name"] => value.clone_into(topic),
            [ROOT, TOPICS, "", "topic_metadata", "serialization_format"]
                if self.encodings.len() < MAX_TOPICS =>
            {
                self.encodings.insert(mem::take(topic), value.to_owned());
            }
            [ROOT, "relative_file_paths", ""] if self.files.len() < MAX_FILES => {
                // Old versions of rosbag2 write paths relative to the parent folder. The files are in the folder.
                let name = value.rsplit(['/', '\\']).next().unwrap_or_default();
                if !matches!(name, "" | "." | "..") {
                    self.files.push(name.to_owned());
                }
            }
            _ => {}
        }
    }
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

    #[test]
    fn reads_the_metadata_of_a_bag() {
        let text = "rosbag2_bagfile_information:\n  version: 7\n  storage_identifier: sqlite3\n  duration:\n    \
            nanoseconds: 151137181\n  message_count: 7\n  topics_with_message_count:\n    - topic_metadata:\n        \
            name: /array_topic\n        serialization_format: odd\n        storage_identifier: other\n      message_count: 4\n  compression_format: \
            \"\"\n  relative_file_paths:\n    - bag_0.db3\n    - old\\style\\bag_1.db3\n    - bag_0.db3\n    - ../../etc/passwd\n    \
            - ..\n  files:\n    - path: bag_0.db3\n      message_count: 7\n  custom_data: ~\n  ros_distro: jazzy\n";
        let expected = Metadata {
            storage: "sqlite3".to_owned(),
            distribution: "jazzy".to_owned(),
            files: ["bag_0.db3", "bag_1.db3", "passwd"].map(str::to_owned).to_vec(),
            message_count: Some(7),
            encodings: [("/array_topic".to_owned(), "odd".to_owned())].into(),
        };
        assert_eq!(Metadata::parse(text), Some(expected));
    }

    #[test]
    fn other_yaml_is_not_the_metadata_of_a_bag() {
        let nested = "[".repeat(100_000);
        for text in
            ["", "a", "a: b", "[a, b]", "rosbag2_bagfile_information: x", "\t%", "&a [*a, *a]", &nested]
        {
            assert_eq!(Metadata::parse(text), None, "{}", text.chars().take(40).collect::<String>());
        }
    }
}
