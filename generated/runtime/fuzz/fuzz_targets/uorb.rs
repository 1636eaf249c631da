//! Fuzzes uORB payloads. The first byte selects the message.
#![no_main]

use libfuzzer_sys::fuzz_target;
use uavspec::px4::{ArmingCheckReply, BatteryStatus, FailsafeFlags, RegisterExtComponentReply};
use uavspec_runtime::UorbMessage;
use uavspec_runtime_fuzz::dispatch;

fuzz_target!(|data: &[u8]| {
    dispatch!(data, check; ArmingCheckReply, BatteryStatus, FailsafeFlags, RegisterExtComponentReply);
});

/// Checks that the view and strict decoding agree with lenient decoding. Strict decoding may fail only if a `bool` is
/// invalid.
fn check<T: UorbMessage>(payload: &[u8]) {
    match T::from_uorb(payload) {
        Err(error) => {
            assert!(error.offset <= payload.len(), "{error}");
            assert!(T::view(payload).is_err() && T::from_uorb_strict(payload).is_err());
        }
        Ok(message) => {
            let bytes = message.to_uorb();
            let seen = T::from_view(T::view(payload).unwrap_or_else(|error| panic!("{error}")));
            assert_eq!(seen.to_uorb().as_ref(), bytes.as_ref());
            match T::from_uorb_strict(payload) {
                Ok(strict) => assert_eq!(strict.to_uorb().as_ref(), bytes.as_ref()),
                Err(error) => assert!(payload[error.offset] > 1, "{error}"),
            }
            for violation in message.validate() {
                assert!(!violation.to_string().is_empty());
            }
        }
    }
}
