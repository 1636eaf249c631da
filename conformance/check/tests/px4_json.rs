//! Tests that both readers of a message agree on any text, and that the checks of JSON and memory agree.

use std::sync::LazyLock;

use proptest::prelude::*;
use serde_json::json;
use uavspec_dynamic::Types;
use uavspec_model::json::Tree;
use uavspec_model::{Findings, Location};
use uavspec_px4::json::{MessageOrigin, Plans};
use uavspec_px4::memory::Plan;
use uavspec_rules::definitions::Definitions;
use uavspec_schema::msg::Dialect;
use uavspec_schema::{Form, MessageId, PackageInput, SourceMap, read};
use uavspec_test_support::extent;

static DEFINITIONS: LazyLock<Definitions> = LazyLock::new(Definitions::built_in);

static PLANS: LazyLock<Plans<'static>> =
    LazyLock::new(|| Plans::new(&DEFINITIONS.schema, DEFINITIONS.types(), &uavspec_rules::px4::VALUES));

/// The texts that replace random pieces of a message.
const PIECES: [&str; 28] = [
    "null",
    "true",
    "0",
    "-0",
    "1.0",
    "-1",
    "255",
    "256",
    "1e400",
    "1e39",
    "18446744073709551615",
    "18446744073709551616",
    "NaN",
    "-Infinity",
    "\"\"",
    "\"AAAA\"",
    "\"\\u0000\"",
    "\"\\ud800\"",
    "[]",
    "[0]",
    "{}",
    ",",
    ":",
    "}",
    "]",
    "\"",
    " ",
    "\"timestamp\":0,",
];

fn agrees(plans: &Plans<'_>, id: MessageId, text: &str) -> Result<bool, TestCaseError> {
    let mut was_clean = false;
    for is_rosbridge in [false, true] {
        let is_clean = plans.read_text(id, text, is_rosbridge, &mut []).is_ok();
        let mut findings = Findings::default();
        let is_explained = match Tree::read(text) {
            Ok(tree) => {
                let origin = MessageOrigin {
                    id,
                    name: "m",
                    location: Location::Line(1),
                    key: None,
                    is_rosbridge,
                    shared: None,
                };
                let (_, has_ignored) = plans.explain_with_ignored(origin, &tree, &mut findings);
                // The fast reader doesn't ignore unused entries.
                findings.groups().next().is_none() && !has_ignored
            }
            Err(_) => false,
        };
        prop_assert_eq!(is_clean, is_explained, "{} {:?}", text, findings);
        was_clean |= is_clean;
    }
    Ok(was_clean)
}

/// The findings: the id of the rule, the subject, and the count.
fn listed(findings: &Findings) -> Vec<(&'static str, String, u64)> {
    findings.groups().map(|group| (group.rule.id, group.subject.clone(), group.count)).collect()
}

/// The boundaries of the values, keys and punctuation in a text.
fn pieces(text: &str) -> Vec<usize> {
    let is_mark = |byte: u8| matches!(byte, b'{' | b'}' | b'[' | b']' | b',' | b':');
    let marks = text.bytes().enumerate().filter(|(_, byte)| is_mark(*byte));
    marks.flat_map(|(at, _)| [at, at + 1]).collect()
}

/// Runs both readers on ROS 2 messages, which have bounded sequences and strings.
#[test]
fn checks_bounds_of_sequences_and_strings() {
    let mut sources = SourceMap::default();
    let text = "string<=3 name\nuint8[<=2] few\nstring[] any\nwstring<=2[<=1] both\nbyte[] raw\n";
    let file = sources.add("Bounded.msg", text.into()).expect("a file");
    let (schema, mistakes) =
        read(&sources, &[PackageInput::new("demo", Form::Msg(Dialect::Ros2), vec![file])]);
    assert!(mistakes.is_empty(), "{mistakes:?}");
    let types = Types::new(&schema);
    let plans = Plans::new(&schema, &types, &uavspec_rules::px4::VALUES);
    let violated = |text: &str| {
        let id = MessageId(0);
        agrees(&plans, id, text).expect("both agree");
        let mut findings = Findings::default();
        let origin = MessageOrigin {
            id,
            name: "m",
            location: Location::Line(1),
            key: None,
            is_rosbridge: true,
            shared: None,
        };
        plans.explain(origin, &Tree::read(text).expect("JSON"), &mut findings);
        findings
            .groups()
            .map(|group| format!("{} {}", group.subject, group.examples[0].1))
            .collect::<Vec<_>>()
    };
    let good =
        r#"{"name":"\u00e4\u00f6\u00fc","few":[1,2],"any":["","a"],"both":["\ud83d\ude00x"],"raw":"AAEC"}"#;
    assert_eq!(violated(good), Vec::<String>::new());
    for (from, to, text) in [
        (r#""\u00e4\u00f6\u00fc""#, r#""abcd""#, "m.name expected at most 3 characters, found 4"),
        ("[1,2]", "[1,2,3]", "m.few expected at most 2 elements, found 3"),
        ("[1,2]", r#""AQID""#, "m.few expected at most 2 elements, found 3"),
        (r#""\ud83d\ude00x""#, r#""xyz""#, "m.both both[0]: expected at most 2 characters, found 3"),
        (r#""\ud83d\ude00x""#, r#""x","y""#, "m.both expected at most 1 elements, found 2"),
        (r#""AAEC""#, r#""AAE""#, "m.raw expected an array, found \"AAE\""),
        (r#"["","a"]"#, r#"["",[]]"#, "m.any any[1]: expected a string, found an array of 0"),
    ] {
        assert!(good.contains(from), "{from}");
        assert_eq!(violated(&good.replace(from, to)), [text], "{to}");
    }
}

/// Checks a message of type `Tow` in JSON and in memory. Asserts that both have the same findings, and returns them.
fn found_in_both(tow: &str, text: &str) -> Vec<(&'static str, String, u64)> {
    let mut sources = SourceMap::default();
    let files = [("Tow.msg", tow), ("Knot.msg", "int16 width  # [@range 1, 9]\n")]
        .map(|(name, text)| sources.add(name, text.into()).expect("a file"));
    let package = PackageInput::new("demo", Form::Msg(Dialect::Ros2), Vec::from(files));
    let (schema, mistakes) = read(&sources, &[package]);
    assert!(mistakes.is_empty(), "{mistakes:?}");
    let at = schema.messages.iter().position(|message| message.name == "Tow").expect("a message");
    let id = MessageId(u32::try_from(at).expect("few"));

    let (mut in_json, mut in_memory) = (Findings::default(), Findings::default());
    let location = Location::Line(1);
    let origin = MessageOrigin { id, name: "m", location, key: None, is_rosbridge: false, shared: None };
    let types = Types::new(&schema);
    let plans = Plans::new(&schema, &types, &uavspec_rules::px4::VALUES);
    plans.explain(origin, &Tree::read(text).expect("JSON"), &mut in_json);
    let message = types.get(id).from_json_text(text).expect("a message");
    let plan = Plan::new(types.get(id), Some(types.get(id)), &uavspec_rules::px4::VALUES);
    plan.check(message.memory(), "m".into(), location, &mut in_memory);

    let found = listed(&in_json);
    assert_eq!(found, listed(&in_memory), "{tow} {text}");
    found
}

/// Checks a message with counted arrays in JSON and in memory. Each entry violates its range, so the number of findings
/// equals the number of used entries.
#[test]
fn json_and_memory_agree_on_the_entries_in_use() {
    const HIGH: &str = "[@invalid 255] [@uncontrolled 254]";
    // One special value is less than the array length, and the other one is written as a float.
    const LOW: &str = "[@range 2, 7] [@invalid 1] [@uncontrolled 254.0]";
    // The array length is at least the special value.
    const WITHIN: &str = "[@invalid 2]";
    let (too_long, out_of_range) = (Some("PX-LEN-01"), Some("PX-RANGE-01"));
    for (special, count, in_use, violated) in [
        (HIGH, -1, 0, None),
        (HIGH, 0, 0, None),
        (HIGH, 2, 2, None),
        (HIGH, 3, 3, None),
        (HIGH, 4, 3, too_long),
        (HIGH, 253, 3, too_long),
        (HIGH, 254, 0, None),
        (HIGH, 255, 0, None),
        (HIGH, 256, 3, too_long),
        (LOW, -1, 0, out_of_range),
        (LOW, 0, 0, out_of_range),
        (LOW, 1, 0, None),
        (LOW, 2, 2, None),
        (LOW, 3, 3, None),
        (LOW, 4, 3, too_long),
        (LOW, 254, 0, None),
        (LOW, 255, 3, too_long),
        (WITHIN, 1, 1, None),
        (WITHIN, 2, 0, None),
        (WITHIN, 3, 3, None),
        (WITHIN, 4, 3, too_long),
    ] {
        let tow = format!(
            "int16 num_ropes  # {special} [@count ropes]\nuint8[3] ropes  # [@range 10, 90]\n\
             int16 num_knots  # {special} [@count knots]\nKnot[3] knots\n\
             int16 num_turns  # {special} [@count turns]\nuint8[<=3] turns  # [@range 1, 9]\n"
        );
        let text = json!({
            "num_ropes": count, "ropes": [0, 0, 0],
            "num_knots": count, "knots": vec![json!({"width": 0}); 3],
            "num_turns": count, "turns": [0, 0, 0],
        });
        let mut expected: Vec<(&str, String, u64)> = Vec::new();
        for (array, value) in [("knots", "knots.width"), ("ropes", "ropes"), ("turns", "turns")] {
            expected.extend(violated.map(|rule| (rule, format!("m.num_{array}"), 1)));
            if in_use > 0 {
                expected.push(("PX-RANGE-01", format!("m.{value}"), in_use));
            }
        }
        expected.sort_unstable();
        assert_eq!(found_in_both(&tow, &text.to_string()), expected, "{special} {count}");
    }
}

/// Any count is valid for a sequence without a bound, including the special one.
#[test]
fn a_special_count_leaves_the_entries_of_a_sequence_unchecked() {
    let tow = "int16 num_loops  # [@invalid 255] [@count loops]\nuint8[] loops  # [@range 1, 9]\n";
    for (count, in_use) in [(0, 0), (2, 2), (254, 3), (255, 0)] {
        let text = json!({"num_loops": count, "loops": [0, 0, 0]}).to_string();
        let found = (in_use > 0).then(|| ("PX-RANGE-01", "m.loops".to_owned(), in_use));
        assert_eq!(found_in_both(tow, &text), Vec::from_iter(found), "{count}");
    }
}

/// JSON Schema accepts `5.0` as an integer. Some programs write all numbers in this form.
#[test]
fn integers_may_be_written_with_a_fraction_of_zero() {
    let mut sources = SourceMap::default();
    let text = "uint64 timestamp\nint8 small # [@range -3, 5]\nuint8 count\nint32[2] pair\nbool flag\n";
    let file = sources.add("Whole.msg", text.into()).expect("a file");
    let package = PackageInput::new("demo", Form::Msg(Dialect::Px4), vec![file]);
    let (schema, mistakes) = read(&sources, &[package]);
    assert!(mistakes.is_empty(), "{mistakes:?}");
    let types = Types::new(&schema);
    let plans = Plans::new(&schema, &types, &uavspec_rules::px4::VALUES);
    let id = MessageId(0);
    let written = |numbers: [&str; 5]| {
        let [timestamp, small, count, first, second] = numbers;
        format!(
            "{{\"timestamp\":{timestamp},\"small\":{small},\"count\":{count},\"pair\":[{first},{second}],\"flag\":true}}"
        )
    };
    let values = |text: &str| {
        assert!(agrees(&plans, id, text).expect("both agree"), "{text}");
        let mut values = vec![0; 64];
        let clean = plans.read_text(id, text, false, &mut values).expect("no findings");
        assert_eq!(clean.timestamp, Some(17_000), "{text}");
        assert_eq!(plans.timestamp(id, &Tree::read(text).expect("JSON")), Some(17_000), "{text}");
        values
    };
    let plain = written(["17000", "-3", "255", "100", "0"]);
    let other = written(["17000.0", "-3.0", "2.55e2", "1e2", "-0"]);
    assert_eq!(values(&plain), values(&other));
    for wrong in ["-4.0", "6.0", "1.5", "1e30", "5e-1", "\"5.0\""] {
        let text = written(["1", wrong, "2", "3", "4"]);
        assert!(!agrees(&plans, id, &text).expect("both agree"), "{text}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(extent(3_000, 900)))]

    #[test]
    fn both_readers_agree(
        which in any::<prop::sample::Index>(),
        changes in prop::collection::vec(
            (any::<prop::sample::Index>(), 0_usize..3, prop::sample::select(&PIECES[..])), 0..3
        ),
        typo in prop::option::weighted(0.3, (any::<prop::sample::Index>(), any::<char>())),
    ) {
        let (plans, types) = (&*PLANS, DEFINITIONS.types());
        let at = which.index(DEFINITIONS.schema.messages.len());
        let id = MessageId(u32::try_from(at).unwrap_or_default());
        let mut text = types.get(id).default().view().to_json_text().unwrap_or_default();
        for (location, span, piece) in &changes {
            let places = pieces(&text);
            if places.is_empty() {
                break;
            }
            let from = location.index(places.len());
            let to = (from + span).min(places.len() - 1);
            text.replace_range(places[from]..places[to], piece);
        }
        if let Some((location, letter)) = typo {
            let places: Vec<usize> = text.char_indices().map(|(at, _)| at).collect();
            if !places.is_empty() {
                text.insert(places[location.index(places.len())], letter);
            }
        }
        agrees(plans, id, &text)?;
    }
}

#[test]
fn most_default_messages_have_no_findings() {
    let mut clean = 0;
    let count = DEFINITIONS.schema.messages.len();
    for at in 0..count {
        let id = MessageId(u32::try_from(at).expect("few"));
        let text = DEFINITIONS.types().get(id).default().view().to_json_text().expect("JSON");
        clean += usize::from(agrees(&PLANS, id, &text).expect("both agree"));
    }
    assert!(clean * 2 > count, "{clean} of {count}");
}

/// Types that are nested too deeply for codecs can still be checked in JSON.
#[test]
fn deeply_nested_messages_are_checked() {
    let mut sources = SourceMap::default();
    let mut files = Vec::new();
    for depth in 0..40 {
        let inner = if depth == 39 { "uint8 end".to_owned() } else { format!("Level{} inner", depth + 1) };
        files.push(
            sources
                .add(format!("Level{depth}.msg"), format!("uint64 timestamp\n{inner}\n").into())
                .expect("a file"),
        );
    }
    let (schema, mistakes) = read(&sources, &[PackageInput::new("demo", Form::Msg(Dialect::Px4), files)]);
    assert!(mistakes.is_empty(), "{mistakes:?}");
    let types = Types::new(&schema);
    let plans = Plans::new(&schema, &types, &uavspec_rules::px4::VALUES);
    let at = schema.messages.iter().position(|message| message.name == "Level0").expect("a message");
    let id = MessageId(u32::try_from(at).expect("few"));
    assert!(types.get(id).defect().is_some());
    let text = |end: &str| {
        (0..39).fold(format!(r#"{{"timestamp":0,"end":{end}}}"#), |inner, _| {
            format!(r#"{{"timestamp":0,"inner":{inner}}}"#)
        })
    };
    assert!(agrees(&plans, id, &text("1")).expect("both agree"));
    assert!(!agrees(&plans, id, &text("256")).expect("both agree"));
}
