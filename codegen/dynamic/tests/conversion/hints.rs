//! Mistakes in hints.

use uavspec_schema::msg::Dialect;

use super::support::{convert, convert_dialect};

const OLD: &str = "uint8 count\nuint8 MODE_A = 1\nfloat32 sink\nuint8[2] list\n";
const NEW: &str = "uint8 count\nuint8 MODE_A = 2\nuint8 MODE_B = 3\nfloat32 bank_angle_of_left_wing\nfloat32 sink\nuint8[2] list\nbool is_new\n";

#[track_caller]
fn reports(hint: &str, expected: &[&str]) {
    let hints = format!("[[hint]]\nmessage = \"Glider\"\n{hint}\n");
    let found = convert(&[("Glider", OLD)], &[("Glider", NEW)], &hints);
    let all = found.hints.mistakes.iter().chain(&found.conversions.mistakes);
    let lines: Vec<String> = all
        .map(|mistake| {
            let position = found.sources.position(mistake.span);
            format!("{}:{}: {}", position.line, position.column, mistake.message)
        })
        .collect();
    assert_eq!(lines, expected);
}

#[test]
fn reports_all_mistakes_of_a_file_with_locations() {
    reports(
        "nwe.count = 1\nversions = [1]\nnarrow = { sink = \"round\" }\nsame = \"sink\"\ntopic = 3\nnew.count = [1]",
        &[
            "3:1: unknown key `nwe` in a hint",
            "4:12: `versions`: expected two numbers, such as [0, 1], found type array",
            "5:19: unknown policy `round`",
            "6:8: `same`: expected an array of names, found type string",
            "7:9: `topic`: expected a string, found type integer",
            "8:13: `count`: expected a number, true, false, an expression in quotes, or a table of constants, found type array",
        ],
    );
    reports("same = []", &["1:1: the hint decides nothing"]);
    let found = convert(&[("Glider", OLD)], &[("Glider", NEW)], "[[hint]]\nsame = [\"sink\"]\n\n[[hnit]]\n");
    let messages: Vec<&str> = found.hints.mistakes.iter().map(|mistake| mistake.message.as_str()).collect();
    assert_eq!(messages, ["the hint doesn't name its message", "unknown key `hnit`"]);
    let found = convert(&[("Glider", OLD)], &[("Glider", NEW)], "[[hint]\nmessage = 1 2\n");
    assert!(!found.hints.mistakes.is_empty());
}

#[test]
fn reports_syntax_errors_of_expressions_at_their_position() {
    for (expression, expected) in [
        ("", "3:14: expected a value"),
        ("count +", "3:21: expected a value"),
        ("count $ 2", "3:20: unexpected character `$`"),
        ("(count", "3:20: expected `)`, found the end"),
        ("if count then 1", "3:29: expected `else`, found the end"),
        ("1 < 2 < 3", "3:20: comparisons can't be chained; combine them with `and`"),
        ("count 2", "3:20: expected an operator, found `2`"),
        ("0x", "3:14: `0x` is not a number"),
        ("1.2.3", "3:14: `1.2.3` is not a number"),
        ("a.b.c", "3:14: `a.b.c`: expected a field, or a constant such as `NAME`, `old.NAME` or `new.NAME`"),
        ("then", "3:14: expected a value, found `then`"),
    ] {
        reports(&format!("new.count = \"{expression}\""), &[expected]);
    }
    let deep = format!("{}1{}", "(".repeat(1000), ")".repeat(1000));
    reports(&format!("new.count = \"{deep}\""), &["3:78: the expression is nested more than 64 levels deep"]);
    let deep = "not ".repeat(900);
    reports(
        &format!("new.is_new = \"{deep}true\""),
        &["3:267: the expression is nested more than 64 levels deep"],
    );
}

#[test]
fn checks_the_types_of_expressions() {
    for (hint, expected) in [
        ("new.count = \"sink + 1\"", "`count`: expected an integer, found a float"),
        ("new.is_new = \"count + 1\"", "`is_new`: expected a boolean, found an integer"),
        ("new.count = \"not count\"", "`not` can't be applied to an integer"),
        ("new.count = \"~sink\"", "`~` can't be applied to a float"),
        ("new.count = \"count & sink\"", "`&` can't be applied to a float"),
        (
            "new.count = \"if count then 1 else 2\"",
            "the condition is an integer; compare it, for example with 0",
        ),
        ("new.count = \"if true then 1 else false\"", "expected an integer, found a boolean"),
        ("new.count = \"MODE_A\"", "`MODE_A` has two values; write `old.MODE_A` or `new.MODE_A`"),
        ("new.count = \"list + 1\"", "`list` is not a number or a boolean"),
        ("new.list = \"count + 1\"", "`list`: the elements of an array can't be computed"),
    ] {
        let hints = format!("[[hint]]\nmessage = \"Glider\"\n{hint}\n");
        let found = convert(&[("Glider", OLD)], &[("Glider", NEW)], &hints);
        let text: Vec<&str> =
            found.conversions.mistakes.iter().map(|mistake| mistake.message.as_str()).collect();
        assert_eq!(text, [expected], "{hint}");
    }
}

#[test]
fn texts_strings_and_sequences_are_not_computed() {
    let convert = |dialect, ty: &str| {
        let text = format!("{ty} a\n");
        let hints = "[[hint]]\nmessage = \"Glider\"\nnew.a = 65\n";
        convert_dialect(dialect, &[("Glider", &text)], &[("Glider", &text)], hints).problems()
    };
    assert_eq!(convert(Dialect::Px4, "char[4]"), "3:5: `a`: a text can't be computed\n");
    assert_eq!(convert(Dialect::Ros2, "uint8[]"), "3:5: `a`: a sequence can't be computed\n");
    let expected = "3:5: `a`: only numbers and booleans can be computed\n";
    assert_eq!(convert(Dialect::Ros2, "string"), expected);
}

#[test]
fn a_field_that_is_copied_from_another_field_needs_a_fitting_type() {
    let hints = "[[hint]]\nmessage = \"Glider\"\nnew.is_new = \"sink\"\nsame = [\"MODE_A\"]\n";
    let found = convert(&[("Glider", OLD)], &[("Glider", NEW)], hints);
    assert_eq!(found.problems(), "`Glider.is_new` changed its type: float32 and bool\n");
}

#[test]
fn operators_have_the_usual_precedence() {
    let value = |expression: &str| {
        let hints = format!(
            "[[hint]]\nmessage = \"Glider\"\nnew.count = \"if {expression} then 1 else 0\"\nsame = [\"MODE_A\"]\n"
        );
        let found = convert(&[("Glider", OLD)], &[("Glider", NEW)], &hints);
        assert_eq!(found.problems(), "", "{expression}");
        found.converted(found.forward("Glider"), r#"{"count": 6, "sink": 0.5}"#)["count"] == 1
    };
    for expression in [
        "1 + 2 * 3 == 7",
        "(1 + 2) * 3 == 9",
        "count & 2 != 0",
        "count & 1 == 0",
        "6 | 1 == 7",
        "5 ^ 1 == 4",
        "not count == 5",
        "not false and true",
        "true or false and false",
        "-count == -6 and ~0 == -1",
        "sink < 1 and sink == 0.5 and nan != nan",
        "1 / 2 == sink and 1 - 1 - 1 == -1",
        "old.MODE_A == 1 and new.MODE_A == 2 and MODE_B == 3",
        "(if count > 3 then 0x10 else 0b1) == 16",
        "1e3 == 1000 and 1.5e-1 < 1",
    ] {
        assert!(value(expression), "{expression}");
    }
}

#[test]
fn results_are_limited_to_the_type() {
    for (value, expected) in [("count - 100", 0), ("count + 1000", 255)] {
        let hints = format!("[[hint]]\nmessage = \"Glider\"\nnew.count = \"{value}\"\n");
        let found = convert(&[("Glider", "uint8 count\n")], &[("Glider", "uint8 count\n")], &hints);
        assert_eq!(found.converted(found.forward("Glider"), r#"{"count": 6}"#)["count"], expected);
    }
}

#[test]
fn hints_apply_only_between_the_named_versions() {
    let text = |version| format!("uint32 MESSAGE_VERSION = {version}\nuint8 count\n");
    let hints = "[[hint]]\nmessage = \"Glider\"\nversions = [1, 2]\nnew.count = 9\n";
    for (old, new, expected) in [(1, 2, 9), (0, 3, 9), (0, 1, 6), (2, 3, 6)] {
        let found = convert(&[("Glider", &text(old))], &[("Glider", &text(new))], hints);
        assert_eq!(found.converted(found.forward("Glider"), r#"{"count": 6}"#)["count"], expected);
    }
}
