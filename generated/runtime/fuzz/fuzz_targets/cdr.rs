//! Fuzzes CDR payloads. The first byte selects the message.
#![no_main]

use libfuzzer_sys::fuzz_target;
use uavspec::px4::{ArmingCheckReply, BatteryStatus};
use uavspec_runtime::Message;
use uavspec_runtime::cdr::ByteOrder;
use uavspec_runtime_fuzz::{Empty, Point, Sample, dispatch};

fuzz_target!(|data: &[u8]| {
    dispatch!(data, check; Sample, Point, Empty, ArmingCheckReply, BatteryStatus);
});

/// Checks that a decoded message survives encoding and decoding in both byte orders, and that strict decoding differs
/// only for messages with an invalid `bool`.
fn check<T: Message>(payload: &[u8]) {
    match T::from_cdr(payload) {
        Err(error) => {
            assert!(error.offset <= payload.len(), "{error}");
            assert!(T::from_cdr_strict(payload).is_err());
        }
        Ok(message) => {
            let [little, big] = [ByteOrder::LittleEndian, ByteOrder::BigEndian]
                .map(|order| message.to_cdr(order).unwrap_or_else(|error| panic!("{error}")));
            for bytes in [&little, &big] {
                let read = T::from_cdr_strict(bytes).unwrap_or_else(|error| panic!("{error}"));
                assert_eq!(read.to_cdr(ByteOrder::LittleEndian).as_ref(), Ok(&little));
            }
            if let Err(error) = T::from_cdr_strict(payload) {
                assert!(payload[error.offset] > 1, "{error}");
            }
            for violation in message.validate() {
                assert!(!violation.to_string().is_empty());
            }
        }
    }
}
