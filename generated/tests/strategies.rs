//! Tests of the strategies: valid values have no violation, invalid values violate the stated rule, and valid values
//! survive every format.

#![cfg(all(feature = "proptest", feature = "serde"))]

use crate::support;

use std::collections::BTreeSet;
use std::fmt::Debug;

use proptest::arbitrary::{Arbitrary, any};
use proptest::prop_assert_eq;
use proptest::test_runner::TestCaseError;
use support::every::{Bits, Every, Free, Inner, Mode};
use support::{check, draw, extent, for_each_message, published_validator, simplest, values};
use uavspec_runtime::cdr::ByteOrder;
use uavspec_runtime::serde::Serialize;
use uavspec_runtime::serde::de::DeserializeOwned;
use uavspec_runtime::strategy::{invalid, undocumented};
use uavspec_runtime::{ConstraintKind, Message, UorbMessage};
use uavspec_types::flockwave::ErrorCode;
use uavspec_types::px4::battery_status::{BatteryFault, BatteryWarning};
use uavspec_types::px4::{ArmingCheckReply, BatteryStatus, Event, FailsafeFlags, RegisterExtComponentReply};

const CASES: u32 = 1000;

trait Tested: Message + Arbitrary + Debug + Serialize + DeserializeOwned {}

impl<T: Message + Arbitrary + Debug + Serialize + DeserializeOwned> Tested for T {}

fn json<T: Serialize>(value: &T) -> Result<String, TestCaseError> {
    serde_json::to_string(value).map_err(|error| TestCaseError::fail(error.to_string()))
}

fn cdr<T: Message>(value: &T) -> Result<Vec<u8>, TestCaseError> {
    value.to_cdr(ByteOrder::LittleEndian).map_err(|error| TestCaseError::fail(error.to_string()))
}

#[test]
fn valid_values_conform_to_definition_and_schema() {
    fn valid<T: Tested>() {
        let name = format!("{}/{}", T::PACKAGE, T::NAME);
        let schema = (T::PACKAGE == "px4").then(|| published_validator(&name));
        check(CASES, &any::<T>(), |value| {
            prop_assert_eq!(value.validate(), []);
            let json = json(&value)?;
            if let Some(schema) = &schema {
                let result = schema.validate(&json.parse().expect("JSON")).map_err(|error| error.to_string());
                prop_assert_eq!(result, Ok(()));
            }
            Ok(())
        });
    }
    for_each_message!(valid);
    valid::<Every>();
    valid::<Inner>();
    valid::<Free>();
}

#[test]
fn invalid_values_violate_only_the_stated_rule() {
    fn violates<T: Tested>() {
        let strategy = invalid::<T>().expect("the message has constraints");
        check(CASES, &strategy, |invalid| {
            let found: Vec<(ConstraintKind, String)> =
                invalid.value.validate().iter().map(|found| (found.rule, found.path.to_string())).collect();
            prop_assert_eq!(found, [(invalid.rule, invalid.path)]);
            Ok(())
        });
    }
    violates::<ArmingCheckReply>();
    violates::<BatteryStatus>();
    violates::<RegisterExtComponentReply>();
    violates::<uavspec_types::px4::RegisterExtComponentRequest>();
    violates::<uavspec_types::px4::UnregisterExtComponent>();
    violates::<Every>();
    violates::<Inner>();
    assert!(invalid::<Event>().is_none(), "numbers without constraints");
    assert!(invalid::<Free>().is_none());
}

#[test]
fn invalid_values_cover_every_rule_in_every_field() {
    let expected = [
        (ConstraintKind::Bound, "bytes"),
        (ConstraintKind::Bound, "wide"),
        (ConstraintKind::Bound, "inner.names"),
        (ConstraintKind::Bound, "inner.names[]"),
        (ConstraintKind::Bound, "inners"),
        (ConstraintKind::Bound, "inners[].names"),
        (ConstraintKind::Bound, "inners[].names[]"),
        (ConstraintKind::Count, "count"),
        (ConstraintKind::Text, "text"),
        (ConstraintKind::Enum, "mode"),
        (ConstraintKind::Enum, "modes[]"),
        (ConstraintKind::Enum, "bits"),
        (ConstraintKind::Range, "modes[]"),
        (ConstraintKind::Range, "share[]"),
        (ConstraintKind::Range, "far"),
        (ConstraintKind::Range, "inner.number"),
        (ConstraintKind::Range, "inners[].number"),
        (ConstraintKind::Nan, "single"),
        (ConstraintKind::Nan, "share[]"),
    ];
    let expected = BTreeSet::from(expected.map(|(rule, path)| (rule, path.to_owned())));
    let strategy = invalid::<Every>().expect("the message has constraints");
    let mut found = BTreeSet::new();
    for (count, invalid) in values(&strategy).take(20_000).enumerate() {
        // A quick run ends as soon as it has found as many.
        if count >= extent(20_000, 1_000) && found.len() >= expected.len() {
            break;
        }
        let path: String = invalid.path.chars().filter(|character| !character.is_ascii_digit()).collect();
        found.insert((invalid.rule, path));
    }
    assert_eq!(found, expected);
}

#[test]
fn the_published_schema_rejects_violations_that_it_can_express() {
    fn rejects<T: Tested>() {
        let schema = published_validator(&format!("px4/{}", T::NAME));
        check(CASES, &invalid::<T>().expect("the message has constraints"), |invalid| {
            // Invalid UTF-8 has no JSON form. Schemas restrict neither documented values nor NaN.
            let Ok(json) = serde_json::to_value(&invalid.value) else {
                prop_assert_eq!(invalid.rule, ConstraintKind::Text);
                return Ok(());
            };
            let is_expressible =
                matches!(invalid.rule, ConstraintKind::Count | ConstraintKind::Range | ConstraintKind::Bound);
            prop_assert_eq!(schema.is_valid(&json), !is_expressible, "{} at {}", invalid.rule, invalid.path);
            Ok(())
        });
    }
    rejects::<ArmingCheckReply>();
    rejects::<BatteryStatus>();
    rejects::<RegisterExtComponentReply>();
}

#[test]
fn valid_values_survive_json_and_cdr() {
    fn formats<T: Tested>() {
        check(CASES, &any::<T>(), |value| {
            let bytes = cdr(&value)?;
            let from_json: T = serde_json::from_str(&json(&value)?).expect("an encoded message");
            prop_assert_eq!(&cdr(&from_json)?, &bytes, "through JSON");
            for order in [ByteOrder::LittleEndian, ByteOrder::BigEndian] {
                let payload = value.to_cdr(order).expect("within bounds");
                let again = T::from_cdr_strict(&payload).expect("an encoded message");
                prop_assert_eq!(&cdr(&again)?, &bytes, "through CDR, {:?}", order);
            }
            Ok(())
        });
    }
    for_each_message!(formats);
    formats::<Every>();
    formats::<Inner>();
}

#[test]
fn valid_values_survive_uorb_and_views() {
    fn memory<T: Tested + UorbMessage>() {
        check(CASES, &any::<T>(), |value| {
            let payload = value.to_uorb();
            let again = T::from_uorb_strict(payload.as_ref()).expect("an encoded message");
            let again = again.to_uorb();
            prop_assert_eq!(again.as_ref(), payload.as_ref());
            let seen = T::from_view(T::view(&payload.as_ref()[..T::SIZE_NO_PADDING]).expect("a payload"));
            prop_assert_eq!(cdr(&seen)?, cdr(&value)?);
            Ok(())
        });
    }
    for_each_message!(memory);
}

#[test]
fn views_return_the_fields_of_the_message() {
    check(CASES, &any::<ArmingCheckReply>(), |reply| {
        let payload = reply.to_uorb();
        let view = ArmingCheckReply::view(payload.as_ref()).expect("a payload");
        prop_assert_eq!(view.timestamp(), reply.timestamp);
        prop_assert_eq!(view.health_component_index(), reply.health_component_index);
        prop_assert_eq!(view.mode_req_manual_control(), reply.mode_req_manual_control);
        for (event, owned) in view.events().iter().zip(&reply.events) {
            prop_assert_eq!(event.id(), owned.id);
            prop_assert_eq!(event.arguments().as_bytes(), &owned.arguments[..]);
        }
        Ok(())
    });
    check(CASES, &any::<BatteryStatus>(), |battery| {
        let payload = battery.to_uorb();
        let view = BatteryStatus::view(payload.as_ref()).expect("a payload");
        prop_assert_eq!((view.warning(), view.faults()), (battery.warning, battery.faults));
        let bits = |values: &mut dyn Iterator<Item = f32>| values.map(f32::to_bits).collect::<Vec<_>>();
        let cells = bits(&mut battery.voltage_cell_v.iter().copied());
        prop_assert_eq!(bits(&mut view.voltage_cell_v().iter()), cells);
        prop_assert_eq!(view.voltage_v().to_bits(), battery.voltage_v.to_bits());
        Ok(())
    });
}

#[test]
fn edge_cases_are_frequent() {
    #[track_caller]
    fn frequent(values: &[Every], min: usize, is_edge_case: impl Fn(&Every) -> bool) {
        let found = values.iter().filter(|value| is_edge_case(value)).count();
        assert!(found >= min, "{found} of {}", values.len());
    }
    let values = draw(2000, &any::<Every>());
    frequent(&values, 20, |value| value.long == 0);
    frequent(&values, 20, |value| value.long == u64::MAX);
    frequent(&values, 100, |value| value.double.is_nan());
    frequent(&values, 10, |value| value.double.to_bits() == (-0.0_f64).to_bits());
    frequent(&values, 10, |value| value.double.is_subnormal());
    frequent(&values, 10, |value| value.single.is_subnormal());
    frequent(&values, 10, |value| value.single >= f32::MAX || value.double <= f64::MIN);
    frequent(&values, 100, |value| value.share.contains(&-1.0));
    frequent(&values, 100, |value| value.share.contains(&0.1_f32));
    frequent(&values, 20, |value| value.inner.number == i64::MAX);
    frequent(&values, 20, |value| value.inner.number == -5);
    frequent(&values, 20, |value| value.modes.contains(&Mode(9)));
    frequent(&values, 100, |value| value.mode == Mode(5));
    frequent(&values, 100, |value| value.bits == Bits(0) || value.bits == Bits(-32768));
    frequent(&values, 100, |value| value.bits == Bits(-32768 | 0x42));
    frequent(&values, 20, |value| value.count == 3);
    frequent(&values, 100, |value| value.bytes.len() == 3 && value.bytes.is_empty() != value.any.is_empty());
    frequent(&values, 100, |value| value.any.len() > 4);
    frequent(&values, 100, |value| value.inners.len() == 3);
    frequent(&values, 100, |value| value.wide.chars().count() == 5);
    frequent(&values, 100, |value| value.text.bytes().len() == 6);
    frequent(&values, 100, |value| value.text.bytes().is_empty());
    frequent(&values, 100, |value| !value.text.as_str().expect("UTF-8").is_ascii());
}

fn known(is_known: bool, expected: bool) -> Result<(), TestCaseError> {
    prop_assert_eq!(is_known, expected);
    Ok(())
}

#[test]
fn draws_documented_or_undocumented_values_as_requested() {
    check(CASES, &any::<BatteryWarning>(), |warning| known(warning.is_known(), true));
    check(CASES, &any::<BatteryFault>(), |faults| known(faults.is_known(), true));
    check(CASES, &any::<ErrorCode>(), |code| known(code.is_known(), true));
    check(CASES, &any::<Bits>(), |bits| known(bits.is_known(), true));
    let unknown = undocumented::<BatteryWarning>().expect("most values have no name");
    check(CASES, &unknown, |warning| known(warning.is_known(), false));
    let unknown = undocumented::<BatteryFault>().expect("some bits have no name");
    check(CASES, &unknown, |faults| known(faults.is_known(), false));
    let unknown = undocumented::<ErrorCode>().expect("most codes have no name");
    check(CASES, &unknown, |code| known(code.is_known(), false));
    let drawn: BTreeSet<ErrorCode> = draw(2000, &any::<ErrorCode>()).into_iter().collect();
    assert!(drawn.into_iter().eq(ErrorCode::all()), "the strategy generates every code");
    let drawn: BTreeSet<u32> = draw(500, &unknown).into_iter().map(|code| code.0).collect();
    assert!(drawn.len() > 100, "too few different codes: {drawn:?}");
}

#[test]
fn simplifies_a_failing_value_leaf_by_leaf() {
    let simple = Every { far: 1e10, mode: Mode(-1), modes: [Mode(-1); 2], ..Every::default() };
    assert_eq!(simplest(&any::<Every>(), |_| true), simple);
    assert_eq!(
        simplest(&any::<Every>(), |value| value.long > 4711 && value.mode == Mode(5)),
        Every { long: 4712, mode: Mode(5), ..simple.clone() }
    );
    // Proptest doesn't always find the simplest float.
    let found = simplest(&any::<Every>(), |value| value.single < -20.5);
    assert_eq!(found, Every { single: found.single, ..simple.clone() });
    assert_eq!(
        simplest(&any::<Every>(), |value| value.share[1] < 0.0),
        Every { share: [0.0, -1.0, 0.0], ..simple.clone() }
    );
    assert_eq!(
        simplest(&any::<Every>(), |value| value.bits.contains(Bits(0x40))),
        Every { bits: Bits(0x40), ..simple.clone() }
    );
    assert_eq!(
        simplest(&any::<Every>(), |value| value.any.iter().any(|number| *number > 100)),
        Every { any: vec![101], ..simple.clone() }
    );
    let found = simplest(&any::<Every>(), |value| value.text.bytes().len() > 2 && !value.wide.is_ascii());
    assert_eq!(found.text.bytes().len(), 3);
    let found = simplest(&any::<Every>(), |value| {
        value.inners.iter().flat_map(|inner| &inner.names).any(|name| name.chars().count() > 1)
    });
    let names = found.inners[0].names.clone();
    assert_eq!((names.len(), names[0].chars().count()), (1, 2));
    let inner = Inner { names, ..Inner::default() };
    assert_eq!(found, Every { inners: vec![inner], ..simple });
}

#[test]
fn an_invalid_value_stays_invalid_during_simplification() {
    let strategy = invalid::<Every>().expect("the message has constraints");
    for rule in ConstraintKind::ALL {
        let found = simplest(&strategy, |invalid| invalid.rule == rule);
        let violations = found.value.validate();
        assert_eq!(violations.len(), 1, "{found:?}");
        assert_eq!((violations[0].rule, violations[0].path.to_string()), (rule, found.path));
    }
    let found = simplest(&strategy, |invalid| invalid.path.starts_with("inners["));
    assert_eq!(found.value.inners.len(), 1);
    let found = simplest(&strategy, |invalid| invalid.path == "bytes");
    assert_eq!(found.value.bytes, [0; 4]);
    let found = simplest(&strategy, |invalid| invalid.path == "count");
    assert_eq!(found.value.count, 4);
    let found = simplest(&strategy, |invalid| invalid.path == "text" && invalid.value.long > 4711);
    assert_eq!((found.path.as_str(), found.value.long), ("text", 4712));
}

#[test]
fn simplifies_flags_and_enums() {
    assert_eq!(simplest(&any::<Bits>(), |bits| bits.contains(Bits(0x40))), Bits(0x40));
    assert_eq!(simplest(&any::<Mode>(), |_| true), Mode(-1));
    assert_eq!(simplest(&any::<Mode>(), |mode| *mode != Mode(-1)), Mode(3));
}

#[test]
fn simplification_takes_few_steps() {
    // At most a few steps for each bit, well within the default budget of a runner.
    let steps = std::cell::Cell::new(0);
    simplest(&any::<FailsafeFlags>(), |flags| {
        steps.set(steps.get() + 1);
        flags.timestamp > 0
    });
    assert!(steps.get() < 300, "{}", steps.get());
}
