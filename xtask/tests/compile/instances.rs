//! Reads lines of a type, its CDR in both byte orders and its JSON; checks that each becomes the other,
//! and writes the JSON again.

use uavspec_runtime::cdr::ByteOrder;
use uavspec_runtime::serde::{Serialize, de::DeserializeOwned};
use uavspec_runtime::{Message, UorbMessage};

fn main() {
    for line in std::io::stdin().lines() {
        let line = line.expect("a line");
        let mut words = line.splitn(4, ' ');
        let mut word = || words.next().expect("four words");
        let (name, little, big, text) = (word(), word(), word(), word());
        println!("{}", convert(name, text, [&bytes(little), &bytes(big)]));
    }
}

fn convert(name: &str, text: &str, bytes: [&[u8]; 2]) -> String {
    match name {
        // an arm for each type
        _ => panic!("no type {name}"),
    }
}

fn bytes(hex: &str) -> Vec<u8> {
    let digits = |at: usize| u8::from_str_radix(&hex[at..at + 2], 16).expect("hexadecimal digits");
    (0..hex.len()).step_by(2).map(digits).collect()
}

/// A message of any size.
fn any<T: Message + Serialize + DeserializeOwned>(text: &str, bytes: [&[u8]; 2]) -> String {
    let value: T = serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"));
    let text = serde_json::to_string(&value).expect("JSON");
    for (order, bytes) in [ByteOrder::LittleEndian, ByteOrder::BigEndian].into_iter().zip(bytes) {
        assert_eq!(value.to_cdr(order).expect("CDR"), bytes, "{order:?} of {text}");
        let read = T::from_cdr_strict(bytes).unwrap_or_else(|error| panic!("{error}: {text}"));
        assert_eq!(serde_json::to_string(&read).expect("JSON"), text, "{order:?}");
        for end in 0..bytes.len() {
            // What is cut off may be the alignment at the end of nothing else.
            let error = T::from_cdr(&bytes[..end]).err().unwrap_or_else(|| panic!("{end} bytes suffice: {text}"));
            assert!(error.offset <= end, "{error}");
        }
        let mut longer = bytes.to_vec();
        longer.resize(bytes.len().next_multiple_of(4), 0);
        assert!(T::from_cdr(&longer).is_ok(), "alignment after the end of {text}");
        longer.push(0);
        assert!(T::from_cdr(&longer).is_err(), "a byte after the end of {text}");
    }
    text
}

/// A message of fixed size.
fn fixed<T: UorbMessage + Serialize + DeserializeOwned>(text: &str, bytes: [&[u8]; 2]) -> String {
    let text = any::<T>(text, bytes);
    let value: T = serde_json::from_str(&text).expect("the same");
    let payload = value.to_uorb();
    let payload = payload.as_ref();
    for end in 0..payload.len() {
        assert_eq!(T::from_uorb(&payload[..end]).is_ok(), end == T::SIZE_NO_PADDING, "{end} bytes of {text}");
    }
    let read = T::from_uorb_strict(&payload[..T::SIZE_NO_PADDING]).expect("the payload");
    assert_eq!(serde_json::to_string(&read).expect("JSON"), text);
    let seen = T::from_view(T::view(payload).expect("the payload"));
    assert_eq!(seen.to_uorb().as_ref(), payload);
    text
}
