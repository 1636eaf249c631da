//! Processes every message of the corpus. The argument is the task. The list of messages is appended to this file.

use std::fmt::Debug;
use std::io::stdin;

use proptest::arbitrary::{Arbitrary, any};
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::TestRunner;
use uavspec_runtime::cdr::ByteOrder;
use uavspec_runtime::schemars::{JsonSchema, schema_for};
use uavspec_runtime::serde::{Serialize, de::DeserializeOwned};
use uavspec_runtime::strategy::invalid;
use uavspec_runtime::{Message, UorbMessage};

struct Row {
    name: &'static str,
    convert: fn(&str, [&[u8]; 2]) -> String,
    schema: fn() -> String,
    strategies: fn(&mut TestRunner),
}

fn row<T: Message + Arbitrary + JsonSchema + Serialize + DeserializeOwned + Debug>(
    name: &'static str,
) -> Row {
    Row { name, convert: convert::<T>, schema: schema::<T>, strategies: strategies::<T> }
}

fn fixed_row<T: UorbMessage + Arbitrary + JsonSchema + Serialize + DeserializeOwned + Debug>(
    name: &'static str,
) -> Row {
    Row { convert: convert_fixed::<T>, ..row::<T>(name) }
}

fn bytes(hex: &str) -> Vec<u8> {
    let digits = |at: usize| u8::from_str_radix(&hex[at..at + 2], 16).expect("hexadecimal digits");
    (0..hex.len()).step_by(2).map(digits).collect()
}

/// Checks that JSON can be converted to CDR and back, in both byte orders. Returns the written JSON.
fn convert<T: Message + Serialize + DeserializeOwned>(text: &str, bytes: [&[u8]; 2]) -> String {
    let value: T = serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"));
    let text = serde_json::to_string(&value).expect("JSON");
    for (order, bytes) in [ByteOrder::LittleEndian, ByteOrder::BigEndian].into_iter().zip(bytes) {
        assert_eq!(value.to_cdr(order).expect("CDR"), bytes, "{order:?} of {text}");
        let read = T::from_cdr_strict(bytes).unwrap_or_else(|error| panic!("{error}: {text}"));
        assert_eq!(serde_json::to_string(&read).expect("JSON"), text, "{order:?}");
        for end in 0..bytes.len() {
            // The truncated payload may end with alignment, so the error may be before its end.
            let error =
                T::from_cdr(&bytes[..end]).err().unwrap_or_else(|| panic!("{end} bytes suffice: {text}"));
            assert!(error.offset <= end, "{error}");
        }
        let mut longer = bytes.to_vec();
        longer.resize(bytes.len().next_multiple_of(4), 0);
        assert!(T::from_cdr(&longer).is_ok(), "alignment after the end of {text}");
        longer.push(0);
        assert!(T::from_cdr(&longer).is_err(), "a byte after the end of {text}");
    }
    text
}

/// Like `convert`, for a message of fixed size. Also checks the memory form and the view.
fn convert_fixed<T: UorbMessage + Serialize + DeserializeOwned>(text: &str, bytes: [&[u8]; 2]) -> String {
    let text = convert::<T>(text, bytes);
    let value: T = serde_json::from_str(&text).expect("the same");
    let payload = value.to_uorb();
    let payload = payload.as_ref();
    for end in 0..payload.len() {
        assert_eq!(T::from_uorb(&payload[..end]).is_ok(), end == T::SIZE_NO_PADDING, "{end} bytes of {text}");
    }
    let read = T::from_uorb_strict(&payload[..T::SIZE_NO_PADDING]).expect("the payload");
    assert_eq!(serde_json::to_string(&read).expect("JSON"), text);
    let seen = T::from_view(T::view(payload).expect("the payload"));
    assert_eq!(seen.to_uorb().as_ref(), payload);
    text
}

fn schema<T: JsonSchema>() -> String {
    serde_json::to_string(&schema_for!(T)).expect("JSON")
}

/// Checks that generated values are valid and survive CDR and JSON, and that mutants violate the stated rule.
fn strategies<T: Message + Arbitrary + Serialize + DeserializeOwned + Debug>(runner: &mut TestRunner) {
    let strategy = any::<T>();
    for _ in 0..30 {
        let value = strategy.new_tree(runner).expect("a value").current();
        assert_eq!(value.validate(), [], "{value:?}");
        let bytes = |value: &T| value.to_cdr(ByteOrder::BigEndian).expect("within bounds");
        let payload = bytes(&value);
        assert_eq!(bytes(&T::from_cdr_strict(&payload).expect("what was written")), payload, "{value:?}");
        let json = serde_json::to_string(&value).expect("JSON");
        assert_eq!(bytes(&serde_json::from_str(&json).expect("what was written")), payload, "{json}");
    }
    let Some(strategy) = invalid::<T>() else { return };
    for _ in 0..30 {
        let invalid = strategy.new_tree(runner).expect("a value").current();
        let found = invalid.value.validate();
        assert_eq!(found.len(), 1, "{invalid:?}: {found:?}");
        assert_eq!((found[0].rule, found[0].path.to_string()), (invalid.rule, invalid.path));
    }
}

fn main() {
    let rows = rows();
    match std::env::args().nth(1).as_deref() {
        // Each line contains a type, its CDR in both byte orders, and its JSON.
        Some("convert") => {
            for line in stdin().lines() {
                let line = line.expect("a line");
                let mut words = line.splitn(4, ' ');
                let mut word = || words.next().expect("four words");
                let (name, little, big, text) = (word(), word(), word(), word());
                let row = rows.iter().find(|row| row.name == name).expect("a type");
                println!("{}", (row.convert)(text, [&bytes(little), &bytes(big)]));
            }
        }
        Some("schemas") => rows.iter().for_each(|row| println!("{} {}", row.name, (row.schema)())),
        Some("strategies") => {
            let mut runner = TestRunner::deterministic();
            rows.iter().for_each(|row| (row.strategies)(&mut runner));
        }
        _ => panic!("unknown task"),
    }
}
