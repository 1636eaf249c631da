//! Writes `SQLite` files and `metadata.yaml` as rosbag2 does, in the newest form that all distributions since Foxy read:
//! version 8 of the metadata, and version 4 of the tables.

use std::fmt::{self, Write as _};
use std::io;
use std::path::Path;

use rusqlite::{Connection, params};
use uavspec_schema::json_text;

use super::metadata::{FILE_NAME, FILES, ROOT, TOPICS};
use super::sqlite::{Definition, Topic};

/// The tables. The index of the times follows at the end, because this takes less time.
const TABLES: &str = "\
    PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF; PRAGMA locking_mode = EXCLUSIVE;
    CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
    CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);
    CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
        serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL, type_description_hash TEXT NOT NULL);
    CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, encoding TEXT NOT NULL,
        encoded_message_definition TEXT NOT NULL, type_description_hash TEXT NOT NULL);
    CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,
        data BLOB NOT NULL);
    BEGIN;";

const END: &str = "CREATE INDEX timestamp_idx ON messages (timestamp ASC); COMMIT;";

/// The policies of the quality of service: their keys, and the names of their values from 0. Distributions before Jazzy only
/// read the numbers.
const POLICIES: [(&str, &[&str]); 4] = [
    ("history", &["system_default", "keep_last", "keep_all", "unknown"]),
    ("reliability", &["system_default", "reliable", "best_effort", "unknown", "best_available"]),
    ("durability", &["system_default", "transient_local", "volatile", "unknown", "best_available"]),
    (
        "liveliness",
        &["system_default", "automatic", "manual_by_node", "manual_by_topic", "unknown", "best_available"],
    ),
];

/// The start of a bag without messages, in ns.
const NO_START: u64 = i64::MAX as u64;

/// Replaces the names of policies by their numbers in the YAML text of a quality of service.
pub fn portable_qos(text: &str) -> String {
    let mut text = text.to_owned();
    for (key, names) in POLICIES {
        for (number, name) in names.iter().enumerate() {
            text = text.replace(&format!("{key}: {name}"), &format!("{key}: {number}"));
        }
    }
    text
}

/// Writes a `SQLite` file.
#[derive(Debug)]
pub struct Writer {
    connection: Connection,
}

impl Writer {
    /// Writes the tables to an empty file.
    pub fn new(path: &Path) -> io::Result<Self> {
        let connection = Connection::open(path).map_err(io::Error::other)?;
        connection.execute_batch(TABLES).map_err(io::Error::other)?;
        Ok(Self { connection })
    }

    fn insert(&self, statement: &str, values: &[&dyn rusqlite::ToSql]) -> io::Result<()> {
        let inserted = self.connection.prepare_cached(statement).and_then(|mut row| row.execute(values));
        inserted.map(drop).map_err(io::Error::other)
    }

    /// Writes a topic.
    pub fn topic(&self, Topic { id, name, ty, encoding, hash, qos }: &Topic) -> io::Result<()> {
        let values = params![id, name, ty, encoding, qos, hash];
        self.insert("INSERT INTO topics VALUES (?1, ?2, ?3, ?4, ?5, ?6)", values)
    }

    /// Writes the definition of a type.
    pub fn definition(&self, Definition { ty, encoding, text, hash }: &Definition) -> io::Result<()> {
        let values = params![ty, encoding, text, hash];
        self.insert("INSERT INTO message_definitions VALUES (NULL, ?1, ?2, ?3, ?4)", values)
    }

    /// Writes a message with its log time in ns. `SQLite` can't store times after 2262.
    pub fn message(&self, topic: i64, time: u64, payload: &[u8]) -> io::Result<()> {
        let values = params![topic, i64::try_from(time).unwrap_or(i64::MAX), payload];
        self.insert("INSERT INTO messages VALUES (NULL, ?1, ?2, ?3)", values)
    }

    /// Writes the end of the file. `distribution` is the ROS distribution of the messages; it may be empty.
    pub fn finish(self, distribution: &str) -> io::Result<()> {
        self.insert("INSERT INTO schema VALUES (4, ?1)", params![distribution])?;
        self.connection.execute_batch(END).map_err(io::Error::other)?;
        self.connection.close().map_err(|(_, error)| io::Error::other(error))
    }
}

/// The content of a file of a bag, for the metadata of the bag.
#[derive(Clone, Debug, Default)]
pub struct FileContent {
    /// The name.
    pub name: String,
    /// The first and the last log time, in ns.
    pub times: Option<(u64, u64)>,
    /// The topics, with their numbers of messages.
    pub topics: Vec<(Topic, u64)>,
}

impl FileContent {
    fn count(&self) -> u64 {
        self.topics.iter().map(|(_, count)| count).sum()
    }
}

/// The metadata of a bag, displayed as the text of its `metadata.yaml`.
#[derive(Debug)]
pub struct BagContent<'c> {
    /// The storage format: `sqlite3` or `mcap`.
    pub storage: &'c str,
    /// The ROS distribution of the messages; it may be empty.
    pub distribution: &'c str,
    /// The files, in order.
    pub files: &'c [FileContent],
}

impl BagContent<'_> {
    /// Writes the `metadata.yaml` of a folder.
    pub fn write(&self, folder: &Path) -> io::Result<()> {
        std::fs::write(folder.join(FILE_NAME), self.to_string())
    }

    /// The topics of all files. Files of the same bag repeat their topics.
    fn topics(&self) -> Vec<(Topic, u64)> {
        let mut topics: Vec<(Topic, u64)> = Vec::new();
        for (topic, count) in self.files.iter().flat_map(|file| &file.topics) {
            let is_same = |known: &Topic| Topic { id: topic.id, ..known.clone() } == *topic;
            match topics.iter_mut().find(|(known, _)| is_same(known)) {
                Some((_, sum)) => *sum += count,
                None => topics.push((topic.clone(), *count)),
            }
        }
        topics
    }
}

/// A text in double quotes. All strings of JSON are strings of YAML.
fn quoted(text: &str) -> String {
    json_text::compact(text)
}

/// The start and the duration, in ns, indented by `indent` columns.
fn times(text: &mut String, indent: usize, times: Option<(u64, u64)>) -> fmt::Result {
    let (start, end) = times.unwrap_or((NO_START, NO_START));
    let margin = " ".repeat(indent);
    writeln!(text, "{margin}duration:\n{margin}  nanoseconds: {}", end - start)?;
    writeln!(text, "{margin}starting_time:\n{margin}  nanoseconds_since_epoch: {start}")
}

impl fmt::Display for BagContent<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = format!("{ROOT}:\n  version: 8\n  storage_identifier: {}\n", self.storage);
        let all = self.files.iter().filter_map(|file| file.times);
        times(&mut text, 2, all.reduce(|one, other| (one.0.min(other.0), one.1.max(other.1))))?;
        writeln!(text, "  message_count: {}", self.files.iter().map(FileContent::count).sum::<u64>())?;
        let topics = self.topics();
        writeln!(text, "  {TOPICS}:{}", if topics.is_empty() { " []" } else { "" })?;
        for (Topic { name, ty, encoding, hash, qos, .. }, count) in topics {
            writeln!(
                text,
                "    - topic_metadata:\n        name: {}\n        type: {}",
                quoted(&name),
                quoted(&ty)
            )?;
            writeln!(text, "        serialization_format: {}", quoted(&encoding))?;
            writeln!(text, "        offered_qos_profiles: {}", quoted(&qos))?;
            writeln!(text, "        type_description_hash: {}\n      message_count: {count}", quoted(&hash))?;
        }
        text.push_str("  compression_format: \"\"\n  compression_mode: \"\"\n");
        let none = if self.files.is_empty() { " []" } else { "" };
        writeln!(text, "  {FILES}:{none}")?;
        for file in self.files {
            writeln!(text, "    - {}", quoted(&file.name))?;
        }
        writeln!(text, "  files:{none}")?;
        for file in self.files {
            writeln!(text, "    - path: {}", quoted(&file.name))?;
            times(&mut text, 6, file.times)?;
            writeln!(text, "      message_count: {}", file.count())?;
        }
        writeln!(text, "  custom_data: ~\n  ros_distro: {}", quoted(self.distribution))?;
        formatter.write_str(&text)
    }
}

#[cfg(test)]
mod tests {
    use super::super::metadata::Metadata;
    use super::super::sqlite::{Bag, Facts};
    use super::*;

    #[test]
    fn names_of_policies_become_numbers() {
        let named = "- history: keep_last\n  depth: 10\n  reliability: best_effort\n  durability: transient_local\n  \
                     liveliness: automatic\n- {history: unknown, reliability: reliable}";
        let portable = "- history: 1\n  depth: 10\n  reliability: 2\n  durability: 1\n  liveliness: 1\n- {history: 3, \
                        reliability: 1}";
        assert_eq!(portable_qos(named), portable);
        assert_eq!(portable_qos(portable), portable);
    }

    fn topic(id: i64, name: &str) -> Topic {
        let texts = ["sky_msgs/msg/Wind", "cdr", "RIHS01_1", "- history: 1\n  depth: 2"];
        let [ty, encoding, hash, qos] = texts.map(str::to_owned);
        Topic { id, name: name.to_owned(), ty, encoding, hash, qos }
    }

    #[test]
    fn the_reader_returns_what_the_writer_writes() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("bag.db3");
        let writer = Writer::new(&path).expect("a file");
        let [ty, encoding, text, hash] =
            ["sky_msgs/msg/Wind", "ros2msg", "int8 speed\n", "RIHS01_1"].map(str::to_owned);
        let definition = Definition { ty, encoding, text, hash };
        writer.definition(&definition).expect("a definition");
        let topics = [topic(3, "/wind"), topic(9, "/gust")];
        for topic in &topics {
            writer.topic(topic).expect("a topic");
        }
        for (topic, time) in [(3, 20), (9, 10), (3, u64::MAX)] {
            writer.message(topic, time, &[1, 2]).expect("a message");
        }
        writer.finish("jazzy").expect("a file");
        let (bag, problems) = Bag::open(&path).expect("a bag");
        assert_eq!(
            (problems, bag.distribution(), bag.check_structure()),
            (Vec::new(), "jazzy".to_owned(), Ok(()))
        );
        let (mut read, mut definitions, mut messages) = (Vec::new(), Facts::default(), Vec::new());
        bag.topics(|topic| read.push(topic)).expect("topics");
        bag.definitions(|found| definitions.add(&found.ty.clone(), "RIHS01_1", true, found))
            .expect("definitions");
        bag.messages(|message| {
            assert_eq!(message.payload, Ok(&[1_u8, 2][..]));
            messages.push((message.topic, message.time));
            std::ops::ControlFlow::Continue(())
        })
        .expect("messages");
        assert_eq!(read, topics);
        assert_eq!(definitions.of(&topics[0]), Some(&definition));
        assert_eq!(messages, [(9, 10), (3, 20), (3, i64::MAX as u64)]);
    }

    #[test]
    fn the_metadata_can_be_read() {
        let file = |name: &str, times, count| FileContent {
            name: name.to_owned(),
            times,
            topics: vec![(topic(1, "/wind: \"strong\"\n"), count)],
        };
        let files =
            [file("a_0.db3", Some((5, 9)), 2), file("a_1.db3", Some((8, 30)), 3), file("a_2.db3", None, 0)];
        let content = BagContent { storage: "sqlite3", distribution: "jazzy", files: &files };
        let found = Metadata::parse(content.to_string().as_bytes()).expect("metadata");
        let counts =
            [("a_0.db3", 2), ("a_1.db3", 3), ("a_2.db3", 0)].map(|(name, count)| (name.to_owned(), count));
        let expected = Metadata {
            storage: "sqlite3".to_owned(),
            distribution: "jazzy".to_owned(),
            has_compressed_messages: false,
            files: counts.clone().map(|(name, _)| name).to_vec(),
            message_count: Some(5),
            file_counts: counts.into(),
            topic_counts: [("/wind: \"strong\"\n".to_owned(), 5)].into(),
            encodings: [("/wind: \"strong\"\n".to_owned(), "cdr".to_owned())].into(),
            problems: Vec::new(),
        };
        assert_eq!(found, expected);
        let text = content.to_string();
        assert!(text.contains(
            "  duration:\n    nanoseconds: 25\n  starting_time:\n    nanoseconds_since_epoch: 5\n"
        ));
        let empty = BagContent { storage: "mcap", distribution: "", files: &[] }.to_string();
        assert_eq!(Metadata::parse(empty.as_bytes()).expect("metadata").problems, Vec::<String>::new());
    }
}
