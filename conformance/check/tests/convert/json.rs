//! Tests of conversions of JSON messages.

use uavspec_check::Summary;
use uavspec_check::convert::{Action, ConversionReport, Error, Settings};
use uavspec_rules::sample::Encoding;
use uavspec_test_support::extent;

use super::{checked_against, release, sample, short_flight, try_converted};

/// Converts messages of a release.
fn converted(bytes: &[u8], from: &str, to: &str) -> (ConversionReport, String) {
    let (report, output) =
        try_converted(bytes, release(from), to, Settings::default()).expect("a conversion");
    (report, String::from_utf8(output).expect("UTF-8"))
}

/// A typical message of a release, as JSON.
fn message(from: &str, name: &str) -> String {
    let flight = short_flight(from);
    let topic = flight.topic(name).expect("a message");
    flight.messages.iter().find(|sent| sent.topic == topic).expect("a message").value.to_string()
}

/// A line with a typical message.
fn line(from: &str, name: &str) -> String {
    format!(r#"{{"type": "px4/{name}", "message": {}}}"#, message(from, name))
}

#[test]
fn converted_lines_agree_with_the_target_release() {
    let pairs = [("1.16", "1.17"), ("1.17", "1.16"), ("1.13", "1.18"), ("main", "1.14")];
    for (from, to) in pairs.into_iter().step_by(extent(1, 2)) {
        let (from, to) = (format!("px4@{from}"), format!("px4@{to}"));
        let (flight, target) = (sample(&from), release(&to));
        for encoding in [Encoding::Lines, Encoding::Rosbridge] {
            let bytes = encoding.write(&flight).expect("an encoding");
            // The keys of the messages indicate the release.
            let (report, output) = super::converted(&bytes, &to, Settings::default());
            assert_eq!(report.from, [from.as_str()]);
            assert!(report.is_complete(), "{:?}", report.problems);
            assert!(report.count(Action::Converted) > extent(100, 15) && report.count(Action::Copied) == 0);
            let left_out = report.topics.iter().filter(|topic| topic.action == Action::LeftOut);
            let left_out: u64 = left_out.map(|topic| topic.messages).sum();
            let found = checked_against(&output, target).result;
            assert_eq!(found.records, flight.messages.len() as u64 - left_out);
            let Summary::Json(summary) = &found.summary else { panic!("JSON") };
            // A topic keeps its name if several topics of the target replace it.
            let unknown = summary.undefined.len();
            assert!(
                unknown <= 5 && (unknown == 0 || encoding == Encoding::Rosbridge),
                "{:?}",
                summary.undefined
            );
            assert_eq!(
                (found.corruption.len(), found.checked),
                (0, found.records - 2 * unknown as u64),
                "{from} {to}"
            );
            // A value that is valid only in the source release is copied unchanged.
            let is_form = |id: &&str| !["PX-ENUM-01", "PX-RANGE-01"].contains(id);
            let wrong: Vec<&str> =
                found.findings.groups().map(|group| group.rule.id).filter(is_form).collect();
            assert_eq!(wrong, Vec::<&str>::new(), "{from} {to} {encoding:?}");
        }
    }
}

#[test]
fn messages_of_the_target_release_stay_the_same() {
    let mut flight = short_flight("px4@1.16").clone();
    flight.messages.truncate(flight.topics.len());
    for encoding in [Encoding::Lines, Encoding::Rosbridge] {
        let bytes = encoding.write(&flight).expect("an encoding");
        let (_, output) = converted(&bytes, "px4@1.16", "px4@1.16");
        assert!(output.as_bytes() == bytes);
    }
}

#[test]
fn other_members_and_other_lines_stay_the_same() {
    let (old, new) = (message("px4@1.17", "AirspeedValidated"), "\"calibrated_airspeed_m_s\"");
    assert!(old.contains("calibraded_airspeed_synth_m_s") && old.contains(new));
    let around =
        [r#"{ "t":1.50, "type":"px4_msgs/msg/AirspeedValidated" ,"message": "#, r#" , "e":[1e3,"\u0041"]}"#];
    let other = r#"{"type": "club/Winch", "message": {"id":7.0}}"#;
    let imu = r#"{"message": {"x": NaN }, "type": "sensor_msgs/msg/Imu"}"#;
    let status = r#"{"op":"status", "level":"info"}"#;
    let text = format!("{}{old}{}\n{other}\n{imu}\n{status}\n", around[0], around[1]);
    let (report, output) = converted(text.as_bytes(), "px4@1.17", "px4@1.16");
    assert!(report.is_complete());
    let lines: Vec<&str> = output.lines().collect();
    let message = lines[0].strip_prefix(around[0]).and_then(|rest| rest.strip_suffix(around[1]));
    let message = message.expect("the same members");
    assert!(message.contains(new) && !message.contains("calibraded_airspeed_synth_m_s"), "{message}");
    assert_eq!(lines[1..], [other, imu, status]);
    let losses: Vec<_> = report.topics.iter().flat_map(|topic| &topic.losses).collect();
    assert!(losses.iter().any(|loss| loss.messages == Some(1)), "{losses:?}");
}

/// The fields of these messages are unknown.
#[test]
fn types_that_only_the_target_defines_are_left_out() {
    let line = line("px4@1.17", "BatteryInfo");
    let (report, output) = converted(line.as_bytes(), "px4@1.16", "px4@1.17");
    assert_eq!((report.topics[0].action, output.as_str()), (Action::LeftOut, ""));
    let (report, output) = converted(format!("[{line}]").as_bytes(), "px4@1.16", "px4@1.17");
    assert_eq!((report.topics[0].action, output.as_str()), (Action::LeftOut, "[]\n"));
}

#[test]
fn topics_and_types_are_renamed_in_all_operations() {
    let request = message("px4@1.16", "ArmingCheckRequest");
    let text = format!(
        r#"{{"op": "advertise", "topic": "/fmu/out/arming_check_request", "type": "px4_msgs/msg/ArmingCheckRequest"}}
{{"op": "publish", "msg": {request}, "topic": "/fmu/out/arming_check_request"}}
{{"op": "unadvertise", "topic": "/fmu/out/arming_check_request"}}
"#
    );
    let (report, output) = converted(text.as_bytes(), "px4@1.16", "px4@1.17");
    assert_eq!(report.topics[0].renamed.as_deref(), Some("/fmu/out/arming_check_request_v1"));
    assert_eq!(output.matches(r#""topic": "/fmu/out/arming_check_request_v1""#).count(), 3, "{output}");
    let data = message("px4@1.17", "GpsInjectData");
    let text = format!(
        r#"{{"op": "advertise", "topic": "/fmu/in/gps_inject_data", "type": "px4_msgs/msg/GpsInjectData"}}
{{"op": "publish", "topic": "/fmu/in/gps_inject_data", "msg": {data}}}
{{"type": "px4/GpsInjectData", "message": {data}}}
"#
    );
    let (_, output) = converted(text.as_bytes(), "px4@1.17", "px4@1.18");
    let lines: Vec<&str> = output.lines().collect();
    let advertised =
        r#"{"op": "advertise", "topic": "/fmu/in/rtcm_corrections", "type": "px4_msgs/msg/RtcmData"}"#;
    assert_eq!(lines[0], advertised);
    assert!(lines[1].contains(r#""topic": "/fmu/in/rtcm_corrections""#), "{}", lines[1]);
    assert!(lines[2].starts_with(r#"{"type": "px4/RtcmData", "#), "{}", lines[2]);
}

/// A rosbridge message.
fn published(topic: &str, message: &str) -> String {
    format!(r#"{{"op":"publish","topic":"{topic}","msg":{message}}}"#)
}

/// Other programs use the names of PX4 topics for other types.
#[test]
fn names_of_topics_outside_of_px4_need_the_keys_of_the_type() {
    let (robot, px4) = ("/robot/arming_check_request", "/robot/fmu/out/arming_check_request");
    let sent = r#"{"timestamp":9,"request_id":3}"#;
    let other = r#"{"robot":"Ada","request_id":3}"#;
    let new = r#"{"timestamp":9,"request_id":3,"valid_registrations_mask":4294967295}"#;
    let subscribed = format!(r#"{{"op":"subscribe","topic":"{robot}"}}"#);
    let advertised = |ty: &str| format!(r#"{{"op":"advertise","topic":"{robot}","type":"{ty}"}}"#);
    let px4_type = advertised("px4_msgs/msg/ArmingCheckRequest");
    let club_type = advertised("club_msgs/msg/Request");
    for (before, topic, messages, expected, action) in [
        ("", robot, &[other, sent][..], &[other, sent][..], Action::Copied),
        ("", robot, &[sent, sent], &[new, new], Action::Converted),
        ("", robot, &[sent, other], &[new], Action::Converted),
        // An operation without a type doesn't decide anything.
        (subscribed.as_str(), robot, &[sent], &[new], Action::Converted),
        (subscribed.as_str(), robot, &[other], &[other], Action::Copied),
        (subscribed.as_str(), robot, &[], &[], Action::Copied),
        // If a type is stated, or the topic is in one of PX4's folders, the type isn't a guess.
        (px4_type.as_str(), robot, &[other], &[], Action::Converted),
        (club_type.as_str(), robot, &[sent], &[sent], Action::Copied),
        ("", px4, &[other], &[], Action::Converted),
    ] {
        let lines = |messages: &[&str]| {
            let start = Some(before.to_owned()).filter(|line| !line.is_empty());
            let all = start.into_iter().chain(messages.iter().map(|message| published(topic, message)));
            all.map(|line| line + "\n").collect::<String>()
        };
        let text = lines(messages);
        let (report, output) = converted(text.as_bytes(), "px4@1.16", "px4@1.17");
        assert_eq!(output, lines(expected), "{text}");
        let [found] = &report.topics[..] else { panic!("{:?}", report.topics) };
        let (count, lost) = (messages.len() as u64, (messages.len() - expected.len()) as u64);
        assert_eq!((found.action, found.messages, found.unreadable), (action, count, lost), "{text}");
        assert_eq!((report.is_complete(), &found.reason), (lost == 0, &None), "{text}");
        let is_checked = checked_against(text.as_bytes(), release("px4@1.16")).result.checked > 0;
        assert_eq!(is_checked, action == Action::Converted, "`check` and `convert` must agree: {text}");
    }
}

/// The first non-empty message determines the type, unless a type is stated before it. Earlier messages are copied.
#[test]
fn messages_without_keys_decide_nothing() {
    let topic = "/robot/arming_check_request";
    let sent = r#"{"timestamp":9,"request_id":3}"#;
    let new = r#"{"timestamp":9,"request_id":3,"valid_registrations_mask":4294967295}"#;
    let other = r#"{"robot":"Ada","request_id":3}"#;
    let [empty, null, sent, new, other] =
        ["{}", "null", sent, new, other].map(|message| published(topic, message));
    let advertised = |ty: &str| format!(r#"{{"op":"advertise","topic":"{topic}","type":"{ty}"}}"#);
    let [typed, club] = ["px4_msgs/msg/ArmingCheckRequest", "club_msgs/msg/Request"].map(advertised);
    for (before, after, skipped) in [
        (&[&empty, &sent][..], &[&empty, &new][..], Some("1 message")),
        (&[&empty, &null, &sent, &sent], &[&empty, &null, &new, &new], Some("2 messages")),
        (&[&empty, &typed, &sent], &[&empty, &typed, &new], Some("1 message")),
        // Of the types that are stated before the first non-empty message, the last one applies.
        (&[&empty, &club, &typed, &sent], &[&empty, &club, &typed, &new], Some("1 message")),
        (&[&club, &empty, &typed, &sent], &[&club, &empty, &typed, &new], Some("1 message")),
        (&[&empty, &typed, &club, &other], &[&empty, &typed, &club, &other], None),
        (&[&empty, &null, &other, &sent], &[&empty, &null, &other, &sent], None),
        (&[&empty, &null], &[&empty, &null], None),
    ] {
        let lines = |all: &[&String]| all.iter().map(|line| String::clone(line) + "\n").collect::<String>();
        let text = lines(before);
        let (report, output) = converted(text.as_bytes(), "px4@1.16", "px4@1.17");
        assert_eq!(output, lines(after), "{text}");
        let [found] = &report.topics[..] else { panic!("{:?}", report.topics) };
        let action = if skipped.is_some() { Action::Converted } else { Action::Copied };
        let reason = skipped.map(|count| format!("copied: {count} without keys"));
        assert_eq!((found.action, &found.reason), (action, &reason), "{text}");
        assert_eq!(found.messages, text.matches("publish").count() as u64, "{text}");
        assert!(report.is_complete(), "{text}");
        let result = checked_against(text.as_bytes(), release("px4@1.16")).result;
        let num_new = output.matches(&new).count() as u64;
        assert_eq!((result.records, result.checked), (found.messages, num_new), "{text}");
    }
}

/// PX4 1.18 renames `gps_inject_data`.
#[test]
fn topics_keep_the_name_under_which_lines_were_copied() {
    let empty = published("/robot/gps_inject_data", "{}") + "\n";
    let published = published("/robot/gps_inject_data", &message("px4@1.17", "GpsInjectData"));
    let renamed = |before: &str| {
        let text = format!("{before}{published}\n");
        converted(text.as_bytes(), "px4@1.17", "px4@1.18").1.contains("/robot/rtcm_corrections")
    };
    assert!(renamed(""));
    let subscribed = "{\"op\":\"subscribe\",\"topic\":\"/robot/gps_inject_data\"}\n";
    assert!(!renamed(subscribed));
    assert!(!renamed(&empty));
    // A type may be stated several times.
    let advertised = "{\"op\":\"advertise\",\"topic\":\"/robot/gps_inject_data\",\
                      \"type\":\"px4_msgs/msg/GpsInjectData\"}\n";
    assert!(!renamed(&[subscribed, advertised, advertised].concat()));
    let other = advertised.replace("px4_msgs", "club_msgs");
    assert!(!renamed(&[other.as_str(), advertised].concat()));
}

/// Only PX4 1.17 defines `battery_info`.
#[test]
fn names_that_only_the_target_defines_need_the_keys_of_the_type() {
    let (of_px4, other) = (message("px4@1.17", "BatteryInfo"), r#"{"timestamp":1,"level":3}"#);
    for (topic, sent, action) in [
        ("/robot/battery_info", other, Action::Copied),
        ("/robot/battery_info", of_px4.as_str(), Action::LeftOut),
        ("/fmu/out/battery_info", other, Action::LeftOut),
    ] {
        let line = published(topic, sent) + "\n";
        let (report, output) = converted(line.as_bytes(), "px4@1.16", "px4@1.17");
        let [found] = &report.topics[..] else { panic!("{:?}", report.topics) };
        assert_eq!((found.action, found.messages, found.unreadable), (action, 1, 0), "{line}");
        assert_eq!(output, if action == Action::Copied { line.as_str() } else { "" });
    }
    // Earlier empty messages are copied if other programs may use the name of their topic.
    for (topic, copied, end) in [
        ("/robot/battery_info", 1, "defines it; copied: 1 message without keys"),
        ("/fmu/out/battery_info", 0, "defines it"),
    ] {
        let lines = ["{}", of_px4.as_str()].map(|sent| published(topic, sent) + "\n");
        let (report, output) = converted(lines.concat().as_bytes(), "px4@1.16", "px4@1.17");
        let [found] = &report.topics[..] else { panic!("{:?}", report.topics) };
        assert_eq!((found.action, found.messages), (Action::LeftOut, 2), "{topic}");
        assert!(found.reason.as_deref().is_some_and(|reason| reason.ends_with(end)), "{:?}", found.reason);
        assert_eq!(output, lines[..copied].concat());
    }
}

/// Both releases define `battery_status`, but with fields other than those of the message.
#[test]
fn topics_that_resemble_no_definition_are_copied() {
    let other = published("/robot/battery_status", r#"{"voltage":12.1,"percentage":0.5}"#);
    let text = format!("{other}\n{}\n", line("px4@1.17", "BatteryStatus"));
    let (report, output) = converted(text.as_bytes(), "px4@1.17", "px4@1.16");
    assert!(report.is_complete(), "{:?}", report.topics);
    assert_eq!((report.count(Action::Converted), report.count(Action::Copied)), (1, 1));
    assert_eq!((output.lines().next(), output.lines().count()), (Some(other.as_str()), 2));
}

/// rosbridge writes bytes as base64, and ROS 2 writes text as numbers.
#[test]
fn the_notation_of_bytes_stays_the_same() {
    let mut value: serde_json::Value =
        serde_json::from_str(&message("px4@1.15", "DebugArray")).expect("JSON");
    let name: Vec<u8> = (0..10).map(|at| if at < 3 { b'a' + at } else { 0 }).collect();
    for (form, text) in
        [(serde_json::json!(name), "[97,98,99,0,"), (serde_json::json!("YWJjAAAAAAAAAA=="), "\"YWJj")]
    {
        value["name"] = form;
        let text_of =
            |value| format!(r#"{{"op": "publish", "topic": "/fmu/out/debug_array", "msg": {value}}}"#);
        let (report, output) = converted(text_of(&value).as_bytes(), "px4@1.15", "px4@1.17");
        assert!(report.is_complete(), "{:?}", report.topics);
        assert!(output.contains(text), "{output}");
        let found = checked_against(output.as_bytes(), release("px4@1.17")).result;
        assert_eq!((found.checked, found.findings.groups().count()), (1, 0), "{output}");
    }
    // Other programs write text only.
    let (report, _) = converted(
        format!(r#"{{"type": "px4/DebugArray", "message": {value}}}"#).as_bytes(),
        "px4@1.15",
        "px4@1.17",
    );
    assert_eq!(report.topics[0].unreadable, 1);
}

#[test]
fn unreadable_values_are_reported_and_left_out() {
    let good = line("px4@1.17", "BatteryStatus");
    let wrong = good.replace("\"timestamp\":", "\"timestomp\":");
    let repeated = good.replace("{\"timestamp\":", "{\"timestamp\":1,\"timestamp\":");
    let unknown = r#"{"winch": 7}"#;
    let text = [&good, "{\"type\": 1", &wrong, &repeated, "\u{fffd}", unknown, &good, &good[..99]].join("\n");
    let bytes: Vec<u8> = text.bytes().filter(|byte| *byte != 0xbf).collect();
    let (report, output) = converted(&bytes, "px4@1.17", "px4@1.16");
    assert!(!report.is_complete());
    let lines: Vec<&str> = report.problems.iter().filter_map(|problem| problem.split(':').next()).collect();
    assert_eq!(lines, ["line 2", "line 5", "line 6", "line 8"], "{:?}", report.problems);
    assert_eq!((report.topics[0].messages, report.topics[0].unreadable), (4, 2));
    assert!(report.topics[0].error.as_ref().is_some_and(|error| error.contains("timestomp")));
    assert_eq!(output.lines().count(), 3);
    assert!(output.lines().nth(1) == Some(unknown), "a value of an unknown form may not be a message");
}

#[test]
fn arrays_stay_arrays_and_values_get_one_line_each() {
    let good = line("px4@1.17", "BatteryStatus");
    let other = "{\"type\": \"club/Winch\",\n  \"message\": {}}";
    let (report, output) =
        converted(format!("[{good},\n{other}, {good}]").as_bytes(), "px4@1.17", "px4@1.16");
    assert!(report.is_complete());
    let values: Vec<serde_json::Value> = serde_json::from_str(&output).expect("an array");
    assert_eq!(values.len(), 3);
    let spread =
        format!("{other}\n{good}\n{other}").replace("\"px4/BatteryStatus\",", "\"px4/BatteryStatus\",\n");
    let (report, output) = converted(spread.as_bytes(), "px4@1.17", "px4@1.16");
    assert!(report.is_complete(), "{:?}", report.problems);
    assert_eq!(
        output.lines().filter(|line| serde_json::from_str::<serde_json::Value>(line).is_ok()).count(),
        3
    );
}

#[test]
fn flockwave_sessions_are_rejected() {
    let session = r#"{"$fw.version": "1.0", "id": "a", "body": {"type": "SYS-VER"}}"#;
    let error = try_converted(session.as_bytes(), release("px4@1.17"), "px4@1.16", Settings::default());
    assert!(matches!(error, Err(Error::Input(problem)) if problem.contains("Flockwave")));
}

#[test]
fn text_without_objects_is_rejected() {
    for text in ["", "plain text\nwithout values\n", "[1, 2]"] {
        let error = try_converted(text.as_bytes(), release("px4@1.17"), "px4@1.16", Settings::default());
        assert!(
            matches!(error, Err(Error::Input(problem)) if problem == "expected objects in JSON, found none"),
            "{text}"
        );
    }
}

#[test]
fn every_part_of_a_truncated_file_is_converted_or_reported() {
    let text = [line("px4@1.17", "AirspeedValidated"), line("px4@1.17", "BatteryStatus")].join("\n");
    let first = text.find('\n').expect("two lines");
    for cut in [1, 9, 40, first - 1, first, first + 1, first + 2, first + 300, text.len() - 1] {
        let (report, output) = converted(&text.as_bytes()[..cut], "px4@1.17", "px4@1.16");
        assert_eq!(output.lines().count(), usize::from(cut >= first), "{cut}");
        assert_eq!(report.is_complete(), [first, first + 1].contains(&cut), "{cut}");
    }
}

/// Both releases have the same definition of the message.
#[test]
fn messages_of_unchanged_types_are_read() {
    let good = message("px4@1.18", "VehicleAttitude");
    let without = |key: &str| {
        let mut message: serde_json::Value = serde_json::from_str(&good).expect("JSON");
        message.as_object_mut().expect("an object").remove(key);
        message.to_string()
    };
    let line = |message: &str| format!("{{\"type\": \"px4/VehicleAttitude\", \"message\": {message}}}\n");
    let nan = without("delta_q_reset").replacen('{', "{\"delta_q_reset\": [NaN, 1.0, NaN, 0.5], ", 1);
    let lines: String = [good.clone(), nan, without("q"), good.replacen('{', "{\"winch\": 1, ", 1)]
        .map(|message| line(&message))
        .concat();
    let (report, output) = converted(lines.as_bytes(), "px4@1.18", "px4@1.17");
    let topic = &report.topics[0];
    assert_eq!((topic.action, topic.messages, topic.unreadable), (Action::Converted, 4, 2), "{topic:?}");
    assert!(!report.is_complete());
    let found: Vec<&str> = output.lines().collect();
    assert_eq!((found.len(), found[0]), (2, line(&good).trim_end()));
    assert!(found[1].contains("\"delta_q_reset\":[null,1.0,null,0.5]"), "{}", found[1]);
}
