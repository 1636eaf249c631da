//! Tests of the differences that definitions decide, and of undecided differences.

use serde_json::json;
use uavspec_dynamic::conversion::{Elements, Step};
use uavspec_schema::msg::Dialect;

use super::support::{convert, convert_dialect};

/// The undecided parts of a conversion between two versions of a message.
fn undecided(old: &str, new: &str, hints: &str) -> String {
    convert(&[("Glider", old)], &[("Glider", new)], hints).problems()
}

#[test]
fn types_that_hold_all_values_are_copied() {
    for (narrow, wide) in [
        ("uint8", "uint16"),
        ("uint8", "int16"),
        ("int32", "int64"),
        ("float32", "float64"),
        ("uint16", "float32"),
        ("uint32", "float64"),
    ] {
        let [old, new] = [narrow, wide].map(|ty| format!("{ty} sink\n"));
        let found = convert(&[("Glider", &old)], &[("Glider", &new)], "");
        assert!(found.forward("Glider").is_decided(), "{narrow} to {wide}");
        assert!(!found.backward("Glider").is_decided(), "{wide} to {narrow}");
        assert!(found.problems().ends_with(&format!(": {narrow} and {wide}\n")), "{}", found.problems());
    }
    for (one, other) in [
        ("bool", "uint8"),
        ("int32", "float32"),
        ("float32", "int64"),
        ("char[4]", "uint8[4]"),
        ("uint8", "uint8[2]"),
    ] {
        assert_ne!(undecided(&format!("{one} sink\n"), &format!("{other} sink\n"), ""), "", "{one} {other}");
    }
}

#[test]
fn narrowing_policies_decide() {
    let policies = [("nearest", json!(255)), ("neutral", json!(7))];
    for (policy, expected) in policies {
        let hints = format!("[[hint]]\nmessage = \"Glider\"\nnarrow = {{ sink = \"{policy}\" }}\n");
        let found = convert(
            &[("Glider", "uint8 sink  # [@invalid 7]\n")],
            &[("Glider", "uint16 sink  # [@invalid 7]\n")],
            &hints,
        );
        assert_eq!(found.problems(), "");
        assert_eq!(found.converted(found.backward("Glider"), r#"{"sink": 300}"#)["sink"], expected);
        assert_eq!(found.converted(found.backward("Glider"), r#"{"sink": 30}"#)["sink"], json!(30));
    }
}

#[test]
fn numbers_that_do_not_fit_get_the_default() {
    let hints = "[[hint]]\nmessage = \"Glider\"\nnarrow = { sink = \"neutral\" }\n";
    let ros =
        |old: &str, new: &str| convert_dialect(Dialect::Ros2, &[("Glider", old)], &[("Glider", new)], hints);
    let found = ros("int32 sink\n", "int8 sink 7\n");
    assert_eq!(found.problems(), "");
    let converted = |sink: i64| {
        let message = found.message(found.forward("Glider").from, &format!(r#"{{"sink": {sink}}}"#));
        found.run(found.forward("Glider"), &message)["sink"].clone()
    };
    assert_eq!([300, -300, 30].map(converted), [json!(7), json!(7), json!(30)]);
    let found = ros("int32[2] sink\n", "int8[2] sink [1, 2]\n");
    assert_eq!(
        found.problems(),
        "`Glider.sink` has no neutral value for numbers that don't fit: its elements have no common default\n"
    );
}

#[test]
fn numbers_that_do_not_fit_need_a_valid_neutral_value() {
    let hints = "[[hint]]\nmessage = \"Glider\"\nnarrow = { sink = \"neutral\" }\n";
    let range = "# [@range 1, 9] Rate";
    let text = undecided(&format!("int32 sink  {range}\n"), &format!("int8 sink  {range}\n"), hints);
    let expected = "`Glider.sink` has no neutral value for numbers that don't fit: 0 is not a valid value, and the \
                    definition has no value for missing data\n";
    assert_eq!(text, expected);
}

#[test]
fn a_missing_neutral_value_is_reported_once() {
    let hints = "[[hint]]\nmessage = \"Glider\"\nnarrow = { sink = \"neutral\" }\n";
    let range = "# [@range 1, 9] Rate";
    let text = undecided(&format!("int32[2] sink  {range}\n"), &format!("int8[3] sink  {range}\n"), hints);
    let expected = "`Glider.sink` has more elements, and 0 is not a valid value, and the definition has no value for \
                    missing data\n";
    assert_eq!(text, expected);
}

#[test]
fn renamed_fields_are_copied_only_if_their_comments_are_the_same() {
    let old = "float32 sink  # Sink rate\n";
    let found = convert(&[("Glider", old)], &[("Glider", "float32 rate_of_sink  # Sink rate\n")], "");
    assert_eq!(found.problems(), "");
    let new = found.converted(found.forward("Glider"), r#"{"sink": 2}"#);
    assert_eq!(new["rate_of_sink"], json!(2.0));
    for new in ["float32 sink_filtered  # Filtered sink rate\n", "float32 bearing  # Bearing\n"] {
        let name = new.split_whitespace().nth(1).expect("a name");
        let text = undecided(old, new, "");
        assert!(text.contains(&format!("`Glider.{name}` may be `sink` under another name")), "{text}");
        let hint = format!("[[hint]]\nmessage = \"Glider\"\nrename = {{ sink = \"{name}\" }}\n");
        assert_eq!(undecided(old, new, &hint), "");
        let hint = format!("[[hint]]\nmessage = \"Glider\"\nnew.{name} = 0\nold.sink = nan\n");
        assert_eq!(undecided(old, new, &hint), "");
    }
}

#[test]
fn changed_meanings_are_undecided() {
    for (old, new, part) in [
        (
            "float32 sink  # [m/s] Rate\n",
            "float32 sink  # [cm/s] Rate\n",
            "a different unit: cm/s instead of m/s",
        ),
        (
            "float32 x  # [m] [@frame NED] X\n",
            "float32 x  # [m] [@frame FRD] X\n",
            "a different frame: FRD instead of NED",
        ),
        (
            "float32 x  # [m] [@invalid -1] X\n",
            "float32 x  # [m] [@invalid NaN] X\n",
            "a different value for missing data: NaN instead of -1",
        ),
        ("uint8 MODE_A = 1\nuint8 mode\n", "uint8 MODE_A = 2\nuint8 mode\n", "`MODE_A` is 2 instead of 1"),
        (
            "uint8 MODE_LIFT = 1\nuint8 mode\n",
            "uint8 MODE_TOW = 1\nuint8 mode\n",
            "1 is `MODE_TOW` instead of `MODE_LIFT`",
        ),
    ] {
        let found = undecided(old, new, "");
        assert!(found.contains(part), "{found}");
        let name =
            if old.contains("MODE") { new.split_whitespace().nth(1) } else { old.split_whitespace().nth(1) };
        let hint = format!("[[hint]]\nmessage = \"Glider\"\nsame = [\"{}\"]\n", name.expect("a name"));
        assert_eq!(undecided(old, new, &hint), "", "{part}");
    }
    // A reference to a renamed field is the same frame, unless the hint gives the new field another value.
    let [old, new] = ["axes", "axis"].map(|name| {
        format!("uint8 {name}  # Axes of the wind\nfloat32 wind  # [m/s] [@frame @{name}] Wind\n")
    });
    assert_eq!(undecided(&old, &new, ""), "");
    let hint = "[[hint]]\nmessage = \"Glider\"\nnew.axis = 0\nold.axes = 0\n";
    let found = undecided(&old, &new, hint);
    assert!(found.contains("a different frame: @axis instead of @axes"), "{found}");
    // Adding or removing an annotation is not a contradiction.
    assert_eq!(undecided("float32 sink\n", "float32 sink  # [m/s] Rate\n", ""), "");
}

#[test]
fn enums_convert_by_name() {
    let old = "uint8 mode  # [@enum MODE]\nuint8 MODE_A = 0\nuint8 MODE_B = 1\nuint8 MODE_C = 2\n";
    let new = "uint8 mode  # [@enum MODE]\nuint8 MODE_A = 0\nuint8 MODE_C = 1\nuint8 MODE_B = 2\n";
    let found = convert(&[("Glider", old)], &[("Glider", new)], "");
    assert_eq!(found.problems(), "");
    for conversion in [found.forward("Glider"), found.backward("Glider")] {
        for (before, after) in [(0, 0), (1, 2), (2, 1), (9, 9)] {
            let fields = json!({"mode": before}).to_string();
            assert_eq!(found.converted(conversion, &fields)["mode"], json!(after));
        }
    }
}

#[test]
fn an_enum_that_becomes_a_float_is_undecided_if_its_numbers_change() {
    let old = "uint8 mode  # [@enum MODE]\nuint8 MODE_A = 0\nuint8 MODE_B = 1\n";
    let new = "float32 mode\nuint8 MODE_A = 1\nuint8 MODE_B = 0\n";
    let text = undecided(old, new, "");
    assert!(text.contains("`Glider.mode` changed its type and the numbers of its constants"), "{text}");
}

#[test]
fn a_new_bool_may_state_its_value_for_missing_data() {
    for (value, expected) in [("0", false), ("1", true)] {
        let new = format!("uint8 id\nbool is_towed  # [@invalid {value}]\n");
        let found = convert(&[("Glider", "uint8 id\n")], &[("Glider", &new)], "");
        assert_eq!(found.problems(), "");
        let converted = found.converted(found.forward("Glider"), r#"{"id": 3}"#);
        assert_eq!(converted["is_towed"], json!(expected));
    }
}

#[test]
fn flags_convert_bit_by_bit() {
    let old = "uint8 faults  # [@flags FAULT]\nuint8 FAULT_A = 1\nuint8 FAULT_B = 2\nuint8 FAULT_C = 4\n";
    let new = "uint8 faults  # [@flags FAULT]\nuint8 FAULT_C = 1\nuint8 FAULT_B = 2\nuint8 FAULT_A = 4\n";
    let found = convert(&[("Glider", old)], &[("Glider", new)], "");
    assert_eq!(found.problems(), "");
    for (before, after) in [(0, 0), (1, 4), (3, 6), (7, 7), (64 + 5, 64 + 5), (64 + 4, 64 + 1)] {
        let fields = json!({"faults": before}).to_string();
        assert_eq!(found.converted(found.forward("Glider"), &fields)["faults"], json!(after));
    }
}

#[test]
fn constants_without_a_counterpart_are_undecided_in_one_direction() {
    let old = "uint8 mode  # [@enum MODE]\nuint8 MODE_A = 0\n";
    let new = "uint8 mode  # [@enum MODE]\nuint8 MODE_A = 0\nuint8 MODE_B = 1\n";
    let found = convert(&[("Glider", old)], &[("Glider", new)], "");
    assert!(found.forward("Glider").is_decided() && !found.backward("Glider").is_decided());
    assert_eq!(found.problems(), "`Glider.mode`: the old definition has no counterpart of `MODE_B`\n");
    let hints = "[[hint]]\nmessage = \"Glider\"\nold.mode = { MODE_B = \"MODE_A\" }\n";
    let found = convert(&[("Glider", old)], &[("Glider", new)], hints);
    assert_eq!(found.problems(), "");
    assert_eq!(found.converted(found.backward("Glider"), r#"{"mode": 1}"#)["mode"], json!(0));
    let losses: Vec<&str> = found.backward("Glider").losses.iter().map(|loss| loss.text.as_str()).collect();
    assert_eq!(losses, ["`mode`: `MODE_A`, `MODE_B` have the same counterpart"]);
}

#[test]
fn arrays_are_cut_and_extended_and_their_counts_limited() {
    let text = |length| format!("uint8 count  # [@count items]\nuint16[{length}] items  # [@invalid 9]\n");
    let found = convert(&[("Glider", &text(2))], &[("Glider", &text(4))], "");
    assert_eq!(found.problems(), "");
    let new = found.converted(found.forward("Glider"), r#"{"count": 2, "items": [1, 2]}"#);
    assert_eq!(new, json!({"count": 2, "items": [1, 2, 9, 9]}));
    let old = found.converted(found.backward("Glider"), r#"{"count": 3, "items": [1, 2, 3, 4]}"#);
    assert_eq!(old, json!({"count": 2, "items": [1, 2]}));
}

#[test]
fn sequences_and_strings_of_ros_are_cut() {
    let found = convert_dialect(
        Dialect::Ros2,
        &[("Glider", "string<=8 name\nuint8[] data\nuint8[<=3] few\n")],
        &[("Glider", "string<=3 name\nuint8[<=2] data\nuint8[2] few\n")],
        "",
    );
    assert_eq!(found.problems(), "");
    let new = found.converted(found.forward("Glider"), r#"{"name": "äöüß", "data": [1, 2, 3], "few": [7]}"#);
    assert_eq!(new, json!({"name": "äöü", "data": [1, 2], "few": [7, 0]}));
    let kept: Vec<bool> = (0..3).map(|at| found.forward("Glider").keeps(at)).collect();
    assert_eq!(kept, [false; 3]);
}

#[test]
fn a_new_field_without_a_valid_neutral_value_is_undecided() {
    let text = undecided("bool a\n", "bool a\nuint8 share  # [%] [@range 1, 100] Share\n", "");
    assert_eq!(
        text,
        "`Glider.share` has no neutral value: 0 is not a valid value, and the definition has no value for missing data\n"
    );
}

#[test]
fn lists_fields_whose_valid_values_differ() {
    let [old, new] =
        ["", "[@range 1, 2] "].map(|range| format!("float32 a  # {range}A\nfloat32 b  # [@range 0, 1] B\n"));
    let found = convert(&[("Glider", &old)], &[("Glider", &new)], "");
    assert_eq!(found.forward("Glider").unchecked, [0]);
    assert!(found.backward("Glider").unchecked.is_empty());
}

#[test]
fn undecided_nested_messages_block_the_messages_that_contain_them() {
    let found = convert(
        &[("Glider", "Rate rate\n"), ("Rate", "float32 sink  # [m/s] Rate\n")],
        &[("Glider", "Rate rate\n"), ("Rate", "float32 sink  # [cm/s] Rate\n")],
        "",
    );
    assert!(found.forward("Glider").undecided.is_empty());
    assert!(!found.forward("Glider").is_decided());
    assert_eq!(found.conversions.undecided().len(), 1);
}

#[test]
fn nested_conversions_are_shared() {
    // Without sharing, each level would double the number of conversions.
    let mut definitions = vec![("L0".to_owned(), "uint8 a\n".to_owned())];
    for level in 1..15 {
        let inner = level - 1;
        definitions.push((format!("L{level}"), format!("L{inner} one\nL{inner} two\n")));
    }
    let definitions: Vec<(&str, &str)> =
        definitions.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    let found = convert(&definitions, &definitions, "");
    assert_eq!(found.conversions.forward.len(), 15);
    let Step::Copy(copy) = &found.forward("L14").steps[0] else { panic!("a copy") };
    assert!(matches!(&copy.elements, Elements::Message(_)));
}
