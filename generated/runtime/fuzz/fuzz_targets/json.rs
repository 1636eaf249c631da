//! Fuzzes JSON texts. The first byte selects the message.
#![no_main]

use libfuzzer_sys::fuzz_target;
use uavspec::px4::{ArmingCheckReply, BatteryStatus, Event, RegisterExtComponentReply};
use uavspec_runtime::Message;
use uavspec_runtime::serde::{Serialize, de::DeserializeOwned};
use uavspec_runtime_fuzz::{Point, Sample, dispatch};

fuzz_target!(|data: &[u8]| {
    dispatch!(data, check; Sample, Point, ArmingCheckReply, BatteryStatus, Event, RegisterExtComponentReply);
});

/// Checks that a parsed message can be written, and that reading and writing the result yields the same text.
fn check<T: Message + Serialize + DeserializeOwned>(text: &[u8]) {
    let Ok(message) = serde_json::from_slice::<T>(text) else { return };
    let written = serde_json::to_string(&message).unwrap_or_else(|error| panic!("{error}"));
    let read: T = serde_json::from_str(&written).unwrap_or_else(|error| panic!("{error}: {written}"));
    assert_eq!(serde_json::to_string(&read).ok(), Some(written));
}
