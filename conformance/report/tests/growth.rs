//! Tests that allocations grow linearly with each dimension of each kind of input.

use std::sync::LazyLock;
use std::time::Duration;

use allocation_counter::measure;
use clap::ValueEnum as _;
use serde_json::json;
use uavspec_check::baseline::{finding_name, is_rule, rule_ids};
use uavspec_check::timeline::{Texts, Timeline};
use uavspec_check::{CaptureResult, check_bytes, check_capture};
use uavspec_lint::baseline::{Lists, Name, Outcome, Scope};
use uavspec_report::timeline::{to_html, to_json, to_text};
use uavspec_report::{Action, CheckedCapture, Kind, Report, Settings, Subject};
use uavspec_rules::definitions::{Definitions, Library};
use uavspec_rules::flockwave::sample::Session;
use uavspec_rules::px4;
use uavspec_schema::Date;
use uavspec_schema::translation::Translations;
use uavspec_test_captures::mcap::{Form, channel, chunk, file, message, record, schema, text};
use uavspec_test_support::{Writer, extent};

static DEFINITIONS: LazyLock<Definitions> = LazyLock::new(Definitions::built_in);

static LIBRARY: LazyLock<Library> = LazyLock::new(Library::built_in);

/// A kind of input that grows in one dimension: its name, the number of parts, and a function that returns the bytes
/// for any number of parts.
type Dimension = (&'static str, usize, fn(usize) -> Vec<u8>);

const CAPTURES: &[Dimension] = &[
    ("subscriptions without a format", 200, |count| {
        log(count, |log, id| {
            log.subscribe(id, 0, &format!("wind_{id:05}"));
            log.data(id, &[0; 16]);
        })
    }),
    ("formats", 200, |count| {
        log(count, |log, id| _ = log.format(&format!("wind_{id:05}:uint64_t timestamp;")))
    }),
    ("fields of a format", 200, |count| {
        let fields = numbered(count, "float speed_~;");
        log(1, |log, id| {
            log.format(&format!("wind:uint64_t timestamp;{fields}"));
            log.subscribe(id, 0, "wind");
            log.data(id, &vec![0; 8 + 4 * count]);
        })
    }),
    ("nested formats", 100, |count| {
        log(count, |log, id| {
            let inner = if id == 0 { "uint64_t".to_owned() } else { format!("wind_{:05}", id - 1) };
            log.format(&format!("wind_{id:05}:{inner} timestamp;"));
        })
    }),
    ("formats that are declared again", 200, |count| {
        log(count, |log, id| _ = log.format(&format!("wind:uint64_t timestamp;float speed_{id:05};")))
    }),
    ("topics", 200, |count| {
        let mut log = Writer {
            bytes: log(count, |log, id| _ = log.format(&format!("wind_{id:05}:uint64_t timestamp;"))),
        };
        let id = |number: usize| u16::try_from(number).expect("an id");
        (0..count).for_each(|number| _ = log.subscribe(id(number), 0, &format!("wind_{number:05}")));
        (0..count).for_each(|number| _ = log.data(id(number), &[1; 8]));
        log.bytes
    }),
    ("instances of a topic", 100, |count| {
        log(count, |log, id| {
            log.format("vehicle_attitude:uint64_t timestamp;float[4] q;");
            log.subscribe(id, u8::try_from(id).expect("an instance"), "vehicle_attitude");
            log.data(id, &[1; 24]);
            log.data(id, &[0; 24]);
        })
    }),
    ("dropouts", 200, |count| log(count, |log, id| _ = log.dropout(id))),
    ("corrupt parts", 200, |count| {
        log(count, |log, _| {
            log.bytes.extend([0xff; 50]);
            log.sync();
        })
    }),
    ("parameters", 200, |count| {
        log(count, |log, id| _ = log.entry(b'P', &[], &format!("int32_t WIND_{id:05}"), &[0; 4]))
    }),
    ("information", 200, |count| {
        log(count, |log, id| {
            log.entry(b'I', &[], &format!("char[4] wind_{id:05}"), b"calm");
            log.entry(b'M', &[1], &format!("char[4] gust_{id:05}"), b"calm");
            log.line(format!("wind {id}").as_bytes());
        })
    }),
    ("channels", 200, |count| {
        let schema = schema(1, "px4_msgs/msg/Wind", "ros2msg", b"float32 speed\n");
        file(&each(count, schema, |id| {
            [channel(id, 1, &format!("/wind_{id:05}"), "cdr", &[]), message(id, &[0; 8])].concat()
        }))
    }),
    ("schemas", 200, |count| {
        file(&each(count, Vec::new(), |id| {
            let schema = schema(id, &format!("px4_msgs/msg/Wind{id:05}"), "ros2msg", b"float32 speed\n");
            [schema, channel(id, id, "/wind", "cdr", &[]), message(id, &[0; 8])].concat()
        }))
    }),
    ("fields of a schema", 200, |count| {
        let schema =
            schema(1, "px4_msgs/msg/Wind", "ros2msg", numbered(count, "float32 speed_~\n").as_bytes());
        file(&[schema, channel(1, 1, "/wind", "cdr", &[]), message(1, &vec![0; 4 + 4 * count])].concat())
    }),
    ("chunks", 200, |count| {
        let first = chunk(Form::Plain, &channel(1, 0, "/wind", "json", &[]));
        file(&each(count, first, |_| chunk(Form::Plain, &message(1, b"{}"))))
    }),
    ("attachments", 200, |count| {
        file(&each(count, Vec::new(), |id| {
            let name = text(format!("wind_{id:05}").as_bytes());
            record(9, &[&[0; 16], &name, &text(b"text/plain"), &4_u64.to_le_bytes(), b"calm", &[0; 4]])
        }))
    }),
    ("metadata", 200, |count| {
        file(&each(count, Vec::new(), |id| {
            record(12, &[&text(format!("wind_{id:05}").as_bytes()), &text(b"")])
        }))
    }),
    ("topics in a table", 100, |count| {
        let number = |id: i64| {
            (
                id,
                [
                    format!("/wind_{id:05}"),
                    format!("px4_msgs/msg/Wind{id:05}"),
                    "cdr".to_owned(),
                    String::new(),
                ],
            )
        };
        let ids = 1..=i64::try_from(count).expect("a number");
        let content = uavspec_test_captures::rosbag::Content {
            topics: ids.clone().map(number).collect(),
            messages: ids.map(|id| (id, id, vec![0, 1, 0, 0, 0, 0, 0, 0])).collect(),
            ..Default::default()
        };
        content.to_bytes()
    }),
    ("types of JSON messages", 200, |count| {
        lines(count, "{\"type\":\"px4/Wind~\",\"message\":{\"speed\":1}}")
    }),
    ("JSON messages", 200, |count| {
        lines(count, "{\"type\":\"px4/Event\",\"message\":{\"timestamp\":1~,\"id\":-1}}")
    }),
    ("fields of a JSON message", 200, |count| {
        let fields = numbered(count, "\"wind_~\":1,");
        format!("{{\"type\":\"px4/Event\",\"message\":{{{fields}\"timestamp\":1}}}}\n").into_bytes()
    }),
    ("nested values", 40, |count| {
        let (open, close) = ("{\"wind\":[".repeat(count), "]}".repeat(count));
        format!("{{\"type\":\"px4/Event\",\"message\":{{\"id\":{open}{close}}}}}\n").into_bytes()
    }),
    ("JSON lines that can't be read", 200, |count| lines(count, "{\"type\":\"px4/Wind~\",")),
    ("messages of a session", 100, |count| {
        session(count, |session, _| {
            session.exchange(json!({ "type": "UAV-LIST" }), json!({ "ids": ["kite"] }));
        })
    }),
    ("requests in flight", 100, |count| {
        let mut ids = Vec::new();
        let mut session = Session::opened();
        for _ in 0..count {
            ids.push(session.sends(json!({ "type": "UAV-LIST" })));
        }
        for id in ids.iter().rev() {
            session.answers(id, json!({ "body": { "type": "UAV-LIST", "ids": ["kite"] } }));
        }
        session.to_bytes()
    }),
    ("requests without a response", 100, |count| {
        session(count, |session, _| _ = session.sends(json!({ "type": "UAV-LIST" })))
    }),
    ("operations of a request", 100, |count| {
        let ids: Vec<String> = (0..count).map(|id| format!("kite-{id:05}")).collect();
        let receipts: serde_json::Map<_, _> =
            ids.iter().map(|id| (id.clone(), format!("to-{id}").into())).collect();
        let mut session = Session::opened();
        session.exchange(json!({ "type": "UAV-LAND", "ids": ids }), json!({ "receipt": receipts }));
        session.to_bytes()
    }),
    ("UAVs of a report", 100, |count| {
        let status: serde_json::Map<_, _> = (0..count)
            .map(|id| (format!("kite-{id:05}"), json!({ "id": format!("kite-{id:05}"), "wind": 1 })))
            .collect();
        let mut session = Session::opened();
        session.notify(json!({ "type": "UAV-INF", "status": status }));
        session.to_bytes()
    }),
    ("types of a session", 100, |count| {
        session(count, |session, id| session.notify(json!({ "type": format!("WIND-{id:05}") })))
    }),
    ("findings of a session", 100, |count| {
        session(count, |session, id| {
            let list = json!({ "type": "UAV-LIST", "ids": ["kite"], (format!("wind_{id:05}")): 1 });
            session.exchange(json!({ "type": "UAV-LIST" }), list);
        })
    }),
    ("nested values of a session", 20, |count| {
        session(1, |session, _| {
            let body = (0..count).fold(json!(1), |inner, _| json!({ "wind": [inner] }));
            session.notify(json!({ "type": "UAV-INF", "status": body }));
        })
    }),
];

/// A log that consists of `count` parts.
fn log(count: usize, mut add: impl FnMut(&mut Writer, u16)) -> Vec<u8> {
    let mut log = Writer::with_flags();
    (0..count).for_each(|id| add(&mut log, u16::try_from(id).expect("an id")));
    log.bytes
}

/// Bytes that consist of `first` and `count` parts.
fn each(count: usize, first: Vec<u8>, mut part: impl FnMut(u16) -> Vec<u8>) -> Vec<u8> {
    (1..=count).fold(first, |mut all, id| {
        all.extend(part(u16::try_from(id).expect("an id")));
        all
    })
}

fn session(count: usize, mut add: impl FnMut(&mut Session, usize)) -> Vec<u8> {
    let mut session = Session::opened();
    (0..count).for_each(|id| add(&mut session, id));
    session.to_bytes()
}

/// `count` copies of a text, in which a five-digit number replaces `~`.
fn numbered(count: usize, text: &str) -> String {
    (0..count).map(|number| text.replace('~', &format!("{number:05}"))).collect()
}

fn lines(count: usize, line: &str) -> Vec<u8> {
    numbered(count, &format!("{line}\n")).into_bytes()
}

/// Reads an input.
type Work = fn(&[u8]);

/// The functions of the program that use a capture.
const WORK: &[(&str, Work)] = &[
    ("check", |bytes| _ = checked(bytes)),
    ("choose a release", |bytes| _ = check_bytes(bytes, &LIBRARY)),
    ("report", |bytes| {
        let capture = CheckedCapture::new("capture".to_owned(), checked(bytes), Duration::ZERO);
        let subject = Subject::from_capture(capture, &DEFINITIONS, &Settings::default());
        let report = Report::new(
            Action::Check,
            String::new(),
            &DEFINITIONS.name,
            vec![subject],
            Vec::new(),
            Vec::new(),
        );
        for kind in Kind::value_variants() {
            report.to_text(*kind);
        }
    }),
    ("timeline", |bytes| {
        let texts = Texts::of(Translations::default());
        if let Ok(timeline) = Timeline::of_bytes(bytes, &DEFINITIONS, &texts) {
            let _ = (to_text(&timeline, "en"), to_html(&timeline, "en", "uavspec"), to_json(&timeline));
        }
    }),
];

fn checked(bytes: &[u8]) -> CaptureResult {
    check_capture(bytes, None, &DEFINITIONS).expect("bytes can be read")
}

/// Other inputs, each with the function that reads it.
const INPUTS: &[(Dimension, Work)] = &[
    (("files of a bag", 200, |count| metadata(count, 1)), read_metadata),
    (("topics of a bag", 200, |count| metadata(1, count)), read_metadata),
    (
        ("entries of a baseline", 100, |count| {
            lines(count, "[[known]]\nrule = \"PX-DATA-01\"\nsubject = \"wind_~.speed\"\nreason = \"old\"")
        }),
        |bytes| {
            let rule = &px4::DATA_01.rule;
            let subjects: Vec<String> =
                (0..entries(bytes)).map(|number| format!("wind_{number:05}.speed")).collect();
            let names = subjects.iter().map(|subject| finding_name(rule, subject.into(), "a.ulg"));
            compare_baseline(bytes, &is_rule, names);
        },
    ),
    (
        ("cases of a baseline", 100, |count| lines(count, "[[known]]\ncase = \"wind/~\"\nreason = \"old\"")),
        |bytes| {
            let cases: Vec<String> = (0..entries(bytes)).map(|number| format!("wind/{number:05}")).collect();
            compare_baseline(bytes, &|rule| rule.is_none(), cases.iter().map(|case| Name::case(case)));
        },
    ),
    (("mistakes of a baseline", 100, |count| lines(count, "[[known]]\ncase = \"[~\"")), |bytes| {
        let error =
            Lists::parse([("known.toml".to_owned(), bytes.to_vec())], &rule_ids()).expect_err("mistakes");
        assert!(!error.to_string().is_empty());
    }),
    #[cfg(feature = "schemas")]
    (("files of schemas", 20, |count| lines(count, "{\"required\":[\"wind_~\"]}")), |bytes| {
        let text = String::from_utf8_lossy(bytes);
        load_schemas(
            text.lines().enumerate().map(|(number, text)| (format!("SOAR-{number}.json"), text.to_owned())),
        );
    }),
];

fn metadata(files: usize, topics: usize) -> Vec<u8> {
    let files = numbered(files, "    - wind_~.db3\n");
    let topic = "    - topic_metadata:\n        name: /wind_~\n        serialization_format: cdr\n      message_count: 1\n";
    let topics = numbered(topics, topic);
    format!("rosbag2_bagfile_information:\n  storage_identifier: sqlite3\n  relative_file_paths:\n{files}  topics_with_message_count:\n{topics}")
        .into_bytes()
}

fn read_metadata(bytes: &[u8]) {
    let metadata = uavspec_capture::rosbag::metadata::Metadata::parse(bytes).expect("metadata");
    assert!(!metadata.files.is_empty() && !metadata.encodings.is_empty());
}

fn entries(bytes: &[u8]) -> usize {
    String::from_utf8_lossy(bytes).matches("[[known]]").count()
}

/// Compares a baseline with failures, removes outdated entries, and compares it again.
fn compare_baseline<'n>(bytes: &[u8], scope: Scope<'_>, names: impl Iterator<Item = Name<'n>>) {
    let lists = Lists::parse([("known.toml".to_owned(), bytes.to_vec())], &rule_ids()).expect("a list");
    let failed = |name| (name, Outcome::Failed(vec!["calm".to_owned()]));
    let results: Vec<(Name<'_>, Outcome)> = names.map(failed).collect();
    for (name, _) in &results {
        lists.find(name, &["calm".to_owned()]);
    }
    let stale = lists.find_stale(scope, &results, Date { year: 2026, month: 5, day: 9 });
    lists.updated(&stale).expect("a list");
}

#[cfg(feature = "schemas")]
fn load_schemas(files: impl Iterator<Item = (String, String)>) {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).expect("a file");
    }
    uavspec_flockwave::body_schema::Schemas::load(&[folder.path().to_owned()], DEFINITIONS.defined_schemas())
        .expect("schemas");
}

#[test]
fn allocations_grow_linearly_with_each_dimension() {
    let mut failures = Vec::new();
    let mut compare = |name: &str, work: &str, count: usize, input: fn(usize) -> Vec<u8>, run: Work| {
        // The first run also initializes everything that is created lazily.
        run(&input(2));
        let [once, twice] = [count, 2 * count].map(|count| {
            let bytes = input(count);
            measure(|| run(&bytes))
        });
        let pairs = [("all", once.bytes_total, twice.bytes_total), ("most", once.bytes_max, twice.bytes_max)];
        for (what, once, twice) in pairs {
            if 10 * twice > 22 * once {
                failures.push(format!(
                    "{work}, twice the {name}: {once} and {twice} bytes of {what} allocations"
                ));
            }
        }
    };
    let captures = CAPTURES.iter().flat_map(|dimension| WORK.iter().map(move |work| (dimension, *work)));
    let inputs = INPUTS.iter().map(|(dimension, run)| (dimension, ("read", *run)));
    // Even the larger step of quick mode includes each kind of work.
    for ((name, count, input), (work, run)) in captures.chain(inputs).step_by(extent(1, 41)) {
        compare(name, work, *count, *input, run);
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
