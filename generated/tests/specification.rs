//! Checks the generated types against facts from other sources.

use uavspec_runtime::descriptor::{Element, Shape};
use uavspec_runtime::record::Record as _;
use uavspec_runtime::{ErrorClass, Severity, UorbMessage};
use uavspec_types::flockwave::ErrorCode;
use uavspec_types::px4::battery_status::{BatteryFault, BatteryWarning};
use uavspec_types::px4::{
    ArmingCheckReply, ArmingCheckRequest, BatteryStatus, Event, FailsafeFlags, RegisterExtComponentReply,
    RegisterExtComponentRequest, UnregisterExtComponent,
};

/// The expected size, size without padding and hash come from PX4's own generator. The values for `FailsafeFlags` and
/// `BatteryStatus` are from release 1.15. The other values are from releases in which the message has the same fields.
#[test]
fn layouts_and_hashes_match_px4() {
    fn facts<T: UorbMessage>() -> (usize, usize, u32) {
        (T::SIZE, T::SIZE_NO_PADDING, T::HASH)
    }
    assert_eq!(facts::<FailsafeFlags>(), (88, 85, 3_652_994_069));
    assert_eq!(facts::<BatteryStatus>(), (168, 167, 3_808_166_550));
    assert_eq!(facts::<ArmingCheckReply>(), (232, 232, 2_083_851_748));
    assert_eq!(facts::<ArmingCheckRequest>(), (16, 13, 1_848_233_421));
    assert_eq!(facts::<Event>(), (40, 40, 2_076_212_785));
    assert_eq!(facts::<RegisterExtComponentRequest>(), (56, 49, 902_686_241));
    assert_eq!(facts::<RegisterExtComponentReply>(), (48, 47, 1_062_872_879));
    assert_eq!(facts::<UnregisterExtComponent>(), (40, 36, 1_478_728_617));
}

#[test]
fn the_descriptor_contains_the_offset_of_a_field() {
    let field = &ArmingCheckReply::DESCRIPTOR.fields[9];
    assert_eq!((field.name, field.offset, field.shape), ("events", 32, Shape::Array(5)));
    assert_eq!(field.element, Element::Message(Event::DESCRIPTOR));
}

#[test]
fn the_severity_of_every_code_comes_from_two_bits() {
    assert_eq!(ErrorCode::all().len(), 63);
    for code in ErrorCode::all() {
        assert_eq!(code.severity() as u32, (code.0 & 0xFF) >> 6, "{code}");
        assert!(code.class().codes().contains(&code.0), "{code}");
        assert!(code.is_known() && code.abbreviation().is_some() && code.description().is_some(), "{code}");
        for other in code.alternatives() {
            assert!(other.alternatives().contains(&code), "{code} and {other}");
            assert!(code.see_also().contains(other), "{code} names {other}");
        }
    }
}

#[test]
fn unknown_codes_are_preserved_and_have_a_severity() {
    let code = ErrorCode(0x1_0042);
    assert!(!code.is_known());
    assert_eq!((code.severity(), code.class()), (Severity::Warning, ErrorClass::UserDefined));
    assert_eq!(format!("{code} {code:?}"), "65602 ErrorCode(65602)");
    assert_eq!(format!("{:?}", ErrorCode::RC_LOST_WARNING), "ErrorCode(65 RC LOST)");
}

#[test]
fn debug_output_of_messages_contains_the_fields() {
    let request = ArmingCheckRequest { request_id: 7, ..Default::default() };
    let expected = "ArmingCheckRequest { timestamp: 0, request_id: 7, valid_registrations_mask: 0 }";
    assert_eq!(format!("{request:?}"), expected);
    let payload = request.to_uorb();
    assert_eq!(format!("{:?}", ArmingCheckRequest::view(&payload).expect("a payload")), expected);
}

#[test]
fn debug_output_of_enums_and_flags_contains_the_names() {
    assert_eq!(format!("{:?}", BatteryWarning::CRITICAL), "CRITICAL");
    assert_eq!(
        format!("{:?} {:?}", BatteryWarning(200), BatteryWarning(200).name()),
        "BatteryWarning(200) None"
    );
    let faults = BatteryFault::SPIKES | BatteryFault::OVER_CURRENT;
    assert_eq!(faults.0, 0b1010);
    assert!(faults.contains(BatteryFault::SPIKES) && faults.is_known());
    assert_eq!(format!("{faults:?}"), "BatteryFault(SPIKES | OVER_CURRENT)");
    assert_eq!(format!("{:?}", BatteryFault(0x8002)), "BatteryFault(SPIKES | 0x8000)");
}

#[cfg(feature = "serde")]
mod json {
    use super::*;

    #[test]
    fn reads_a_message_with_fields_in_any_order() {
        let event = Event { timestamp: u64::MAX, id: 7, arguments: [9; 25], ..Event::default() };
        let text = serde_json::to_string(&event).expect("JSON");
        assert!(text.starts_with("{\"timestamp\":18446744073709551615,\"id\":7,"), "{text}");
        assert_eq!(serde_json::from_str::<Event>(&text).expect("an event"), event);
        let other_order = text.replace("\"id\":7,", "").replace('}', ",\"id\":7}");
        assert_eq!(serde_json::from_str::<Event>(&other_order).expect("an event"), event);
    }

    #[test]
    fn rejects_missing_repeated_unknown_and_unsuitable_fields() {
        let text = serde_json::to_string(&Event::default()).expect("JSON");
        for (text, expected) in [
            (text.replace("\"id\":0,", ""), "missing field `id`"),
            (text.replace("\"id\":0,", "\"id\":0,\"id\":0,"), "duplicate field `id`"),
            (text.replace("\"id\"", "\"it\""), "unknown field `it`"),
            (text.replace("\"log_levels\":0", "\"log_levels\":256"), "256"),
            (text.replace("[0,0,", "[0,"), "expected an array of 25"),
            (text.replace("[0,0,", "[0,0,0,"), "expected an array of 25"),
            ("[0,0,0,[],0]".to_owned(), "expected an object with the fields of Event"),
        ] {
            let error = serde_json::from_str::<Event>(&text).expect_err("an invalid event").to_string();
            assert!(error.contains(expected), "{error}: {text}");
        }
    }

    #[test]
    fn writes_nan_as_null_and_reports_the_field_with_infinity() {
        let battery = BatteryStatus { temperature: f32::NAN, ..BatteryStatus::default() };
        let text = serde_json::to_string(&battery).expect("JSON");
        assert!(text.contains("\"temperature\":null"), "{text}");
        assert!(serde_json::from_str::<BatteryStatus>(&text).expect("a battery").temperature.is_nan());
        let mut battery = BatteryStatus::default();
        battery.voltage_cell_v[3] = f32::INFINITY;
        let error = serde_json::to_string(&battery).expect_err("infinity has no JSON form").to_string();
        assert!(error.contains("voltage_cell_v is inf"), "{error}");
        let text = serde_json::to_string(&BatteryStatus::default())
            .expect("JSON")
            .replace("\"temperature\":0.0", "\"temperature\":1e39");
        assert!(serde_json::from_str::<BatteryStatus>(&text).is_err());
    }

    #[test]
    fn writes_text_of_fixed_size_as_a_string() {
        let reply =
            RegisterExtComponentReply { name: "Land".parse().expect("it fits"), ..Default::default() };
        let text = serde_json::to_string(&reply).expect("JSON");
        assert!(text.contains("\"name\":\"Land\""), "{text}");
        assert_eq!(serde_json::from_str::<RegisterExtComponentReply>(&text).expect("a reply"), reply);
        assert!(
            serde_json::from_str::<RegisterExtComponentReply>(&text.replace("Land", &"x".repeat(26)))
                .is_err()
        );
    }
}
