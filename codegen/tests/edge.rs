//! Small definitions at the edge of the language, against what the reference tools say of them:
//! rosidl for ROS 2, PX4's own generator for PX4.

use crate::support;

use std::collections::BTreeMap;
use std::fs;

use serde_json::{Value as Json, json};
use uavspec_codegen::diagnostic::has_errors;
use uavspec_codegen::emit::inspect;
use uavspec_codegen::msg::Dialect;
use uavspec_codegen::schema::Form;
use uavspec_codegen::{PackageInput, SourceMap, read, render};

/// Where we say something else than PX4's generator, and why. A deviation that is none fails the test.
const PX4_DEVIATIONS: &[(&str, &str)] = &[
    ("lone_cr", "a carriage return alone ends no line in editors: it hides a field"),
    ("tab_sep", "a tab parts words as a blank does; read, with a warning"),
    ("const_hex", "read as meant, with a warning"),
    ("const_HEX", "read as meant, with a warning"),
    ("const_neghex", "read as meant, with a warning"),
    ("const_bin", "read as meant, with a warning"),
    ("const_oct", "read as meant, with a warning"),
    ("const_nan", "read as meant, with a warning: the generator fails where it makes an integer of it"),
    ("const_inf", "read as meant, with a warning: the generator fails where it makes an integer of it"),
    ("const_bool_true", "read as meant, with a warning"),
    ("const_bool_2", "a bool is never 2; the generator makes it true without a word"),
    ("const_dup", "the generator's C++ doesn't compile"),
    ("field_upper", "names are a matter of style as long as they are identifiers: a warning"),
    ("arr_zero", "C++ has no such arrays"),
    ("arr_huge", "no message of 4 GiB fits any memory"),
    ("str", "the generator gives it no memory"),
    ("byte", "the generator gives it no memory"),
    ("time", "the generator gives it no memory"),
    ("duration", "the generator gives it no memory"),
];

/// Where we say something else than rosidl, and why.
const ROS2_DEVIATIONS: &[(&str, &str)] = &[
    ("lead_ws", "rosidl crashes at blanks at the start of a line"),
    ("lone_cr", "a carriage return alone ends no line in editors: it hides a field"),
    ("const_string_hash", "a # in quotes starts no comment; rosidl cuts the string there"),
    ("default_str_hash", "a # in quotes starts no comment; rosidl cuts the string there"),
    ("default_str_eq", "an = in quotes makes no constant"),
    ("arr_huge", "no message of 4 GiB fits any memory"),
    ("time", "short for builtin_interfaces/Time, as rosidl's reader has it; only its IDL writer fails"),
    (
        "duration",
        "short for builtin_interfaces/Duration, as rosidl's reader has it; only its IDL writer fails",
    ),
];

/// Messages that the cases refer to. PX4's generator had none of them.
const COMPANIONS: [(&str, &str, &str); 5] = [
    ("pkg", "Foo.msg", "uint8 a\n"),
    ("pkg", "Header.msg", "uint8 a\n"),
    ("std_msgs", "Header.msg", "uint8 a\n"),
    ("builtin_interfaces", "Time.msg", "int32 sec\nuint32 nanosec\n"),
    ("builtin_interfaces", "Duration.msg", "int32 sec\nuint32 nanosec\n"),
];

/// The case as a message: the model of it and whether there are warnings, or what is wrong with it.
fn read_case(text: &str, dialect: Dialect) -> Result<(Json, bool), String> {
    let mut sources = SourceMap::default();
    let mut packages: BTreeMap<&str, PackageInput> = BTreeMap::new();
    let companions = if dialect == Dialect::Ros2 { &COMPANIONS[..] } else { &[] };
    for (package, path, text) in [("pkg", "Case.msg", text)].iter().chain(companions) {
        let id = sources.add(*path, text.as_bytes().to_vec());
        let id = id.map_err(|diagnostic| render::render(&[diagnostic], &sources, false))?;
        let input = packages.entry(package).or_insert_with(|| support::package(package, Form::Msg(dialect)));
        input.sources.push(id);
    }
    let packages: Vec<PackageInput> = packages.into_values().collect();
    let (schema, diagnostics) = read(&sources, &packages);
    if has_errors(&diagnostics) {
        return Err(render::render(&diagnostics, &sources, false));
    }
    let case = inspect::schema(&schema)["packages"]["pkg"]["messages"]["Case"].clone();
    Ok((case, !diagnostics.is_empty()))
}

/// Fields and constants in the form of the reference tools.
fn declarations(message: &Json, keys: &[&str]) -> Json {
    let pick = |list: &str, keys: &[&str]| -> Json {
        let entries = message[list].as_array().expect("a list").iter();
        let picked =
            |entry: &Json| keys.iter().map(|key| ((*key).to_owned(), entry[*key].clone())).collect::<Json>();
        entries.map(picked).collect()
    };
    json!({ "fields": pick("fields", keys), "constants": pick("constants", &["type", "name", "value"]) })
}

/// Types with the names of their packages taken off where the tool puts its own, and NaN as we write it.
fn normalised(text: &str) -> Json {
    let text = text.replace("\"pkg/", "\"").replace("\"nan\"", "\"NaN\"");
    serde_json::from_str(&text).expect("JSON")
}

fn ros2_deviation(case: &Json) -> Option<String> {
    let is_accepted = case["rosidl"] == "accept" && case["rosidl_idl"] == "accept";
    let found = read_case(case["text"].as_str()?, Dialect::Ros2);
    match (is_accepted, found) {
        (true, Ok((message, _))) => {
            let found = declarations(&message, &["type", "name", "default"]);
            let expected = normalised(&case["rosidl_out"].to_string());
            (found != expected).then(|| format!("read as {found}, by rosidl as {expected}"))
        }
        (false, Err(_)) => None,
        (true, Err(diagnostics)) => Some(format!("refused, not by rosidl:\n{diagnostics}")),
        (false, Ok((message, _))) => Some(format!("read as {message}, refused by rosidl")),
    }
}

fn px4_deviation(case: &Json) -> Option<String> {
    let verdict = case.get("px4_tool").or(case.get("px4")).expect("a verdict");
    let text = case["text"].as_str()?;
    match (verdict == "accept", read_case(text, Dialect::Px4)) {
        (true, Ok((message, _))) => {
            let found = declarations(&message, &["type", "name"]);
            let expected = normalised(&case["px4_out"].to_string());
            (found != expected)
                .then(|| format!("read as {found}, by genmsg as {expected}"))
                .or_else(|| layout_deviation(case, text))
        }
        (false, Err(_)) => None,
        (true, Err(diagnostics)) => Some(format!("refused, not by PX4:\n{diagnostics}")),
        (false, Ok((message, has_warnings))) => {
            assert!(has_warnings, "{text:?} is refused by PX4, and read here without a word");
            Some(format!("read as {message}, refused by PX4"))
        }
    }
}

/// PX4's generator takes no message without a time stamp: the cases without one had one put below.
fn layout_deviation(case: &Json, text: &str) -> Option<String> {
    let stamped =
        if text.contains("timestamp") { text.to_owned() } else { format!("{text}\nuint64 timestamp\n") };
    let (message, _) = read_case(&stamped, Dialect::Px4).expect("no error without the stamp");
    let found = json!([message["uorb"]["size"], message["uorb"]["size_no_padding"], message["hash"]]);
    let tool = &case["px4_tool_out"];
    let expected = json!([tool["struct_size"], tool["size_no_padding"], tool["hash"]]);
    (found != expected).then(|| format!("laid out as {found}, by PX4 as {expected}"))
}

fn check(deviation: fn(&Json) -> Option<String>, known: &[(&str, &str)]) {
    let Some(path) = support::shared("oracle/edge/cases.json") else { return };
    let cases: Json = serde_json::from_str(&fs::read_to_string(path).expect("readable")).expect("JSON");
    let cases = cases.as_array().expect("cases");
    assert_eq!(cases.len(), 130);
    for case in cases {
        let name = case["name"].as_str().expect("a name");
        let reason = known.iter().find(|(known, _)| *known == name).map(|(_, reason)| reason);
        match (deviation(case), reason) {
            (Some(found), None) => panic!("{name} {}: {found}", case["text"]),
            (None, Some(reason)) => panic!("{name} is no deviation any more: {reason}"),
            _ => {}
        }
    }
    for (name, _) in known {
        assert!(cases.iter().any(|case| case["name"] == *name), "no case {name}");
    }
}

#[test]
fn px4_definitions_are_read_as_by_its_generator() {
    check(px4_deviation, PX4_DEVIATIONS);
}

#[test]
fn ros2_definitions_are_read_as_by_rosidl() {
    check(ros2_deviation, ROS2_DEVIATIONS);
}
