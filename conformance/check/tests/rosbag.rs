//! Tests of rosbag2 bags: `SQLite` files have the same findings as MCAP files, and hostile files cause no damage.

mod folders;
mod hostile;
mod services;

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use flate2::Compression;
use flate2::write::GzEncoder;
use ruzstd::encoding::{CompressionLevel, compress_to_vec};
use tempfile::TempDir;
use uavspec_capture::MCAP_MAGIC;
use uavspec_check::{BagSummary, Basis, CaptureResult, CheckStatus, Summary, check_capture, check_path};
use uavspec_model::{Extent, Location};
use uavspec_report::{CheckedCapture, Settings, Subject};
use uavspec_rules::definitions::{Definitions, Library};
use uavspec_rules::sample::Flight;
use uavspec_rules::{Mutant, mutants};
use uavspec_test_captures::rosbag::{Content, metadata};
use uavspec_test_support::{extent, shared};

/// The built-in definitions, used for all captures.
static FIXED: LazyLock<Library> = LazyLock::new(|| Library::fixed(Definitions::built_in()));

/// Chooses the definitions of the release that a capture matches.
static LIBRARY: LazyLock<Library> = LazyLock::new(Library::built_in);

/// Checks a file or a folder against the built-in definitions.
fn checked(path: &Path) -> CaptureResult {
    checked_with(path, &FIXED)
}

fn checked_with(path: &Path, library: &Library) -> CaptureResult {
    check_path(path, None, library, &|input| input).expect("the path can be opened").result
}

fn checked_bytes(bytes: &[u8]) -> CaptureResult {
    check_capture(bytes, None, FIXED.base()).expect("bytes can be read")
}

fn summary(result: &CaptureResult) -> &BagSummary {
    match &result.summary {
        Summary::Bag(summary) => summary,
        other => panic!("expected a bag, found {other:?}"),
    }
}

/// The findings without their locations.
fn violated(result: &CaptureResult) -> Vec<(&'static str, String, u64, Vec<String>)> {
    let groups = result.findings.groups();
    groups.map(|group| (group.rule.id, group.subject.clone(), group.count, group.messages())).collect()
}

fn corrupt(result: &CaptureResult) -> Vec<String> {
    result.corruption.iter().map(|(location, text)| format!("{location}: {text}")).collect()
}

/// Asserts that two captures have the same findings, counts and coverage. Their log times may differ.
fn assert_same(left: &CaptureResult, right: &CaptureResult, name: &str) {
    assert_eq!(violated(left), violated(right), "{name}");
    let counts = |result: &CaptureResult| {
        let coverage = serde_json::to_value(&result.coverage).expect("JSON");
        (result.records, result.checked, result.extent, corrupt(result), coverage)
    };
    let without_times = |result: &CaptureResult| {
        let (records, checked, extent, corrupt, mut coverage) = counts(result);
        for part in coverage["parts"].as_array_mut().expect("parts") {
            for key in ["first_us", "last_us", "rate_hz"] {
                part[key].take();
            }
        }
        (records, checked, extent, corrupt, coverage)
    };
    assert_eq!(without_times(left), without_times(right), "{name}");
}

/// Writes a file to a new folder.
fn file_with(name: &str, bytes: &[u8]) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    fs::write(&path, bytes).expect("a file");
    (folder, path)
}

/// The recording of a flight as a `SQLite` file.
fn flight() -> Content {
    static FLIGHT: LazyLock<Content> =
        LazyLock::new(|| Content::of_mcap(&Flight::new(FIXED.base()).bag().to_bytes()));
    FLIGHT.clone()
}

/// The recording of a flight with the topics of a release; in quick mode, the recording of its start.
fn flight_of_release() -> Content {
    static FLIGHT: LazyLock<Content> = LazyLock::new(|| {
        let release = Library::load(Path::new("px4@1.14"), None).expect("a release");
        let mut flight = Flight::new(release.base());
        flight.messages.truncate(extent(usize::MAX, 2 * flight.topics.len()));
        Content::of_mcap(&flight.bag().to_bytes())
    });
    FLIGHT.clone()
}

#[test]
fn sqlite_files_have_the_findings_of_mcap_files() {
    let flight = Flight::new(FIXED.base());
    // SQLite files contain neither applications nor publishers and subscribers.
    let is_on_messages =
        |mutant: &Mutant| !["PX-HASH-02", "PX-QOS-01", "PX-TYPE-01"].contains(&mutant.rule.id);
    let mutated = mutants().filter(|mutant| !mutant.rule.is_on_flockwave() && is_on_messages(mutant));
    let mutated = mutated.step_by(extent(1, 5)).flat_map(|mutant| mutant.captures(&flight));
    let captures = mutated.chain([("a conforming flight".to_owned(), flight.bag().to_bytes())]);
    let mut num_files = 0;
    for (name, bytes) in captures.filter(|(_, bytes)| bytes.starts_with(&MCAP_MAGIC)) {
        num_files += 1;
        let (_folder, path) = file_with("bag.db3", &Content::of_mcap(&bytes).to_bytes());
        assert_same(&checked(&path), &checked_bytes(&bytes), &name);
    }
    assert!(num_files > extent(20, 3), "{num_files} mutants");
}

#[test]
fn the_summary_names_the_storage_and_the_distribution() {
    let content = flight();
    let result = checked_bytes(&content.to_bytes());
    let found = summary(&result);
    assert_eq!((&*found.storage, &*found.distribution, found.num_files), ("sqlite3", "jazzy", 1));
    assert_eq!(found.channels.len(), content.topics.len());
    assert_eq!((result.records, result.extent), (content.messages.len() as u64, Extent::Whole));
    // The time from the first to the last log time, including messages that aren't checked.
    assert_eq!(result.duration, (content.messages.len() as u64 - 1) * 1_000);
    let mut unknown = content.clone();
    for (_, [_, ty, ..]) in &mut unknown.topics {
        "soar_msgs/msg/Thermal".clone_into(ty);
    }
    assert_eq!(checked_bytes(&unknown.to_bytes()).duration, result.duration);
}

#[test]
fn a_finding_names_the_message_and_its_log_time() {
    let mut content = flight();
    content.messages[7].2.push(0);
    content.messages[7].2.extend([0; 8]);
    let result = checked_bytes(&content.to_bytes());
    let group = result.findings.groups().find(|group| group.rule.id == "PX-CDR-02").expect("a finding");
    let (location, detail) = &group.examples[0];
    let time = u64::try_from(content.messages[7].1).expect("a time");
    assert_eq!((*location, detail.log_time, detail.sequence), (Location::Message(8), Some(time), None));
    let checked = CheckedCapture {
        path: "bag.db3".to_owned(),
        result,
        notes: Vec::new(),
        requests: Vec::new(),
        cut_short: Vec::new(),
        elapsed: 0,
    };
    let subject = Subject::from_capture(checked, FIXED.base(), &Settings::default());
    let finding = subject.findings.iter().find(|finding| finding.rule == "PX-CDR-02").expect("a finding");
    let example = &finding.examples[0];
    let moment = example.moment();
    assert!(moment.ends_with("s (2026-09-21T14:13:20.007Z), log time 1790000000.007000000"), "{moment}");
    let text = serde_json::to_string(example).expect("JSON");
    assert_eq!(text.matches("\"message\":").count(), 1, "the keys are unique: {text}");
    assert!(
        text.contains("\"message_number\":8") && text.contains("\"log_time_ns\":1790000000007000000"),
        "{text}"
    );
}

/// Files may be compressed as a whole, and rosbag2 can compress each message.
#[test]
fn compressed_files_and_messages_have_the_same_findings() {
    let content = flight();
    let bytes = content.to_bytes();
    let plain = checked_bytes(&bytes);
    assert_eq!((plain.checked, plain.bytes), (plain.records, bytes.len() as u64));
    let pack = |bytes: &[u8]| compress_to_vec(bytes, CompressionLevel::Fastest);
    let mut gzip = GzEncoder::new(Vec::new(), Compression::fast());
    gzip.write_all(&bytes).expect("memory");
    let mut packed_messages = content.clone();
    packed_messages.messages.iter_mut().for_each(|(_, _, payload)| *payload = pack(payload));
    for (name, bytes) in [
        ("bag.db3", bytes.clone()),
        ("bag.db3.zstd", pack(&bytes)),
        ("bag.db3.gz", gzip.finish().expect("memory")),
        ("messages.db3", packed_messages.to_bytes()),
    ] {
        let (_folder, path) = file_with(name, &bytes);
        assert_same(&checked(&path), &plain, name);
    }
    let (_folder, path) = file_with("cut.db3.zstd", &pack(&bytes)[..2_000]);
    assert_eq!(checked(&path).extent, Extent::Unreadable);
}

/// rosbag2 plays messages in the order of time. With several writers, the rows are in another order.
#[test]
fn reads_messages_by_time_with_and_without_an_index() {
    let content = flight();
    let expected = checked_bytes(&content.to_bytes());
    let mut reversed = content.clone();
    reversed.messages.reverse();
    for statement in ["", "DROP INDEX timestamp_idx"] {
        let (_folder, path) = file_with("bag.db3", &reversed.to_bytes());
        rusqlite::Connection::open(&path).and_then(|bag| bag.execute_batch(statement)).expect("a database");
        let found = checked(&path);
        assert_same(&found, &expected, statement);
    }
}

/// Files of early versions have neither hashes nor definitions.
#[test]
fn reads_files_of_early_versions() {
    let content = flight();
    let (_folder, path) = file_with("bag.db3", &content.to_bytes());
    let bag = rusqlite::Connection::open(&path).expect("a database");
    let statements = "DROP TABLE schema; DROP TABLE message_definitions;
        ALTER TABLE topics DROP COLUMN type_description_hash; ALTER TABLE topics DROP COLUMN offered_qos_profiles;";
    bag.execute_batch(statements).expect("a database");
    drop(bag);
    let result = checked(&path);
    assert_eq!((violated(&result), corrupt(&result)), (vec![], vec![]));
    assert_eq!((result.checked, result.records), (result.records, content.messages.len() as u64));
    assert!(summary(&result).distribution.is_empty());
}

#[test]
fn ros_1_bags_are_named_with_the_way_to_convert_them() {
    let result = checked_bytes(b"#ROSBAG V2.0\nE\0\0\0");
    let Summary::Unknown(summary) = result.summary else { panic!("a ROS 1 bag can't be read") };
    assert!(summary.reason.starts_with("a ROS 1 bag: convert it first"), "{}", summary.reason);
}

/// rosbag2's own tests use these recordings. They are available in both storage formats.
#[test]
fn real_recordings_have_the_same_findings_in_both_formats() {
    let Some((bags, ros)) = shared("corpus/bags").zip(shared("corpus/ros2-distros/rolling")) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let package = |name: &str| {
        let include = ros.join(name).join("msg/*.msg");
        format!(
            "[[package]]\nname = \"{name}\"\ndialect = \"ros2\"\ninclude = [{:?}]\n",
            include.display().to_string()
        )
    };
    let config = ["std_msgs", "rcl_interfaces", "builtin_interfaces"].map(package).concat();
    fs::write(folder.path().join("uavspec.toml"), config).expect("a file");
    let loaded = Library::load(&folder.path().join("uavspec.toml"), None).expect("definitions");
    let libraries = [&loaded, &*FIXED, &*LIBRARY];
    let (mut num_files, mut num_bags, mut num_checked) = (0, 0, 0);
    for entry in walkdir::WalkDir::new(bags.join("sqlite3")).sort_by_file_name() {
        let path = entry.expect("a file").into_path();
        let below = path.strip_prefix(bags.join("sqlite3")).expect("below").to_owned();
        let name = below.display().to_string();
        let is_file = path.extension().is_some_and(|extension| extension == "db3");
        let twin = match (is_file, path.join("metadata.yaml").is_file()) {
            (true, _) => bags.join("mcap").join(&below).with_extension("mcap"),
            (false, true) => bags.join("mcap").join(&below),
            (false, false) => continue,
        };
        // This SQLite file contains an encoding that contradicts its metadata.
        if is_file && name.starts_with("wrong_rmw_test") {
            continue;
        }
        // In quick mode, each recording is checked with one of the libraries.
        let first = extent(0, (num_files + num_bags) % 3);
        for library in libraries.into_iter().skip(first).step_by(extent(1, 3)) {
            let (left, right) = (checked_with(&path, library), checked_with(&twin, library));
            assert_eq!((left.extent, right.extent), (Extent::Whole, Extent::Whole), "{name}");
            // Some of these SQLite files lack the schemas that are in the MCAP files.
            if left.checked == right.checked {
                assert_same(&left, &right, &name);
            } else {
                assert!(left.checked < right.checked, "{name}");
                assert_eq!((violated(&left), violated(&right)), (vec![], vec![]), "{name}");
            }
            num_checked += left.checked;
        }
        num_files += usize::from(is_file);
        num_bags += usize::from(!is_file);
    }
    assert_eq!((num_files, num_bags), (13, 7));
    assert!(num_checked > extent(15_000, 3_000), "{num_checked}");
}

/// Humble writes neither definitions nor hashes to `SQLite` files, so the message sizes indicate the release.
#[test]
fn bags_without_hashes_are_checked_against_the_release_with_their_sizes() {
    let mut content = flight_of_release();
    content.definitions.clear();
    content.topics.iter_mut().for_each(|(_, [.., hash])| hash.clear());
    // Each topic has messages in only one of the files.
    content.messages.sort_by_key(|(topic, ..)| *topic);
    let pack = |bytes: &[u8]| compress_to_vec(bytes, CompressionLevel::Fastest);
    let mut packed = content.clone();
    packed.messages.iter_mut().for_each(|(_, _, payload)| *payload = pack(payload));
    let bag = tempfile::tempdir().expect("a folder");
    let in_folder = |name: &str, files: &[(&str, Vec<u8>)]| {
        let folder = bag.path().join(name);
        fs::create_dir(&folder).expect("a folder");
        for (file, bytes) in files {
            fs::write(folder.join(file), bytes).expect("a file");
        }
        let names: Vec<&str> = files.iter().map(|(file, _)| *file).collect();
        let text = metadata("sqlite3", &names, content.messages.len());
        fs::write(folder.join("metadata.yaml"), text).expect("a file");
        checked_with(&folder, &LIBRARY)
    };
    let part = |messages: &[(i64, i64, Vec<u8>)]| {
        Content { messages: messages.to_vec(), ..content.clone() }.to_bytes()
    };
    let (first, second) = content.messages.split_at(content.messages.len() / 2);
    let whole = in_folder("whole", &[("bag_0.db3", content.to_bytes())]);
    assert_eq!((whole.checked, whole.corruption.len()), (content.messages.len() as u64, 0));
    for (name, result) in [
        ("compressed", in_folder("compressed", &[("bag_0.db3.zstd", pack(&content.to_bytes()))])),
        ("split", in_folder("split", &[("bag_0.db3", part(first)), ("bag_1.db3", part(second))])),
        ("messages", in_folder("messages", &[("bag_0.db3", packed.to_bytes())])),
    ] {
        let releases = |result| serde_json::to_value(&summary(result).releases).expect("JSON");
        assert_eq!(releases(&result), releases(&whole), "{name}");
        assert_same(&result, &whole, name);
    }
    let [found] = &summary(&whole).releases[..] else { panic!("expected one release") };
    assert_eq!((found.release.as_str(), found.others.len()), ("px4@1.14", 0));
    assert_eq!(violated(&whole).iter().filter(|(rule, ..)| rule.starts_with("PX-CDR")).count(), 0);
}

/// rosbag2 stores one definition for each type, with the hash of the first topic. Other topics may lack a hash.
#[test]
fn topics_without_a_hash_have_the_definition_of_their_type() {
    let mut content = flight_of_release();
    let expected = checked_bytes(&content.to_bytes());
    content.topics.iter_mut().for_each(|(_, [.., hash])| hash.clear());
    let found = checked_bytes(&content.to_bytes());
    let facts = |result: &CaptureResult| {
        let groups = violated(result).into_iter().map(|(rule, subject, count, _)| (rule, subject, count));
        let statuses = summary(result).channels.iter().map(|channel| channel.status.clone());
        (groups.collect::<Vec<_>>(), statuses.collect::<Vec<_>>(), result.checked)
    };
    assert_eq!(facts(&found), facts(&expected));
    let is_compared = |status: &CheckStatus| matches!(status, CheckStatus::Checked(Basis::Compared(_)));
    assert!(summary(&found).channels.iter().any(|channel| is_compared(&channel.status)));
    // A definition whose text doesn't match its hash indicates neither the fields nor the release.
    for [_, _, text, _] in &mut content.definitions {
        text.insert_str(0, "uint8 added_by_the_club\n");
    }
    let (_folder, path) = file_with("bag.db3", &content.to_bytes());
    let result = checked_with(&path, &LIBRARY);
    let [found] = &summary(&result).releases[..] else { panic!("expected one release") };
    assert_eq!((found.release.as_str(), found.others.len()), ("px4@1.14", 0));
    assert_eq!(result.checked, content.messages.len() as u64);
    assert!(summary(&result).channels.iter().all(|channel| !is_compared(&channel.status)));
}

/// If there is a second definition of the same type, it is unclear which one applies to a topic without a hash.
#[test]
fn topics_without_a_hash_have_none_of_several_definitions() {
    let mut content = flight();
    for [ty, encoding, text, _] in content.definitions.clone() {
        content.definitions.push([ty, encoding, text, "RIHS01_of_another_topic".to_owned()]);
    }
    content.topics.iter_mut().for_each(|(_, [.., hash])| hash.clear());
    let result = checked_bytes(&content.to_bytes());
    assert_eq!((violated(&result), corrupt(&result)), (vec![], vec![]));
    let expected = CheckStatus::Checked(Basis::NoSchema);
    assert!(summary(&result).channels.iter().all(|channel| channel.status == expected));
}
