//! Tests of bags that consist of several files.

use std::fs;
use std::io::Read;
use std::path::Path;

use uavspec_capture::input::files;
use uavspec_check::check_path;
use uavspec_model::Extent;
use uavspec_test_captures::mcap;
use uavspec_test_captures::rosbag::{Content, metadata};

use super::{FIXED, LIBRARY, assert_same, checked, corrupt, flight, summary, violated};

/// Writes the messages of a bag to several files, and returns the number of files.
fn split(content: &Content, folder: &Path) -> usize {
    let parts = content.messages.chunks(content.messages.len().div_ceil(3));
    for (number, messages) in parts.clone().enumerate() {
        let part = Content { messages: messages.to_vec(), ..content.clone() };
        part.write(&folder.join(format!("bag_{number}.db3")));
    }
    let names: Vec<String> = (0..parts.len()).map(|number| format!("bag_{number}.db3")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    fs::write(folder.join("metadata.yaml"), metadata("sqlite3", &names, content.messages.len()))
        .expect("a file");
    names.len()
}

#[test]
fn the_files_of_a_bag_are_one_capture() {
    let content = flight();
    let folder = tempfile::tempdir().expect("a folder");
    let bag = folder.path().join("flight");
    fs::create_dir(&bag).expect("a folder");
    let num_files = split(&content, &bag);
    content.write(&folder.path().join("whole.db3"));
    fs::write(folder.path().join("metadata.yaml"), "a: b").expect("a file");
    let found = files(&[folder.path().to_owned()]).expect("files");
    assert_eq!(found.captures, [bag.clone(), folder.path().join("whole.db3")]);
    assert_eq!(found.skipped.len(), 1, "other YAML: {:?}", found.skipped);
    let whole = checked(&found.captures[1]);
    for path in [bag.clone(), bag.join("metadata.yaml")] {
        let result = checked(&path);
        assert_same(&result, &whole, "the bag");
        let found = summary(&result);
        assert_eq!((found.num_files, found.channels.len()), (num_files as u64, content.topics.len()));
    }
    let part = checked(&bag.join("bag_1.db3"));
    assert!(part.records > 0 && part.records < whole.records && part.extent == Extent::Whole);
}

/// Rules on message sequences see the messages of all files.
#[test]
fn rules_span_the_files_of_a_bag() {
    let content = flight();
    let folder = tempfile::tempdir().expect("a folder");
    split(&content, folder.path());
    // Only the middle file contains a message whose timestamp goes back.
    let (topic, _, payload) = content.messages[0].clone();
    let (_, time, _) = content.messages[2 * content.messages.len().div_ceil(3) - 1];
    let early = Content { messages: vec![(topic, time, payload)], ..content.clone() };
    early.write(&folder.path().join("early.db3"));
    let names = ["bag_0.db3", "bag_1.db3", "early.db3", "bag_2.db3"];
    let text = metadata("sqlite3", &names, content.messages.len() + 1);
    fs::write(folder.path().join("metadata.yaml"), text).expect("a file");
    let result = checked(folder.path());
    let found = violated(&result);
    assert!(found.iter().any(|(rule, ..)| *rule == "PX-TIME-01"), "{found:?}");
}

#[test]
fn missing_and_unknown_files_are_reported() {
    let content = flight();
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    split(&content, folder.path());
    fs::remove_file(path("bag_1.db3")).expect("a file");
    fs::write(path("bag_2.db3"), "neither this nor that").expect("a file");
    fs::write(path("extra.jsonl"), "").expect("a file");
    let result = checked(folder.path());
    let found = corrupt(&result);
    assert_eq!((result.extent, found.len()), (Extent::WithGaps, 2), "{found:?}");
    assert!(found[0].contains("bag_1.db3, which metadata.yaml lists, can't be opened: "), "{found:?}");
    assert!(found[1].ends_with("bag_2.db3: neither a SQLite nor an MCAP file"), "{found:?}");
    assert!(result.checked > 0);
    let found = files(&[folder.path().to_owned()]).expect("files");
    assert_eq!(found.captures, [folder.path().to_owned(), path("extra.jsonl")]);
}

/// Opening a pipe would block until there is a writer.
#[cfg(unix)]
#[test]
fn pipes_in_the_folder_of_a_bag_are_not_opened() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let make_pipe = |name: &str| {
        let made = std::process::Command::new("mkfifo").arg(path(name)).status();
        assert!(made.expect("mkfifo runs").success(), "a pipe");
    };
    make_pipe("metadata.yaml");
    let found = files(&[folder.path().to_owned()]).expect("files");
    assert_eq!(found.skipped, [(path("metadata.yaml"), "a named pipe")]);
    fs::remove_file(path("metadata.yaml")).expect("a pipe");
    make_pipe("bag_0.db3");
    fs::write(path("metadata.yaml"), metadata("sqlite3", &["bag_0.db3"], 1)).expect("a file");
    let found = corrupt(&checked(folder.path()));
    assert!(
        found[0].ends_with("bag_0.db3, which metadata.yaml lists, can't be opened: it is not a file"),
        "{found:?}"
    );
}

#[test]
fn another_number_of_messages_than_the_metadata_counts_is_incomplete() {
    let content = flight();
    let folder = tempfile::tempdir().expect("a folder");
    content.write(&folder.path().join("bag_0.db3"));
    for (difference, is_reported) in [(0, false), (1, true), (-1, true)] {
        let count = content.messages.len().checked_add_signed(difference).expect("a number");
        fs::write(folder.path().join("metadata.yaml"), metadata("sqlite3", &["bag_0.db3"], count))
            .expect("a file");
        let result = checked(folder.path());
        assert_eq!(result.extent != Extent::Whole, is_reported, "{difference}: {:?}", result.corruption);
    }
}

#[test]
fn a_bag_of_mcap_files_is_one_capture() {
    let content = flight();
    let folder = tempfile::tempdir().expect("a folder");
    let whole = tempfile::tempdir().expect("a folder");
    let declared: Vec<u8> = content
        .topics
        .iter()
        .zip(&content.definitions)
        .flat_map(|((id, topic), definition)| {
            let id = u16::try_from(*id).expect("an id");
            let hash = [("topic_type_hash", topic[3].as_str())];
            let schema = mcap::schema(id + 1, &definition[0], &definition[1], definition[2].as_bytes());
            [schema, mcap::channel(id, id + 1, &topic[0], "cdr", &hash)].concat()
        })
        .collect();
    let file = |messages: &[(i64, i64, Vec<u8>)]| {
        let messages = messages
            .iter()
            .flat_map(|(topic, _, payload)| mcap::message(u16::try_from(*topic).expect("an id"), payload));
        mcap::file(&[declared.clone(), messages.collect()].concat())
    };
    let (first, second) = content.messages.split_at(content.messages.len() / 2);
    for (name, messages) in [("bag_0.mcap", first), ("bag_1.mcap", second)] {
        fs::write(folder.path().join(name), file(messages)).expect("a file");
    }
    let text = metadata("mcap", &["bag_0.mcap", "bag_1.mcap"], content.messages.len());
    fs::write(folder.path().join("metadata.yaml"), text).expect("a file");
    fs::write(whole.path().join("whole.mcap"), file(&content.messages)).expect("a file");
    let result = checked(folder.path());
    assert_same(&result, &checked(&whole.path().join("whole.mcap")), "the bag");
    assert_eq!(summary(&result).storage, "mcap");
}

#[test]
fn a_file_of_a_bag_that_grows_while_it_is_read_is_named() {
    let content = flight();
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("bag_0.db3");
    content.write(&file);
    let text = metadata("sqlite3", &["bag_0.db3"], content.messages.len());
    fs::write(folder.path().join("metadata.yaml"), text).expect("a file");
    let extend = |input: Box<dyn Read + Send>| {
        let mut longer = fs::read(&file).expect("a file");
        longer.extend([0; 77]);
        fs::write(&file, longer).expect("a file");
        input
    };
    let result = check_path(folder.path(), None, &FIXED, &extend).expect("the path can be opened").result;
    assert_eq!((violated(&result), corrupt(&result)), (vec![], vec![]));
    assert_eq!((result.records, result.checked), (content.messages.len() as u64, result.records));
    let [reason] = &result.cut_short[..] else { panic!("{:?}", result.cut_short) };
    assert!(reason.starts_with("bag_0.db3: the file grew from "), "{reason}");
}

/// A bag without a schema or hash, with a message whose type differs between two distributions.
fn ranges() -> Content {
    let ty = "sensor_msgs/msg/Range";
    let empty_header = [&[0; 8][..], &1_u32.to_le_bytes(), &[0; 4]].concat();
    // Up to Humble, the message has no variance.
    let payload = [&[0, 1, 0, 0][..], &empty_header, &[0; 16]].concat();
    Content {
        definitions: Vec::new(),
        topics: vec![(1, ["/range", ty, "cdr", ""].map(str::to_owned))],
        messages: vec![(1, 1, payload)],
        ..Content::default()
    }
}

/// The release that a capture is checked against, and the number of checked messages.
fn release(path: &Path) -> (String, u64) {
    let result = check_path(path, None, &LIBRARY, &|input| input).expect("a capture").result;
    let releases: Vec<String> = result.summary.releases().iter().map(|found| found.release.clone()).collect();
    (releases.join(" "), result.checked)
}

#[test]
fn a_bag_may_state_its_distribution() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let content = ranges();
    let states = |distribution: &str, yaml: &str| {
        let path = path(&format!("{distribution}{}.db3", yaml.len()));
        content.write(&path);
        let bag = rusqlite::Connection::open(&path).expect("a database");
        bag.execute("UPDATE schema SET ros_distro = ?1", [distribution]).expect("a row");
        bag.execute_batch("CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata TEXT NOT NULL)")
            .expect("a table");
        bag.execute("INSERT INTO metadata VALUES (NULL, ?1)", [yaml]).expect("a row");
        release(&path)
    };
    assert_eq!(states("humble", ""), ("ros2@humble".to_owned(), 1));
    assert_eq!(states("", "version: 6\nros_distro: humble\n"), ("ros2@humble".to_owned(), 1));
    assert_eq!(states("", "").1, 0);
    // For the folder of a bag, it is in `metadata.yaml`.
    let bag = path("bag");
    fs::create_dir(&bag).expect("a folder");
    content.write(&bag.join("a.db3"));
    rusqlite::Connection::open(bag.join("a.db3"))
        .and_then(|bag| bag.execute_batch("UPDATE schema SET ros_distro = ''"))
        .expect("a database");
    for (distribution, expected) in [("humble", 1), ("unknown", 0)] {
        let text = metadata("sqlite3", &["a.db3"], 1).replace("jazzy", distribution);
        fs::write(bag.join("metadata.yaml"), text).expect("a file");
        assert_eq!(release(&bag).1, expected, "{distribution}");
    }
}

#[test]
fn an_mcap_file_may_state_its_distribution() {
    let pair = |key: &str, value: &str| [mcap::text(key.as_bytes()), mcap::text(value.as_bytes())].concat();
    let record = |key: &str, value: &str| {
        mcap::record(0x0c, &[&mcap::text(b"rosbag2"), &mcap::text(&pair(key, value))])
    };
    let (_, _, payload) = &ranges().messages[0];
    let data = [
        mcap::schema(1, "sensor_msgs/msg/Range", "ros2msg", b""),
        mcap::channel(1, 1, "/range", "cdr", &[]),
        mcap::message(1, payload),
    ]
    .concat();
    let humble = record("serialized_metadata", "version: 8\nros_distro: humble\n");
    let other = record("ROS_DISTRO", "humble");
    let unknown = record("serialized_metadata", "version: 8\nros_distro: \"\"\n");
    for (before, after, expected) in
        [(&humble, &unknown, 1), (&unknown, &humble, 1), (&other, &unknown, 1), (&unknown, &unknown, 0)]
    {
        let bytes = mcap::file(&[&before[..], &data, &after[..]].concat());
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join("a.mcap"), bytes).expect("a file");
        assert_eq!(release(&folder.path().join("a.mcap")).1, expected);
    }
}
