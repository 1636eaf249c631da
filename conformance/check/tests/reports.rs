//! Tests that the fast path for status reports and the check of all rules have the same results.

use std::sync::LazyLock;

use proptest::prelude::*;
use serde_json::{Value, json};
use uavspec_check::FlockwaveChecker;
use uavspec_rules::definitions::Definitions;
use uavspec_rules::flockwave::sample::Session;
use uavspec_rules::mutants;
use uavspec_rules::sample::Flight;
use uavspec_test_support::{extent, shared};

/// The built-in definitions.
static DEFINITIONS: LazyLock<Definitions> = LazyLock::new(Definitions::built_in);

/// The result for a recording, as text, and the number of reports on the fast path.
fn checked(mut run_check: FlockwaveChecker<'_>, recording: &[u8]) -> (String, u64) {
    let mut number = 0;
    for line in recording.split(|byte| *byte == b'\n').filter(|line| !line.is_empty()) {
        number += 1;
        run_check.line(line, number, false);
    }
    let at_once = run_check.num_known_reports();
    (format!("{:#?}", run_check.finish(recording.len() as u64)), at_once)
}

/// Asserts that both paths have the same result, and returns the number of reports on the fast path.
fn compare(recording: &[u8], definitions: &Definitions) -> u64 {
    let (quick, at_once) = checked(FlockwaveChecker::new(definitions), recording);
    let (thorough, none) = checked(FlockwaveChecker::new(definitions).thorough(), recording);
    // The first line that differs is easier to read than both texts.
    let difference = quick.lines().zip(thorough.lines()).find(|(one, other)| one != other);
    assert_eq!(difference, None, "{}", String::from_utf8_lossy(recording));
    assert_eq!((quick.len(), none), (thorough.len(), 0));
    at_once
}

#[test]
fn both_paths_find_violations() {
    assert!(compare(&Session::new().to_bytes(), &DEFINITIONS) > 0);
    let flight = Flight::new(&DEFINITIONS);
    for mutant in mutants().step_by(extent(1, 31)).filter(|mutant| mutant.rule.is_on_flockwave()) {
        let (_, bytes) = mutant.captures(&flight).pop().expect("the definitions have it");
        compare(&bytes, &DEFINITIONS);
    }
}

#[test]
fn both_paths_agree_on_recordings_of_a_real_server() {
    let Some(corpus) = shared("corpus/flockwave") else { return };
    for name in ["clean.jsonl", "main.jsonl"] {
        let recording = std::fs::read(corpus.join(name)).expect("a recording");
        let lines: Vec<&[u8]> = recording.split_inclusive(|byte| *byte == b'\n').collect();
        let parts: Vec<&[&[u8]]> = lines.chunks(50).step_by(extent(1, 6)).collect();
        let recording: Vec<u8> = parts.concat().concat();
        assert!(compare(&recording, &DEFINITIONS) > 0, "{name}");
    }
}

#[test]
fn checks_states_by_the_given_definitions() {
    let folder = tempfile::TempDir::new().expect("a folder");
    std::fs::write(folder.path().join("Glider.msg"), "uint64 timestamp # [us] Time\n").expect("a file");
    let definitions = Definitions::load(folder.path()).expect("definitions");
    assert!(compare(&Session::new().to_bytes(), &definitions) > 0);
}

/// A valid or invalid value of a status field.
fn value(field: &'static str) -> BoxedStrategy<Value> {
    let sound = match field {
        "timestamp" => (1_790_000_000_000_i64..1_790_000_009_000).prop_map(Value::from).boxed(),
        "mode" => prop::sample::select(vec!["auto", "soaring", "", "ö"]).prop_map(Value::from).boxed(),
        "position" => {
            prop::collection::vec(-900_000_000_i64..900_000_000, 2..6).prop_map(Value::from).boxed()
        }
        "velocity" => prop::collection::vec(-9_999_i64..9_999, 3).prop_map(Value::from).boxed(),
        "gps" => prop_oneof![Just(json!([3])), Just(json!([4, 12])), Just(json!([5, null, 800]))].boxed(),
        "battery" => (0_i64..200, -3_i64..101).prop_map(|(volt, percent)| json!([volt, percent])).boxed(),
        "errors" => prop::sample::select(vec![json!([]), json!([]), json!([5]), json!([64, 6])]).boxed(),
        "debug" => prop::sample::select(vec![json!(""), json!("Z2xpZGU=")]).boxed(),
        _ => (0_i64..3600).prop_map(Value::from).boxed(),
    };
    let odd = prop::sample::select(vec![
        json!(null),
        json!(-1),
        json!(-0.0),
        json!(7.0),
        json!(7.5),
        json!(u64::MAX),
        json!(true),
        json!("a\"b"),
        json!([]),
        json!([0]),
        json!([188, 188]),
        json!([[1]]),
        json!(["]"]),
        json!({ "a": 1 }),
    ]);
    prop_oneof![60 => sound, 4 => Just(json!(null)), 1 => odd].boxed()
}

const FIELDS: [&str; 11] = [
    "timestamp",
    "mode",
    "position",
    "velocity",
    "heading",
    "gps",
    "battery",
    "light",
    "errors",
    "debug",
    "flaps",
];

/// A UAV and its status. The id in the status usually equals the key.
fn state() -> impl Strategy<Value = (String, Value)> {
    let uav = prop_oneof![20 => prop::sample::select(vec!["kite", "owl", "swift", "möwe"]).prop_map(str::to_owned),
                          1 => "[a-z/\\\\\"]{0,3}", 1 => "[x]{63,70}"];
    // Some fields are omitted. `flaps` isn't a defined field.
    let fields = FIELDS.map(|field| {
        let weight = match field {
            "timestamp" => 60,
            "flaps" => 1,
            _ => 8,
        };
        prop_oneof![weight => value(field).prop_map(Some), 4 => Just(None)]
    });
    let is_itself = prop::bool::weighted(0.98);
    (uav, Vec::from(fields), is_itself, any::<bool>()).prop_map(|(uav, values, is_itself, is_turned)| {
        let mut members: Vec<(String, Value)> = FIELDS
            .iter()
            .zip(values)
            .filter_map(|(field, value)| Some(((*field).to_owned(), value?)))
            .collect();
        members.push(("id".to_owned(), if is_itself { uav.clone().into() } else { "hawk".into() }));
        if is_turned {
            members.reverse();
        }
        (uav, Value::Object(members.into_iter().collect()))
    })
}

/// A UAV and its status, in the form of other states: only the values differ.
fn regular_state() -> impl Strategy<Value = (String, Value)> {
    let fields = ["timestamp", "mode", "position", "heading", "gps", "battery", "errors", "debug"];
    let uav = prop::sample::select(vec!["kite", "owl", "swift", "möwe"]);
    (uav, Vec::from(fields.map(value))).prop_map(move |(uav, values)| {
        let mut members = serde_json::Map::from_iter([("id".to_owned(), uav.into())]);
        members.extend(fields.iter().map(|field| (*field).to_owned()).zip(values));
        (uav.to_owned(), members.into())
    })
}

/// The body of a message, a flag that is true if the server sends the message, and the id of the answered request, if
/// any.
type Content = (Value, bool, Option<&'static str>);

/// The content of a message, usually a status report.
fn content() -> impl Strategy<Value = Content> {
    let report = prop_oneof![
        prop::collection::vec(state(), 0..4).boxed(),
        prop::collection::vec(regular_state(), 0..4).boxed(),
    ];
    let report = report.prop_map(|states| {
        let status: serde_json::Map<String, Value> = states.into_iter().collect();
        (json!({ "type": "UAV-INF", "status": status }), true, None)
    });
    let request = prop::sample::select(vec![
        json!({ "type": "UAV-RTH", "ids": ["kite"] }),
        json!({ "type": "UAV-INF", "ids": ["kite", "owl"] }),
        json!({ "type": "SYS-TIME" }),
        json!({ "type": "ASYNC-CANCEL", "ids": ["rcpt-1"] }),
        json!({ "type": "UAV-LIST" }),
    ]);
    let answer = prop::sample::select(vec![
        json!({ "type": "UAV-RTH", "receipt": { "kite": "rcpt-1" } }),
        json!({ "type": "SYS-TIME", "timestamp": 1_790_000_000_500_u64 }),
        json!({ "type": "ASYNC-CANCEL", "success": ["rcpt-1"] }),
        json!({ "type": "UAV-LIST", "ids": ["kite", "owl"] }),
        json!({ "type": "UAV-INF", "status": { "kite": { "id": "kite", "timestamp": 1_790_000_003_000_u64 } } }),
    ]);
    let notice = prop::sample::select(vec![
        json!({ "type": "OBJ-DEL", "ids": ["owl"] }),
        json!({ "type": "ASYNC-ST", "id": "rcpt-1", "progress": {} }),
        json!({ "type": "ASYNC-RESP", "id": "rcpt-1", "result": true }),
        json!({ "type": "SYS-CLOSE" }),
        json!({ "type": "CONN-INF", "status": {} }),
    ]);
    let refs = prop::sample::select(vec!["ask-1", "ask-2", "say-3"]);
    prop_oneof![
        20 => report,
        2 => request.prop_map(|body| (body, false, None)),
        2 => (answer, refs).prop_map(|(body, refs)| (body, true, Some(refs))),
        2 => notice.prop_map(|body| (body, true, None)),
    ]
}

/// The form of a line: member order, white space, connection, and time.
#[derive(Clone, Debug)]
struct Style {
    is_type_first: bool,
    is_body_first: bool,
    is_wide: bool,
    connection: &'static str,
    after: f64,
    /// The id; `None` for the next number.
    id: Option<String>,
    version: &'static str,
    event: Option<&'static str>,
    corruption: Option<(prop::sample::Index, u8)>,
}

fn style() -> impl Strategy<Value = Style> {
    let connection =
        prop::sample::select(vec!["tcp#1", "tcp#1", "tcp#1", "tcp#2", "udp#1", "http", "tcp \"3\""]);
    let after = prop_oneof![20 => 0.0..0.2, 1 => 5.0..25.0, 1 => -2.0..0.0];
    let id = prop_oneof![20 => Just(None), 1 => prop::sample::select(vec!["ask-1", "say-3", "", "a\nb"])
        .prop_map(|id| Some(id.to_owned())), 1 => "[xä]{30,40}".prop_map(Some)];
    let version = prop_oneof![20 => Just("1.0"), 1 => Just("2"), 1 => Just("first")];
    let event = prop_oneof![40 => Just(None), 1 => Just(Some("connect")), 1 => Just(Some("closed"))];
    let corruption =
        (any::<prop::sample::Index>(), prop::sample::select(b"\"\\{}[],:0-.eE \x07\xffaN".to_vec()));
    let corruption = prop_oneof![20 => Just(None), 1 => corruption.prop_map(Some)];
    (any::<[bool; 3]>(), connection, after, id, version, event, corruption).prop_map(
        |([is_type_first, is_body_first, is_wide], connection, after, id, version, event, corruption)| {
            Style { is_type_first, is_body_first, is_wide, connection, after, id, version, event, corruption }
        },
    )
}

/// The start of a recording. The server sends its time, so that later status timestamps can be compared, and starts an
/// operation that is cancelled later.
fn beginning() -> Vec<u8> {
    let requested = [
        (json!({ "type": "SYS-TIME" }), json!({ "type": "SYS-TIME", "timestamp": 1_790_000_000_000_u64 })),
        (
            json!({ "type": "UAV-RTH", "ids": ["kite"] }),
            json!({ "type": "UAV-RTH", "receipt": { "kite": "rcpt-1" } }),
        ),
        (
            json!({ "type": "ASYNC-CANCEL", "ids": ["rcpt-1"] }),
            json!({ "type": "ASYNC-CANCEL", "success": ["rcpt-1"] }),
        ),
    ];
    let line = |direction: &str, key: &str, value: Value| {
        let mut line = json!({ "t": 1_790_000_000.0, "conn": "tcp#1", "dir": direction });
        line[key] = value;
        format!("{line}\n")
    };
    let mut text = line("event", "event", "connect".into());
    for (number, (request, answer)) in requested.into_iter().enumerate() {
        let (ask, say) = (format!("first-{number}"), format!("then-{number}"));
        text += &line("out", "msg", json!({ "$fw.version": "1.0", "id": ask, "body": request }));
        text += &line("in", "msg", json!({ "$fw.version": "1.0", "id": say, "refs": ask, "body": answer }));
    }
    text.into_bytes()
}

/// A recording with these lines.
fn recording(lines: Vec<(Content, Style)>) -> Vec<u8> {
    let mut recording = beginning();
    let mut time = 1_790_000_000.0;
    for (number, ((mut body, is_from_server, refs), style)) in lines.into_iter().enumerate() {
        time += style.after;
        if let Some(event) = style.event {
            let line = json!({ "t": time, "conn": style.connection, "dir": "event", "event": event });
            recording.extend(format!("{line}\n").into_bytes());
            continue;
        }
        if !style.is_type_first
            && let Some(body) = body.as_object_mut()
            && let Some(kind) = body.shift_remove("type")
        {
            body.insert("type".to_owned(), kind);
        }
        let id =
            style.id.unwrap_or_else(|| format!("{}-{number}", if is_from_server { "say" } else { "ask" }));
        let mut message = json!({ "$fw.version": style.version });
        if style.is_body_first {
            message["body"] = body;
            message["id"] = id.into();
        } else {
            message["id"] = id.into();
            message["body"] = body;
        }
        if let Some(refs) = refs {
            message["refs"] = refs.into();
        }
        let direction = if is_from_server { "in" } else { "out" };
        let line = json!({ "t": time, "conn": style.connection, "dir": direction, "msg": message });
        let mut line = line.to_string().into_bytes();
        if style.is_wide {
            line = String::from_utf8_lossy(&line).replace("\":", "\": ").replace(",\"", ", \"").into_bytes();
        }
        if let Some((at, byte)) = style.corruption {
            let at = at.index(line.len());
            line[at] = byte;
        }
        recording.extend(line);
        recording.push(b'\n');
    }
    recording
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(extent(256, 16)))]

    #[test]
    fn both_paths_agree_on_random_recordings(lines in prop::collection::vec((content(), style()), 1..40)) {
        compare(&recording(lines), &DEFINITIONS);
    }
}

/// `serde_json` can't represent duplicate keys.
#[test]
fn finds_duplicate_members() {
    let definitions = Definitions::built_in();
    let line = |message: &str| format!(r#"{{"t":1790000000,"conn":"tcp#1","dir":"in","msg":{message}}}"#);
    let state = r#"{"id":"kite","timestamp":1790000000000}"#;
    let report = |states: &str| {
        line(&format!(
            r#"{{"$fw.version":"1.0","id":"say-1","body":{{"type":"UAV-INF","status":{{{states}}}}}}}"#
        ))
    };
    let twice = r#""kite":{"id":"kite","id":"kite","timestamp":1790000000000}"#;
    assert_eq!(compare(report(&format!(r#""kite":{state}"#)).as_bytes(), &definitions), 1);
    assert_eq!(compare(report("").as_bytes(), &definitions), 1);
    assert_eq!(compare(report(twice).as_bytes(), &definitions), 0);
    assert_eq!(compare(report(&format!(r#""kite":{state},"kite":{state}"#)).as_bytes(), &definitions), 0);
    let doubled = line(
        r#"{"$fw.version":"1.0","$fw.version":"1.0","id":"say-1","body":{"type":"UAV-INF","status":{}}}"#,
    );
    assert_eq!(compare(doubled.as_bytes(), &definitions), 0);
    // Together, both values have every key once.
    let body = r#""body":{"type":"UAV-INF","status":{}}"#;
    let bodies = r#""body":{"type":"UAV-INF"},"body":{"status":{}}"#;
    let messages = format!(r#"{{"$fw.version":"1.0","id":"say-1"}},"msg":{{{body}}}"#);
    let whole = format!(r#"{{"$fw.version":"1.0","id":"say-1",{body}}}"#);
    for message in [
        format!(r#"{{"$fw.version":"1.0","id":"say-1",{bodies}}}"#),
        format!(r#"{{"$fw.version":"1.0","id":"say-1","body":{{}},{body}}}"#),
        format!(r#"{{}},"msg":{whole}"#),
        messages,
    ] {
        assert_eq!(compare(line(&message).as_bytes(), &definitions), 0, "{message}");
    }
    assert_eq!(compare(format!("{} 7", report("")).as_bytes(), &definitions), 0);
}

/// Both paths count findings that concern a whole message, and report a UAV even if its first line can't be read.
#[test]
fn both_paths_agree_on_findings_of_a_message() {
    let definitions = Definitions::built_in();
    let line = |number: usize, connection: &str, uavs: &[&str], errors: &str| {
        let state =
            |uav: &&str| format!(r#""{uav}":{{"id":"{uav}","timestamp":1790000000000,"errors":{errors}}}"#);
        let states = uavs.iter().map(state).collect::<Vec<_>>().join(",");
        format!(
            r#"{{"t":1790000000.{number},"conn":"{connection}","dir":"in","msg":{{"$fw.version":"1.0","id":"say-{number}","body":{{"type":"UAV-INF","status":{{{states}}}}}}}}}"#
        ) + "\n"
    };
    for errors in ["[NaN]", r#"[{"a":1,"a":2}]"#, "[0]"] {
        let lines = (0..8).map(|number| line(number, "tcp#1", &["kite", "owl"], errors));
        compare(lines.collect::<String>().as_bytes(), &definitions);
    }
    let mut text: String = (0..3).map(|number| line(number, "tcp#1", &["kite"], "[0]")).collect();
    text += &line(3, &"x".repeat(200), &["owl"], "[0]");
    text += &line(4, "tcp#1", &["owl"], "[0]");
    compare(text.as_bytes(), &definitions);
}

/// Statuses are still checked if there are more kinds of states than can be stored.
#[test]
fn both_paths_agree_on_any_number_of_kinds() {
    let definitions = Definitions::built_in();
    let mut text = String::new();
    for code in 1..=600 {
        let status = json!({ "kite": { "id": "kite", "timestamp": 1_790_000_000_000_u64, "errors": [code % 300 + 1] } });
        let body = json!({ "type": "UAV-INF", "status": status });
        let message =
            json!({ "$fw.version": format!("1.{}", code / 2), "id": format!("say-{code}"), "body": body });
        let line = json!({ "t": 1_790_000_000.5, "conn": "tcp#1", "dir": "in", "msg": message });
        text.extend([line.to_string().as_str(), "\n"]);
    }
    assert!(compare(text.as_bytes(), &definitions) > 0);
}

/// User-defined definitions may allow values that the rules examine, such as numbers that aren't integers.
#[test]
fn both_paths_agree_on_other_definitions() {
    let folder = tempfile::TempDir::new().expect("a folder");
    let configuration = "[[package]]\nname = \"flockwave\"\ndialect = \"table\"\ninclude = [\"*.md\"]\n";
    std::fs::write(folder.path().join("uavspec.toml"), configuration).expect("a file");
    for page in uavspec_definitions::FLOCKWAVE.files() {
        let mut text = page.contents_utf8().expect("a page").to_owned();
        for (before, after) in [
            ("| 1 | `east` | yes | integer |", "| 1 | `east` | yes | number |"),
            ("| `velocityXYZ` | no | VelocityXYZ |", "| `velocityXYZ` | no | list of integer |"),
            ("| `debug` | no | Base64 |", "| `debug` | no | any |"),
        ] {
            let is_changed = page.path().ends_with("types.md");
            assert_eq!(text.contains(before), is_changed);
            text = text.replace(before, after);
        }
        std::fs::write(folder.path().join(page.path()), text).expect("a file");
    }
    let definitions = Definitions::load(folder.path()).expect("definitions");
    for (common, rare) in [
        (r#""velocity":[0,0,0]"#, r#""velocity":[0,-20000000,0]"#),
        (r#""velocityXYZ":[0,0,0]"#, r#""velocityXYZ":[0,-20000000,0]"#),
        (r#""debug":1"#, r#""debug":NaN"#),
    ] {
        for (first, second) in [(common, rare), (rare, common)] {
            let report = |number: usize, value: &str| {
                format!(
                    r#"{{"t":1790000000.{number},"conn":"tcp#1","dir":"in","msg":{{"$fw.version":"1.0","id":"say-{number}","body":{{"type":"UAV-INF","status":{{"kite":{{"id":"kite","timestamp":1790000000000,{value}}}}}}}}}}}"#
                ) + "\n"
            };
            let lines = (0..9).map(|number| report(number, if number < 5 { first } else { second }));
            let (found, _) =
                checked(FlockwaveChecker::new(&definitions), lines.clone().collect::<String>().as_bytes());
            assert!(found.contains("FW-VAL-01") || found.contains("FW-ENV-23"), "{first} {second}");
            compare(lines.collect::<String>().as_bytes(), &definitions);
        }
    }
}
