//! Targets for the codecs of generated types. The first byte of the input selects the message type.

use uavspec_runtime::cdr::ByteOrder;
use uavspec_runtime::serde::Serialize;
use uavspec_runtime::serde::de::DeserializeOwned;
use uavspec_runtime::{Definition, Message, UorbMessage};
use uavspec_types::px4::{ArmingCheckReply, BatteryStatus, Event, FailsafeFlags, RegisterExtComponentReply};

/// Calls the function that the first byte selects, with the rest of the input.
fn select(data: &[u8], checks: &[fn(&[u8])]) {
    if let Some((first, data)) = data.split_first() {
        checks[usize::from(*first) % checks.len()](data);
    }
}

/// Reads CDR payloads.
pub(crate) fn cdr(data: &[u8]) {
    let checks: [fn(&[u8]); 5] = [
        check_cdr::<Sample>,
        check_cdr::<Point>,
        check_cdr::<Empty>,
        check_cdr::<ArmingCheckReply>,
        check_cdr::<BatteryStatus>,
    ];
    select(data, &checks);
}

/// Reads uORB payloads.
pub(crate) fn uorb(data: &[u8]) {
    let checks: [fn(&[u8]); 4] = [
        check_uorb::<ArmingCheckReply>,
        check_uorb::<BatteryStatus>,
        check_uorb::<FailsafeFlags>,
        check_uorb::<RegisterExtComponentReply>,
    ];
    select(data, &checks);
}

/// Reads JSON texts.
pub(crate) fn json(data: &[u8]) {
    let checks: [fn(&[u8]); 6] = [
        check_json::<Sample>,
        check_json::<Point>,
        check_json::<ArmingCheckReply>,
        check_json::<BatteryStatus>,
        check_json::<Event>,
        check_json::<RegisterExtComponentReply>,
    ];
    select(data, &checks);
}

macro_rules! sample {
    ($type:ident { $($field:ident: $field_type:ty),* }) => {
        // A variable-size message, written like generated code.
        #[derive(Clone, Default, PartialEq)]
        struct $type {
            $($field: $field_type,)*
        }

        impl Message for $type {
            const DEFINITION: Definition = Definition::new("samples", stringify!($type));
        }
    };
}

sample!(Sample {
    flag: bool,
    name: String,
    wide: String,
    numbers: Vec<f64>,
    few: Vec<u16>,
    points: Vec<Point>,
    pair: [Point; 2],
    empties: Vec<Empty>,
    names: Vec<String>
});

sample!(Point { tag: u8, label: String, x: u64 });

sample!(Empty {});

uavspec_runtime::record! {
    Sample[9];
    0 flag = bool("flag", 0);
    1 name = string("name", 0).at_most(5);
    2 wide = wstring("wide", 0);
    3 numbers = float64("numbers", 0).sequence();
    4 few = uint16("few", 0).bounded(3);
    5 points = message::<Point>("points", 0).sequence();
    6 pair = message::<Point>("pair", 0).array(2);
    7 empties = message::<Empty>("empties", 0).sequence();
    8 names = string("names", 0).at_most(4).bounded(2);
}

uavspec_runtime::record! {
    Point[3];
    0 tag = uint8("tag", 0);
    1 label = string("label", 0);
    2 x = uint64("x", 0);
}

uavspec_runtime::record! {
    Empty[0];
}

/// Checks that a decoded message survives encoding and decoding in both byte orders, and that strict decoding differs
/// only for messages with an invalid `bool`.
fn check_cdr<T: Message>(payload: &[u8]) {
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

/// Checks that the view and strict decoding agree with lenient decoding. Strict decoding may fail only if a `bool` is
/// invalid.
fn check_uorb<T: UorbMessage>(payload: &[u8]) {
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

/// Checks that a parsed message can be written, and that reading and writing the result yields the same text.
fn check_json<T: Message + Serialize + DeserializeOwned>(text: &[u8]) {
    let Ok(message) = serde_json::from_slice::<T>(text) else { return };
    let written = serde_json::to_string(&message).unwrap_or_else(|error| panic!("{error}"));
    let read: T = serde_json::from_str(&written).unwrap_or_else(|error| panic!("{error}: {written}"));
    assert_eq!(serde_json::to_string(&read).ok(), Some(written));
}
