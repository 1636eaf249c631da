//! Does with every message of the corpus what its argument says; the list of all follows at the end.

use std::fmt::Debug;
use std::io::stdin;

use proptest::arbitrary::{Arbitrary, any};
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::TestRunner;
use uavspec_runtime::Message;
use uavspec_runtime::cdr::ByteOrder;
use uavspec_runtime::schemars::{JsonSchema, schema_for};
use uavspec_runtime::serde::{Serialize, de::DeserializeOwned};
use uavspec_runtime::strategy::broken;

struct Row {
    name: &'static str,
    again: fn(&str) -> String,
    schema: fn() -> String,
    strategies: fn(&mut TestRunner),
}

fn row<T: Message + Arbitrary + JsonSchema + Serialize + DeserializeOwned + Debug>(name: &'static str) -> Row {
    Row { name, again: again::<T>, schema: schema::<T>, strategies: strategies::<T> }
}

/// Reads JSON and writes it again.
fn again<T: Serialize + DeserializeOwned>(text: &str) -> String {
    let value: T = serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"));
    serde_json::to_string(&value).expect("JSON")
}

fn schema<T: JsonSchema>() -> String {
    serde_json::to_string(&schema_for!(T)).expect("JSON")
}

/// Values are valid and survive CDR and JSON, or broken as they say.
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
    let Some(strategy) = broken::<T>() else { return };
    for _ in 0..30 {
        let broken = strategy.new_tree(runner).expect("a value").current();
        let found = broken.value.validate();
        assert_eq!(found.len(), 1, "{broken:?}: {found:?}");
        assert_eq!((found[0].rule, found[0].path.to_string()), (broken.rule, broken.path));
    }
}

fn main() {
    let rows = rows();
    match std::env::args().nth(1).as_deref() {
        Some("again") => {
            for line in stdin().lines() {
                let line = line.expect("a line");
                let (name, text) = line.split_once(' ').expect("two words");
                let row = rows.iter().find(|row| row.name == name).expect("a type");
                println!("{}", (row.again)(text));
            }
        }
        Some("schemas") => rows.iter().for_each(|row| println!("{} {}", row.name, (row.schema)())),
        Some("strategies") => {
            let mut runner = TestRunner::deterministic();
            rows.iter().for_each(|row| (row.strategies)(&mut runner));
        }
        _ => panic!("what shall be done?"),
    }
}
