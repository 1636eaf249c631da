//! Folders with ROS 2 packages, as colcon lays them out.

use std::fs;
use std::path::Path;

use tempfile::TempDir;
use uavspec_codegen::load::read_definitions;
use uavspec_schema::Schema;

fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (path, text) in files {
        let path = folder.path().join(path);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(path, text).expect("a file");
    }
    folder
}

/// For each package: its name, a flag that is true if other packages refer to it, and the names of its messages.
fn packages(schema: &Schema) -> Vec<(String, bool, Vec<String>)> {
    let packages = schema.packages.iter().filter(|package| !package.messages.is_empty());
    let names = packages.map(|package| {
        let names = package.messages.iter().map(|id| schema.message(*id).name.clone());
        (package.name.clone(), package.is_dependency, names.collect())
    });
    names.collect()
}

fn read(path: &Path) -> Vec<(String, bool, Vec<String>)> {
    packages(&read_definitions(path).expect("valid definitions").1)
}

fn package(name: &str, is_dependency: bool, messages: &[&str]) -> (String, bool, Vec<String>) {
    (name.to_owned(), is_dependency, messages.iter().map(ToString::to_string).collect())
}

#[test]
fn built_in_packages_fill_what_a_folder_lacks() {
    let folder = folder(&[
        ("kite_msgs/msg/Line.msg", "std_msgs/Header header\nfloat64 length\n"),
        ("reel_msgs/msg/Reel.msg", "kite_msgs/Line line\nsensor_msgs/Temperature[2] heat\n"),
    ]);
    let (sources, schema) = read_definitions(folder.path()).expect("valid definitions");
    let found = packages(&schema);
    assert_eq!(
        found,
        [
            package("builtin_interfaces", true, &["Time"]),
            package("kite_msgs", false, &["Line"]),
            package("reel_msgs", false, &["Reel"]),
            package("sensor_msgs", true, &["Temperature"]),
            package("std_msgs", true, &["Header"]),
        ]
    );
    let header = schema.messages.iter().find(|message| message.name == "Header").expect("a message");
    assert!(sources.path(sources.source_of(header.span)).starts_with("ros2@jazzy/std_msgs/Header"));
    let origin = schema.package_of(header).origin.as_deref();
    assert_eq!(origin, Some("the definitions of ROS 2 jazzy in uavspec"));
}

#[test]
fn packages_in_the_folder_take_precedence_over_built_in_ones() {
    let folder = folder(&[
        ("kite_msgs/msg/Line.msg", "std_msgs/Header header\n"),
        ("std_msgs/msg/Header.msg", "uint8 own\n"),
    ]);
    assert_eq!(
        read(folder.path()),
        [package("kite_msgs", false, &["Line"]), package("std_msgs", false, &["Header"])]
    );
}

#[test]
fn other_missing_packages_are_errors() {
    let folder = folder(&[
        (
            "uavspec.toml",
            "[[package]]\nname = \"kite_msgs\"\ndialect = \"ros2\"\ninclude = [\"msg/*.msg\"]\n",
        ),
        ("msg/Line.msg", "reel_msgs/Reel reel\nstd_msgs/Header header\nstd_msgs/Reel other\n"),
    ]);
    let error = read_definitions(folder.path()).expect_err("missing packages").to_string();
    assert!(error.contains("no package `reel_msgs`") && error.contains("has no message `Reel`"), "{error}");
    assert!(!error.contains("`Header`"), "{error}");
}

#[test]
fn build_output_of_a_workspace_is_skipped() {
    let line = "std_msgs/Header header\n";
    let folder = folder(&[
        ("src/kite_msgs/msg/Line.msg", line),
        ("src/winch/interfaces/package.xml", "<package><name>winch_msgs</name></package>"),
        ("src/winch/interfaces/msg/Winch.msg", "kite_msgs/Line line\n"),
        ("src/winch/other/msg/Rope.msg", "winch_msgs/Winch winch\n"),
        ("build/COLCON_IGNORE", ""),
        ("build/kite_msgs/rosidl_adapter/kite_msgs/msg/Line.msg", line),
        ("install/COLCON_IGNORE", ""),
        ("install/kite_msgs/share/kite_msgs/msg/Line.msg", line),
    ]);
    let found = read(folder.path());
    let own: Vec<_> = found.iter().filter(|(_, is_dependency, _)| !is_dependency).collect();
    let expected = [
        package("kite_msgs", false, &["Line"]),
        package("other", false, &["Rope"]),
        package("winch_msgs", false, &["Winch"]),
    ];
    assert_eq!(own, expected.iter().collect::<Vec<_>>());
}

/// In addition to each service, installed packages contain a message for each of its parts.
#[test]
fn generated_parts_of_services_are_skipped() {
    let folder = folder(&[
        ("share/kite_msgs/srv/Reel.srv", "float64 length\n---\nbool done\n"),
        ("share/kite_msgs/srv/Reel_Request.msg", "float64 length\n"),
        ("share/kite_msgs/srv/Reel_Response.msg", "bool done\n"),
        ("share/kite_msgs/action/Pull.action", "float64 length\n---\nbool done\n---\nfloat64 left\n"),
        ("share/kite_msgs/action/Pull_Goal.msg", "float64 length\n"),
        ("share/kite_msgs/msg/Line.msg", "float64 length\n"),
        ("share/kite_msgs/msg/Pull_Result.msg", "bool done\n"),
    ]);
    assert_eq!(read(folder.path()), [package("kite_msgs", false, &["Line", "Pull_Result"])]);
}
