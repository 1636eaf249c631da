//! Tests that the tokenizer accepts the same texts as `serde_json`, and reads the same values.

use proptest::prelude::*;
use serde::de::IgnoredAny;
use serde_json::{Number, Value};
use uavspec_test_support::extent;

use super::super::Tree;
use super::*;

/// Texts that are JSON, or are similar to JSON.
fn texts() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        "[-0-9.eE+]{1,22}",
        "-?(0|[1-9][0-9]{0,20})(\\.[0-9]{1,3})?([eE][-+]?[0-9]{1,3})?",
        "\"[ -~\u{e4}\u{1F6F8}]{0,12}\"",
        "\"([ -!a-c\u{e4}]|\\\\[\"\\\\/bfnrtux]|\\\\u[0-9a-fA-F]{3,4}|\\\\ud[89cd]00){0,6}\"",
        prop::sample::select(
            &["null", "true", "false", "NaN", "-Infinity", "nul", "-Inf", "\"\u{1}\"", "\""][..]
        )
        .prop_map(str::to_owned),
    ];
    leaf.prop_recursive(4, 24, 4, |inner| {
        let separator = prop::sample::select(&[",", " , ", ",\t\n\r", ",,", ""][..]);
        let list = (prop::collection::vec(inner.clone(), 0..4), separator.clone())
            .prop_map(|(values, separator)| format!("[{}]", values.join(separator)));
        let member = ("\"[ab\\\\n]{0,3}\"", prop::sample::select(&[":", " : ", ""][..]), inner)
            .prop_map(|(key, colon, value)| key + colon + &value);
        let object = (prop::collection::vec(member, 0..4), separator)
            .prop_map(|(members, separator)| format!("{{{}}}", members.join(separator)));
        prop_oneof![list, object]
    })
}

/// The equivalent `serde_json` value, if there is one.
fn value(tree: &Tree<'_>) -> Option<Value> {
    Some(match tree {
        Tree::Null => Value::Null,
        Tree::Bool(value) => Value::Bool(*value),
        Tree::Int(value) => Value::Number(Number::from_i128(*value)?),
        Tree::Float(value, _) => Value::Number(Number::from_f64(*value)?),
        Tree::Huge(_) | Tree::Token(_) => return None,
        Tree::Text(text) => Value::String(text.to_string()),
        Tree::List(values) => Value::Array(values.iter().map(value).collect::<Option<_>>()?),
        Tree::Object(members) => {
            let members = members.iter().map(|(key, member)| Some((key.to_string(), value(member)?)));
            Value::Object(members.collect::<Option<_>>()?)
        }
    })
}

fn skips(text: &str) -> bool {
    let mut tokens = Tokens::new(text);
    tokens.skip().is_ok() && tokens.end().is_ok()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(extent(4_096, 768)))]

    #[test]
    fn reads_fractions_like_the_standard_library(text in "-?(0|[1-9][0-9]{0,18})\\.[0-9]{1,21}") {
        let value: f64 = text.parse().expect("a number");
        let found = Tokens::new(&text).token();
        let Ok(Token::Float(found, written)) = found else { panic!("{found:?}") };
        prop_assert_eq!((found.to_bits(), written), (value.to_bits(), &*text));
    }

    #[test]
    fn accepts_the_same_texts_and_values_as_serde_json(
        text in texts(),
        cut in any::<prop::sample::Index>(),
        is_cut in prop::bool::weighted(0.2),
    ) {
        let ends: Vec<usize> = text.char_indices().map(|(at, _)| at).collect();
        let text = if is_cut { &text[..ends[cut.index(ends.len())]] } else { &text };
        let tree = Tree::read(text);
        prop_assert_eq!(tree.as_ref().ok().and_then(value), serde_json::from_str(text).ok(), "{}", text);
        prop_assert_eq!(skips(text), serde_json::from_str::<IgnoredAny>(text).is_ok(), "{}", text);
        if let Err(error) = tree {
            let is_at_end = error.at == text.len();
            prop_assert_eq!(error.problem == TRUNCATED, is_at_end, "{}: {}", text, error);
            prop_assert!(text.is_char_boundary(error.at), "{}: {}", text, error);
        }
    }

    #[test]
    fn reads_an_integer_as_any_token(text in "-?[0-9]{1,20}[,.e ]?") {
        let mut tokens = Tokens::new(&text);
        if let Some(found) = tokens.integer().filter(|_| !matches!(tokens.peek(), Some(b'0'..=b'9' | b'.' | b'e'))) {
            prop_assert_eq!(Tokens::new(&text).token(), Ok(Token::Int(found.into())));
        }
    }
}

#[test]
fn leaves_unusual_numbers_and_strings_to_other_readers() {
    for text in ["-0", "01", "-", "", "1234567890123456789x", "x"] {
        let mut tokens = Tokens::new(text);
        assert!(tokens.integer().is_none() || tokens.end().is_err(), "{text}");
    }
    for text in ["\"\\n\"", "\"", "\"\u{1}\"", "1"] {
        assert_eq!(Tokens::new(text).plain_text(), None, "{text}");
    }
    assert_eq!(Tokens::new(" [1,\"a\"]]").flat_list(), Some("[1,\"a\"]"));
}

#[test]
fn takes_a_key_only_if_it_is_the_whole_key() {
    for name in ["", "id", "velocityNED13", "a_longer_name_than_16_bytes"] {
        let text = format!(" \"{name}\":7}}");
        let mut tokens = Tokens::new(&text);
        assert!(tokens.takes_key(name) && tokens.integer() == Some(7), "{text}");
        for other in [format!("\"{name}x\":7"), format!("\"{name}\" :7"), format!("\"{name}")] {
            let mut tokens = Tokens::new(&other);
            assert!(!tokens.takes_key(name) && tokens.at() == 0, "{other}");
        }
    }
}

#[test]
fn limits_the_depth_of_reading_but_not_of_skipping() {
    for (depth, is_readable) in [(127, true), (128, false), (100_000, false)] {
        for [open, close] in [["[", "]"], ["{\"a\":[", "]}"]] {
            let levels = depth / open.bytes().filter(|byte| matches!(byte, b'{' | b'[')).count();
            let text = open.repeat(levels) + &close.repeat(levels);
            let is_too_deep =
                Tree::read(&text).is_err_and(|error| error.problem == "values are nested too deeply");
            assert_eq!(is_too_deep, !is_readable, "{depth}");
            assert!(skips(&text), "{depth}");
        }
    }
}

/// An error has the offset of the problem, not the offset at which the string starts.
#[test]
fn describes_strings_that_cannot_be_read() {
    for (text, at, problem) in [
        (r#"{"a":"x\ud800"}"#, 7, "unpaired surrogate"),
        (r#"{"a":"\ud800\ud800"}"#, 6, "unpaired surrogate"),
        (r#"{"a\udc00":1}"#, 3, "unpaired surrogate"),
        (r#"["\ud83d\ude00", "\uDFFF x"]"#, 18, "unpaired surrogate"),
        (r#"["\ud83d\u0041"]"#, 2, "unpaired surrogate"),
        (r#"["\ud83d\n"]"#, 2, "unpaired surrogate"),
        (r#"["ab\x"]"#, 4, "an invalid escape"),
        (r#"["ab\u12g4"]"#, 4, "an invalid escape"),
        (r#"["ab\ud83d\u12"]"#, 4, "unpaired surrogate"),
        ("[\"ab\tc\"]", 4, "a control character"),
    ] {
        let error = Tree::read(text).expect_err(text);
        assert_eq!(error.at, at, "{text}: {error}");
        assert!(error.problem.contains(problem), "{text}: {error}");
    }
}
