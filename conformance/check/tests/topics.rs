//! Tests of topics that share parts of their names: each has separate findings.

use uavspec_check::baseline::finding_name;
use uavspec_check::{CaptureResult, check_capture};
use uavspec_lint::baseline::Lists;
use uavspec_model::Group;
use uavspec_rules::definitions::Definitions;
use uavspec_rules::sample::{Encoding, Entry, Flight};
use uavspec_test_captures::mcap::{channel, file, message, schema};

fn checked(bytes: &[u8]) -> CaptureResult {
    check_capture(bytes, None, &Definitions::built_in()).expect("bytes")
}

/// The findings of a rule: the subject, including the instance, and the count.
fn found(result: &CaptureResult, rule: &str) -> Vec<(String, u64)> {
    let groups = result.findings.groups().filter(|group| group.rule.id == rule);
    groups.map(|group| (group.name().to_string(), group.count)).collect()
}

/// A bag with one text schema for each type, and a message on each topic.
fn bag(topics: &[(&str, &str, &str, &[u8])]) -> Vec<u8> {
    let records = (1..).zip(topics).flat_map(|(id, (topic, ty, text, body))| {
        let payload = [&[0, 1, 0, 0][..], body].concat();
        [
            schema(id, ty, "ros2msg", text.as_bytes()),
            channel(id, id, topic, "cdr", &[]),
            message(id, &payload),
        ]
    });
    file(&records.collect::<Vec<_>>().concat())
}

#[test]
fn topics_in_other_namespaces_have_separate_findings() {
    let text = "bool is_open\n";
    let result = checked(&bag(&[
        ("/kite1/winch/door", "club_msgs/msg/Door", text, &[7]),
        ("/kite2/winch/door", "club_msgs/msg/Door", text, &[9]),
        ("/kite3/winch/door", "club_msgs/msg/Door", text, &[1]),
    ]));
    let expected = ["/kite1/winch/door.is_open", "/kite2/winch/door.is_open"];
    assert_eq!(found(&result, "PX-BOOL-01"), expected.map(|name| (name.to_owned(), 1)));
}

#[test]
fn findings_cite_the_definition_of_their_type() {
    let definitions = Definitions::built_in();
    for topics in [["/a/state", "/b/state"], ["/state", "/state"]] {
        let records = [("BatteryStatus", 1), ("FailsafeFlags", 2)].map(|(name, id)| {
            let ty = format!("px4_msgs/msg/{name}");
            let topic = topics[usize::from(id) - 1];
            [schema(id, &ty, "ros2msg", b""), channel(id, id, topic, "cdr", &[]), message(id, &[0, 1, 0, 0])]
                .concat()
        });
        let result = check_capture(&file(&records.concat())[..], None, &definitions).expect("bytes");
        let groups: Vec<&Group> =
            result.findings.groups().filter(|group| group.rule.id == "PX-CDR-02").collect();
        let files: Vec<&str> =
            groups.iter().filter_map(|group| Some(definitions.line(group.definition?).file)).collect();
        let count = |name: &str| files.iter().filter(|file| file.ends_with(name)).count();
        assert_eq!(
            (count("BatteryStatus.msg"), count("FailsafeFlags.msg"), groups.len()),
            (1, 1, 2),
            "{files:?}"
        );
    }
}

/// A log of a flight in which each of these instances of a topic violates a rule in its last message.
fn log_with_instances(instances: &[u8]) -> Vec<u8> {
    let definitions = Definitions::built_in();
    let flight = Flight::new(&definitions);
    let topic = flight.topic("FailsafeFlags").expect("a topic");
    let mut flight = flight
        .with_last(topic, |flags| {
            flags["mode_req_attitude"] = 0.into();
            flags["attitude_invalid"] = true.into();
        })
        .expect("a flight");
    flight.messages.retain(|sent| sent.topic == topic);
    let mut log = flight.log();
    let subscribed: Vec<u16> = log
        .entries
        .iter()
        .filter_map(|entry| match entry {
            Entry::Subscription(id, _, name) if name == "failsafe_flags" => Some(*id),
            _ => None,
        })
        .collect();
    let mut entries = Vec::new();
    for entry in std::mem::take(&mut log.entries) {
        match entry {
            Entry::Subscription(id, _, name) if subscribed.contains(&id) => {
                entries.extend(instances.iter().map(|instance| {
                    Entry::Subscription(id + 1_000 * u16::from(*instance), *instance, name.clone())
                }));
            }
            Entry::Data(id, payload) if subscribed.contains(&id) => {
                entries.extend(
                    instances
                        .iter()
                        .map(|instance| Entry::Data(id + 1_000 * u16::from(*instance), payload.clone())),
                );
            }
            other => entries.push(other),
        }
    }
    log.entries = entries;
    log.to_bytes()
}

#[test]
fn findings_name_the_instance_if_a_log_has_several() {
    let name = "failsafe_flags.attitude_invalid";
    for (instances, expected) in [
        (&[0][..], vec![name.to_owned()]),
        (&[1], vec![format!("{name} (instance 1)")]),
        (&[0, 1], vec![format!("{name} (instance 0)"), format!("{name} (instance 1)")]),
    ] {
        let result = checked(&log_with_instances(instances));
        let expected: Vec<(String, u64)> = expected.into_iter().map(|name| (name, 1)).collect();
        assert_eq!(found(&result, "PX-FSF-03"), expected, "{instances:?}");
    }
}

#[test]
fn json_topics_and_types_have_full_names() {
    let definitions = Definitions::built_in();
    let flight = Flight::new(&definitions);
    let topic = flight.topic("FailsafeFlags").expect("a topic");
    let sent = flight.messages.iter().find(|sent| sent.topic == topic).expect("a message");
    let mut message = sent.value.clone();
    message["attitude_invalid"] = 7.into();
    let lines = ["/a/fmu/out/failsafe_flags", "/b/fmu/out/failsafe_flags"]
        .map(|topic| format!("{}\n", serde_json::json!({ "op": "publish", "topic": topic, "msg": message })));
    let typed = format!("{}\n", serde_json::json!({ "type": "px4/FailsafeFlags", "message": message }));
    let result = checked((lines.concat() + &typed).as_bytes());
    let expected = ["/a/fmu/out/failsafe_flags", "/b/fmu/out/failsafe_flags", "px4/FailsafeFlags"];
    let with_field = expected.map(|name| (format!("{name}.attitude_invalid"), 1));
    assert_eq!(found(&result, "PX-JSON-02"), with_field);
    let parts: Vec<&str> = result.coverage.parts.iter().map(|part| part.name.as_str()).collect();
    assert_eq!(parts, expected);
}

#[test]
fn entries_of_baselines_may_leave_out_the_namespace_and_the_instance() {
    let rule = uavspec_rules::rule("PX-BOOL-01").expect("a rule");
    let text = |subject: &str| {
        format!("[[known]]\nrule = \"PX-BOOL-01\"\nsubject = \"{subject}\"\nreason = \"it is old\"\n")
    };
    let is_known = |pattern: &str, name: &str, instance: Option<u8>| {
        let lists = Lists::parse([("b.toml".to_owned(), text(pattern).into_bytes())], &["PX-BOOL-01"]);
        let subject = uavspec_model::SubjectName { name, instance };
        lists.expect("a list").find(&finding_name(rule, subject, "a.mcap"), &[String::new()]).is_some()
    };
    for (pattern, name, instance, expected) in [
        ("door.is_open", "/kite1/winch/door.is_open", None, true),
        ("/kite1/winch/door.is_open", "/kite1/winch/door.is_open", None, true),
        ("/kite2/winch/door.is_open", "/kite1/winch/door.is_open", None, false),
        ("winch/door.is_open", "/kite1/winch/door.is_open", None, false),
        ("*/door.is_open", "/kite1/winch/door.is_open", None, true),
        ("sensor_accel.x", "/sensor_accel/1.x", None, true),
        ("FailsafeFlags.x", "px4/FailsafeFlags.x", None, true),
        ("battery_status.warning", "battery_status.warning", Some(1), true),
        ("battery_status.warning (instance 1)", "battery_status.warning", Some(1), true),
        ("battery_status.warning (instance 1)", "battery_status.warning", Some(0), false),
        ("battery_status", "battery_status.warning", None, false),
    ] {
        assert_eq!(is_known(pattern, name, instance), expected, "{pattern} {name} {instance:?}");
    }
}

#[test]
fn formats_of_all_encodings_have_full_names() {
    let definitions = Definitions::built_in();
    let flight = Flight::new(&definitions);
    let bytes = Encoding::Mcap.write(&flight).expect("a bag");
    let result = checked(&bytes);
    assert!(result.coverage.parts.iter().all(|part| part.name.starts_with('/')));
}
