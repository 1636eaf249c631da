//! Reads bags in rosbag2's `SQLite` format (`.db3`).
//!
//! # Untrusted files
//!
//! `SQLite` executes parts of a file: views, triggers, virtual tables and generated columns. The reader accepts
//! ordinary tables only, and opens the file read-only and immutable. It bounds the size of all values, the memory of
//! `SQLite`, and the work between two messages. `SQLite` never writes to the folder of the file.
//!
//! # Corrupt files
//!
//! Each payload is read separately, so an unreadable payload doesn't affect other messages. A truncated file is read as
//! far as possible. The index of the times is compared with the table, and the structure of the tables is checked: a
//! changed bit may hide messages without any error.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::ffi::CStr;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::io::Read as _;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use rusqlite::blob::Blob;
use rusqlite::config::DbConfig;
use rusqlite::limits::Limit;
use rusqlite::types::ValueRef;
use rusqlite::{Connection, ErrorCode, OpenFlags, Row};
use uavspec_model::Extent;
use uavspec_model::text::{command_line, plural, shown, thousands};

use super::{QOS, metadata};
use crate::limits::{MAX_HEAP, MAX_NAME, MAX_RECORD, MAX_ROWS};

/// The size of the page cache of a database, in KiB.
const CACHE: i64 = 512;

/// The minimum size of a message in the file, in bytes: the header of its row, and the row's address in the page.
const MIN_MESSAGE: u64 = 8;

/// The number of instructions of `SQLite`'s virtual machine between two checks of the budget.
const INSTRUCTIONS: i32 = 1_000;

/// The maximum number of instructions for a result, divided by [`INSTRUCTIONS`]: a constant, and a number per byte of
/// the file, which is enough to sort the messages.
const BUDGET: (u64, u64) = (10_000, 20);

/// The limits of `SQLite` that prevent expensive schemas.
const LIMITS: [(Limit, i32); 8] = [
    (Limit::SQLITE_LIMIT_LENGTH, 4 << 20),
    (Limit::SQLITE_LIMIT_SQL_LENGTH, 64 << 10),
    (Limit::SQLITE_LIMIT_COLUMN, 100),
    (Limit::SQLITE_LIMIT_EXPR_DEPTH, 20),
    (Limit::SQLITE_LIMIT_COMPOUND_SELECT, 3),
    (Limit::SQLITE_LIMIT_ATTACHED, 0),
    (Limit::SQLITE_LIMIT_TRIGGER_DEPTH, 1),
    (Limit::SQLITE_LIMIT_WORKER_THREADS, 0),
];

/// The settings that restrict what a schema can execute.
const SETTINGS: [(DbConfig, bool); 4] = [
    (DbConfig::SQLITE_DBCONFIG_TRUSTED_SCHEMA, false),
    (DbConfig::SQLITE_DBCONFIG_ENABLE_TRIGGER, false),
    (DbConfig::SQLITE_DBCONFIG_ENABLE_VIEW, false),
    (DbConfig::SQLITE_DBCONFIG_ENABLE_FTS3_TOKENIZER, false),
];

/// The table of the messages.
const MESSAGES: &str = "messages";

/// The table of the messages, and the column of their payloads.
const PAYLOADS: (&CStr, &CStr) = (c"messages", c"data");

/// The end of a query that reads the messages by time and then by row, with the index of the times if there is one.
const BY_TIME: &str = "messages ORDER BY timestamp, rowid";

/// Like [`BY_TIME`], but without the index.
const BY_TIME_WITHOUT_INDEX: &str = "messages NOT INDEXED ORDER BY timestamp, rowid";

/// The end of a query that reads the messages by row.
const BY_ROW: &str = "messages NOT INDEXED ORDER BY rowid";

/// The table of the definitions of message types.
const DEFINITIONS: &str = "message_definitions";

/// The size of the file header, in bytes.
const HEADER: u64 = 100;

/// The first bytes of the journal of an unfinished transaction.
const JOURNAL_MAGIC: [u8; 8] = [0xd9, 0xd5, 0x05, 0xf9, 0x20, 0xa1, 0x63, 0xd7];

/// A bag that is being read.
#[derive(Debug)]
pub struct Bag {
    connection: Connection,
    /// The size of the file, in bytes.
    size: u64,
    /// The number of instructions since the last result, divided by [`INSTRUCTIONS`].
    used: Arc<AtomicU64>,
}

/// A topic of the bag.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Topic {
    /// The id, to which messages refer.
    pub id: i64,
    /// The name.
    pub name: String,
    /// The type of the messages, such as `std_msgs/msg/String`.
    pub ty: String,
    /// The encoding of the messages, such as `cdr`.
    pub encoding: String,
    /// The type hash; empty if the bag contains none.
    pub hash: String,
    /// The quality of service of the publishers, in YAML; empty if the bag contains none.
    pub qos: String,
}

/// The definition of a type, with the definitions of its nested types.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Definition {
    /// The type.
    pub ty: String,
    /// The language of the definition, such as `ros2msg`.
    pub encoding: String,
    /// The text.
    pub text: String,
    /// The type hash; empty if the bag contains none.
    pub hash: String,
}

/// Facts about the definitions in a bag. rosbag2 stores one definition for each type, with the hash of the first topic
/// that has this type.
#[derive(Debug, Default)]
pub struct Facts<T> {
    /// The facts by the type and the type hash of the definition. The flag is true if the hash matches the text.
    by_type: HashMap<String, BTreeMap<String, (bool, T)>>,
}

impl<T> Facts<T> {
    /// Adds a fact about the definition of a type. `is_verified` is true if the type hash in the bag matches the text.
    pub fn add(&mut self, ty: &str, hash: &str, is_verified: bool, fact: T) {
        self.by_type.entry(ty.to_owned()).or_default().insert(hash.to_owned(), (is_verified, fact));
    }

    /// The fact about the definition of a topic's messages.
    pub fn of(&self, topic: &Topic) -> Option<&T> {
        let facts = self.by_type.get(&topic.ty)?;
        // Old files, and some newer files, lack the hash in one of the tables.
        let (_, fact) = facts.get(&topic.hash).or_else(|| facts.get("")).or_else(|| {
            // Without the hash of the topic, it is unknown which of several definitions applies. A text without a
            // matching hash may be incomplete.
            let only = facts.values().next().filter(|_| topic.hash.is_empty() && facts.len() == 1);
            only.filter(|(is_verified, _)| *is_verified)
        })?;
        Some(fact)
    }
}

/// A message of the bag.
#[derive(Debug)]
pub struct Message<'m> {
    /// The id of the topic.
    pub topic: i64,
    /// The log time, in ns.
    pub time: u64,
    /// The payload, or the reason why it can't be read.
    pub payload: Result<&'m [u8], String>,
}

/// A problem in the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// The text.
    pub text: String,
    /// The data that is affected.
    pub extent: Extent,
}

impl Problem {
    fn gap(text: impl Into<String>) -> Self {
        Self { text: text.into(), extent: Extent::WithGaps }
    }
}

impl From<rusqlite::Error> for Problem {
    fn from(error: rusqlite::Error) -> Self {
        Self::gap(match error.sqlite_error_code() {
            Some(ErrorCode::OperationInterrupted) => "reading the database takes too many steps".to_owned(),
            _ => format!("the database is unreadable: {error}"),
        })
    }
}

impl Bag {
    /// Opens a file. Also returns the problems that don't prevent reading.
    pub fn open(path: &Path) -> Result<(Self, Vec<Problem>), Problem> {
        let unreadable = |error: std::io::Error| Problem::gap(format!("the file can't be read: {error}"));
        // The header is read first: a file that a writer extends now must not look truncated.
        let header = start_of(path).map_err(unreadable)?;
        let size = fs::metadata(path).map_err(unreadable)?.len();
        let mut problems = Vec::new();
        problems.extend(unfinished(path));
        let missing = missing(&header, size);
        if missing > 0 {
            let text = format!("the file is truncated: {} bytes are missing", thousands(missing));
            problems.push(Problem { text, extent: Extent::EndsEarly });
        }
        let path = std::path::absolute(path).map_err(unreadable)?;
        let connection = connect(&path, false).or_else(|error| {
            if error.sqlite_error_code() != Some(ErrorCode::DatabaseCorrupt) {
                return Err(error);
            }
            if missing == 0 {
                problems.push(Problem::gap("parts of the database's schema are corrupt"));
            }
            connect(&path, true)
        })?;
        let bag = Self { connection, size, used: Arc::default() };
        bag.bound_work()?;
        Ok((bag, problems))
    }

    /// Makes `SQLite` end statements that exceed the budget.
    fn bound_work(&self) -> Result<(), Problem> {
        let used = Arc::clone(&self.used);
        let budget = BUDGET.0 + self.size.saturating_mul(BUDGET.1) / u64::from(INSTRUCTIONS.unsigned_abs());
        let is_exceeded = move || used.fetch_add(1, Ordering::Relaxed) >= budget;
        Ok(self.connection.progress_handler(INSTRUCTIONS, Some(is_exceeded))?)
    }

    /// The ROS distribution that recorded the bag; empty if unknown. Old bags don't contain it.
    pub fn distribution(&self) -> String {
        let mut distribution = String::new();
        let take = |row: &Row<'_>| {
            distribution = name(row, 0)?;
            Ok(())
        };
        if self.rows("schema", &["ros_distro"], &[], take).is_err() {
            distribution.clear();
        }
        if distribution.is_empty() { self.distribution_in_metadata() } else { distribution }
    }

    /// The ROS distribution in the latest metadata that a recorder wrote into the file; empty if unknown.
    fn distribution_in_metadata(&self) -> String {
        let mut found = String::new();
        let take = |row: &Row<'_>| {
            found = metadata::distribution(&text(row, 0)?)
                .filter(|name| name.len() <= MAX_NAME)
                .unwrap_or_default();
            Ok(())
        };
        let result = self.rows("metadata", &["metadata"], &[], take);
        if result.is_ok() { found } else { String::new() }
    }

    /// Passes the topics to `take`.
    pub fn topics(&self, mut take: impl FnMut(Topic)) -> Result<(), Problem> {
        let columns = ["id", "name", "type", "serialization_format"];
        self.rows("topics", &columns, &["type_description_hash", QOS], |row| {
            let id = row.get_ref(0)?.as_i64().unwrap_or_default();
            let (topic, ty, encoding) = (name(row, 1)?, name(row, 2)?, name(row, 3)?);
            take(Topic { id, name: topic, ty, encoding, hash: name(row, 4)?, qos: text(row, 5)? });
            Ok(())
        })
    }

    /// Passes the definitions of the message types to `take`. Old bags have no such table.
    pub fn definitions(&self, mut take: impl FnMut(Definition)) -> Result<(), Problem> {
        if self.columns(DEFINITIONS)?.is_empty() {
            return Ok(());
        }
        let columns = ["topic_type", "encoding", "encoded_message_definition"];
        self.rows(DEFINITIONS, &columns, &["type_description_hash"], |row| {
            let (ty, encoding, definition) = (name(row, 0)?, name(row, 1)?, text(row, 2)?);
            take(Definition { ty, encoding, text: definition, hash: name(row, 3)? });
            Ok(())
        })
    }

    /// Passes the first stored message of each of these topics to `take`, with the id of the topic. Messages that can't be
    /// read are left out.
    pub fn first_messages(
        &self,
        mut topics: BTreeSet<i64>,
        mut take: impl FnMut(i64, &[u8]),
    ) -> Result<(), Problem> {
        let columns = self.columns(MESSAGES)?;
        for column in ["topic_id", "data"] {
            require(&columns, MESSAGES, column)?;
        }
        self.used.store(0, Ordering::Relaxed);
        let mut statement = self.connection.prepare("SELECT rowid, topic_id FROM messages NOT INDEXED")?;
        let mut rows = statement.query([])?;
        let (mut blob, mut buffer) = (None, Vec::new());
        while !topics.is_empty()
            && let Some(row) = rows.next()?
        {
            let topic = row.get_ref(1)?.as_i64().unwrap_or(i64::MIN);
            if topics.remove(&topic) && self.payload(row.get(0)?, &mut blob, &mut buffer).is_ok() {
                take(topic, &buffer);
            }
        }
        Ok(())
    }

    /// Passes the messages to `take`, by time and then by row, as rosbag2 plays them, until it breaks. A corrupt index of
    /// the times could hide messages, so it is compared with the table.
    pub fn messages(&self, mut take: impl FnMut(Message<'_>) -> ControlFlow<()>) -> Result<(), Problem> {
        let columns = self.columns(MESSAGES)?;
        for column in ["topic_id", "timestamp", "data"] {
            require(&columns, MESSAGES, column)?;
        }
        match (self.tally(BY_ROW), self.tally(BY_TIME)) {
            (Ok(rows), Ok(indexed)) if rows == indexed => self.messages_in(BY_TIME, &mut take),
            (Ok(_), _) => {
                self.messages_in(BY_TIME_WITHOUT_INDEX, &mut take)?;
                Err(Problem::gap(
                    "the time index doesn't match the messages, so they were read without it; SQLite's `REINDEX` \
                     repairs it",
                ))
            }
            // The first problem is the cause, so a second problem isn't reported.
            (Err(problem), _) => {
                let mut count = 0_u64;
                let mut counted = |message: Message<'_>| {
                    count += 1;
                    take(message)
                };
                let result = self.messages_in(BY_TIME, &mut counted);
                if result.is_err() && count == 0 {
                    let _ = self.messages_in(BY_ROW, &mut take);
                }
                Err(problem)
            }
        }
    }

    /// The number of messages, and a checksum of their rows and times.
    fn tally(&self, from: &str) -> Result<(u64, u64), Problem> {
        self.used.store(0, Ordering::Relaxed);
        let mut statement = self.connection.prepare(&format!("SELECT rowid, timestamp FROM {from}"))?;
        let mut rows = statement.query([])?;
        let (mut count, mut sum) = (0_u64, 0_u64);
        while let Some(row) = rows.next()? {
            let mut hasher = DefaultHasher::new();
            (row.get::<_, i64>(0)?, row.get_ref(1)?.as_i64().unwrap_or_default()).hash(&mut hasher);
            (count, sum) = (count + 1, sum.wrapping_add(hasher.finish()));
            if count.saturating_mul(MIN_MESSAGE) > self.size {
                return Err(too_many());
            }
        }
        Ok((count, sum))
    }

    /// Checks the structure of the tables. Corrupt pages may hide rows without any other error.
    pub fn check_structure(&self) -> Result<(), Problem> {
        for table in ["schema", "topics", DEFINITIONS, MESSAGES] {
            if self.columns(table)?.is_empty() {
                continue;
            }
            self.used.store(0, Ordering::Relaxed);
            let query = format!("PRAGMA quick_check({table})");
            let found = self.connection.query_row(&query, [], |row| text(row, 0))?;
            if found != "ok" {
                let found = shown(&found.lines().collect::<Vec<_>>().join(" "));
                return Err(Problem::gap(format!("the table `{table}` is corrupt: {found}")));
            }
        }
        Ok(())
    }

    /// Passes messages to `take`. `from` is the rest of the query, after `FROM`.
    fn messages_in(
        &self,
        from: &str,
        take: &mut dyn FnMut(Message<'_>) -> ControlFlow<()>,
    ) -> Result<(), Problem> {
        self.used.store(0, Ordering::Relaxed);
        let query = format!("SELECT rowid, topic_id, timestamp FROM {from}");
        let mut statement = self.connection.prepare(&query)?;
        let mut rows = statement.query([])?;
        let (mut blob, mut buffer, mut total, mut untimed) = (None, Vec::new(), 0_u64, 0_u64);
        while let Some(row) = rows.next()? {
            self.used.store(0, Ordering::Relaxed);
            // A value of another type belongs to no topic.
            let topic = row.get_ref(1)?.as_i64().unwrap_or(i64::MIN);
            let time = row.get_ref(2)?.as_i64().ok().and_then(|time| u64::try_from(time).ok());
            untimed += u64::from(time.is_none());
            let payload = self.payload(row.get(0)?, &mut blob, &mut buffer);
            total += MIN_MESSAGE + payload.as_ref().map_or(0, |()| buffer.len() as u64);
            if total > self.size {
                return Err(too_many());
            }
            let time = time.unwrap_or_default();
            if take(Message { topic, time, payload: payload.map(|()| &buffer[..]) }).is_break() {
                break;
            }
        }
        if untimed > 0 {
            return Err(Problem::gap(format!("the times of {} are invalid", plural(untimed, "message"))));
        }
        Ok(())
    }

    /// Reads a payload into `buffer`. `blob` is reused for the next payload.
    fn payload<'b>(
        &'b self,
        row: i64,
        blob: &mut Option<Blob<'b>>,
        buffer: &mut Vec<u8>,
    ) -> Result<(), String> {
        let unreadable = |error: rusqlite::Error| format!("the message is unreadable: {error}");
        // A blob can't be reused once its row couldn't be opened.
        let reopened = blob.take().and_then(|mut blob| blob.reopen(row).is_ok().then_some(blob));
        let opened = match reopened {
            Some(opened) => opened,
            None => {
                self.connection.blob_open(c"main", PAYLOADS.0, PAYLOADS.1, row, true).map_err(unreadable)?
            }
        };
        let length = opened.len();
        if length as u64 > MAX_RECORD {
            return Err(format!(
                "the message has {} bytes: more than the limit of {MAX_RECORD}",
                thousands(length)
            ));
        }
        buffer.clear();
        buffer.resize(length, 0);
        opened.read_at_exact(buffer, 0).map_err(unreadable)?;
        *blob = Some(opened);
        Ok(())
    }

    /// Passes the rows of a table to `take`. Missing optional columns are empty.
    fn rows(
        &self,
        table: &str,
        columns: &[&str],
        optional: &[&str],
        mut take: impl FnMut(&Row<'_>) -> rusqlite::Result<()>,
    ) -> Result<(), Problem> {
        let existing = self.columns(table)?;
        for column in columns {
            require(&existing, table, column)?;
        }
        let has = |column: &&str| existing.iter().any(|known| known == column);
        let optional = optional.iter().map(|column| if has(column) { column } else { "''" });
        let selected: Vec<&str> = columns.iter().copied().chain(optional).collect();
        self.used.store(0, Ordering::Relaxed);
        let mut statement =
            self.connection.prepare(&format!("SELECT {} FROM {table}", selected.join(", ")))?;
        let mut rows = statement.query([])?;
        let mut count = 0;
        while let Some(row) = rows.next()? {
            self.used.store(0, Ordering::Relaxed);
            count += 1;
            if count > MAX_ROWS {
                return Err(Problem::gap(format!("the table `{table}` has more than {MAX_ROWS} rows")));
            }
            take(row)?;
        }
        Ok(())
    }

    /// The stored columns of an ordinary table. Empty if there is no such table.
    fn columns(&self, table: &str) -> Result<Vec<String>, Problem> {
        // Virtual tables have no pages.
        let query = "SELECT count(*) FROM sqlite_schema WHERE type = 'table' AND name = ?1 AND rootpage > 0";
        let count: i64 = self.connection.query_row(query, [table], |row| row.get(0))?;
        if count != 1 {
            return Ok(Vec::new());
        }
        let mut statement =
            self.connection.prepare("SELECT name FROM pragma_table_xinfo(?1) WHERE hidden = 0")?;
        let names = statement.query_map([table], |row| text(row, 0))?;
        Ok(names.collect::<rusqlite::Result<_>>()?)
    }
}

/// The error for a database whose messages need more space than the file has.
fn too_many() -> Problem {
    Problem::gap("the messages are larger than the file: the database is corrupt")
}

/// Fails if a table lacks a column.
fn require(existing: &[String], table: &str, column: &str) -> Result<(), Problem> {
    if existing.is_empty() {
        return Err(Problem::gap(format!("the database is not a bag: it has no table `{table}`")));
    }
    if existing.iter().any(|known| known == column) {
        return Ok(());
    }
    Err(Problem::gap(format!("the database is not a bag: its table `{table}` has no column `{column}`")))
}

/// A text value. Bytes that aren't UTF-8 are replaced.
fn text(row: &Row<'_>, index: usize) -> rusqlite::Result<String> {
    Ok(match row.get_ref(index)? {
        ValueRef::Text(bytes) | ValueRef::Blob(bytes) => String::from_utf8_lossy(bytes).into_owned(),
        ValueRef::Null | ValueRef::Integer(_) | ValueRef::Real(_) => String::new(),
    })
}

/// Reads a name from a text value. A very long name is truncated.
fn name(row: &Row<'_>, index: usize) -> rusqlite::Result<String> {
    Ok(text(row, index)?.chars().take(MAX_NAME).collect())
}

/// Opens a connection with all restrictions. If `is_lenient` is true, a truncated file and invalid parts of the schema
/// are accepted.
fn connect(path: &Path, is_lenient: bool) -> rusqlite::Result<Connection> {
    let flags =
        OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_URI | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let connection = Connection::open_with_flags(uri(path), flags)?;
    for (limit, value) in LIMITS {
        connection.set_limit(limit, value)?;
    }
    for (setting, value) in SETTINGS {
        connection.set_db_config(setting, value)?;
    }
    connection.set_db_config(DbConfig::SQLITE_DBCONFIG_DEFENSIVE, !is_lenient)?;
    connection.set_db_config(DbConfig::SQLITE_DBCONFIG_WRITABLE_SCHEMA, is_lenient)?;
    let pragmas = format!(
        "PRAGMA query_only = ON; PRAGMA mmap_size = 0; PRAGMA cache_size = -{CACHE}; PRAGMA cell_size_check = ON; \
         PRAGMA hard_heap_limit = {MAX_HEAP};"
    );
    connection.execute_batch(&pragmas)?;
    // SQLite reads the file only now.
    connection.query_row("SELECT count(*) FROM sqlite_schema", [], |_| Ok(()))?;
    Ok(connection)
}

/// The URI of a file that nobody changes. `SQLite` then creates no other files next to it.
fn uri(path: &Path) -> String {
    let mut uri = "file://".to_owned();
    let bytes = path.as_os_str().as_encoded_bytes();
    // On Windows, `C:\bag.db3` becomes `/C:/bag.db3`. A network path already starts with separators.
    if !bytes.starts_with(b"/") && !bytes.starts_with(b"\\") {
        uri.push('/');
    }
    for byte in bytes {
        match byte {
            b'\\' if cfg!(windows) => uri.push('/'),
            b'/' | b':' | b'.' | b'-' | b'_' => uri.push(char::from(*byte)),
            byte if byte.is_ascii_alphanumeric() => uri.push(char::from(*byte)),
            // Writing to a string can't fail.
            byte => _ = write!(uri, "%{byte:02X}"),
        }
    }
    uri + "?immutable=1"
}

/// The problem, if any, that the bag's last messages are in a second file because its writer didn't finish.
fn unfinished(path: &Path) -> Option<Problem> {
    let other = |suffix: &str| {
        let mut name = path.as_os_str().to_owned();
        name.push(suffix);
        PathBuf::from(name)
    };
    let has_log = fs::metadata(other("-wal")).is_ok_and(|metadata| metadata.len() > 0);
    let has_journal = start_of(&other("-journal")).is_ok_and(|start| start.starts_with(&JOURNAL_MAGIC));
    let suffix = if has_log {
        "-wal"
    } else if has_journal {
        "-journal"
    } else {
        return None;
    };
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    Some(Problem::gap(format!(
        "the recording didn't finish: its last messages may be in `{name}{suffix}`; `{}` completes the file",
        command_line(["sqlite3", &name, ".tables"])
    )))
}

/// The number of bytes by which a file of this size is shorter than its header says.
fn missing(header: &[u8], size: u64) -> u64 {
    let number = |at: usize| header.get(at..at + 4)?.first_chunk().map(|bytes| u32::from_be_bytes(*bytes));
    let page_size =
        header.get(16..18).and_then(|bytes| bytes.first_chunk()).map(|bytes| u16::from_be_bytes(*bytes));
    // Old versions of SQLite don't update the number of pages. The version field then differs from the change counter.
    let (Some(page_size), Some(pages), true) = (page_size, number(28), number(24) == number(92)) else {
        return 0;
    };
    let page_size = if page_size == 1 { 1 << 16 } else { u64::from(page_size) };
    (page_size * u64::from(pages)).saturating_sub(size)
}

/// The header of a file.
fn start_of(path: &Path) -> std::io::Result<Vec<u8>> {
    let mut start = Vec::new();
    File::open(path)?.take(HEADER).read_to_end(&mut start)?;
    Ok(start)
}
