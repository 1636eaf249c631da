//! Tests of the different forms in which JSON messages and numbers can be written.

use serde_json::{Value, json};
use uavspec_check::Summary;
use uavspec_rules::rule;
use uavspec_test_support::Writer;

use super::{
    PERIOD, check_bare, check_bytes, corruption, glider, published, source, type_name, typed, violated,
};

#[test]
fn reads_several_forms_of_messages() {
    let (one, two) = (glider(PERIOD), glider(2 * PERIOD));
    let pretty = |value: &Value| serde_json::to_string_pretty(value).expect("JSON");
    for (text, lines) in [
        (format!("{one}\n{two}\n"), 2),
        (format!("{one}\r\n\r\n  \r\n{two}"), 4),
        (json!([one, two]).to_string(), 1),
        (format!("[\n{one},\n{two}\n]\n"), 4),
        (format!("\n {}\n{}", pretty(&one), pretty(&two)), 79),
        (format!("{}\n", pretty(&json!([one, two]))), 80),
    ] {
        let result = check_bare(&text);
        assert_eq!((violated(&result), corruption(&result)), (vec![], vec![]), "{text}");
        assert_eq!((result.records, result.checked), (2, 2), "{text}");
        if lines < 10 {
            assert_eq!(source(&result).lines, lines, "{text}");
        }
    }
    let swapped = format!(r#"{{"message":{one},"id":1,"type":"{}"}}"#, type_name());
    let mixed = [
        json!({"op": "advertise", "topic": "/fmu/out/glider", "type": "px4_msgs/msg/Glider"}).to_string(),
        published("/fmu/out/glider", &one),
        published("/fmu/out/kite", &one),
        published("/fmu/out/kite", &json!(1)),
        published("/2/fmu/out/glider", &one),
        swapped,
        format!(r#"{{"topic":"/2/fmu/out/glider","msg":{two},"op":"publish"}}"#),
    ];
    let result = check_bytes(mixed.join("\n").as_bytes());
    assert_eq!((violated(&result), corruption(&result)), (vec![], vec![]));
    assert_eq!((result.records, result.checked), (6, 4));
    let found = source(&result);
    assert_eq!((found.lines, found.types, found.skipped), (7, 1, 1));
    assert_eq!(found.undefined.iter().collect::<Vec<_>>(), ["/fmu/out/kite"]);
}

/// The type that rosbridge advertises for a topic takes precedence over the topic name.
#[test]
fn uses_the_advertised_type_of_a_topic() {
    let topics = [
        ("/any", "px4_msgs/msg/Glider", true),
        ("/glider", "px4_msgs/Glider", true),
        ("/robot/glider", "robot_msgs/msg/Wing", false),
        ("/other/glider", "", true),
        ("/other", "", false),
    ];
    let mut lines = Vec::new();
    for (topic, ty, _) in topics {
        if !ty.is_empty() {
            lines.push(json!({"op": "advertise", "topic": topic, "type": ty}).to_string());
        }
        lines.push(published(topic, &glider(PERIOD)));
    }
    lines.push(json!({"op": "subscribe", "topic": "/some"}).to_string());
    lines.push(json!({"op": "subscribe", "topic": "/more", "type": "px4_msgs/msg/Glider"}).to_string());
    lines.push(published("/more", &glider(PERIOD)));
    let result = check_bytes(lines.join("\n").as_bytes());
    assert_eq!((violated(&result), corruption(&result)), (vec![], vec![]));
    assert_eq!((result.records, result.checked), (6, 4));
    assert_eq!(source(&result).undefined.iter().collect::<Vec<_>>(), ["/other", "/robot/glider"]);
    assert_eq!(source(&result).skipped, 5);
}

/// As in MCAP, an instance number in the topic name doesn't change the type.
#[test]
fn instances_of_a_topic_have_its_type() {
    let lines: Vec<String> = ["/fmu/out/glider/1", "/glider_1", "/glider.01", "/glider_v2_0", "/glider/"]
        .iter()
        .map(|topic| published(topic, &glider(PERIOD)))
        .collect();
    let result = check_bytes(lines.join("\n").as_bytes());
    assert_eq!((violated(&result), corruption(&result)), (vec![], vec![]));
    assert_eq!((result.checked, source(&result).undefined.len()), (5, 0));
    let mut wrong = glider(PERIOD);
    wrong["speed"] = json!(61);
    let result = check_bytes(published("/fmu/out/glider/1", &wrong).as_bytes());
    assert_eq!(
        violated(&result),
        [("PX-RANGE-01", "/fmu/out/glider/1.speed: 61 is outside the range 0 to 60".to_owned())]
    );
}

#[test]
fn reads_and_names_the_dialect_of_rosbridge() {
    let mut message = glider(PERIOD);
    message["raw"] = json!("AQIDBAU=");
    let numbers = published("/glider", &{
        let mut message = message.clone();
        message["name"] = json!([68, 45, 49, 0]);
        message
    });
    message["name"] = json!("RC0xAA==");
    let result = check_bytes(format!("{numbers}\n{}\n", published("/glider", &message)).as_bytes());
    assert_eq!((violated(&result), corruption(&result), result.checked), (vec![], vec![], 2));
    let dialects: Vec<String> = source(&result).dialects.iter().map(|dialect| dialect.to_string()).collect();
    assert_eq!(dialects, ["base64 for arrays of uint8 (rosbridge)", "numbers for char[N] (ROS 2)"]);
    message["raw"] = json!("AQID");
    let result = check_bytes(published("/glider", &message).as_bytes());
    assert_eq!(violated(&result), [("PX-ARR-01", "/glider.raw: expected 5 elements, found 3".to_owned())]);
}

#[test]
fn reads_64_bit_integers_exactly() {
    let mut message = glider(u64::MAX);
    message["serial"] = json!(i64::MAX);
    let result = check_bare(&message.to_string());
    assert_eq!(violated(&result), []);
    let text = message.to_string().replace(&i64::MAX.to_string(), "9223372036854775808");
    assert_eq!(violated(&check_bare(&text)).len(), 1);
    let text = message.to_string().replace(&u64::MAX.to_string(), "18446744073709551616");
    assert_eq!(violated(&check_bare(&text)).len(), 1);
}

#[test]
fn detects_logs_by_their_magic() {
    let result = check_bytes(&Writer::with_flags().bytes);
    assert!(matches!(result.summary, Summary::Log(_)));
    assert!(matches!(check_bytes(b"").summary, Summary::Unknown(_)));
}

/// Checks messages on a topic with these timestamps. Returns the findings, and the number of compared times.
fn check_times(topic: &str, times: &[u64]) -> (Vec<(&'static str, String)>, u64) {
    let lines: Vec<String> = times.iter().map(|time| published(topic, &glider(*time))).collect();
    let result = check_bytes(lines.join("\n").as_bytes());
    assert_eq!((corruption(&result), result.checked), (vec![], times.len() as u64));
    (violated(&result), result.findings.covered(rule("PX-TIME-01").expect("a rule")))
}

#[test]
fn only_a_single_early_message_has_a_wrong_time() {
    const EPOCH: u64 = 1_700_000_000_000_000;
    let text = "/fmu/out/glider.timestamp: timestamp 50 is earlier than the previous timestamp, 60";
    let wrong = vec![("PX-TIME-01", text.to_owned())];
    assert_eq!(check_times("/fmu/out/glider", &[20, 40, 60, 50, 100]), (wrong, 4));
    // A long pause loses its influence.
    let regular = (0..200).map(|number| 7_000 + 20 * number);
    let pause: Vec<u64> = [1].into_iter().chain(regular).chain([10_970, 11_020]).collect();
    assert_eq!(check_times("/fmu/out/glider", &pause).0.len(), 1);
    for times in [
        // The clock was set back, or the autopilot restarted.
        &[20, 40, 60, 10, 30, 50][..],
        // The clock was set back by slightly more than a period: only the early message is before the latest time.
        &[20, 40, 60, 50, 70, 90],
        &[20, 40, 60, 59, 79, 99],
        // The last message doesn't show whether the clock was set back. Without a pause, neither does the next message.
        &[20, 40, 60, 50],
        &[60, 50, 100],
        // PX4 lost its synchronisation with the computer for a single message.
        &[EPOCH, EPOCH + 20, 40, EPOCH + 60],
        &[20, 0, 20],
        &[20, 20],
    ] {
        assert_eq!(check_times("/fmu/out/glider", times).0, [], "{times:?}");
    }
    // Two autopilots publish the same topic.
    assert_ne!(check_times("/fmu/out/glider", &[100, 50, 120, 70, 140, 90, 160]).0, []);
    // Several nodes may send messages to PX4, and a type may contain the messages of several instances.
    assert_eq!(check_times("/second/fmu/in/glider", &[20, 40, 60, 50, 100]), (vec![], 0));
    let lines = [20, 40, 60, 50, 100].map(|time| typed(&glider(time)));
    let result = check_bytes(lines.join("\n").as_bytes());
    assert_eq!((violated(&result), result.checked), (vec![], 5));
    assert_eq!(result.findings.covered(rule("PX-TIME-01").expect("a rule")), 0);
}

#[test]
fn only_topics_of_px4_end_with_a_version() {
    let version = |topic: &str| {
        let rules = check_times(topic, &[1, 2]).0.into_iter().map(|(rule, _)| rule);
        rules.collect::<Vec<_>>()
    };
    assert_eq!(version("/fmu/out/glider_v7"), ["PX-VER-01"]);
    assert_eq!(version("/left/glider_v7"), Vec::<&str>::new());
}
