//! Small definitions at the limits of the language, compared with the reference tools: rosidl for ROS 2, and PX4's
//! generator for PX4.

use std::collections::BTreeMap;
use std::fs;

use serde_json::{Value as Json, json};
use uavspec_emit::inspect;
use uavspec_schema::diagnostic::has_errors;
use uavspec_schema::msg::Dialect;
use uavspec_schema::{Form, PackageInput, SourceMap, read, render};
use uavspec_test_definitions as support;

/// Deviations from PX4's generator, with reasons. The test fails if a listed deviation no longer occurs.
const PX4_DEVIATIONS: &[(&str, &str)] = &[
    ("lone_cr", "a single carriage return doesn't end a line in editors, so it would hide a field"),
    ("tab_sep", "a tab is a separator; read with a warning"),
    ("const_hex", "read as intended, with a warning"),
    ("const_HEX", "read as intended, with a warning"),
    ("const_neghex", "read as intended, with a warning"),
    ("const_bin", "read as intended, with a warning"),
    ("const_oct", "read as intended, with a warning"),
    ("const_nan", "read as intended, with a warning; the generator fails to convert it to an integer"),
    ("const_inf", "read as intended, with a warning; the generator fails to convert it to an integer"),
    ("const_bool_true", "read as intended, with a warning"),
    ("const_bool_2", "a bool can't be 2; the generator silently makes it true"),
    ("const_dup", "the generated C++ doesn't compile"),
    ("field_upper", "the style of a valid identifier is only a warning"),
    ("arr_zero", "C++ has no arrays of length 0"),
    ("arr_huge", "a message of 4 GiB is too large"),
    ("str", "the generator allocates no memory for it"),
    ("byte", "the generator allocates no memory for it"),
    ("time", "the generator allocates no memory for it"),
    ("duration", "the generator allocates no memory for it"),
];

/// Deviations from rosidl, with reasons. Each deviation causes an error or a warning.
const ROS2_DEVIATIONS: &[(&str, &str)] = &[
    ("lead_ws", "rosidl crashes at white space at the start of a line; read with a warning"),
    ("lone_cr", "a single carriage return doesn't end a line in editors, so it would hide a field"),
    ("const_string_hash", "a # in quotes is part of the string, with a warning; rosidl truncates the string"),
    ("default_str_hash", "a # in quotes is part of the string, with a warning; rosidl truncates the string"),
    ("default_str_eq", "an = in quotes doesn't declare a constant; read with a warning"),
    ("arr_huge", "a message of 4 GiB is too large"),
    ("time", "short for builtin_interfaces/Time, with a warning; rosidl's IDL writer fails"),
    ("duration", "short for builtin_interfaces/Duration, with a warning; rosidl's IDL writer fails"),
];

/// Messages that the cases refer to. PX4's generator ran without them.
const COMPANIONS: [(&str, &str, &str); 5] = [
    ("pkg", "Foo.msg", "uint8 a\n"),
    ("pkg", "Header.msg", "uint8 a\n"),
    ("std_msgs", "Header.msg", "uint8 a\n"),
    ("builtin_interfaces", "Time.msg", "int32 sec\nuint32 nanosec\n"),
    ("builtin_interfaces", "Duration.msg", "int32 sec\nuint32 nanosec\n"),
];

/// Reads a case. Returns the model of the message, and a flag that is true if there are warnings. Errors are returned
/// as rendered text.
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

/// The fields and constants in the form of the reference tools.
fn declarations(message: &Json, keys: &[&str]) -> Json {
    let pick = |list: &str, keys: &[&str]| -> Json {
        let entries = message[list].as_array().expect("a list").iter();
        let picked =
            |entry: &Json| keys.iter().map(|key| ((*key).to_owned(), entry[*key].clone())).collect::<Json>();
        entries.map(picked).collect()
    };
    json!({ "fields": pick("fields", keys), "constants": pick("constants", &["type", "name", "value"]) })
}

/// Removes the package names that the tool adds to types, and writes NaN in our notation.
fn normalised(text: &str) -> Json {
    let text = text.replace("\"pkg/", "\"").replace("\"nan\"", "\"NaN\"");
    serde_json::from_str(&text).expect("JSON")
}

fn ros2_deviation(case: &Json) -> Option<String> {
    let is_accepted = case["rosidl"] == "accept" && case["rosidl_idl"] == "accept";
    let found = read_case(case["text"].as_str()?, Dialect::Ros2);
    match (is_accepted, found) {
        (true, Ok((message, has_warnings))) => {
            let found = declarations(&message, &["type", "name", "default"]);
            let expected = normalised(&case["rosidl_out"].to_string());
            assert!(
                found == expected || has_warnings,
                "{} is read otherwise, without a warning",
                case["text"]
            );
            (found != expected).then(|| format!("read as {found}; rosidl reads {expected}"))
        }
        (false, Err(_)) => None,
        (true, Err(diagnostics)) => Some(format!("rejected, but accepted by rosidl:\n{diagnostics}")),
        (false, Ok((message, has_warnings))) => {
            assert!(has_warnings, "{} is rejected by rosidl, and must cause a warning", case["text"]);
            Some(format!("read as {message}, but rejected by rosidl"))
        }
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
                .then(|| format!("read as {found}; genmsg reads {expected}"))
                .or_else(|| layout_deviation(case, text))
        }
        (false, Err(_)) => None,
        (true, Err(diagnostics)) => Some(format!("rejected, but accepted by PX4:\n{diagnostics}")),
        (false, Ok((message, has_warnings))) => {
            assert!(has_warnings, "{text:?} is rejected by PX4, and must cause a warning");
            Some(format!("read as {message}, but rejected by PX4"))
        }
    }
}

/// PX4's generator rejects messages without a timestamp, so the oracle added a timestamp to the cases that have none.
fn layout_deviation(case: &Json, text: &str) -> Option<String> {
    let stamped =
        if text.contains("timestamp") { text.to_owned() } else { format!("{text}\nuint64 timestamp\n") };
    let (message, _) = read_case(&stamped, Dialect::Px4).expect("no error without the timestamp");
    let found = json!([message["uorb"]["size"], message["uorb"]["size_no_padding"], message["hash"]]);
    let tool = &case["px4_tool_out"];
    let expected = json!([tool["struct_size"], tool["size_no_padding"], tool["hash"]]);
    (found != expected).then(|| format!("layout {found}; PX4's is {expected}"))
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
            (None, Some(reason)) => panic!("{name} is not a deviation anymore: {reason}"),
            _ => {}
        }
    }
    for (name, _) in known {
        assert!(cases.iter().any(|case| case["name"] == *name), "missing case {name}");
    }
}

#[test]
fn px4_definitions_match_the_generator_of_px4() {
    check(px4_deviation, PX4_DEVIATIONS);
}

#[test]
fn ros2_definitions_match_rosidl() {
    check(ros2_deviation, ROS2_DEVIATIONS);
}

/// Checks that the defaults of arrays have the values that rosidl reads. The reference file contains no such
/// defaults. rosidl's parser splits lists of numbers at each comma, and skips a comma directly before the closing
/// bracket of a list of strings.
#[test]
fn reads_commas_in_default_lists_as_rosidl_does() {
    let default = |text: &str| {
        let (message, _) = read_case(&format!("{text}\n"), Dialect::Ros2).ok()?;
        Some(message["fields"][0]["default"].clone())
    };
    for (text, expected) in [
        ("int32[] a [1, 2]", Some(json!([1, 2]))),
        ("int32[] a [1, 2,]", None),
        ("int32[] a [1, 2, ]", None),
        ("int32[] a [1 , 2 ]", Some(json!([1, 2]))),
        ("int32[<=3] a [1,2,]", None),
        ("int32[2] a [1,2,]", None),
        ("float32[] a [1.5,]", None),
        ("bool[] a [true,]", None),
        ("int32[] a [1,,2]", None),
        ("int32[] a [,1]", None),
        ("int32[] a [,]", None),
        ("int32[] a []", Some(json!([]))),
        ("int32[] a [ ]", None),
        ("string[] a ['x', 'y',]", Some(json!(["x", "y"]))),
        ("string[2] a ['x', 'y' ,]", Some(json!(["x", "y"]))),
        ("string[] a [x,]", Some(json!(["x"]))),
        ("string[] a ['x', ]", None),
        ("string[] a ['x',,]", None),
        ("string[] a [,]", None),
        ("string[] a []", Some(json!([]))),
        ("string[] a [ ]", None),
    ] {
        assert_eq!(default(text), expected, "{text}");
    }
}

#[test]
fn a_comma_after_the_last_default_is_an_error_with_a_hint() {
    let error = read_case("int32[] a [1, 2,]  # text\n", Dialect::Ros2).expect_err("an error");
    assert!(error.contains("`[1, 2,]` is not a value of type `array`"), "{error}");
    assert!(error.contains("remove the comma after the last element"), "{error}");
}
