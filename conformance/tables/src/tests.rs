//! Tests of the tables, with the reader of Parquet files.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::time::Duration;

use arrow_array::RecordBatch;
use arrow_array::cast::AsArray as _;
use arrow_array::types::{Int64Type, UInt8Type};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use tempfile::TempDir;
use uavspec_check::check_capture;
use uavspec_report::{CheckedCapture, Origin, Settings, Subject, TableFormat, Unreadable};
use uavspec_rules::definitions::Definitions;
use uavspec_rules::sample::Flight;
use uavspec_test_support::extent;

use super::column::Table;
use super::rows::{TABLES, is_of_timeline};
use super::{
    Capture, Checker, Dataset, Done, Options, captures, events, failures, findings, rules, timeline, topics,
};

/// The page of the guide that describes the tables.
const PAGE: &str = "../../xtask/site/guide/query.md";

/// Captures that violate the tested rules.
static SUBJECTS: LazyLock<Vec<Subject>> = LazyLock::new(|| {
    let definitions = Definitions::built_in();
    let flight = Flight::new(&definitions);
    let mutants = uavspec_rules::mutants().step_by(extent(1, 31));
    let subject = |(path, bytes): (String, Vec<u8>)| {
        let result = check_capture(&bytes[..], None, &definitions).expect("bytes can be read");
        let checked = CheckedCapture::new(path, result, Duration::from_millis(7));
        Subject::from_capture(checked, &definitions, &Settings::default())
    };
    mutants.flat_map(|mutant| mutant.captures(&flight)).map(subject).collect()
});

fn write<'s>(folder: &Path, subjects: impl IntoIterator<Item = &'s Subject>) {
    let mut tables = Dataset::create(folder, TableFormat::Parquet, false).expect("a new folder");
    for subject in subjects {
        tables.add(subject, &Origin { size: Some(7), etag: None }, None);
    }
    tables.finish().expect("written");
}

/// The files of a table, in order.
fn files(folder: &Path, table: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder.join(table)).expect("a folder");
    let mut files: Vec<_> = entries.map(|entry| entry.expect("an entry").path()).collect();
    files.sort();
    files
}

fn read(file: &Path) -> Vec<RecordBatch> {
    let builder =
        ParquetRecordBatchReaderBuilder::try_new(File::open(file).expect("a file")).expect("Parquet");
    builder.build().expect("a reader").map(|batch| batch.expect("a batch")).collect()
}

/// The texts of a column in all files of a table.
fn texts(folder: &Path, table: &str, column: &str) -> Vec<String> {
    let batches = files(folder, table).into_iter().flat_map(|file| read(&file));
    let values = batches.flat_map(|batch| {
        let array = batch.column_by_name(column).expect("a column").as_string::<i32>().clone();
        array.iter().map(|text| text.unwrap_or("missing").to_owned()).collect::<Vec<_>>()
    });
    values.collect()
}

#[test]
fn tables_contain_what_the_report_contains() {
    let (folder, subjects) = (TempDir::new().expect("a folder"), &*SUBJECTS);
    write(folder.path(), subjects);
    let counts = |texts: Vec<String>| {
        let mut counts = BTreeMap::new();
        for text in texts {
            *counts.entry(text).or_insert(0) += 1;
        }
        counts
    };
    let rules = subjects.iter().flat_map(|subject| &subject.findings).map(|finding| finding.rule.to_owned());
    assert_eq!(counts(texts(folder.path(), "findings", "rule")), counts(rules.collect()));
    let verdicts =
        subjects.iter().flat_map(|subject| &subject.rules).map(|rule| rule.verdict.name().to_owned());
    assert_eq!(counts(texts(folder.path(), "rules", "verdict")), counts(verdicts.collect()));
    let parts = subjects.iter().flat_map(|subject| &subject.coverage.parts).map(|part| part.name.clone());
    assert_eq!(counts(texts(folder.path(), "topics", "topic")), counts(parts.collect()));
    let paths: Vec<String> = subjects.iter().map(|subject| subject.path.clone()).collect();
    assert_eq!(texts(folder.path(), "captures", "capture"), paths);
    assert!(!folder.path().join("timeline").exists());
}

#[test]
fn parts_contain_all_rows_of_their_captures() {
    let (folder, subjects) = (TempDir::new().expect("a folder"), &*SUBJECTS);
    let many: Vec<&Subject> = subjects.iter().cycle().take(600).collect();
    write(folder.path(), many.iter().copied());
    for table in TABLES.into_iter().filter(|table| !is_of_timeline(table)) {
        assert_eq!(files(folder.path(), table).len(), 3, "{table}");
    }
    let last = texts(folder.path(), "captures", "capture");
    assert_eq!(last.len(), 600);
    let again = TempDir::new().expect("a folder");
    write(again.path(), many);
    for table in ["captures", "findings", "rules", "topics"] {
        let bytes = |folder: &Path| -> Vec<Vec<u8>> {
            files(folder, table).iter().map(|file| fs::read(file).expect("a file")).collect()
        };
        assert!(bytes(folder.path()) == bytes(again.path()), "{table} differs");
    }
}

#[test]
fn statistics_show_the_rules_of_a_row_group() {
    let (folder, subjects) = (TempDir::new().expect("a folder"), &*SUBJECTS);
    write(folder.path(), subjects.iter().cycle().take(256));
    let file = File::open(&files(folder.path(), "rules")[0]).expect("a file");
    let reader = ParquetRecordBatchReaderBuilder::try_new(file).expect("Parquet");
    assert_eq!(reader.schema().metadata()["uavspec.table"], "rules");
    let bounds = reader.metadata().row_groups().iter().map(|group| {
        let statistics = group.column(0).statistics().expect("statistics");
        [statistics.min_bytes_opt(), statistics.max_bytes_opt()].map(|bound| bound.expect("a bound").to_vec())
    });
    let bounds: Vec<[Vec<u8>; 2]> = bounds.collect();
    assert!(bounds.is_sorted() && bounds.concat().is_sorted(), "a query for a rule reads few groups");
}

#[test]
fn used_folders_stay_unchanged() {
    let folder = TempDir::new().expect("a folder");
    write(folder.path(), &[]);
    assert_eq!(texts(folder.path(), "captures", "capture"), Vec::<String>::new());
    let again = Dataset::create(folder.path(), TableFormat::Arrow, false).err().expect("an error");
    assert!(again.to_string().contains("already contains `"), "{again}");
    let other = TempDir::new().expect("a folder");
    std::fs::write(other.path().join("notes.txt"), "mine").expect("a file");
    let create = Dataset::create(other.path(), TableFormat::Arrow, false).err();
    for problem in [create, Dataset::resume(other.path(), false).err()] {
        assert_eq!(problem.expect("an error").to_string(), "the folder already contains `notes.txt`");
    }
    assert_eq!(std::fs::read_dir(other.path()).expect("a folder").count(), 1);
}

/// If two runs wrote to a folder, their parts would have the same names.
#[test]
fn only_one_run_at_a_time_writes_to_a_folder() {
    let parent = TempDir::new().expect("a folder");
    let folder = parent.path().join("tables");
    let create = || Dataset::create(&folder, TableFormat::Parquet, false);
    let first = create().expect("a new folder");
    for second in [create().err(), Dataset::resume(&folder, false).err()] {
        assert_eq!(second.expect("an error").to_string(), "another run is writing to this folder");
    }
    drop(first);
    assert!(!folder.exists(), "nothing was written");
    let (first, _) = resume(&folder);
    assert!(create().is_err() && Dataset::resume(&folder, false).is_err());
    first.finish().expect("written");
    resume(&folder);
}

#[test]
fn files_that_cannot_be_opened_are_listed() {
    let folder = TempDir::new().expect("a folder");
    let mut tables = Dataset::create(folder.path(), TableFormat::Arrow, true).expect("a new folder");
    let file = Unreadable { path: "../../gone.ulg".to_owned(), message: "no such file".to_owned() };
    tables.add_unreadable(&file);
    tables.finish().expect("written");
    let file = File::open(folder.path().join("failures/part-00000.arrow")).expect("a file");
    let reader = arrow_ipc::reader::FileReader::try_new(file, None).expect("Arrow");
    assert_eq!(reader.schema().metadata()["uavspec.tables"], "1");
    let batches: Vec<RecordBatch> = reader.map(|batch| batch.expect("a batch")).collect();
    assert_eq!(
        batches[0].column_by_name("capture").expect("a column").as_string::<i32>().value(0),
        "../../gone.ulg"
    );
    assert!(folder.path().join("timeline/part-00000.arrow").exists());
}

/// Continues the tables in a folder.
fn resume(folder: &Path) -> (Dataset, Done) {
    Dataset::resume(folder, false).expect("tables")
}

#[test]
fn a_resumed_run_continues_after_the_complete_parts() {
    let (folder, subject) = (TempDir::new().expect("a folder"), &SUBJECTS[0]);
    let (mut tables, done) = resume(folder.path());
    let origin = |number: u32| Origin { size: Some(7), etag: Some(number.to_string()) };
    assert!(!done.contains(&subject.path, &origin(0)), "a new folder has no tables");
    for number in 0..300 {
        tables.add(subject, &origin(number), None);
    }
    tables.add_unreadable(&Unreadable { path: "gone.ulg".to_owned(), message: "no such file".to_owned() });
    // If a run is killed here, one part is complete, and there may be files of the next part.
    drop(tables);
    fs::copy(&files(folder.path(), "rules")[0], folder.path().join("rules/part-00001.parquet"))
        .expect("a copy");
    let (mut tables, done) = resume(folder.path());
    let is_done: Vec<u32> =
        (0..300).filter(|number| done.contains(&subject.path, &origin(*number))).collect();
    assert_eq!(is_done, (0..256).collect::<Vec<_>>());
    assert!(!done.contains("other.ulg", &origin(0)));
    for number in 256..300 {
        tables.add(subject, &origin(number), None);
    }
    tables.finish().expect("written");
    assert_eq!(
        texts(folder.path(), "captures", "etag"),
        (0..300).map(|number| number.to_string()).collect::<Vec<_>>()
    );
    let whole = TempDir::new().expect("a folder");
    write(whole.path(), std::iter::repeat_n(subject, 300));
    for table in ["findings", "rules", "topics"] {
        assert_eq!(texts(folder.path(), table, "capture"), texts(whole.path(), table, "capture"), "{table}");
    }
}

#[test]
fn a_version_of_a_capture_is_its_etag_or_its_size() {
    let folder = TempDir::new().expect("a folder");
    write(folder.path(), [&SUBJECTS[0]]);
    let (tables, done) = resume(folder.path());
    let path = &SUBJECTS[0].path;
    let contains =
        |size, etag: Option<&str>| done.contains(path, &Origin { size, etag: etag.map(str::to_owned) });
    assert!(contains(Some(7), None));
    assert!(!contains(Some(8), None) && !contains(None, None) && !contains(Some(7), Some("7")));
    tables.finish().expect("written");
    assert_eq!(files(folder.path(), "captures").len(), 1, "a run without new captures adds no part");
}

#[test]
fn captures_without_a_version_are_checked_again() {
    let (folder, subject) = (TempDir::new().expect("a folder"), &SUBJECTS[0]);
    let (mut tables, _) = resume(folder.path());
    tables.add(subject, &Origin::default(), None);
    tables.finish().expect("written");
    let (_, done) = resume(folder.path());
    assert!(!done.contains(&subject.path, &Origin::default()));
}

#[test]
fn other_files_are_not_continued() {
    let folder = TempDir::new().expect("a folder");
    write(folder.path(), [&SUBJECTS[0]]);
    let problem =
        |has_timeline| Dataset::resume(folder.path(), has_timeline).err().expect("an error").to_string();
    assert_eq!(problem(true), "the tables have no timeline");
    let file = &files(folder.path(), "captures")[0];
    let bytes = fs::read(file).expect("a file");
    for content in [&b""[..], b"PAR1", &bytes[..bytes.len() / 2]] {
        fs::write(file, content).expect("written");
        assert!(problem(false).contains("part-00000.parquet: "), "{}", problem(false));
    }
    fs::copy(&files(folder.path(), "topics")[0], file).expect("a copy");
    assert!(problem(false).contains("there is no column `etag`"), "{}", problem(false));
}

#[test]
fn tables_of_an_engine_are_continued_if_they_are_complete() {
    let folder = TempDir::new().expect("a folder");
    write(folder.path(), [&SUBJECTS[0]]);
    for table in ["captures", "failures", "findings", "rules", "topics"] {
        let file = &files(folder.path(), table)[0];
        fs::rename(file, file.with_file_name("part-00000-c000.snappy.parquet")).expect("renamed");
    }
    let problem = Dataset::resume(folder.path(), false).err().expect("an error").to_string();
    assert!(problem.ends_with(": the engine that wrote this file did not finish"), "{problem}");
    let hidden = ["_SUCCESS", ".part-00000.crc"].map(|name| folder.path().join("captures").join(name));
    for file in &hidden {
        File::create(file).expect("a file");
    }
    let (mut tables, done) = resume(folder.path());
    let origin = Origin { size: Some(7), etag: None };
    assert!(done.contains(&SUBJECTS[0].path, &origin));
    tables.add(&SUBJECTS[0], &origin, None);
    tables.finish().expect("written");
    for file in &hidden {
        fs::remove_file(file).expect("removed");
    }
    assert_eq!(texts(folder.path(), "captures", "capture").len(), 2);
}

/// A capture of arming check requests with these ids.
fn requests(ids: &[u64]) -> Capture {
    let lines = ids.iter().map(|id| {
        format!(r#"{{"type": "px4/ArmingCheckRequest", "message": {{"timestamp": {id}, "request_id": {id}, "valid_registrations_mask": 1}}}}"#)
    });
    let bytes = lines.collect::<Vec<_>>().join("\n").into_bytes();
    Capture::Bytes { name: format!("{}.jsonl", ids.len()), bytes: bytes.into() }
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let checker = Checker::new(&Options::default()).expect("built-in definitions");
    let missing = Capture::Named("absent.ulg".to_owned());
    let captures = [requests(&[1, 2]), missing, requests(&[300]), requests(&[3; 9])];
    let check = |jobs| checker.check_all(&captures, NonZeroUsize::new(jobs)).expect("tables");
    let (one, many) = (check(1), check(4));
    for (name, batch) in one.iter() {
        assert_eq!(Some(batch), many.get(name), "{name}");
    }
    let rows = |name| one.get(name).map(RecordBatch::num_rows);
    assert_eq!([rows("captures"), rows("failures"), rows("timeline")], [Some(3), Some(1), None]);
    let single = checker.check(&captures[2]).expect("bytes");
    assert_eq!(
        single.tables.get("findings").map(RecordBatch::num_rows),
        rows("findings"),
        "the others conform"
    );
}

#[test]
fn messages_of_a_topic_are_rows() {
    let checker = Checker::new(&Options::default()).expect("built-in definitions");
    let ids: Vec<u64> = (0..70_000).map(|number| number % 256).collect();
    let messages = checker.read(&requests(&ids), "px4/ArmingCheckRequest", 0).expect("a topic");
    let found: Vec<u64> = messages
        .batches
        .iter()
        .flat_map(|batch| {
            let column = batch.column_by_name("request_id").expect("a column").clone();
            column.as_primitive::<UInt8Type>().values().iter().map(|id| u64::from(*id)).collect::<Vec<_>>()
        })
        .collect();
    assert_eq!(found, ids);
    assert_eq!(messages.batches.len(), 2, "batches are limited");
    let problem = checker.read(&requests(&[1]), "px4/ArmingCheckRequests", 0).expect_err("another name");
    assert_eq!(
        problem.to_string(),
        "1.jsonl: there is no topic `px4/ArmingCheckRequests`; did you mean `px4/ArmingCheckRequest`?"
    );
}

/// A checker with metadata for the event 7. Also returns the path of the metadata.
fn checker_of_events(folder: &TempDir, description: &str) -> (Checker, PathBuf) {
    let path = folder.path().join("kite.json");
    let json = format!(
        r#"{{"version": 2, "components": {{"0": {{"namespace": "common", "event_groups": {{"default": {{"events": {{
        "7": {{"name": "kite_landed", "message": "The kite landed at {{1:.1m/s}}", "description": "{description}",
        "arguments": [{{"name": "speed", "type": "float"}}, {{"name": "place", "type": "int8_t"}}]}}}}}}}}}}}}}}"#
    );
    fs::write(&path, json).expect("a file");
    let options = Options { events: Some(path.clone()), has_timeline: true, ..Options::default() };
    (Checker::new(&options).expect("event metadata"), path)
}

/// A capture of events with these ids. The events are numbered from 8.
fn events_with(ids: impl IntoIterator<Item = u8>) -> Capture {
    let arguments = [&[0, 0, 0xa0, 0x3f, 0xff][..], &[0; 20]].concat();
    let event = |(sequence, id)| {
        format!(
            "{{\"type\": \"px4/Event\", \"message\": {{\"timestamp\": {sequence}, \"id\": {id}, \"event_sequence\": \
             {sequence}, \"arguments\": {arguments:?}, \"log_levels\": 70}}}}"
        )
    };
    let bytes = (8..).zip(ids).map(event).collect::<Vec<_>>().join("\n").into_bytes();
    Capture::Bytes { name: "kite.jsonl".to_owned(), bytes: bytes.into() }
}

#[test]
fn the_texts_of_events_are_limited() {
    let folder = TempDir::new().expect("a folder");
    let (checker, _) = checker_of_events(&folder, &"x".repeat(4_000));
    let events = checker.explain(&events_with([7; 4_500])).expect("a timeline").events;
    assert!((4_000..4_200).contains(&events.num_rows()), "{} rows", events.num_rows());
}

#[test]
fn events_are_rows_with_their_texts() {
    let folder = TempDir::new().expect("a folder");
    let (checker, path) = checker_of_events(&folder, "On grass.");
    let capture = events_with([7, 5]);
    let tables = checker.check(&capture).expect("bytes").tables;
    let events = tables.get("events").expect("a table");
    let explained = checker.explain(&capture).expect("a timeline").events;
    assert_eq!((events.num_rows(), explained.num_rows()), (2, 2));
    let text = |column: &str| {
        let array = events.column_by_name(column).expect("a column").as_string::<i32>().clone();
        array.iter().map(|text| text.map(str::to_owned)).collect::<Vec<_>>()
    };
    // An event without a name is sorted first.
    for (column, expected) in [
        ("name", "common::kite_landed"),
        ("event_group", "default"),
        ("message", "The kite landed at 1.2 m/s"),
        ("description", "On grass."),
        ("arguments", r#"{"speed":1.25,"place":-1}"#),
    ] {
        assert_eq!(text(column), [None, Some(expected.to_owned())], "{column}");
    }
    for (column, expected) in [("level", "info"), ("log_level", "warning")] {
        assert_eq!(text(column), [Some(expected.to_owned()), Some(expected.to_owned())], "{column}");
    }
    assert_eq!(text("event_metadata")[0].as_deref(), path.to_str());
    let sequences = events.column_by_name("sequence").expect("a column").as_primitive::<Int64Type>();
    assert_eq!(sequences.values()[..], [9, 8]);
}

/// A table that describes the columns, for the guide.
fn described<R>(table: &Table<R>) -> String {
    let mut text = format!(
        "### {}\n\n{}\n\n| Column | Type | Unit | Meaning |\n|---|---|---|---|\n",
        table.name, table.description
    );
    for column in table.columns {
        let unit = column.unit.unwrap_or_default();
        let _ = writeln!(
            text,
            "| `{}` | {} | {unit} | {} |",
            column.name,
            column.type_name(),
            column.description
        );
    }
    text
}

#[test]
fn the_guide_lists_all_columns() {
    let tables = [
        described(&captures::TABLE),
        described(&events::TABLE),
        described(&failures::TABLE),
        described(&findings::TABLE),
        described(&rules::TABLE),
        described(&timeline::TABLE),
        described(&topics::TABLE),
    ];
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(PAGE);
    let page = fs::read_to_string(&path).expect("a page");
    let (before, rest) = page.split_once("<!-- columns -->\n").expect("a mark");
    let (_, after) = rest.split_once("<!-- end of the columns -->").expect("a mark");
    let expected =
        format!("{before}<!-- columns -->\n{}\n<!-- end of the columns -->{after}", tables.join("\n"));
    if std::env::var_os("UAVSPEC_UPDATE_FIXTURES").is_some() {
        fs::write(&path, &expected).expect("written");
    }
    let update = "UAVSPEC_UPDATE_FIXTURES=1 cargo test -p uavspec-tables --features arrow --lib";
    assert!(fs::read_to_string(&path).expect("a page") == expected, "run `{update}`");
}
