//! Writes bags as rosbag2 does: `SQLite` files and `metadata.yaml`.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use rusqlite::{Connection, params};
use uavspec_capture::mcap::{Event, Reader};

/// The tables of schema version 4.
const TABLES: &str = "
    CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
    CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
        serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL, type_description_hash TEXT NOT NULL);
    CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, encoding TEXT NOT NULL,
        encoded_message_definition TEXT NOT NULL, type_description_hash TEXT NOT NULL);
    CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,
        data BLOB NOT NULL);
    CREATE INDEX timestamp_idx ON messages (timestamp ASC);
    INSERT INTO schema VALUES (4, 'jazzy');";

/// The content of a bag.
#[derive(Clone, Default)]
pub struct Content {
    /// The definitions: type, encoding, text and hash.
    pub definitions: Vec<[String; 4]>,
    /// The topics: id, name, type, encoding and hash.
    pub topics: Vec<(i64, [String; 4])>,
    /// The messages: topic, time in ns, and payload.
    pub messages: Vec<(i64, i64, Vec<u8>)>,
    /// The quality of service of all topics.
    pub qos: String,
}

impl Content {
    /// The content of an MCAP file. The log times are regular.
    pub fn of_mcap(bytes: &[u8]) -> Self {
        let mut content = Self::default();
        let (mut schemas, mut reader) = (BTreeMap::new(), Reader::new(bytes));
        while let Some(item) = reader.next().expect("bytes can be read") {
            match item.event {
                Event::Schema { id, name, encoding, text } => {
                    schemas.insert(id, (name, encoding, String::from_utf8_lossy(text).into_owned()));
                }
                Event::Channel { id, schema, topic, encoding, metadata } => {
                    let hash = metadata.get("topic_type_hash").cloned().unwrap_or_default();
                    let (name, language, text) = schemas.get(&schema).cloned().unwrap_or_default();
                    content.topics.push((id.into(), [topic, name.clone(), encoding, hash.clone()]));
                    content.definitions.push([name, language, text, hash]);
                }
                Event::Message { channel, payload, .. } => {
                    let time = 1_790_000_000_000_000_000
                        + 1_000_000 * i64::try_from(content.messages.len()).expect("a number");
                    content.messages.push((channel.into(), time, payload.to_vec()));
                }
                _ => {}
            }
        }
        content
    }

    /// Writes a `SQLite` file.
    pub fn write(&self, path: &Path) {
        let connection = Connection::open(path).expect("a database");
        connection.execute_batch(TABLES).expect("tables");
        self.insert(&connection);
    }

    /// Adds the rows to existing tables.
    pub fn insert(&self, connection: &Connection) {
        connection.execute_batch("BEGIN").expect("a transaction");
        for [ty, encoding, text, hash] in &self.definitions {
            let row = params![ty, encoding, text, hash];
            let statement = "INSERT INTO message_definitions VALUES (NULL, ?1, ?2, ?3, ?4)";
            connection.execute(statement, row).expect("a definition");
        }
        for (id, [name, ty, encoding, hash]) in &self.topics {
            let row = params![id, name, ty, encoding, self.qos, hash];
            connection.execute("INSERT INTO topics VALUES (?1, ?2, ?3, ?4, ?5, ?6)", row).expect("a topic");
        }
        for (topic, time, payload) in &self.messages {
            let row = params![topic, time, payload];
            connection.execute("INSERT INTO messages VALUES (NULL, ?1, ?2, ?3)", row).expect("a message");
        }
        connection.execute_batch("COMMIT").expect("a transaction");
    }

    /// The bytes of a `SQLite` file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("bag.db3");
        self.write(&path);
        fs::read(path).expect("a file")
    }
}

/// The text of `metadata.yaml`.
pub fn metadata(storage: &str, files: &[&str], message_count: usize) -> String {
    let mut text = format!(
        "rosbag2_bagfile_information:\n  version: 8\n  storage_identifier: {storage}\n  message_count: {message_count}\n  \
         topics_with_message_count: []\n  compression_format: \"\"\n  compression_mode: \"\"\n  relative_file_paths:\n"
    );
    for file in files {
        let _ = writeln!(text, "    - {file}");
    }
    text + "  ros_distro: jazzy\n"
}
