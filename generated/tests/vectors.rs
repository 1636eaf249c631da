//! Checks the generated types against the vectors. Each case must be accepted, or rejected by the stated rule. The JSON
//! and the bytes of a case must decode to equal messages.

use std::collections::BTreeSet;

use serde_json::{Value as Json, json};
use uavspec_runtime::cdr::ByteOrder;
use uavspec_runtime::serde::Serialize;
use uavspec_runtime::serde::de::DeserializeOwned;
use uavspec_runtime::{DecodeError, ErrorClass, Fault, UorbMessage};
use uavspec_types::flockwave::ErrorCode;
use uavspec_types::px4::{
    ArmingCheckReply, ArmingCheckRequest, BatteryStatus, Event, FailsafeFlags, RegisterExtComponentReply,
    RegisterExtComponentRequest, UnregisterExtComponent,
};

fn cases(name: &str) -> Vec<Json> {
    let path = format!("{}/vectors/{name}.vectors.json", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).expect("vectors");
    let file: Json = serde_json::from_str(&text).expect("JSON");
    let cases = file["cases"].as_array().expect("cases").clone();
    assert!(!cases.is_empty(), "{path}");
    cases
}

fn hex(text: &Json) -> Option<Vec<u8>> {
    let text = text.as_str()?;
    let byte = |at| u8::from_str_radix(&text[at..at + 2], 16).expect("hexadecimal");
    Some((0..text.len()).step_by(2).map(byte).collect())
}

/// The ids of the rules that a message violates.
fn violated<T: UorbMessage>(message: &T) -> BTreeSet<&'static str> {
    message.validate().iter().map(|violation| violation.rule.id()).collect()
}

fn violated_by_bytes<T: UorbMessage>(read: &Result<T, DecodeError>) -> BTreeSet<&'static str> {
    match read.as_ref().map_err(|error| error.fault) {
        Ok(message) => violated(message),
        Err(Fault::Size { .. }) => ["PX-DATA-01"].into(),
        Err(Fault::Bool(_)) => ["PX-BOOL-01"].into(),
        Err(Fault::Encapsulation(_)) => ["PX-CDR-01"].into(),
        Err(_) => ["PX-CDR-02"].into(),
    }
}

fn check<T: UorbMessage + Serialize + DeserializeOwned>() {
    for case in cases(&format!("{}/{}", T::PACKAGE, T::NAME)) {
        let name = format!("{} {}", T::NAME, case["id"]);
        let rule = case["rule"].as_str();
        let expected: BTreeSet<&str> = rule.into_iter().collect();
        let intended: Option<T> = match case.get("json").or(case.get("decoded")) {
            Some(json) => match serde_json::from_value(json.clone()) {
                Ok(message) => {
                    assert_eq!(violated::<T>(&message), expected, "{name}");
                    Some(message)
                }
                Err(error) => {
                    let is_json_rule =
                        rule.is_some_and(|rule| rule.starts_with("PX-JSON") || rule == "PX-ARR-01");
                    assert!(is_json_rule, "{name}: {error}");
                    None
                }
            },
            None => None,
        };
        let (uorb, cdr) = (hex(&case["uorb"]), hex(&case["cdr"]));
        let decoded = [
            uorb.as_ref().map(|bytes| T::from_uorb_strict(bytes)),
            cdr.as_ref().map(|bytes| T::from_cdr_strict(bytes)),
        ];
        for decoded in decoded.into_iter().flatten() {
            assert_eq!(violated_by_bytes(&decoded), expected, "{name}");
            if let (Ok(decoded), Some(intended)) = (decoded, &intended) {
                // Compares the JSON, because NaN is not equal to itself.
                let json = |message: &T| serde_json::to_string(message).expect("JSON");
                assert_eq!(json(&decoded), json(intended), "{name}");
            }
        }
        if let (Some(intended), true) = (&intended, case.get("json").is_some()) {
            assert_eq!(intended.to_uorb().as_ref(), uorb.expect("bytes"), "{name}");
            assert_eq!(
                intended.to_cdr(ByteOrder::LittleEndian).expect("bytes"),
                cdr.expect("bytes"),
                "{name}"
            );
        }
    }
}

#[test]
fn messages_are_accepted_and_rejected_as_in_the_vectors() {
    check::<ArmingCheckReply>();
    check::<ArmingCheckRequest>();
    check::<BatteryStatus>();
    check::<Event>();
    check::<FailsafeFlags>();
    check::<RegisterExtComponentReply>();
    check::<RegisterExtComponentRequest>();
    check::<UnregisterExtComponent>();
}

#[test]
fn error_codes_are_accepted_and_rejected_as_in_the_vectors() {
    for case in cases("flockwave/ErrorCode") {
        let read = serde_json::from_value::<ErrorCode>(case["json"].clone());
        assert_eq!(json!(read.is_ok()), case["valid"], "{}", case["id"]);
        if let Ok(code) = read {
            assert_eq!(code.severity().name(), case["severity"], "{code:?}");
            assert_eq!(ErrorClass::of(code.0).name(), case["class"], "{code:?}");
        }
    }
}
