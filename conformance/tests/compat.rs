//! Tests of `uavspec compat`: its verdicts, its reports and its errors.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;
use uavspec_test_support::write;

const NODE: &str = "\
void Node::start() {
  // create_subscription<px4_msgs::msg::Wind>(\"/fmu/out/wind\");
  status_ = create_subscription<px4_msgs::msg::VehicleStatus>(\"/fmu/out/vehicle_status\", qos, on_status);
  position_ = create_subscription<px4_msgs::msg::VehicleLocalPosition>(
    \"/fmu/out/vehicle_local_position\" + version<px4_msgs::msg::VehicleLocalPosition>(), qos, on_position);
  command_ = create_publisher<px4_msgs::msg::VehicleCommand>(ns + \"in/vehicle_command\", 10);
}
";

const LAUNCH: &str = "remappings:\n- [setpoint, /uav_1/fmu/in/rover_position_setpoint]\n";

/// A workspace with the sources of an application, but without `px4_msgs`.
fn workspace() -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    write(folder.path(), "src/app/src/node.cpp", NODE);
    write(folder.path(), "src/app/launch/app.yaml", LAUNCH);
    write(folder.path(), "build/app/node.cpp", "f(\"/fmu/out/wind\");");
    folder
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_uavspec"));
    command.arg("compat").args(arguments).current_dir(folder).output().expect("uavspec runs")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

#[test]
fn each_topic_is_compared_with_each_release() {
    let folder = workspace();
    let output = run(folder.path(), &["src", "--definitions", "px4@1.15", "--with", "px4@1.15..1.17"]);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    let printed = text(&output.stdout);
    let table: Vec<&str> = printed.lines().take(7).collect();
    assert_eq!(
        table,
        [
            "4 topics of src in 2 source files, built with PX4 1.15",
            "",
            "Topic                                     Type                   px4@1.15  px4@1.16    px4@1.17",
            "/fmu/in/rover_position_setpoint           RoverPositionSetpoint  absent    breaks      breaks",
            "/fmu/in/vehicle_command                   VehicleCommand         works     works       works",
            "/fmu/out/vehicle_local_position{version}  VehicleLocalPosition   works     breaks      breaks",
            "/fmu/out/vehicle_status                   VehicleStatus          works     translated  translated",
        ]
    );
    for line in [
        "/fmu/in/rover_position_setpoint (src/app/launch/app.yaml:2:14)",
        "  px4@1.16, px4@1.17: breaks: the application has no definition of\n    RoverPositionSetpoint\n",
        "  px4@1.16: breaks: the application's VehicleLocalPosition differs from PX4's:\n    missing fields: ",
        "breaks: the name of PX4's topic is `vehicle_local_position_v1`, not\n    `vehicle_local_position`; ",
        "  px4@1.16, px4@1.17: translated: the application uses version 0, and PX4 uses\n    version 1\n",
    ] {
        assert!(printed.contains(line), "{line}\n{printed}");
    }
}

#[test]
fn an_application_works_with_the_release_of_its_definitions() {
    let folder = workspace();
    for release in ["px4@1.16", "px4@1.17", "px4@main"] {
        let output =
            run(folder.path(), &["src", "--definitions", release, "--with", release, "--format", "json"]);
        let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let topics = report["topics"].as_array().expect("topics");
        let verdict = |topic: &Value| topic["verdicts"][0]["verdict"].as_str().map(str::to_owned);
        let works: Vec<bool> =
            topics.iter().map(|topic| verdict(topic).as_deref() == Some("works")).collect();
        // The source appends no version to the topic `vehicle_status`, whose version isn't 0.
        assert_eq!(works, [true, true, true, false], "{release}: {topics:#?}");
        assert_eq!(topics[3]["places"][0]["line"], 3);
        assert_eq!(output.status.code(), Some(1));
    }
}

#[test]
fn a_checkout_of_px4_names_its_topics_and_rates() {
    let folder = workspace();
    let status = "uint32 MESSAGE_VERSION = 1\nuint64 timestamp\nuint8 nav_state\n";
    let old = "uint32 MESSAGE_VERSION = 0\nuint64 timestamp\nuint16 nav_state\n";
    let command = "uint64 timestamp\nuint32 command\n";
    for (path, text) in [
        ("src/px4_msgs/msg/VehicleStatus.msg", old),
        ("src/px4_msgs/msg/VehicleCommand.msg", command),
        ("src/px4_msgs/msg/VehicleLocalPosition.msg", "uint64 timestamp\nfloat32 x\n"),
        ("px4/msg/versioned/VehicleStatus.msg", status),
        ("px4/msg/px4_msgs_old/msg/VehicleStatusV0.msg", old),
        ("px4/msg/VehicleCommand.msg", command),
        ("px4/msg/VehicleLocalPosition.msg", "uint64 timestamp\nfloat32 x\n"),
        (
            "px4/src/modules/uxrce_dds_client/dds_topics.yaml",
            "publications:\n- topic: /fmu/out/vehicle_status\n  type: px4_msgs::msg::VehicleStatus\n  rate_limit: 5.\n\
             subscriptions:\n- topic: /fmu/in/vehicle_command\n  type: px4_msgs::msg::VehicleCommand\n",
        ),
        ("hints.toml", "[[topic]]\ntopic = \"fmu/out/vehicle_status_v1\"\ntype = \"VehicleStatus\"\n"),
    ] {
        write(folder.path(), path, text);
    }
    let output =
        run(folder.path(), &["src", "--against", "px4", "--hints", "hints.toml", "--format", "markdown"]);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    assert_eq!(
        text(&output.stdout),
        "| Topic | Type | px4 |\n\
         |---|---|---|\n\
         | `/fmu/in/rover_position_setpoint` | unknown | absent |\n\
         | `/fmu/in/vehicle_command` | VehicleCommand | works |\n\
         | `/fmu/out/vehicle_local_position{version}` | VehicleLocalPosition | not offered |\n\
         | `/fmu/out/vehicle_status` | VehicleStatus | translated |\n\
         | `/fmu/out/vehicle_status_v1` | VehicleStatus | breaks |\n\
         \n\
         - `/fmu/in/rover_position_setpoint`, px4: absent: PX4 has no topic `rover_position_setpoint`\n\
         - `/fmu/out/vehicle_local_position{version}`, px4: not offered: PX4 doesn't offer the topic over DDS\n\
         - `/fmu/out/vehicle_status`, px4: translated: the application uses version 0, and PX4 uses version 1\n\
         - `/fmu/out/vehicle_status`: px4 sends at most 5 messages a second\n\
         - `/fmu/out/vehicle_status_v1`, px4: breaks: the application's VehicleStatus differs from PX4's: fields of \
         a different type: nav_state (uint16, defined as uint8)\n\
         - `/fmu/out/vehicle_status_v1`: px4 sends at most 5 messages a second\n"
    );
}

#[test]
fn an_application_may_name_several_versions() {
    let folder = tempfile::tempdir().expect("a folder");
    let names = ["", "_v1"].map(|version| {
        format!("self.create_subscription(VehicleLocalPosition, 'fmu/out/vehicle_local_position{version}', f, 1)\n")
    });
    write(folder.path(), "node.py", names.concat());
    let output = run(folder.path(), &[".", "--definitions=px4@1.16", "--with=px4@1.15..1.17"]);
    let printed = text(&output.stdout);
    let verdicts = |line: usize| {
        let cells = printed.lines().nth(line).expect("a line").split_whitespace().skip(2);
        cells.map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!([verdicts(3), verdicts(4)], [["breaks", "works", "unused"], ["breaks", "unused", "works"]]);
}

#[test]
fn sarif_names_the_line_of_each_topic() {
    let folder = workspace();
    let output =
        run(folder.path(), &["src", "--definitions=px4@1.15", "--with=px4@1.16,px4@1.17", "--format=sarif"]);
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let results = report["runs"][0]["results"].as_array().expect("results");
    let found: Vec<(&str, u64)> = results
        .iter()
        .map(|result| {
            let line = &result["locations"][0]["physicalLocation"]["region"]["startLine"];
            (result["ruleId"].as_str().expect("a rule"), line.as_u64().expect("a line"))
        })
        .collect();
    assert_eq!(
        found,
        [("compat-breaks", 2), ("compat-breaks", 5), ("compat-breaks", 5), ("compat-translated", 3)]
    );
}

#[test]
fn what_is_not_read_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    write(path, "node.py", "self.create_publisher(VehicleCommand, self.topic, 10)\n");
    write(path, "hints.toml", "[[topic]]\ntopic = \"fmu/in/vehicle_command\"\n");
    let arguments = [".", "--definitions=px4@1.16", "--with=px4@1.16"];
    let output = run(path, &arguments);
    assert_eq!(output.status.code(), Some(6));
    let unread = "  node.py:1:6: can't read the name of this topic of type `VehicleCommand`\n";
    assert!(text(&output.stdout).contains(unread), "{}", text(&output.stdout));
    let output = run(path, &[&arguments[..], &["--hints=hints.toml"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stdout));
    fs::write(path.join("node.py"), "x = 'a'\n").expect("a file");
    assert_eq!(run(path, &arguments).status.code(), Some(5));
}

#[test]
fn wrong_usage_is_explained() {
    let folder = workspace();
    write(folder.path(), "wrong.toml", "[[topic]]\ntopic = \"vehicle_command\"\n");
    write(folder.path(), "dds.yaml", "publications:\n");
    for (arguments, status, wanted) in [
        (&["src"][..], 2, "src: no package `px4_msgs`\n  help: specify the release"),
        (
            &["src", "--definitions=px4@1.16", "--with=px4@1.13"],
            2,
            "can't compare with `px4@1.13`\n  help: the releases",
        ),
        (
            &["src", "--definitions=px4@1.16", "--with=px4@1.17..1.16"],
            2,
            "the range `px4@1.17..1.16` is empty",
        ),
        (
            &["src", "--definitions=px4@1.16", "--hints=wrong.toml"],
            2,
            "`vehicle_command` is not a topic of PX4",
        ),
        (&["src", "--definitions=px4@1.16", "--dds-topics=dds.yaml"], 2, "dds.yaml: it contains no topics"),
        (&["src", "--definitions=px4@1.16", "--against=none"], 2, "none"),
        (&["none", "--definitions=px4@1.16"], 3, "none"),
    ] {
        let output = run(folder.path(), arguments);
        let printed = text(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{arguments:?}: {printed}");
        assert!(printed.contains(wanted), "{arguments:?}: {printed}");
    }
}
