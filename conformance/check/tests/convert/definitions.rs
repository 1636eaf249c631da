//! Tests of conversions between packages that no release contains.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::{Value, json};
use tempfile::TempDir;
use uavspec_check::convert::{Action, ConversionReport, Error, Output, Plan, Settings, convert};
use uavspec_check::open_path;
use uavspec_rules::definitions::{Library, Stated};
use uavspec_runtime::cdr::ByteOrder;
use uavspec_test_captures::mcap;

use super::LIBRARY;
use super::formats::Bag;

/// Files of a ROS package: paths and texts.
type Files<'f> = &'f [(&'f str, &'f str)];

/// The files of a package before it changes.
const OLD: Files<'static> = &[
    (
        "old_msgs/msg/Tank.msg",
        "std_msgs/Header header\nuint8 IDLE=0\nuint8 mode\nint32 level\nfloat32 temp\nValve[] valves\n",
    ),
    ("old_msgs/msg/Valve.msg", "bool is_open\nfloat32 flow\n"),
    ("old_msgs/srv/Fill.srv", "uint16 level\n---\nbool success\n"),
    ("old_msgs/action/Drain.action", "uint16 level\n---\nbool success\n---\nuint16 level\n"),
];

/// A folder with these files, and a `package.xml` for each package.
fn package(files: Files<'_>) -> TempDir {
    let folder = TempDir::new().expect("a folder");
    for (path, text) in files {
        let path = folder.path().join(path);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(&path, text).expect("a file");
        let package = path.ancestors().nth(2).expect("a package");
        let name = package.file_name().and_then(|name| name.to_str()).expect("a name");
        let manifest = format!("<package format=\"3\"><name>{name}</name><version>1.0.0</version></package>");
        fs::write(package.join("package.xml"), manifest).expect("a file");
    }
    folder
}

/// The old files, with these replaced. `None` removes a file.
fn changed(changes: &[(&str, Option<&str>)]) -> TempDir {
    let replaced = |path: &str| changes.iter().find(|(changed, _)| *changed == path);
    let kept = OLD.iter().filter(|(path, _)| replaced(path).is_none()).copied();
    let added = changes.iter().filter_map(|(path, text)| Some((*path, (*text)?)));
    package(&kept.chain(added).collect::<Vec<_>>())
}

/// The type hash that captures contain for a type in a folder, its definition, and the type in the definition.
fn stated(folder: &Path, ty: &str) -> (String, String, Arc<Stated>) {
    let library = Library::load(folder, None).expect("definitions");
    let definitions = library.base();
    let id = definitions.message_of_type(ty).expect("a type");
    let text = definitions.bag_text(id);
    let stated = library.shared().stated(ty, text.as_bytes()).expect("a type");
    (definitions.captured_hash(definitions.schema.message(id)), text, stated)
}

/// A bag with a message of each of these types.
fn bag(folder: &Path, messages: &[(&str, Value)]) -> Vec<u8> {
    let mut records = Vec::new();
    for (id, (ty, message)) in (1..).zip(messages) {
        let (hash, text, stated) = stated(folder, ty);
        let payload = stated.root().from_json(message).expect("a message").to_cdr(ByteOrder::BigEndian);
        records.push(mcap::schema(id, ty, "ros2msg", text.as_bytes()));
        records.push(mcap::channel(id, id, &format!("/topic{id}"), "cdr", &[("topic_type_hash", &hash)]));
        records.push(mcap::message(id, &payload.expect("a payload")));
    }
    mcap::file(&records.concat())
}

/// Converts a bag.
fn converted(
    bag: &[u8],
    to: &Path,
    from: Option<&Path>,
    hints: Option<&str>,
) -> Result<(ConversionReport, Vec<u8>), Error> {
    let folder = TempDir::new().expect("a folder");
    let (path, hint_path) = (folder.path().join("in"), folder.path().join("hints.toml"));
    fs::write(&path, bag).expect("a file");
    let hints = hints.map(|hints| {
        fs::write(&hint_path, hints).expect("a file");
        hint_path.as_path()
    });
    let from = from.map(|path| Library::load(path, None).expect("definitions"));
    let library = from.as_ref().unwrap_or(&LIBRARY);
    let to = Library::load(to, None).expect("definitions");
    let opened = open_path(&path, library, &|input| input).expect("a file").expect("a capture");
    let plan = Plan::new(opened.definitions.clone(), library, Some(&to), hints)?;
    let mut output = Vec::new();
    let report = convert((&path, opened), &plan, Settings::default(), Output::Stream(&mut output))?;
    Ok((report, output))
}

fn tank() -> Value {
    json!({
        "header": {"stamp": {"sec": 1, "nanosec": 2}, "frame_id": "hull"},
        "mode": 1, "level": 70, "temp": 20.5,
        "valves": [{"is_open": true, "flow": 1.5}, {"is_open": false, "flow": 0.0}],
    })
}

const TANK: &str = "old_msgs/msg/Tank.msg";

/// The message after a conversion of a tank, and the losses or the reason why the message is left out.
fn migrated(to: &Path, hints: Option<&str>) -> (Option<(String, Value)>, Vec<String>) {
    let source = package(OLD);
    let bag = bag(source.path(), &[("old_msgs/msg/Tank", tank())]);
    let (report, output) = converted(&bag, to, None, hints).expect("a conversion");
    let [topic] = &report.topics[..] else { panic!("{:?}", report.topics) };
    if topic.action == Action::LeftOut {
        return (None, topic.reason.iter().cloned().collect());
    }
    let output = Bag::read(output);
    let ty = output.types["/topic1"].root();
    let name = format!("{}/{}", ty.package(), ty.name());
    let message = output.messages("/topic1")[0].1.clone();
    (Some((name, message)), topic.losses.iter().map(|loss| loss.text.clone()).collect())
}

/// The tank with other fields.
fn tank_with(change: impl FnOnce(&mut serde_json::Map<String, Value>)) -> Value {
    let mut tank = tank();
    change(tank.as_object_mut().expect("fields"));
    tank
}

#[test]
fn added_fields_are_neutral_and_removed_fields_are_lost() {
    let text = "std_msgs/Header header\nuint8 IDLE=0\nuint8 mode\nint64 level\nfloat64 pressure 2.5\nValve[] valves\n";
    let to = changed(&[(TANK, Some(text)), ("old_msgs/msg/Valve.msg", Some("bool is_open\n"))]);
    let (found, losses) = migrated(to.path(), None);
    let expected = tank_with(|tank| {
        tank.remove("temp");
        tank["valves"] = json!([{"is_open": true}, {"is_open": false}]);
        tank.insert("pressure".to_owned(), json!(2.5));
    });
    assert_eq!(found, Some(("old_msgs/Tank".to_owned(), expected)));
    assert_eq!(losses, ["`temp` is dropped", "in `valves`, `flow` is dropped"]);
}

#[test]
fn renames_need_a_hint_which_works_in_both_directions() {
    let text = OLD[0].1.replace("temp", "temperature");
    let to = changed(&[(TANK, Some(&text))]);
    let (found, reason) = migrated(to.path(), None);
    assert_eq!(found, None);
    assert!(reason[0].contains("`Tank.temperature` may be `temp` under another name"), "{reason:?}");
    let expected = tank_with(|tank| {
        let temperature = tank.remove("temp").expect("a field");
        tank.insert("temperature".to_owned(), temperature);
    });
    for rename in ["temp = \"temperature\"", "temperature = \"temp\""] {
        let hints = format!("[[hint]]\nmessage = \"Tank\"\nrename = {{ {rename} }}\n");
        assert_eq!(migrated(to.path(), Some(&hints)).0.expect("a message").1, expected, "{rename}");
    }
}

#[test]
fn packages_and_messages_may_have_new_names() {
    let files: Vec<(String, &str)> =
        OLD.iter().map(|(path, text)| (path.replace("old_msgs", "new_msgs"), *text)).collect();
    let files: Vec<(&str, &str)> = files.iter().map(|(path, text)| (path.as_str(), *text)).collect();
    let to = package(&files);
    assert_eq!(migrated(to.path(), None).0, Some(("old_msgs/Tank".to_owned(), tank())));
    for hints in ["[packages]\nold_msgs = \"new_msgs\"\n", "[packages]\nnew_msgs = \"old_msgs\"\n"] {
        assert_eq!(migrated(to.path(), Some(hints)).0, Some(("new_msgs/Tank".to_owned(), tank())));
    }
    // A message with the same fields may be unrelated.
    let to = changed(&[(TANK, None), ("old_msgs/msg/Barrel.msg", Some(OLD[0].1))]);
    let (found, reason) = migrated(to.path(), None);
    assert_eq!(found, None);
    assert!(reason[0].ends_with("lacks the message Tank; if Barrel replaces it, write a hint"), "{reason:?}");
    let hints = "[[hint]]\nold_message = \"Tank\"\nnew_message = \"Barrel\"\n";
    assert_eq!(migrated(to.path(), Some(hints)).0, Some(("old_msgs/Barrel".to_owned(), tank())));
}

#[test]
fn changes_that_the_definitions_do_not_decide_leave_messages_out() {
    for (text, expected) in [
        (OLD[0].1.replace("float32 temp", "string temp"), "changed its type"),
        (OLD[0].1.replace("int32 level", "int8 level"), "has a narrower type"),
        (String::new(), ""),
    ] {
        let to = changed(&[(TANK, (!text.is_empty()).then_some(&text))]);
        let (found, reason) = migrated(to.path(), None);
        assert!(found.is_none() && reason[0].contains(expected), "{reason:?}");
    }
}

#[test]
fn hints_with_mistakes_fail_and_unused_hints_are_noted() {
    let source = package(OLD);
    let bag = bag(source.path(), &[("old_msgs/msg/Tank", tank())]);
    for (hints, place) in [
        ("[[hint]]\nmessage = \"Winch\"\nnew.id = 0\n", "2:11"),
        ("[packages]\nwinch_msgs = \"new_msgs\"\n", "2:1"),
    ] {
        let (report, _) = converted(&bag, source.path(), None, Some(hints)).expect("a conversion");
        let [note] = &report.notes[..] else { panic!("{:?}", report.notes) };
        assert!(note.ends_with(&format!("hints.toml:{place}: this hint isn't used")), "{note}");
    }
    let to = changed(&[(TANK, Some(&OLD[0].1.replace("temp", "temperature")))]);
    let hints = "[[hint]]\nmessage = \"Tank\"\nnew.mode = \"temp + 1\"\n";
    let Err(Error::Hints(failure)) = converted(&bag, to.path(), None, Some(hints)) else {
        panic!("no failure")
    };
    assert!(failure.to_string().contains("hints.toml:3:5: "), "{failure}");
}

/// If the order of two packages is unknown, a hint describes the change to the target, unless it only applies in the
/// opposite direction.
#[test]
fn hints_never_change_values_twice() {
    let level = |factor: &str| OLD[0].1.replace("int32 level", factor);
    let tenfold = |tank: &mut serde_json::Map<String, Value>| tank["level"] = json!(700);
    let to = changed(&[(TANK, Some(&level("int64 level")))]);
    let hints = "[[hint]]\nmessage = \"Tank\"\nnew.level = \"level * 10\"\n";
    assert_eq!(migrated(to.path(), Some(hints)).0.expect("a message").1, tank_with(tenfold));
    // Equal definitions need no hints.
    let same = package(OLD);
    assert_eq!(migrated(same.path(), Some(hints)).0.expect("a message").1, tank());
    // Both directions are possible.
    let hints = format!("{hints}old.level = \"level * 2\"\n");
    let (found, reason) = migrated(to.path(), Some(&hints));
    assert_eq!(found, None);
    assert!(reason[0].contains("the hints apply in both directions, with different results"), "{reason:?}");
}

#[test]
fn messages_get_their_old_names_back() {
    let text = OLD[1].1;
    let source = package(&[("old_msgs/msg/Valve.msg", text)]);
    let to = package(&[("old_msgs/msg/Tap.msg", "bool is_open\nfloat32 flow\nint8 size\n")]);
    let valve = json!({"is_open": true, "flow": 1.5});
    let bag = bag(source.path(), &[("old_msgs/msg/Valve", valve)]);
    for (old, new) in [("Valve", "Tap"), ("Tap", "Valve")] {
        let hints = format!("[[hint]]\nold_message = \"{old}\"\nnew_message = \"{new}\"\n");
        let (report, output) = converted(&bag, to.path(), None, Some(&hints)).expect("a conversion");
        assert_eq!(report.count(Action::Converted), 1, "{old}: {}", report.to_text());
        let message = json!({"is_open": true, "flow": 1.5, "size": 0});
        assert_eq!(Bag::read(output).messages("/topic1"), [(7, &message)]);
    }
}

/// A package keeps its name if the target contains it, even if a hint says that another package became this package.
#[test]
fn packages_keep_their_names_if_possible() {
    let source = package(&[("new_msgs/msg/Valve.msg", OLD[1].1)]);
    let to = package(&[("old_msgs/msg/Valve.msg", OLD[1].1), ("new_msgs/msg/Valve.msg", OLD[1].1)]);
    let bag = bag(source.path(), &[("new_msgs/msg/Valve", json!({"is_open": true, "flow": 1.5}))]);
    let hints = "[packages]\nold_msgs = \"new_msgs\"\n";
    let (report, output) = converted(&bag, to.path(), None, Some(hints)).expect("a conversion");
    assert_eq!(report.count(Action::Converted), 1, "{}", report.to_text());
    assert_eq!(Bag::read(output).types["/topic1"].root().package(), "new_msgs");
}

#[test]
fn the_target_has_one_version_of_each_package() {
    let to = package(OLD);
    let folders: String = ["one", "two"]
        .map(|name| {
            format!(
                "[[package]]\nname = \"{name}\"\nros_package = \"old_msgs\"\ndialect = \"ros2\"\ninclude = \
                 [\"old_msgs/msg/*.msg\"]\n"
            )
        })
        .concat();
    fs::write(to.path().join("uavspec.toml"), folders).expect("a file");
    let library = Library::load(to.path(), None).expect("definitions");
    let plan = Plan::new(LIBRARY.base().clone(), &LIBRARY, Some(&library), None);
    let failure = plan.err().expect("a failure").to_string();
    assert!(failure.contains("`one` and `two` are both versions of the package `old_msgs`"), "{failure}");
}

#[test]
fn services_and_actions_are_converted() {
    let source = package(OLD);
    let event = json!({
        "info": {
            "event_type": 1, "stamp": {"sec": 3, "nanosec": 4}, "client_gid": vec![7; 16], "sequence_number": 5,
        },
        "request": [{"level": 9}], "response": [],
    });
    let id = json!({"uuid": vec![3; 16]});
    let goal = json!({"goal_id": id, "goal": {"level": 8}});
    let messages = [
        ("old_msgs/srv/Fill_Event", event),
        ("old_msgs/srv/Fill_Request", json!({"level": 9})),
        ("old_msgs/action/Drain_SendGoal_Request", goal),
        ("old_msgs/action/Drain_FeedbackMessage", json!({"goal_id": id, "feedback": {"level": 7}})),
    ];
    let bag = bag(source.path(), &messages);
    let to = changed(&[
        ("old_msgs/srv/Fill.srv", Some("uint32 level\nuint8 speed 3\n---\nbool success\n")),
        (
            "old_msgs/action/Drain.action",
            Some("uint16 level\nbool is_urgent\n---\nbool success\n---\nfloat32 share\nuint16 level\n"),
        ),
    ]);
    let (report, output) = converted(&bag, to.path(), None, None).expect("a conversion");
    assert_eq!((report.count(Action::Converted), report.is_complete()), (4, true), "{}", report.to_text());
    let expected = [
        json!([{"level": 9, "speed": 3}]),
        json!({"level": 9, "speed": 3}),
        json!({"level": 8, "is_urgent": false}),
        json!({"share": 0.0, "level": 7}),
    ];
    let output = Bag::read_with(output, |ty| stated(to.path(), ty).0);
    for (topic, (part, expected)) in (1..).zip(["request", "", "goal", "feedback"].into_iter().zip(expected))
    {
        let message = output.messages(&format!("/topic{topic}"))[0].1;
        assert_eq!(if part.is_empty() { message } else { &message[part] }, &expected, "{part}");
    }
    assert_eq!(output.messages("/topic1")[0].1["info"]["client_gid"], json!(vec![7; 16]));
}

/// Without a schema, `--from` provides the definitions.
#[test]
fn messages_without_a_schema_need_their_definitions() {
    let source = package(OLD);
    let (_, _, stated) = stated(source.path(), "old_msgs/msg/Tank");
    let payload = stated.root().from_json(&tank()).expect("a message").to_cdr(ByteOrder::LittleEndian);
    let records = [
        mcap::schema(1, "old_msgs/msg/Tank", "ros2msg", b""),
        mcap::channel(1, 1, "/topic1", "cdr", &[]),
        mcap::message(1, &payload.expect("a payload")),
    ];
    let bag = mcap::file(&records.concat());
    let to = changed(&[(TANK, Some("int32 level\n"))]);
    let (report, _) = converted(&bag, to.path(), None, None).expect("a conversion");
    let reason = report.topics[0].reason.as_deref().unwrap_or_default();
    assert!(reason.ends_with("specify the definitions with --from"), "{reason}");
    let (report, output) = converted(&bag, to.path(), Some(source.path()), None).expect("a conversion");
    assert_eq!(report.from, [PathBuf::from(source.path()).to_string_lossy()]);
    assert_eq!(Bag::read(output).messages("/topic1"), [(7, &json!({"level": 70}))]);
}

/// Messages of packages that the target lacks are copied. This includes packages that the target only refers to.
#[test]
fn other_packages_are_copied() {
    let source = package(&[("other_msgs/msg/Note.msg", "std_msgs/Header header\nint8 kind\n")]);
    let header = json!({"stamp": {"sec": 1, "nanosec": 2}, "frame_id": "hull"});
    let note = json!({"header": header, "kind": 3});
    let bag = bag(source.path(), &[("other_msgs/msg/Note", note), ("std_msgs/msg/Header", header)]);
    let to = package(OLD);
    let (report, output) = converted(&bag, to.path(), None, None).expect("a conversion");
    assert_eq!((report.count(Action::Copied), report.count(Action::LeftOut)), (2, 0), "{}", report.to_text());
    assert_eq!(Bag::read(output).messages.len(), 2);
}

/// An empty definition is the definition of an empty message, if the message is also empty in the target.
#[test]
fn empty_messages_are_converted() {
    let records = [
        mcap::schema(1, "old_msgs/msg/Ping", "ros2msg", b""),
        mcap::channel(1, 1, "/topic1", "cdr", &[]),
        mcap::message(1, &[0, 1, 0, 0, 0]),
    ];
    let to = changed(&[("old_msgs/msg/Ping.msg", Some("# Nothing.\n"))]);
    let (report, output) =
        converted(&mcap::file(&records.concat()), to.path(), None, None).expect("a conversion");
    assert_eq!((report.count(Action::Converted), report.is_complete()), (1, true), "{}", report.to_text());
    assert_eq!(Bag::read(output).messages("/topic1"), [(7, &json!({}))]);
}

/// The text of a service or an action defines the messages that ROS 2 derives from it.
#[test]
fn schemas_of_services_have_the_text_of_the_service() {
    let source = package(OLD);
    let records = [
        mcap::schema(1, "old_msgs/srv/Fill_Request", "ros2msg", b"uint16 level\n"),
        mcap::channel(1, 1, "/topic1", "cdr", &[]),
    ];
    let (report, _) =
        converted(&mcap::file(&records.concat()), source.path(), None, None).expect("a conversion");
    let reason = report.topics[0].reason.as_deref().unwrap_or_default();
    assert_eq!(reason, "its schema doesn't contain the text of its service or action");
}
