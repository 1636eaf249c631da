//! Checks that the cases cover all important values. These values are derived from the definitions alone, independently
//! of the emitter.

use std::collections::BTreeSet;

use serde_json::{Value as Json, json};
use uavspec_runtime::Scalar;
use uavspec_schema::msg::constraint::{INVALID, RANGE, UNCONTROLLED};
use uavspec_schema::value::Value;
use uavspec_schema::{Element, Field, Kind, Message, Shape, Stated};

use super::{Emitted, PX4, all};

/// The values of one field, each with the violated rule. Cases are included only if all other fields have the same
/// values as in the `zero` case.
struct FieldCases {
    values: Vec<(Json, Option<String>)>,
}

impl FieldCases {
    fn new(field: &str, cases: &[(Option<&str>, &Json)]) -> Self {
        let of_field = cases.iter().filter(|(name, _)| name.is_none_or(|name| name == field));
        let value = |(_, case): &(Option<&str>, &Json)| {
            Some((case["json"].get(field)?.clone(), case["rule"].as_str().map(str::to_owned)))
        };
        Self { values: of_field.filter_map(value).collect() }
    }

    /// True if a case with `rule` has a value, or an element, that satisfies `is`.
    fn has(&self, rule: Option<&str>, is: impl Fn(&Json) -> bool) -> bool {
        self.values.iter().any(|(value, found)| {
            found.as_deref() == rule
                && (is(value) || value.as_array().is_some_and(|elements| elements.iter().any(&is)))
        })
    }

    fn number(&self, rule: Option<&str>, is: impl Fn(f64) -> bool) -> bool {
        self.has(rule, |value| value.as_f64().is_some_and(&is))
    }
}

/// The cases in which at most one field differs from the `zero` case, each with this field.
fn isolated(cases: &[Json]) -> Vec<(Option<&str>, &Json)> {
    let zero = cases[0]["json"].as_object().expect("the case of zeros comes first");
    let mut isolated = Vec::new();
    for case in cases {
        let Some(json) = case["json"].as_object().filter(|json| json.len() == zero.len()) else { continue };
        let mut names = json.iter().filter(|(name, value)| zero.get(*name) != Some(*value));
        let name = names.next().map(|(name, _)| name.as_str());
        if names.next().is_none() {
            isolated.push((name, case));
        }
    }
    isolated
}

#[test]
fn covers_every_rule_with_a_violation_and_an_adjacent_valid_value() {
    for emitted in all() {
        for (message, _, cases) in emitted.messages() {
            let form = emitted.schema.package_of(message).form;
            let isolated = isolated(&cases);
            for field in &message.fields {
                let name = format!("{} {}", message.name, field.name);
                let tried = FieldCases::new(&field.name, &isolated);
                check_shape(field, &tried, &cases, &name);
                check_values(emitted, message, field, &tried, &name);
            }
            check_payloads(message, &cases, form == PX4 && message.kind == Kind::Message);
        }
    }
}

fn has_id(cases: &[Json], rule: Option<&str>, is: impl Fn(&Json) -> bool) -> bool {
    cases.iter().any(|case| case["rule"].as_str() == rule && is(case))
}

/// Checks presence, type and length.
fn check_shape(field: &Field, tried: &FieldCases, cases: &[Json], name: &str) {
    let lacks = |case: &Json| {
        case["json"].as_object().is_some_and(|json| !json.is_empty() && !json.contains_key(&field.name))
    };
    let is_only_field = cases[0]["json"].as_object().is_some_and(|json| json.len() == 1);
    assert!(has_id(cases, Some("PX-JSON-01"), lacks) || is_only_field, "no case omits {name}");
    assert!(tried.values.iter().any(|(_, rule)| rule.is_none()), "no case has a valid {name}");
    assert!(tried.values.iter().any(|(_, rule)| rule.as_deref() == Some("PX-JSON-02")), "{name}: wrong type");
    let of_length = |rule, length: u32| {
        tried.values.iter().any(|(value, found)| {
            found.as_deref() == rule && value.as_array().is_some_and(|array| array.len() == length as usize)
        })
    };
    match (field.ty.shape, field.ty.element) {
        (_, Element::Text(room)) => {
            let bytes = |rule, length: usize| {
                tried.has(rule, |value| value.as_str().is_some_and(|text| text.len() == length))
            };
            let room = room as usize;
            assert!(
                bytes(None, room) && bytes(None, 0) && bytes(Some("PX-JSON-02"), room + 1),
                "{name}: text"
            );
            assert!(
                has_id(cases, Some("PX-STR-01"), |case| case["id"]
                    .as_str()
                    .expect("an id")
                    .starts_with(&field.name)),
                "{name}: invalid UTF-8"
            );
        }
        (Shape::Array(length), _) => {
            assert!(of_length(None, length), "{name}");
            assert!(
                of_length(Some("PX-ARR-01"), length - 1) && of_length(Some("PX-ARR-01"), length + 1),
                "{name}"
            );
        }
        (Shape::Bounded(bound), _) => {
            assert!(of_length(None, bound) && of_length(Some("PX-CDR-02"), bound + 1), "{name}");
            assert!(of_length(None, 0) && of_length(None, 1), "{name}");
        }
        (Shape::Sequence, _) => assert!(of_length(None, 0) && of_length(None, 1), "{name}"),
        (Shape::Single, _) => {}
    }
    if let Element::String { bound: Some(bound), .. } = field.ty.element {
        let length = |rule, length: u32| {
            tried.has(rule, |value| {
                value.as_str().is_some_and(|text| text.is_ascii() && text.len() == length as usize)
            })
        };
        assert!(length(None, bound) && length(Some("PX-CDR-02"), bound + 1), "{name}: bound");
    }
}

/// Checks numbers and booleans.
fn check_values(emitted: &Emitted, message: &Message, field: &Field, tried: &FieldCases, name: &str) {
    let Element::Scalar(scalar) = field.ty.element else { return };
    if scalar == Scalar::Bool {
        assert!(
            tried.has(None, |value| value == true) && tried.has(Some("PX-JSON-02"), Json::is_number),
            "{name}"
        );
        return;
    }
    if let Some((min, max)) = scalar.integer_bounds() {
        let text = |value: i128| serde_json::from_str::<Json>(&value.to_string()).expect("a number");
        for outside in [min - 1, max + 1] {
            assert!(tried.has(Some("PX-JSON-02"), |value| *value == text(outside)), "{name}: {outside}");
        }
        for rule in [None, Some("PX-ENUM-01"), Some("PX-RANGE-01"), Some("PX-LEN-01")] {
            if tried.has(rule, |value| *value == text(max)) {
                return check_meanings(emitted, message, field, tried, name);
            }
        }
        panic!("{name}: no case for {max}");
    }
    let has_nan = tried.has(None, Json::is_null) || tried.has(Some("PX-NAN-01"), Json::is_null);
    assert!(has_nan && tried.has(Some("PX-JSON-02"), Json::is_string), "{name}: NaN");
    let is_tried = |is: &dyn Fn(f64) -> bool| tried.number(None, is) || tried.number(Some("PX-RANGE-01"), is);
    assert!(is_tried(&|value| value > 3e38) && is_tried(&|value| value < -3e38), "{name}: the maximum");
    assert!(is_tried(&|value| value == 0.0 && value.is_sign_negative()), "{name}: -0.0");
    assert!(is_tried(&|value| value > 0.0 && value < 1e-44), "{name}: a subnormal number");
    check_meanings(emitted, message, field, tried, name);
}

/// Checks values related to annotations.
#[allow(clippy::cast_possible_truncation)] // the numbers are integers
fn check_meanings(emitted: &Emitted, message: &Message, field: &Field, tried: &FieldCases, name: &str) {
    const CLOSE: f64 = 1e-6;
    let number = |value: &Option<Value>| value.as_ref().and_then(Value::as_f64);
    let specials = || {
        let found = [&INVALID, &UNCONTROLLED].into_iter().filter_map(|kind| field.constraint(kind));
        found.filter_map(|special| special.stated.value().and_then(Value::as_f64))
    };
    if let Some(Stated::Range(range)) = field.constraint(&RANGE).map(|found| &found.stated) {
        let is_integer = !matches!(field.ty.element, Element::Scalar(scalar) if scalar.is_float());
        let reach = if is_integer { 1.0 } else { CLOSE };
        for (end, outwards) in [(number(&range.low), -1.0), (number(&range.high), 1.0)] {
            let Some(end) = end else { continue };
            let is_at = |value: f64| (value - end).abs() <= CLOSE * end.abs().max(1.0);
            let is_beyond = |value: f64| {
                (value - end) * outwards > 0.0 && (value - end).abs() <= reach * end.abs().max(1.0)
            };
            let is_end_of_type = matches!(field.ty.element, Element::Scalar(scalar)
                if scalar.integer_bounds().is_some_and(|(min, max)| [min, max].contains(&(end as i128))));
            assert!(tried.number(None, is_at), "{name}: the end {end}");
            let is_refused =
                tried.number(Some("PX-RANGE-01"), is_beyond) || tried.number(Some("PX-LEN-01"), is_beyond);
            let is_special = is_integer && specials().any(|value| (value - end - outwards).abs() < 0.5);
            assert!(is_refused || is_end_of_type || is_special, "{name}: beyond {end}");
        }
    }
    for special in [&INVALID, &UNCONTROLLED].into_iter().filter_map(|kind| field.constraint(kind)) {
        match special.stated.value().and_then(Value::as_f64) {
            Some(value) if value.is_nan() => assert!(tried.has(None, Json::is_null), "{name}: NaN"),
            Some(value) => assert!(
                tried.number(None, |tried| (tried - value).abs() <= CLOSE * value.abs()),
                "{name}: special {value}"
            ),
            None => {}
        }
    }
    if let Some(array) = field.counts.and_then(|index| message.fields.get(index))
        && let Some(length) = array.ty.max_length()
    {
        assert!(tried.has(None, |value| *value == json!(length)), "{name}: all entries");
        assert!(
            tried.has(Some("PX-LEN-01"), |value| *value == json!(length + 1)),
            "{name}: too many entries"
        );
    }
    let restriction = emitted.schema.restriction(message, field);
    if let Some(found) = field.enumeration.map(|reference| emitted.schema.enumeration(reference))
        && restriction.is_some_and(|restriction| restriction.known.is_some())
    {
        for member in &found.members {
            assert!(
                tried.number(None, |value| value as i128 == member.value),
                "{name}: documented {}",
                member.name
            );
        }
        let all = found.members.iter().fold(0, |all, member| all | member.value);
        let is_known = |value: i128| {
            if found.is_flags {
                value & !all == 0
            } else {
                found.members.iter().any(|member| member.value == value)
            }
        };
        assert!(tried.number(Some("PX-ENUM-01"), |value| !is_known(value as i128)), "{name}: undocumented");
        assert!(!found.is_flags || tried.number(None, |value| value as i128 == all), "{name}: all flags");
    }
}

/// Checks invalid payloads.
fn check_payloads(message: &Message, cases: &[Json], is_uorb: bool) {
    let name = &message.name;
    let sizes = |form: &str, rule: Option<&str>| -> BTreeSet<usize> {
        let of_rule = cases.iter().filter(|case| case["rule"].as_str() == rule);
        of_rule.filter_map(|case| Some(case[form].as_str()?.len() / 2)).collect()
    };
    if let Some(layout) = message.uorb.as_ref().filter(|_| is_uorb) {
        assert_eq!(sizes("uorb", None), [layout.size_no_padding, layout.size].into(), "{name}");
        let broken = sizes("uorb", Some("PX-DATA-01"));
        assert!(
            broken.contains(&(layout.size_no_padding - 1)) && broken.contains(&(layout.size + 1)),
            "{name}"
        );
    } else {
        assert!(cases.iter().all(|case| case.get("uorb").is_none()), "{name}");
    }
    let valid = sizes("cdr", None);
    let broken = sizes("cdr", Some("PX-CDR-02"));
    assert!(broken.iter().any(|size| valid.contains(&(size + 1))), "{name}: CDR too short");
    assert!(
        broken.iter().any(|size| size.is_multiple_of(4) && *size >= valid.first().expect("a size") + 4),
        "{name}"
    );
    assert_eq!(sizes("cdr", Some("PX-CDR-01")).len(), 1, "{name}");
    let has_bool = message.fields.iter().any(|field| field.ty.element == Element::Scalar(Scalar::Bool));
    let odd =
        has_id(cases, Some("PX-BOOL-01"), |case| case["cdr"].as_str().is_some_and(|cdr| cdr.contains("99")));
    assert!(odd || !has_bool, "{name}: an invalid bool");
}
