//! Tests of conversions of `SQLite` files and folders.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use ruzstd::encoding::{CompressionLevel, compress_to_vec};
use tempfile::TempDir;
use uavspec_capture::mcap::{Event, Reader, metadata};
use uavspec_capture::rosbag::metadata::Metadata;
use uavspec_capture::rosbag::sqlite::Bag as Database;
use uavspec_check::convert::{
    Action, ConversionReport, Format, Output, Plan, Settings, convert, convert_folder,
};
use uavspec_check::{check_path, open_folder, open_path};
use uavspec_model::Extent;
use uavspec_rules::definitions::Library;
use uavspec_test_captures::mcap;
use uavspec_test_captures::rosbag::{Content, metadata as metadata_yaml};

use super::{LIBRARY, release, sample};

/// The quality of service of a topic, as Jazzy and older distributions write it.
const QOS: [&str; 2] = [
    "- history: keep_last\n  depth: 10\n  reliability: reliable\n  durability: volatile",
    "- history: 1\n  depth: 10\n  reliability: 1\n  durability: 2",
];

/// The messages by topic and type: the log times in ns, and the payloads.
type Messages = BTreeMap<(String, String), Vec<(u64, Vec<u8>)>>;

/// A bag with some topics of PX4, which contains the quality of service.
fn bag() -> Content {
    let content = Content::of_mcap(&sample("px4@1.16").bag().to_bytes());
    Content { qos: QOS[0].to_owned(), ..content }
}

/// Converts a file to another file.
fn change(input: &Path, output: &Path, to: Option<&Library>) -> ConversionReport {
    let opened = open_path(input, &LIBRARY, &|input| input).expect("a file").expect("a capture");
    let plan = Plan::new(opened.definitions.clone(), &LIBRARY, to, None).expect("a plan");
    let is_database = output.extension().is_some_and(|extension| extension == "db3");
    let format = Some(if is_database { Format::Sqlite } else { Format::Mcap });
    let settings = Settings { format, ..Settings::default() };
    let mut bytes = Vec::new();
    let target = if is_database { Output::Sqlite(output) } else { Output::Stream(&mut bytes) };
    let report = convert((input, opened), &plan, settings, target).expect("a conversion");
    if !is_database {
        fs::write(output, bytes).expect("a file");
    }
    report
}

/// Converts a folder.
fn change_folder(input: &Path, output: Output<'_>, to: Option<&Library>) -> ConversionReport {
    let opened = open_folder(input, &LIBRARY).expect("a folder").expect("a bag");
    let plan = Plan::new(opened.definitions.clone(), &LIBRARY, to, None).expect("a plan");
    let settings = Settings::default();
    convert_folder((input, &opened), &plan, settings, &|input| input, ("new", output)).expect("a conversion")
}

/// The messages of an MCAP file. Each channel has the quality of service with numbers.
fn of_mcap(path: &Path) -> Messages {
    let bytes = fs::read(path).expect("a file");
    let (mut schemas, mut channels, mut messages) = (BTreeMap::new(), BTreeMap::new(), Messages::new());
    let mut reader = Reader::new(&*bytes);
    while let Some(item) = reader.next().expect("bytes") {
        match item.event {
            Event::Schema { id, name, .. } => _ = schemas.insert(id, name),
            Event::Channel { id, schema, topic, metadata, .. } => {
                assert_eq!(metadata["offered_qos_profiles"], QOS[1]);
                channels.insert(id, (topic, schemas[&schema].clone()));
            }
            Event::Message { channel, time, payload, .. } => {
                messages.entry(channels[&channel].clone()).or_default().push((time, payload.to_vec()));
            }
            Event::Problem(problem) => panic!("{problem}"),
            _ => {}
        }
    }
    messages
}

/// The messages of a `SQLite` file.
fn of_database(path: &Path) -> Messages {
    let (bag, problems) = Database::open(path).expect("a bag");
    assert_eq!(
        (problems, bag.check_structure(), bag.distribution()),
        (Vec::new(), Ok(()), "jazzy".to_owned())
    );
    let (mut topics, mut messages) = (BTreeMap::new(), Messages::new());
    bag.topics(|topic| _ = topics.insert(topic.id, (topic.name, topic.ty))).expect("topics");
    bag.messages(|message| {
        let payload = message.payload.expect("a payload").to_vec();
        messages.entry(topics[&message.topic].clone()).or_default().push((message.time, payload));
        std::ops::ControlFlow::Continue(())
    })
    .expect("messages");
    messages
}

/// Asserts that a capture can be read completely.
fn assert_whole(path: &Path) {
    let result = check_path(path, None, &LIBRARY, &|input| input).expect("a capture").result;
    assert_eq!((result.corruption, result.extent), (Vec::new(), Extent::Whole));
}

#[test]
fn the_storage_changes_without_a_target() {
    let folder = TempDir::new().expect("a folder");
    let [first, mcap, last] = ["a.db3", "b.mcap", "c.db3"].map(|name| folder.path().join(name));
    bag().write(&first);
    for (input, output, of_output) in
        [(&first, &mcap, of_mcap as fn(&Path) -> Messages), (&mcap, &last, of_database)]
    {
        let report = change(input, output, None);
        assert!(report.is_complete() && report.count(Action::LeftOut) == 0, "{}", report.to_text());
        assert_eq!(of_output(output), of_database(&first));
        assert_whole(output);
    }
    let bytes = fs::read(&mcap).expect("a file");
    let mut reader = Reader::new(&*bytes);
    let mut records = BTreeMap::new();
    while let Some(item) = reader.next().expect("bytes") {
        if let Event::Metadata { body } = item.event {
            records.extend(metadata(body));
        }
    }
    assert_eq!(records["rosbag2"], [("ROS_DISTRO".to_owned(), "jazzy".to_owned())].into());
}

#[test]
fn a_file_is_converted_in_each_storage() {
    let folder = TempDir::new().expect("a folder");
    let [input, mcap, database, expected] =
        ["a.db3", "b.mcap", "c.db3", "d.mcap"].map(|name| folder.path().join(name));
    bag().write(&input);
    let to = Some(release("px4@1.17"));
    let reports = [change(&input, &mcap, to), change(&input, &database, to)];
    assert!(reports[0].count(Action::Converted) > 3, "{}", reports[0].to_text());
    assert_eq!(reports[0].topics.len(), reports[1].topics.len());
    assert_eq!(of_mcap(&mcap), of_database(&database));
    // Changing the storage first has the same result.
    let between = folder.path().join("between.mcap");
    change(&input, &between, None);
    change(&between, &expected, to);
    assert_eq!(of_mcap(&mcap), of_mcap(&expected));
    assert_whole(&mcap);
    assert_whole(&database);
}

/// Only the metadata of a bag says that messages were compressed separately.
#[test]
fn compressed_messages_become_uncompressed() {
    let folder = TempDir::new().expect("a folder");
    let [plain, packed, output] = ["a.db3", "b.db3", "c.mcap"].map(|name| folder.path().join(name));
    let mut content = bag();
    content.write(&plain);
    for (_, _, payload) in &mut content.messages {
        *payload = compress_to_vec(&**payload, CompressionLevel::Fastest);
    }
    content.write(&packed);
    let report = change(&packed, &output, None);
    assert!(report.is_complete(), "{}", report.to_text());
    assert_eq!(of_mcap(&output), of_database(&plain));
}

/// Splits a bag into several files.
fn split(content: &Content, folder: &Path) -> Vec<String> {
    let parts = content.messages.chunks(content.messages.len().div_ceil(3));
    let names: Vec<String> = (0..parts.len()).map(|number| format!("part{number}.db3")).collect();
    for (messages, name) in parts.zip(&names) {
        Content { messages: messages.to_vec(), ..content.clone() }.write(&folder.join(name));
    }
    let files: Vec<&str> = names.iter().map(String::as_str).collect();
    let text = metadata_yaml("sqlite3", &files, content.messages.len());
    fs::write(folder.join("metadata.yaml"), text).expect("a file");
    names
}

#[test]
fn a_folder_becomes_a_folder_or_a_file() {
    let folder = TempDir::new().expect("a folder");
    let [input, output, whole, merged] =
        ["in", "out", "whole.db3", "merged.mcap"].map(|name| folder.path().join(name));
    for path in [&input, &output] {
        fs::create_dir(path).expect("a folder");
    }
    let content = bag();
    content.write(&whole);
    let names = split(&content, &input);
    let to = Some(release("px4@1.17"));
    let expected = change(&whole, &folder.path().join("expected.db3"), to);
    let report = change_folder(&input, Output::Folder(&output), to);
    assert_eq!(
        report.to_text().lines().skip(1).collect::<Vec<_>>(),
        expected.to_text().lines().skip(1).collect::<Vec<_>>()
    );
    let found = Metadata::read(&output).expect("a file").expect("metadata");
    assert_eq!(found.files, ["new_0.db3", "new_1.db3", "new_2.db3"]);
    assert_eq!((found.distribution.as_str(), found.problems.len()), ("jazzy", 0));
    // The check compares all numbers in the metadata with the messages.
    assert_whole(&output);
    let mut messages = Messages::new();
    for file in &found.files {
        for (topic, found) in of_database(&output.join(file)) {
            messages.entry(topic).or_default().extend(found);
        }
    }
    assert_eq!(messages, of_database(&folder.path().join("expected.db3")));
    let mut bytes = Vec::new();
    let report = change_folder(&input, Output::Stream(&mut bytes), None);
    assert_eq!((report.from_format, report.to_format), (Format::Sqlite, Format::Mcap));
    fs::write(&merged, bytes).expect("a file");
    assert_eq!(of_mcap(&merged), of_database(&whole));
    let summary =
        ::mcap::Summary::read(&fs::read(&merged).expect("a file")).expect("MCAP").expect("a summary");
    assert_eq!(summary.channels.len(), content.topics.len(), "the files share their channels");
    fs::remove_file(input.join(&names[1])).expect("a file");
    let report = change_folder(&input, Output::Stream(&mut Vec::new()), None);
    assert!(!report.is_complete() && report.problems[0].starts_with("part1.db3: "), "{:?}", report.problems);
}

#[test]
fn readable_messages_of_a_truncated_database_are_converted() {
    let folder = TempDir::new().expect("a folder");
    let [whole, part] = ["a.db3", "b.db3"].map(|name| folder.path().join(name));
    Content { qos: String::new(), ..bag() }.write(&whole);
    let bytes = fs::read(&whole).expect("a file");
    let all = bag().messages.len();
    let mut most = 0;
    for percent in [25, 50, 75, 90, 97] {
        fs::write(&part, &bytes[..bytes.len() * percent / 100]).expect("a file");
        let output = folder.path().join(format!("{percent}.db3"));
        let report = change(&part, &output, None);
        assert!(!report.is_complete(), "{}", report.to_text());
        let count: usize = of_database(&output).values().map(Vec::len).sum();
        assert!(count < all);
        most = most.max(count);
    }
    // Without the root of their table, messages can't be found.
    assert!(most > all / 2, "{most} of {all}");
}

/// Bags with unusual content: an MCAP file that becomes a `SQLite` file and an MCAP file again. Returns the reports and the
/// last file.
fn there_and_back(records: &[Vec<u8>]) -> ([ConversionReport; 2], Vec<u8>) {
    let folder = TempDir::new().expect("a folder");
    let [input, database, output] = ["a.mcap", "b.db3", "c.mcap"].map(|name| folder.path().join(name));
    fs::write(&input, mcap::file(&records.concat())).expect("a file");
    let reports = [change(&input, &database, None), change(&database, &output, None)];
    (reports, fs::read(&output).expect("a file"))
}

/// The schemas of the channels and the payloads of an MCAP file, by topic.
fn content(bytes: &[u8]) -> BTreeMap<String, (String, Vec<Vec<u8>>)> {
    let (mut schemas, mut channels) = (BTreeMap::new(), BTreeMap::new());
    let mut content: BTreeMap<String, (String, Vec<Vec<u8>>)> = BTreeMap::new();
    let mut reader = Reader::new(bytes);
    while let Some(item) = reader.next().expect("bytes") {
        match item.event {
            Event::Schema { id, encoding, text, .. } => {
                schemas.insert(id, format!("{encoding} {}", String::from_utf8_lossy(text)));
            }
            Event::Channel { id, schema, topic, .. } => {
                content.entry(topic.clone()).or_default().0.clone_from(&schemas[&schema]);
                channels.insert(id, topic);
            }
            Event::Message { channel, payload, .. } => {
                content.entry(channels[&channel].clone()).or_default().1.push(payload.to_vec());
            }
            _ => {}
        }
    }
    content
}

#[test]
fn topics_keep_their_own_definitions_of_a_type() {
    let payload = [0, 1, 0, 0, 7, 0, 0, 0];
    let (reports, bytes) = there_and_back(&[
        mcap::schema(1, "sky_msgs/msg/Wind", "ros2msg", b"int32 x\n"),
        mcap::schema(2, "sky_msgs/msg/Wind", "ros2msg", b"float32 y\n"),
        mcap::schema(3, "sky_msgs/msg/Calm", "ros2msg", b""),
        mcap::channel(1, 1, "/one", "cdr", &[]),
        mcap::channel(2, 2, "/two", "cdr", &[]),
        mcap::channel(3, 3, "/three", "cdr", &[]),
        mcap::message(1, &payload),
        mcap::message(2, &payload),
    ]);
    assert!(reports.iter().all(|report| report.count(Action::Copied) == 3));
    let content = content(&bytes);
    let schemas: Vec<&str> = content.values().map(|(schema, _)| schema.as_str()).collect();
    assert_eq!(schemas, ["ros2msg int32 x\n", "ros2msg ", "ros2msg float32 y\n"]);
    // Without type hashes, definitions that can't be read can't be distinguished.
    let (reports, _) = there_and_back(&[
        mcap::schema(1, "sky_msgs/msg/Wind", "ros2msg", b"?"),
        mcap::schema(2, "sky_msgs/msg/Wind", "ros2msg", b"!"),
        mcap::channel(1, 1, "/one", "cdr", &[]),
        mcap::channel(2, 2, "/two", "cdr", &[]),
    ]);
    let left_out = reports[0].topics.iter().find(|topic| topic.action == Action::LeftOut).expect("a topic");
    assert!(
        left_out.reason.as_deref().unwrap_or_default().contains("a different definition of this type"),
        "{left_out:?}"
    );
}

#[test]
fn parts_that_sqlite_lacks_are_reported() {
    let packed = compress_to_vec(&b"text"[..], CompressionLevel::Fastest);
    let (reports, bytes) = there_and_back(&[
        mcap::schema(1, "sky.Wind", "protobuf", &[0xff, 0x80]),
        mcap::channel(1, 1, "/wind", "protobuf", &[]),
        mcap::message_at(1, u64::MAX, &packed),
    ]);
    let notes = [
        "a SQLite file can't contain schemas that aren't text in UTF-8 (1): they are left out",
        "a SQLite file can't contain times after 2262 (1): these messages get the latest possible time",
    ];
    assert_eq!(reports[0].notes, notes);
    // Only CDR can't be confused with compressed data.
    assert_eq!(content(&bytes)["/wind"], (" ".to_owned(), vec![packed]));
}

#[test]
fn the_target_states_the_distribution() {
    let folder = TempDir::new().expect("a folder");
    let [input, mcap, output] = ["a.db3", "b.mcap", "c.db3"].map(|name| folder.path().join(name));
    bag().write(&input);
    let to = Some(release("ros2@humble"));
    for (input, output) in [(&input, &mcap), (&mcap, &output)] {
        change(input, output, to);
    }
    let (bag, _) = Database::open(&output).expect("a bag");
    assert_eq!(bag.distribution(), "humble");
}

#[test]
fn a_log_becomes_the_same_bag_in_each_storage() {
    let folder = TempDir::new().expect("a folder");
    let [log, database, through, direct] =
        ["a.ulg", "b.db3", "c.mcap", "d.mcap"].map(|name| folder.path().join(name));
    fs::write(&log, sample("px4@1.17").log().to_bytes()).expect("a file");
    let report = change(&log, &database, None);
    assert!(report.notes.iter().any(|note| note.contains("most metadata of channels")), "{:?}", report.notes);
    change(&database, &through, None);
    change(&log, &direct, None);
    let [through, direct] = [through, direct].map(|path| content(&fs::read(path).expect("a file")));
    assert_eq!(through, direct);
    assert!(direct.len() > 3);
}
