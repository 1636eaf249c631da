//! Tests of explanations, using the releases that the program contains.

use std::sync::LazyLock;

use serde_json::{Value, json};
use uavspec_rules::definitions::Library;
use uavspec_test_support::extent;
use uavspec_test_support::schema::{Published, errors};

use super::answer::Explanation;
use super::{Unknown, explain, to_text};

static LIBRARY: LazyLock<Library> = LazyLock::new(Library::built_in);

const EXPLANATION: Published = Published { title: "Explanation", file: "explanation" };

/// The answers about a word in JSON.
fn answers(library: &Library, word: &str, release: Option<&str>) -> Result<Value, Unknown> {
    let release = release.map(|label| library.index().find(label).expect("a release"));
    let explanation = explain(library, word, release)?;
    Ok(serde_json::to_value(&explanation).expect("JSON")["answers"].take())
}

/// The only answer about a word.
fn answer(word: &str) -> Value {
    let mut answers = answers(&LIBRARY, word, None).unwrap_or_else(|unknown| panic!("{unknown:?}"));
    assert_eq!(answers.as_array().map(Vec::len), Some(1), "{answers}");
    answers[0].take()
}

/// The names of the constants that a value denotes, and the notes.
fn meaning(word: &str) -> (Vec<String>, Vec<String>) {
    let asked = answer(word)["asked"].take();
    let texts = |list: &Value, key: Option<&str>| -> Vec<String> {
        let texts = list.as_array().into_iter().flatten();
        texts.map(|item| key.map_or(item, |key| &item[key]).as_str().expect("a text").to_owned()).collect()
    };
    (texts(&asked["meaning"], Some("name")), texts(&asked["notes"], None))
}

fn help(word: &str) -> String {
    answers(&LIBRARY, word, None).expect_err("an unknown word").help
}

#[test]
fn error_codes_and_rules_read_no_releases() {
    let library = Library::built_in();
    for word in ["134", "999999", "PX-RANGE-01", "px-range-01", ""] {
        let _ = explain(&library, word, None);
        assert!(!library.has_read_releases(), "{word}");
    }
    explain(&library, "vehicle_status", None).expect("a topic");
    assert!(library.has_read_releases());
}

#[test]
fn error_codes_have_meaning_class_and_alternatives() {
    let code = answer("134");
    assert_eq!((&code["kind"], &code["abbreviation"]), (&json!("error_code"), &json!("LOWBAT")));
    assert_eq!((&code["class"], &code["severity"]), (&json!("error"), &json!("error")));
    let alternatives: Vec<&Value> =
        code["alternatives"].as_array().expect("a list").iter().map(|code| &code["code"]).collect();
    assert_eq!(alternatives, [&json!(66), &json!(199)]);
    assert_eq!(code["see_also"], json!([]));
    let all = answers(&LIBRARY, "lowbat", None).expect("error codes");
    let codes: Vec<&Value> = all.as_array().expect("a list").iter().map(|code| &code["code"]).collect();
    assert_eq!(codes, [&json!(66), &json!(134), &json!(199)]);
    let undefined = answer("40000");
    assert_eq!((&undefined["description"], &undefined["class"]), (&Value::Null, &json!("user-defined")));
}

#[test]
fn names_of_all_forms_denote_a_message() {
    let words = [
        "vehicle_status",
        "/fmu/out/vehicle_status",
        "vehicle_status_v1",
        "VehicleStatus",
        "px4/VehicleStatus",
        "px4_msgs/VehicleStatus",
        "px4_msgs/msg/VehicleStatus",
    ];
    for word in words.into_iter().step_by(extent(1, 5)) {
        assert_eq!(answer(word)["name"], "px4_msgs/msg/VehicleStatus", "{word}");
    }
    let imu = answer("sensor_msgs/msg/Imu");
    assert_eq!(
        (&imu["release"], &imu["releases"]),
        (&json!("ros2@jazzy"), &json!(["ros2@humble", "ros2@jazzy", "ros2@rolling"]))
    );
    let both = answers(&LIBRARY, "VehicleCommand", None).expect("a message and a service");
    let names: Vec<&Value> = both.as_array().expect("a list").iter().map(|found| &found["name"]).collect();
    assert_eq!(names, ["px4_msgs/msg/VehicleCommand", "px4_msgs/srv/VehicleCommand"]);
}

#[test]
fn values_denote_constants_and_bits() {
    let cases: [(&str, &[&str], &[&str]); 13] = [
        ("vehicle_status.nav_state=17", &["NAVIGATION_STATE_AUTO_TAKEOFF"], &[]),
        ("VehicleStatus.nav_state=auto_takeoff", &["NAVIGATION_STATE_AUTO_TAKEOFF"], &[]),
        ("vehicle_status.nav_state=NAVIGATION_STATE_AUTO_TAKEOFF", &["NAVIGATION_STATE_AUTO_TAKEOFF"], &[]),
        ("vehicle_status.nav_state=200", &[], &["no constant has this value"]),
        (
            "vehicle_status.nav_state=300",
            &[],
            &["invalid: a uint8 holds 0 to 255", "no constant has this value"],
        ),
        ("mode_req_mission=0x82", &["NAVIGATION_STATE_ALTCTL", "NAVIGATION_STATE_GUIDED_COURSE"], &[]),
        ("failsafe_flags.mode_req_mission=0x80000000", &[], &["bit 31 (0x80000000) has no meaning"]),
        ("failsafe_flags.mode_req_mission=0", &[], &["no bit is set"]),
        ("vehicle_status.failure_detector_status=0b101", &["FAILURE_ROLL", "FAILURE_ALT"], &[]),
        ("vehicle_odometry.pose_frame=3", &[], &["no constant has this value"]),
        ("failsafe_flags.battery_warning=2", &["WARNING_CRITICAL"], &[]),
        ("battery_status.remaining=1.5", &[], &["invalid: outside the range 0 to 1"]),
        ("battery_status.remaining=-1", &[], &["no data"]),
    ];
    for (word, names, notes) in cases.into_iter().step_by(extent(1, 7)) {
        let found = meaning(word);
        assert_eq!((found.0, found.1), (strings(names), strings(notes)), "{word}");
    }
}

fn strings(texts: &[&str]) -> Vec<String> {
    texts.iter().map(|text| (*text).to_owned()).collect()
}

#[test]
fn a_value_may_have_another_meaning_in_other_releases() {
    let names = |word: &str| answer(word)["asked"]["by_release"].take();
    let expected = json!([
        { "releases": ["px4@1.13", "px4@1.14"], "names": [] },
        { "releases": ["px4@1.15", "px4@1.16", "px4@1.17"], "names": ["NAVIGATION_STATE_FREE5"] },
        { "releases": ["px4@1.18", "px4@main"], "names": ["NAVIGATION_STATE_GUIDED_COURSE"] },
    ]);
    assert_eq!(names("vehicle_status.nav_state=7"), expected);
    assert_eq!(names("mode_req_mission=0x80"), expected);
}

#[test]
fn a_value_has_its_meaning_in_a_chosen_release() {
    let old = answers(&LIBRARY, "vehicle_status.nav_state=7", Some("px4@1.15")).expect("a value");
    assert_eq!(old[0]["asked"]["meaning"][0]["name"], "NAVIGATION_STATE_FREE5");
    assert_eq!((&old[0]["release"], &old[0]["releases"]), (&json!("px4@1.15"), &json!(["px4@1.15"])));
    assert_eq!(old[0]["history"], json!([]));
}

#[test]
fn the_history_of_a_field_follows_its_names() {
    let field = answer("failsafe_flags.position_accuracy_low");
    assert_eq!((&field["since"], &field["releases"][0]), (&json!("px4@1.14"), &json!("px4@1.14")));
    let history = field["history"].as_array().expect("a list");
    let renamed = json!({
        "release": "px4@1.17",
        "changes": ["local_position_accuracy_low (bool) was renamed to position_accuracy_low"],
    });
    assert!(history.contains(&renamed), "{history:?}");
    let removed = answer("vehicle_status.failure_detector_status");
    assert_eq!((&removed["release"], &removed["type"]), (&json!("px4@1.17"), &json!("uint16")));
    assert_eq!(removed.get("since"), None, "it is in the oldest release");
    let last = removed["history"].as_array().and_then(|history| history.last()).expect("a change");
    assert_eq!(last["changes"], json!(["failure_detector_status (uint16) was removed"]));
    let constant = answer("NAVIGATION_STATE_GUIDED_COURSE");
    assert_eq!((&constant["since"], &constant["value"]), (&json!("px4@1.18"), &json!("7")));
}

#[test]
fn fields_have_a_unit_a_range_and_documentation() {
    let field = answer("battery_status.remaining");
    assert_eq!((&field["type"], &field["range"]), (&json!("float32"), &json!("0 to 1")));
    assert_eq!(field["facts"], json!(["-1: no data"]));
    assert!(field["description"].as_str().is_some_and(|text| text.starts_with("State of charge")), "{field}");
    let nested = answer("arming_check_reply.events[0].id");
    assert_eq!((&nested["message"], &nested["type"]), (&json!("px4_msgs/msg/Event"), &json!("uint32")));
}

#[test]
fn constants_have_documentation_and_parameters() {
    let renamed = answer("failsafe_flags.battery_warning=2");
    let description = renamed["asked"]["meaning"][0]["description"].as_str();
    assert!(
        description.is_some_and(|text| !text.is_empty()),
        "the documentation of BATTERY_WARNING_CRITICAL"
    );
    let command = answer("VEHICLE_CMD_NAV_TAKEOFF");
    assert_eq!(command["parameters"][3]["unit"], "deg");
    assert_eq!(command["parameters"][3]["range"], "0 to 360");
    let constant = answer("VehicleStatus.ARMING_STATE_ARMED");
    assert_eq!((&constant["value"], &constant["fields"]), (&json!("2"), &json!(["arming_state"])));
    assert_eq!(constant["alternatives"][0]["name"], "ARMING_STATE_DISARMED");
}

#[test]
fn constants_are_inferred_only_if_the_names_agree() {
    let cases = [
        ("vehicle_status.arming_state", Some(false)),
        ("vehicle_status.latest_arming_reason", Some(false)),
        ("estimator_status.gps_check_fail_flags", Some(true)),
        // The constants below these fields belong to other fields.
        ("vehicle_local_position.dist_bottom_reset_counter", None),
        ("system_power.usb_valid", None),
        // The constants are indices of the array.
        ("rc_channels.function", None),
    ];
    for (word, expected) in cases.into_iter().step_by(extent(1, 3)) {
        let values = answer(word).get("values").map(|values| values["flags"] == true);
        assert_eq!(values, expected, "{word}");
    }
}

#[test]
fn hashes_denote_definitions_and_releases() {
    let index = LIBRARY.index();
    let rows = index.rows().iter().filter(|row| row.name == "px4_msgs/msg/VehicleStatus");
    for row in rows.step_by(extent(1, 3)) {
        let labels: Vec<String> = row.releases.iter().map(|release| index.label(release)).collect();
        for word in [format!("{:08x}", row.hash), format!("0x{:08X}", row.hash), row.type_hash.to_owned()] {
            let found = answers(&LIBRARY, &word, None).expect("a hash");
            assert_eq!(found[0]["definitions"][0]["name"], row.name, "{word}");
            assert_eq!(found[0]["definitions"][0]["releases"], json!(labels), "{word}");
        }
    }
    assert!(answers(&LIBRARY, "0x00000000", None).is_err());
}

#[test]
fn names_in_several_messages_are_listed() {
    let found = answer("mode_req_mission");
    let expected = json!(["arming_check_reply.mode_req_mission", "failsafe_flags.mode_req_mission"]);
    assert_eq!((&found["kind"], &found["candidates"]), (&json!("candidates"), &expected));
    // Both fields can have this value.
    assert_eq!(answer("mode_req_mission=1")["kind"], "candidates");
    let text = to_text(&explain(&LIBRARY, "timestamp", None).expect("a field"));
    assert!(text.contains("more; --format json lists all"), "{text}");
}

#[test]
fn similar_names_are_suggested() {
    let cases = [
        ("vehicle_statu", "did you mean vehicle_status?"),
        ("vehicle_status.nav_stat", "did you mean vehicle_status.nav_state?"),
        ("vehicle_statu.nav_stat=3", "did you mean vehicle_status.nav_state?"),
        ("vehicle_status.nav_state=AUTO_TAKEOF", "did you mean vehicle_status.nav_state=AUTO_TAKEOFF?"),
        ("NAVIGATION_STATE_OFBOARD", "did you mean NAVIGATION_STATE_OFFBOARD?"),
        ("LOWBATT", "did you mean LOWBAT?"),
        ("PX-RANGE-99", "did you mean PX-RANGE-01?"),
        ("failsafe_flags.geofence_breached=2", "run `uavspec explain failsafe_flags.geofence_breached`"),
    ];
    for (word, expected) in cases.into_iter().step_by(extent(1, 3)) {
        assert_eq!(help(word), expected, "{word}");
    }
}

#[test]
fn hostile_words_are_unknown_and_escaped() {
    let long = "x".repeat(100_000);
    let words = [
        "",
        " ",
        ".",
        "..",
        "=",
        "=5",
        "a=",
        "[",
        "0x",
        "-",
        "/",
        "//",
        "RIHS01_",
        "é=é",
        "vehicle_status.",
        "vehicle_status.=",
        "vehicle_status.nav_state=",
        "vehicle_status..nav_state",
        "vehicle_status.nav_state=0x",
        "vehicle_status.nav_state=--1",
        "vehicle_status.timestamp.timestamp",
        "\u{1b}[31m",
        "::error::x\n",
        "é\u{202e}x.\u{7}=\0",
        &long,
    ];
    for word in words.into_iter().step_by(extent(1, 7)) {
        let unknown = answers(&LIBRARY, word, None).expect_err(word);
        let text = format!("{}{}", unknown.problem, unknown.help);
        assert!(text.len() < 2_000 && !text.contains(char::is_control), "{text:?}");
    }
}

#[test]
fn texts_fit_a_terminal() {
    let words =
        ["134", "vehicle_status.nav_state=7", "VEHICLE_CMD_NAV_TAKEOFF", "failsafe_flags", "timestamp"];
    for word in words.into_iter().step_by(extent(1, 2)) {
        let text = to_text(&explain(&LIBRARY, word, None).expect("an explanation"));
        let is_long = |line: &&str| line.chars().count() > 80 && !line.contains("RIHS01_");
        assert_eq!(text.lines().find(is_long), None, "{word}");
    }
}

#[test]
fn the_published_schema_is_up_to_date_and_described() {
    EXPLANATION.check::<Explanation>();
}

#[test]
fn all_kinds_of_answers_match_the_schema() {
    let schema = EXPLANATION.schema::<Explanation>();
    let words = [
        "FW-ENV-07",
        "134",
        "VehicleStatus",
        "VehicleCommand",
        "vehicle_status.nav_state=17",
        "failsafe_flags.mode_req_mission=0x80",
        "battery_status.remaining",
        "VEHICLE_CMD_NAV_TAKEOFF",
        "timestamp",
        "a492864e",
    ];
    for word in words.into_iter().step_by(extent(1, 4)) {
        let explanation = explain(&LIBRARY, word, None).unwrap_or_else(|unknown| panic!("{unknown:?}"));
        let mut value = serde_json::to_value(&explanation).expect("JSON");
        assert_eq!(errors(&schema, &value), Vec::<String>::new(), "{word}");
        value["answers"][0]["kind"] = json!("riddle");
        assert!(!errors(&schema, &value).is_empty(), "{word}: the schema rejects unknown kinds");
    }
}
