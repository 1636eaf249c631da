//! Values of the strategies: valid ones are valid, broken ones break what they say, and all survive every
//! format.

#![cfg(all(feature = "proptest", feature = "serde"))]

use crate::support;

use std::collections::BTreeSet;
use std::fmt::Debug;

use proptest::arbitrary::{Arbitrary, any};
use proptest::prop_assert_eq;
use proptest::test_runner::TestCaseError;
use support::every::{Bits, Every, Free, Inner, Mode};
use support::{check, draw, for_each_message, published, publisher, simplest};
use uavspec::flockwave::ErrorCode;
use uavspec::px4::battery_status::{BatteryFault, BatteryWarning};
use uavspec::px4::{ArmingCheckReply, BatteryStatus, Event, FailsafeFlags, RegisterExtComponentReply};
use uavspec_runtime::cdr::ByteOrder;
use uavspec_runtime::serde::Serialize;
use uavspec_runtime::serde::de::DeserializeOwned;
use uavspec_runtime::strategy::{broken, undocumented};
use uavspec_runtime::{Message, Rule, UorbMessage};

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
fn valid_values_are_valid() {
    fn valid<T: Tested>() {
        let (registry, name) = (published(), format!("{}/{}", T::PACKAGE, T::NAME));
        let schema = (T::PACKAGE == "px4").then(|| publisher(&registry, &name));
        check(CASES, &any::<T>(), |value| {
            prop_assert_eq!(value.validate(), []);
            let json = json(&value)?;
            if let Some(schema) = &schema {
                let refused =
                    schema.validate(&json.parse().expect("JSON")).map_err(|error| error.to_string());
                prop_assert_eq!(refused, Ok(()));
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
fn broken_values_break_the_rule_that_they_name_and_no_other() {
    fn breaks<T: Tested>() {
        let strategy = broken::<T>().expect("there is something to break");
        check(CASES, &strategy, |broken| {
            let found: Vec<(Rule, String)> =
                broken.value.validate().iter().map(|found| (found.rule, found.path.to_string())).collect();
            prop_assert_eq!(found, [(broken.rule, broken.path)]);
            Ok(())
        });
    }
    breaks::<ArmingCheckReply>();
    breaks::<BatteryStatus>();
    breaks::<RegisterExtComponentReply>();
    breaks::<uavspec::px4::RegisterExtComponentRequest>();
    breaks::<uavspec::px4::UnregisterExtComponent>();
    breaks::<Every>();
    breaks::<Inner>();
    assert!(broken::<Event>().is_none(), "all numbers and no ranges");
    assert!(broken::<Free>().is_none());
}

#[test]
fn every_rule_is_broken_in_every_place_where_it_can_be() {
    let places = |values: Vec<(Rule, String)>| -> BTreeSet<(Rule, String)> { values.into_iter().collect() };
    let found = places(
        draw(20_000, &broken::<Every>().expect("rules"))
            .into_iter()
            .map(|broken| {
                let of_any_element = |character: &char| !character.is_ascii_digit();
                (broken.rule, broken.path.chars().filter(of_any_element).collect())
            })
            .collect(),
    );
    let expected = [
        (Rule::Bound, "bytes"),
        (Rule::Bound, "wide"),
        (Rule::Bound, "inner.names"),
        (Rule::Bound, "inner.names[]"),
        (Rule::Bound, "inners"),
        (Rule::Bound, "inners[].names"),
        (Rule::Bound, "inners[].names[]"),
        (Rule::Count, "count"),
        (Rule::Text, "text"),
        (Rule::Enum, "mode"),
        (Rule::Enum, "modes[]"),
        (Rule::Enum, "bits"),
        (Rule::Range, "modes[]"),
        (Rule::Range, "share[]"),
        (Rule::Range, "far"),
        (Rule::Range, "inner.number"),
        (Rule::Range, "inners[].number"),
        (Rule::Nan, "single"),
        (Rule::Nan, "share[]"),
    ];
    assert_eq!(found, places(expected.map(|(rule, path)| (rule, path.to_owned())).to_vec()));
}

#[test]
fn the_published_schema_refuses_what_it_can_say() {
    fn refuses<T: Tested>() {
        let registry = published();
        let schema = publisher(&registry, &format!("px4/{}", T::NAME));
        check(CASES, &broken::<T>().expect("there is something to break"), |broken| {
            // A text that is no UTF-8 has no JSON; of the others documented values and NaN are left open.
            let Ok(json) = serde_json::to_value(&broken.value) else {
                prop_assert_eq!(broken.rule, Rule::Text);
                return Ok(());
            };
            let is_sayable = matches!(broken.rule, Rule::Count | Rule::Range | Rule::Bound);
            prop_assert_eq!(schema.is_valid(&json), !is_sayable, "{} at {}", broken.rule, broken.path);
            Ok(())
        });
    }
    refuses::<ArmingCheckReply>();
    refuses::<BatteryStatus>();
    refuses::<RegisterExtComponentReply>();
}

#[test]
fn every_format_gives_back_what_it_took() {
    fn formats<T: Tested>() {
        check(CASES, &any::<T>(), |value| {
            let bytes = cdr(&value)?;
            let from_json: T = serde_json::from_str(&json(&value)?).expect("what was written");
            prop_assert_eq!(&cdr(&from_json)?, &bytes, "through JSON");
            for order in [ByteOrder::LittleEndian, ByteOrder::BigEndian] {
                let payload = value.to_cdr(order).expect("within bounds");
                let again = T::from_cdr_strict(&payload).expect("what was written");
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
fn uorb_and_views_give_back_what_they_took() {
    fn memory<T: Tested + UorbMessage>() {
        check(CASES, &any::<T>(), |value| {
            let payload = value.to_uorb();
            let again = T::from_uorb_strict(payload.as_ref()).expect("what was written");
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
fn views_show_the_fields_of_the_owned_type() {
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
fn values_that_programs_stumble_over_are_frequent() {
    #[track_caller]
    fn frequent(values: &[Every], least: usize, is_wanted: impl Fn(&Every) -> bool) {
        let found = values.iter().filter(|value| is_wanted(value)).count();
        assert!(found >= least, "{found} of {}", values.len());
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
fn enums_flags_and_codes_are_documented_or_not_as_asked() {
    check(CASES, &any::<BatteryWarning>(), |warning| known(warning.is_known(), true));
    check(CASES, &any::<BatteryFault>(), |faults| known(faults.is_known(), true));
    check(CASES, &any::<ErrorCode>(), |code| known(code.is_known(), true));
    check(CASES, &any::<Bits>(), |bits| known(bits.is_known(), true));
    let unknown = undocumented::<BatteryWarning>().expect("few are named");
    check(CASES, &unknown, |warning| known(warning.is_known(), false));
    let unknown = undocumented::<BatteryFault>().expect("few are named");
    check(CASES, &unknown, |faults| known(faults.is_known(), false));
    let unknown = undocumented::<ErrorCode>().expect("few are named");
    check(CASES, &unknown, |code| known(code.is_known(), false));
    let drawn: BTreeSet<ErrorCode> = draw(2000, &any::<ErrorCode>()).into_iter().collect();
    assert!(drawn.into_iter().eq(ErrorCode::all()), "each of them comes up");
    let drawn: BTreeSet<u32> = draw(500, &unknown).into_iter().map(|code| code.0).collect();
    assert!(drawn.len() > 100, "far ones too: {drawn:?}");
}

#[test]
fn a_failing_value_is_simplified_leaf_by_leaf() {
    let simple = Every { far: 1e10, mode: Mode(-1), modes: [Mode(-1); 2], ..Every::default() };
    assert_eq!(simplest(&any::<Every>(), |_| true), simple);
    assert_eq!(
        simplest(&any::<Every>(), |value| value.long > 4711 && value.mode == Mode(5)),
        Every { long: 4712, mode: Mode(5), ..simple.clone() }
    );
    assert_eq!(
        simplest(&any::<Every>(), |value| value.single < -20.5),
        Every { single: -21.0, ..simple.clone() }
    );
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
    assert_eq!(
        simplest(&any::<Every>(), |value| value.text.bytes().len() > 2 && !value.wide.is_ascii()).text,
        "aaa".parse().expect("it fits")
    );
    let inner = Inner { names: vec!["aa".to_owned()], ..Inner::default() };
    assert_eq!(
        simplest(&any::<Every>(), |value| {
            value.inners.iter().flat_map(|inner| &inner.names).any(|name| name.chars().count() > 1)
        }),
        Every { inners: vec![inner], ..simple }
    );
}

#[test]
fn a_broken_value_stays_broken_while_it_is_simplified() {
    let strategy = broken::<Every>().expect("rules");
    for rule in Rule::ALL {
        let found = simplest(&strategy, |broken| broken.rule == rule);
        let violations = found.value.validate();
        assert_eq!(violations.len(), 1, "{found:?}");
        assert_eq!((violations[0].rule, violations[0].path.to_string()), (rule, found.path));
    }
    let found = simplest(&strategy, |broken| broken.path.starts_with("inners["));
    assert_eq!(found.value.inners.len(), 1);
    let found = simplest(&strategy, |broken| broken.path == "bytes");
    assert_eq!(found.value.bytes, [0; 4]);
    let found = simplest(&strategy, |broken| broken.path == "count");
    assert_eq!(found.value.count, 4);
}

#[test]
fn simplifying_takes_few_steps() {
    // As many leaves as this has, each tried a few times, within the budget of a runner by default.
    let steps = std::cell::Cell::new(0);
    simplest(&any::<FailsafeFlags>(), |flags| {
        steps.set(steps.get() + 1);
        flags.timestamp > 0
    });
    assert!(steps.get() < 300, "{}", steps.get());
}
