//! Compares the schemas that schemars derives with the published schemas: both must accept the same instances.

#![cfg(all(feature = "proptest", feature = "schemars", feature = "serde"))]

use crate::support;

use std::cell::Cell;
use std::fmt::Debug;

use jsonschema::Validator;
use proptest::arbitrary::{Arbitrary, any};
use proptest::prop_assert_eq;
use proptest::test_runner::TestCaseError;
use schemars::JsonSchema;
use serde_json::{Value as Json, json};
use support::every::Every;
use support::{check, extent, for_each_message, published_validator};
use uavspec_runtime::Message;
use uavspec_runtime::serde::Serialize;
use uavspec_runtime::strategy::{invalid, undocumented};
use uavspec_types::flockwave::ErrorCode;
use uavspec_types::px4::battery_status::BatteryWarning;
use uavspec_types::px4::{ArmingCheckReply, BatteryStatus};

const CASES: u32 = 2000;

/// Validators for a type's published and derived schemas.
struct Pair {
    published: Validator,
    derived: Validator,
    /// All numbers in the derived schema, such as ranges and lengths.
    numbers: Vec<Json>,
    accepted: Cell<usize>,
    rejected: Cell<usize>,
}

impl Pair {
    fn of<T: JsonSchema>(name: &str) -> Self {
        let derived = Json::from(schemars::schema_for!(T));
        let mut numbers = Vec::new();
        collect_numbers(&derived, &mut numbers);
        Self {
            published: published_validator(name),
            derived: validator(&derived),
            numbers,
            accepted: Cell::new(0),
            rejected: Cell::new(0),
        }
    }

    fn agree(&self, instance: &Json) -> Result<(), TestCaseError> {
        let verdict = self.published.is_valid(instance);
        let count = if verdict { &self.accepted } else { &self.rejected };
        count.set(count.get() + 1);
        let rejection = self
            .derived
            .iter_errors(instance)
            .next()
            .map(|error| format!("{error} at {}", error.instance_path()));
        prop_assert_eq!(rejection.is_none(), verdict, "{:?}: {}", rejection, instance);
        Ok(())
    }
}

fn validator(schema: &Json) -> Validator {
    jsonschema::meta::validate(schema).expect("a schema");
    jsonschema::validator_for(schema).expect("a schema that compiles")
}

/// Collects all numbers in a schema.
fn collect_numbers(schema: &Json, numbers: &mut Vec<Json>) {
    match schema {
        Json::Number(_) => numbers.push(schema.clone()),
        Json::Array(parts) => parts.iter().for_each(|part| collect_numbers(part, numbers)),
        Json::Object(members) => members.values().for_each(|part| collect_numbers(part, numbers)),
        _ => {}
    }
}

/// Collects JSON pointers to all values in an instance.
fn collect_pointers(instance: &Json, pointer: &str, all: &mut Vec<String>) {
    all.push(pointer.to_owned());
    match instance {
        Json::Array(parts) => {
            let parts = parts.iter().enumerate();
            parts.for_each(|(index, part)| collect_pointers(part, &format!("{pointer}/{index}"), all));
        }
        Json::Object(members) => {
            members.iter().for_each(|(name, part)| collect_pointers(part, &format!("{pointer}/{name}"), all));
        }
        _ => {}
    }
}

/// A random number generator, seeded with bits that the runner draws.
struct Dice(u64);

impl Dice {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(self.0 >> 33).expect("31 bits") % end.max(1)
    }
}

/// Changes one value of an instance. Most changes make the instance invalid.
fn mutate(instance: &mut Json, dice: &mut Dice, numbers: &[Json]) {
    let mut all = Vec::new();
    collect_pointers(instance, "", &mut all);
    let value = instance.pointer_mut(&all[dice.below(all.len())]).expect("a valid pointer");
    match (dice.below(4), value) {
        (0, Json::Object(members)) => {
            // An earlier change may have removed all members.
            let name = members.keys().nth(dice.below(members.len())).cloned().unwrap_or_default();
            members.remove(&name);
        }
        (1, Json::Object(members)) => {
            members.insert("no_such_field".to_owned(), json!(0));
        }
        (0, Json::Array(parts)) => drop(parts.pop()),
        (1, Json::Array(parts)) => parts.extend(parts.first().cloned()),
        (0..=2, Json::String(text)) => *text = "é".repeat(dice.below(60)),
        (0, Json::Number(number)) => *number = neighbour(number, dice),
        (1, value @ Json::Number(_)) => *value = json!(value.as_f64()),
        (2, Json::Number(number)) => {
            let Some(Json::Number(bound)) = numbers.get(dice.below(numbers.len())) else { return };
            *number = neighbour(bound, dice);
        }
        (_, value) => *value = unusual_value(dice),
    }
}

/// The number itself, or the next higher or lower integer or float.
fn neighbour(number: &serde_json::Number, dice: &mut Dice) -> serde_json::Number {
    let step = i128::try_from(dice.below(3)).expect("small") - 1;
    if let Some(value) = number.as_i128() {
        let value = value + step;
        return u64::try_from(value)
            .map(Into::into)
            .or_else(|_| i64::try_from(value).map(Into::into))
            .unwrap_or_else(|_| "1e20".parse().expect("a number"));
    }
    let value = number.as_f64().expect("a float");
    let value = [value.next_down(), value, value.next_up()][dice.below(3)];
    serde_json::Number::from_f64(value).unwrap_or_else(|| number.clone())
}

fn unusual_value(dice: &mut Dice) -> Json {
    let texts = [
        "null",
        "true",
        "false",
        "\"\"",
        "\"1\"",
        "[]",
        "{}",
        "[0]",
        "[null]",
        "0",
        "-1",
        "1",
        "1.0",
        "1.5",
        "-0.0",
        "1e39",
        "-1e39",
        "1e308",
        "3.4028235e38",
        "3.4028236e38",
        "127",
        "128",
        "-129",
        "255",
        "256",
        "255.0",
        "65535",
        "65536",
        "2147483648",
        "4294967295",
        "4294967296",
        "18446744073709551615",
        "18446744073709551616",
        "-9223372036854775808",
        "-9223372036854775809",
        "1e-400",
    ];
    texts[dice.below(texts.len())].parse().expect("JSON")
}

#[test]
fn both_schemas_agree_on_valid_and_mutated_messages() {
    fn compare<T: Message + Arbitrary + JsonSchema + Serialize + Debug>() {
        let pair = Pair::of::<T>(&format!("px4/{}", T::NAME));
        check(CASES, &(any::<T>(), any::<[u64; 4]>()), |(value, bits)| {
            let whole = serde_json::to_value(&value).expect("JSON");
            pair.agree(&whole)?;
            for bits in bits {
                let (mut instance, mut dice) = (whole.clone(), Dice(bits));
                mutate(&mut instance, &mut dice, &pair.numbers);
                pair.agree(&instance)?;
                mutate(&mut instance, &mut dice, &pair.numbers);
                pair.agree(&instance)?;
            }
            Ok(())
        });
        let min = extent(CASES, CASES / 8) as usize / 2;
        assert!(
            pair.accepted.get() > min && pair.rejected.get() > min,
            "{}: too few accepted or rejected instances",
            T::NAME
        );
    }
    for_each_message!(compare);
}

#[test]
fn both_schemas_agree_on_messages_with_a_violation() {
    fn compare<T: Message + JsonSchema + Serialize + Debug>() {
        let pair = Pair::of::<T>(&format!("px4/{}", T::NAME));
        check(CASES, &invalid::<T>().expect("the message has constraints"), |invalid| {
            // Invalid UTF-8 has no JSON form.
            serde_json::to_value(&invalid.value).map_or(Ok(()), |instance| pair.agree(&instance))
        });
        assert!(pair.rejected.get() > 0);
    }
    compare::<ArmingCheckReply>();
    compare::<BatteryStatus>();
}

#[test]
fn both_schemas_agree_on_error_codes() {
    let pair = Pair::of::<ErrorCode>("flockwave/ErrorCode");
    let unknown = undocumented::<ErrorCode>().expect("most codes have no name");
    check(CASES, &(any::<ErrorCode>(), unknown, any::<u64>()), |(known, unknown, bits)| {
        for code in [known, unknown] {
            let mut instance = json!(code);
            pair.agree(&instance)?;
            mutate(&mut instance, &mut Dice(bits), &pair.numbers);
            pair.agree(&instance)?;
        }
        Ok(())
    });
    assert!(pair.accepted.get() > 0 && pair.rejected.get() > 0);
}

#[test]
fn nested_messages_are_references() {
    let schema = Json::from(schemars::schema_for!(ArmingCheckReply));
    assert_eq!(schema["properties"]["events"]["items"], json!({ "$ref": "#/$defs/Event" }));
    assert_eq!(schema["$defs"]["Event"]["properties"]["id"]["maximum"], u32::MAX);
    let names: Vec<&String> = schema["$defs"].as_object().expect("definitions").keys().collect();
    assert_eq!(names, ["Event"]);
}

#[test]
fn documented_values_have_titles() {
    let schema = Json::from(schemars::schema_for!(BatteryWarning));
    assert_eq!(schema["title"], "BatteryWarning");
    assert_eq!(schema["anyOf"][1], json!({ "const": 1, "title": "LOW" }));
    let field = &Json::from(schemars::schema_for!(BatteryStatus))["properties"]["warning"];
    assert_eq!(field["anyOf"], schema["anyOf"]);
    let codes = Json::from(schemars::schema_for!(ErrorCode));
    assert_eq!(codes["anyOf"][0], json!({ "const": 1, "title": "GROUND" }));
    assert_eq!(codes["anyOf"].as_array().expect("a list").len(), ErrorCode::all().len() + 1);
}

/// Covers field types that the published messages lack. A test in `xtask` covers the messages of the corpus.
#[test]
fn fields_of_every_kind_have_a_schema() {
    let schema = Json::from(schemars::schema_for!(Every));
    let validator = validator(&schema);
    check(CASES, &any::<Every>(), |value| {
        let instance = serde_json::to_value(&value).expect("JSON");
        let result = validator.validate(&instance);
        prop_assert_eq!(result.map_err(|error| error.to_string()), Ok(()));
        Ok(())
    });
    let properties = &schema["properties"];
    let items = |bound: u32, items: Json| json!({ "title": "inners", "type": "array", "maxItems": bound, "items": items });
    assert_eq!(properties["inners"], items(3, json!({ "$ref": "#/$defs/Inner" })));
    assert_eq!(properties["wide"], json!({ "title": "wide", "type": "string", "maxLength": 5 }));
    let modes = &properties["modes"]["items"];
    let within = json!([{ "oneOf": [{ "type": "integer", "minimum": -128, "maximum": 4 }, { "const": 9 }] }]);
    assert_eq!(modes["allOf"], within);
    assert_eq!(modes["anyOf"].as_array().expect("a list").len(), 5);
    assert_eq!(schema["$defs"]["Inner"]["properties"]["names"]["items"]["maxLength"], 4);
}

#[test]
fn a_schema_rejects_violations_that_it_can_express() {
    use uavspec_runtime::ConstraintKind;

    let validator = validator(&Json::from(schemars::schema_for!(Every)));
    check(CASES, &invalid::<Every>().expect("the message has constraints"), |invalid| {
        let Ok(instance) = serde_json::to_value(&invalid.value) else { return Ok(()) };
        let is_expressible =
            matches!(invalid.rule, ConstraintKind::Count | ConstraintKind::Range | ConstraintKind::Bound);
        prop_assert_eq!(
            validator.is_valid(&instance),
            !is_expressible,
            "{} at {}",
            invalid.rule,
            invalid.path
        );
        Ok(())
    });
}
