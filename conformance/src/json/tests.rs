//! The two readers of a message say the same, whatever is wrong with it.

use proptest::prelude::*;
use uavspec_codegen::dynamic::Types;
use uavspec_codegen::msg::Dialect;
use uavspec_codegen::schema::{Form, MessageId};
use uavspec_codegen::{PackageInput, SourceMap, read};

use super::{Plans, Told, Tree};
use crate::definitions::Definitions;
use crate::finding::Findings;
use crate::record::Place;

/// What stands for something else.
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

fn agrees(plans: &Plans, id: MessageId, text: &str) -> Result<bool, TestCaseError> {
    let mut was_clean = false;
    for is_rosbridge in [false, true] {
        let is_clean = plans.is_clean(id, text, is_rosbridge);
        let mut findings = Findings::default();
        let is_explained = match Tree::read(text) {
            Ok(tree) => {
                let told = Told { id, name: "m", place: Place::Line(1), is_rosbridge };
                plans.explain(told, &tree, &mut findings);
                findings.groups().next().is_none()
            }
            Err(_) => false,
        };
        prop_assert_eq!(is_clean, is_explained, "{} {:?}", text, findings);
        was_clean |= is_clean;
    }
    Ok(was_clean)
}

/// Where the values, keys and marks of a text begin and end.
fn pieces(text: &str) -> Vec<usize> {
    let is_mark = |byte: u8| matches!(byte, b'{' | b'}' | b'[' | b']' | b',' | b':');
    let marks = text.bytes().enumerate().filter(|(_, byte)| is_mark(*byte));
    marks.flat_map(|(at, _)| [at, at + 1]).collect()
}

/// Both readers on messages of ROS 2, whose sequences and strings have bounds.
#[test]
fn bounds_of_sequences_and_strings_are_kept() {
    let mut sources = SourceMap::default();
    let text = "string<=3 name\nuint8[<=2] few\nstring[] any\nwstring<=2[<=1] both\nbyte[] raw\n";
    let file = sources.add("Bounded.msg", text.into()).expect("a file");
    let (schema, mistakes) =
        read(&sources, &[PackageInput::new("demo", Form::Msg(Dialect::Ros2), vec![file])]);
    assert!(mistakes.is_empty(), "{mistakes:?}");
    let plans = Plans::new(&schema);
    let broken = |text: &str| {
        let id = MessageId(0);
        agrees(&plans, id, text).expect("both agree");
        let mut findings = Findings::default();
        let told = Told { id, name: "m", place: Place::Line(1), is_rosbridge: true };
        plans.explain(told, &Tree::read(text).expect("JSON"), &mut findings);
        findings
            .groups()
            .map(|group| format!("{} {}", group.subject, group.examples[0].1))
            .collect::<Vec<_>>()
    };
    let good =
        r#"{"name":"\u00e4\u00f6\u00fc","few":[1,2],"any":["","a"],"both":["\ud83d\ude00x"],"raw":"AAEC"}"#;
    assert_eq!(broken(good), Vec::<String>::new());
    for (from, to, said) in [
        (r#""\u00e4\u00f6\u00fc""#, r#""abcd""#, "m.name expected at most 3 characters, found 4"),
        ("[1,2]", "[1,2,3]", "m.few expected at most 2 elements, found 3"),
        ("[1,2]", r#""AQID""#, "m.few expected at most 2 elements, found 3"),
        (r#""\ud83d\ude00x""#, r#""xyz""#, "m.both both[0]: expected at most 2 characters, found 3"),
        (r#""\ud83d\ude00x""#, r#""x","y""#, "m.both expected at most 1 elements, found 2"),
        (r#""AAEC""#, r#""AAE""#, "m.raw expected an array, found \"AAE\""),
        (r#"["","a"]"#, r#"["",[]]"#, "m.any any[1]: expected a string, found an array of 0"),
    ] {
        assert!(good.contains(from), "{from}");
        assert_eq!(broken(&good.replace(from, to)), [said], "{to}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3_000))]

    #[test]
    fn both_readers_agree(
        which in any::<prop::sample::Index>(),
        changes in prop::collection::vec(
            (any::<prop::sample::Index>(), 0_usize..3, prop::sample::select(&PIECES[..])), 0..3
        ),
        typo in prop::option::weighted(0.3, (any::<prop::sample::Index>(), any::<char>())),
    ) {
        thread_local! {
            static DEFINITIONS: (Definitions, Types, Plans) = {
                let definitions = Definitions::built_in();
                let (types, plans) = (Types::new(&definitions.schema), Plans::new(&definitions.schema));
                (definitions, types, plans)
            };
        }
        DEFINITIONS.with(|(definitions, types, plans)| {
            let at = which.index(definitions.schema.messages.len());
            let id = MessageId(u32::try_from(at).unwrap_or_default());
            let mut text = types.get(id).default().view().to_json_text().unwrap_or_default();
            for (place, span, piece) in &changes {
                let places = pieces(&text);
                if places.is_empty() {
                    break;
                }
                let from = place.index(places.len());
                let to = (from + span).min(places.len() - 1);
                text.replace_range(places[from]..places[to], piece);
            }
            if let Some((place, letter)) = typo {
                let places: Vec<usize> = text.char_indices().map(|(at, _)| at).collect();
                if !places.is_empty() {
                    text.insert(places[place.index(places.len())], letter);
                }
            }
            agrees(plans, id, &text)?;
            Ok::<(), TestCaseError>(())
        })?;
    }
}

#[test]
fn the_messages_that_are_tried_are_often_clean() {
    let definitions = Definitions::built_in();
    let (types, plans) = (Types::new(&definitions.schema), Plans::new(&definitions.schema));
    let mut clean = 0;
    let count = definitions.schema.messages.len();
    for at in 0..count {
        let id = MessageId(u32::try_from(at).expect("few"));
        let text = types.get(id).default().view().to_json_text().expect("JSON");
        clean += usize::from(agrees(&plans, id, &text).expect("both agree"));
    }
    assert!(clean * 2 > count, "{clean} of {count}");
}
