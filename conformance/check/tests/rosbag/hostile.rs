//! Tests of corrupt and hostile `SQLite` files.

use std::fs;

use rusqlite::Connection;
use uavspec_check::Summary;
use uavspec_model::{Extent, Location};
use uavspec_test_captures::rosbag::Content;
use uavspec_test_support::{Random, extent};

use super::{checked, checked_bytes, corrupt, file_with, flight, violated};

/// A file with the tables of a bag, changed by these statements.
fn changed(statements: &str) -> (tempfile::TempDir, std::path::PathBuf) {
    let content = flight();
    let (folder, path) = file_with("bag.db3", &content.to_bytes());
    Connection::open(&path).and_then(|bag| bag.execute_batch(statements)).expect("a database");
    (folder, path)
}

/// Reading a schema executes nothing, although reading each of these tables would take hours or much memory.
#[test]
fn views_virtual_tables_and_generated_columns_are_not_read() {
    let endless = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n)";
    let rows = "SELECT i AS id, 1 AS topic_id, i AS timestamp, zeroblob(1000000000) AS data FROM n";
    for (statements, expected) in [
        (format!("DROP TABLE messages; CREATE VIEW messages AS {endless} {rows}"), "it has no table `messages`"),
        (
            format!("DROP TABLE topics; CREATE VIEW topics AS {endless} SELECT i AS id FROM n"),
            "it has no table `topics`",
        ),
        (
            // The table isn't created directly, because SQLite may lack this module.
            "DROP TABLE messages; PRAGMA writable_schema = ON;
                INSERT INTO sqlite_schema VALUES ('table', 'messages', 'messages', 0,
                'CREATE VIRTUAL TABLE messages USING fts5(topic_id, timestamp, data)')"
                .to_owned(),
            "it has no table `messages`",
        ),
        (
            "DROP TABLE messages; CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER,
                data BLOB AS (zeroblob(1000000000)));
                INSERT INTO messages(topic_id, timestamp) VALUES (1, 1)"
                .to_owned(),
            "its table `messages` has no column `data`",
        ),
        (
            "DROP TABLE messages; CREATE TABLE messages(topic_id, timestamp, data, k PRIMARY KEY) WITHOUT ROWID"
                .to_owned(),
            "no such column: rowid",
        ),
        ("DROP TABLE messages".to_owned(), "it has no table `messages`"),
        ("ALTER TABLE topics DROP COLUMN type".to_owned(), "its table `topics` has no column `type`"),
    ] {
        let (_folder, path) = changed(&statements);
        let result = checked(&path);
        let found = corrupt(&result);
        assert!(found.len() == 1 && found[0].contains(expected), "{statements}: {found:?}");
        assert_eq!((result.extent, result.checked), (Extent::WithGaps, 0), "{statements}");
    }
}

#[test]
fn values_of_other_types_are_reported() {
    let content = flight();
    let count = content.messages.len() as u64;
    for (statement, expected) in [
        (
            "UPDATE messages SET topic_id = 999 WHERE id = 1",
            "a message refers to topic 999, which the bag doesn't",
        ),
        (
            "UPDATE messages SET topic_id = 'x' WHERE id = 1",
            "a message refers to topic -9223372036854775808, which",
        ),
        ("UPDATE messages SET data = 5 WHERE id = 1", "the message is unreadable: "),
    ] {
        let (_folder, path) = changed(statement);
        let result = checked(&path);
        let found = corrupt(&result);
        assert!(found.len() == 1 && found[0].contains(expected), "{statement}: {found:?}");
        assert_eq!(result.corruption[0].0, Location::Message(1), "{statement}");
        assert_eq!((result.extent, result.checked), (Extent::WithGaps, count - 1), "{statement}");
    }
}

/// A corrupt index may omit messages.
#[test]
fn messages_that_the_index_lacks_are_read() {
    let content = flight();
    let hidden = "CREATE TABLE kept AS SELECT * FROM sqlite_schema WHERE name = 'timestamp_idx';
        PRAGMA writable_schema = ON; DELETE FROM sqlite_schema WHERE name = 'timestamp_idx';";
    let (_folder, path) = changed(hidden);
    let topic = content.topics[0].0;
    let shown = format!(
        "INSERT INTO messages VALUES (NULL, {topic}, 1, x'00'); PRAGMA writable_schema = ON;
        INSERT INTO sqlite_schema SELECT * FROM kept; DROP TABLE kept;"
    );
    Connection::open(&path).and_then(|bag| bag.execute_batch(&shown)).expect("a database");
    let result = checked(&path);
    let found = corrupt(&result);
    assert!(found.len() == 1 && found[0].contains("the time index doesn't match"), "{found:?}");
    assert_eq!((result.extent, result.records), (Extent::WithGaps, content.messages.len() as u64 + 1));
}

/// If a flipped bit hides a message in the tables or the index, it is reported.
#[test]
fn a_flipped_bit_hides_no_message() {
    let mut content = flight();
    content.messages.truncate(60);
    let bytes = content.to_bytes();
    let intact = checked_bytes(&bytes);
    assert_eq!((intact.extent, intact.records), (Extent::Whole, 60));
    let mut random = Random(19);
    for _ in 0..extent(4_000, 25) {
        let mut flipped = bytes.clone();
        let at = random.index(bytes.len());
        flipped[at] ^= 1 << random.below(8);
        let result = checked_bytes(&flipped);
        let is_same = (result.records, result.checked) == (intact.records, intact.checked);
        let is_reported = result.extent != Extent::Whole || violated(&result) != violated(&intact);
        // A changed topic name or type name isn't corruption, but the coverage shows it.
        let is_uncovered = !result.coverage.is_full() || matches!(result.summary, Summary::Unknown(_));
        assert!(is_same || is_reported || is_uncovered, "byte {at}");
    }
}

#[test]
fn a_repeated_topic_id_is_reported() {
    let content = flight();
    let (_folder, path) = changed(
        "CREATE TABLE copy AS SELECT * FROM topics; DROP TABLE topics; ALTER TABLE copy RENAME TO topics;
        INSERT INTO topics SELECT id, name, 'px4_msgs/msg/Other', serialization_format, '', '' FROM topics LIMIT 1",
    );
    let result = checked(&path);
    let found = corrupt(&result);
    assert!(found.len() == 1 && found[0].contains("is declared again"), "{found:?}");
    assert_eq!((result.extent, result.checked), (Extent::WithGaps, content.messages.len() as u64));
}

#[test]
fn payloads_have_a_maximum_size() {
    let content = flight();
    let topic = content.topics[0].0;
    let row = |id: u32, length: u32| {
        format!("INSERT INTO messages VALUES ({id}, {topic}, {id}, zeroblob({length}));")
    };
    let statements = ["DELETE FROM messages;".to_owned(), row(1, 5 << 20), row(2, (64 << 20) + 1)];
    let (_folder, path) = changed(&statements.concat());
    let result = checked(&path);
    let found = corrupt(&result);
    assert!(
        found.len() == 1 && found[0].starts_with("message 2: the message has 67,108,865 bytes"),
        "{found:?}"
    );
}

/// The pages of a corrupt file can be reached in several ways, so the file may seem to contain more messages than
/// bytes.
#[test]
fn a_truncated_file_is_checked_as_far_as_possible() {
    let content = flight();
    let bytes = content.to_bytes();
    let mut max = 0;
    for cut in (4..bytes.len()).step_by(extent(509, 4_093)) {
        let (_folder, path) = file_with("bag.db3", &bytes[..cut]);
        let result = checked(&path);
        assert_ne!(result.extent, Extent::Whole, "cut at {cut}");
        assert!(result.checked <= content.messages.len() as u64);
        max = max.max(result.checked);
    }
    assert!(max > content.messages.len() as u64 / 2, "{max} of {}", content.messages.len());
}

#[test]
fn flipped_bits_never_panic() {
    let mut content = flight();
    content.messages.truncate(extent(usize::MAX, 60));
    let bytes = content.to_bytes();
    let mut random = Random(18);
    let mut corrupted = 0;
    for _ in 0..extent(2_000, 24) {
        let mut flipped = bytes.clone();
        for _ in 0..=random.below(4) {
            // Bits in the schema and the roots of the tables matter more than bits in the payloads.
            let end = if random.below(2) == 0 { 3 << 12 } else { bytes.len() };
            flipped[16 + random.index(end - 16)] ^= 1 << random.below(8);
        }
        let result = checked_bytes(&flipped);
        corrupted += u64::from(result.extent != Extent::Whole);
    }
    assert!(corrupted > extent(10, 0), "{corrupted}");
}

/// A killed recorder leaves its last messages in a second file.
#[test]
fn unfinished_recordings_are_incomplete_and_stay_unchanged() {
    let content = flight();
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bag.db3");
    content.write(&path);
    let writer = Connection::open(&path).expect("a database");
    writer.execute_batch("PRAGMA journal_mode = WAL; PRAGMA wal_autocheckpoint = 0").expect("a database");
    let more = Content { messages: content.messages.clone(), ..Content::default() };
    more.insert(&writer);
    let killed = tempfile::tempdir().expect("a folder");
    for name in ["bag.db3", "bag.db3-wal"] {
        fs::copy(folder.path().join(name), killed.path().join(name)).expect("a file");
    }
    drop(writer);
    let before = fs::read(killed.path().join("bag.db3")).expect("a file");
    let result = checked(&killed.path().join("bag.db3"));
    let found = corrupt(&result);
    assert!(found.len() == 1 && found[0].contains("may be in `bag.db3-wal`"), "{found:?}");
    assert_eq!((result.extent, result.checked), (Extent::WithGaps, content.messages.len() as u64));
    let mut names: Vec<_> = fs::read_dir(killed.path())
        .expect("a folder")
        .map(|entry| entry.expect("a file").file_name())
        .collect();
    names.sort();
    assert_eq!(names, ["bag.db3", "bag.db3-wal"], "nothing is written next to the file");
    assert_eq!(fs::read(killed.path().join("bag.db3")).expect("a file"), before);
    fs::remove_file(killed.path().join("bag.db3-wal")).expect("a file");
    assert_eq!(checked(&killed.path().join("bag.db3")).extent, Extent::Whole);
    fs::write(killed.path().join("bag.db3-journal"), b"\xd9\xd5\x05\xf9\x20\xa1\x63\xd7\0\0")
        .expect("a file");
    assert_eq!(checked(&killed.path().join("bag.db3")).extent, Extent::WithGaps);
}

/// These characters have a special meaning in a URI.
#[test]
fn paths_may_contain_any_characters() {
    let content = flight();
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["a b.db3", "50%41?mode=rw#x.db3", "ß&=+;.db3", "file:x.db3"] {
        let path = folder.path().join(name);
        fs::write(&path, content.to_bytes()).expect("a file");
        let result = checked(&path);
        assert_eq!((result.extent, result.checked), (Extent::Whole, content.messages.len() as u64), "{name}");
    }
}
