//! Comparison of generated types with types created at run time, for the same bytes and the same JSON.

use std::sync::LazyLock;

use proptest::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;
use uavspec_dynamic::{DynamicView, MessageType, Types};
use uavspec_runtime::cdr::ByteOrder;
use uavspec_runtime::{Definition, Fault, Message, UorbMessage, record};
use uavspec_schema::msg::Dialect;
use uavspec_schema::{Form, Schema};
use uavspec_test_definitions as support;
use uavspec_types::px4::{
    ArmingCheckReply, ArmingCheckRequest, BatteryStatus, Event, FailsafeFlags, RegisterExtComponentReply,
    RegisterExtComponentRequest, UnregisterExtComponent,
};

use super::values::Draw;

/// A hand-written message type of variable size, which mirrors generated code.
#[derive(Clone, Default, PartialEq)]
struct Leaf {
    on: bool,
    name: String,
    wide: String,
}

#[derive(Clone, Default, PartialEq)]
struct Empty {}

#[derive(Clone, Default, PartialEq)]
struct Tree {
    flags: [bool; 3],
    text: String,
    numbers: Vec<u16>,
    leaves: Vec<Leaf>,
    reals: Vec<f64>,
    nothing: [Empty; 2],
    more: Vec<Empty>,
    names: [String; 2],
    bits: Vec<bool>,
    leaf: Leaf,
    wides: Vec<String>,
    end: u64,
}

const LEAF: &str = "bool on\nstring<=3 name\nwstring wide\n";
const TREE: &str = "bool[3] flags\nstring text\nuint16[] numbers\nLeaf[<=2] leaves\nfloat64[] reals\nEmpty[2] nothing\n\
                    Empty[] more\nstring<=4[2] names\nbool[<=4] bits\nLeaf leaf\nwstring<=2[] wides\nuint64 end\n";

record! {
    Leaf[3];
    0 on = bool("on", 0);
    1 name = string("name", 0).at_most(3);
    2 wide = wstring("wide", 0);
}

record! { Empty[0]; }

record! {
    Tree[12];
    0 flags = bool("flags", 0).array(3);
    1 text = string("text", 0);
    2 numbers = uint16("numbers", 0).sequence();
    3 leaves = message::<Leaf>("leaves", 0).bounded(2);
    4 reals = float64("reals", 0).sequence();
    5 nothing = message::<Empty>("nothing", 0).array(2);
    6 more = message::<Empty>("more", 0).sequence();
    7 names = string("names", 0).at_most(4).array(2);
    8 bits = bool("bits", 0).bounded(4);
    9 leaf = message::<Leaf>("leaf", 0);
    10 wides = wstring("wides", 0).at_most(2).sequence();
    11 end = uint64("end", 0);
}

macro_rules! message {
    ($($type:ident)*) => {$(
        impl Message for $type {
            const DEFINITION: Definition = Definition::new("demo", stringify!($type));
        }
    )*};
}

message!(Empty Leaf Tree);

static PX4: LazyLock<(Schema, Types)> = LazyLock::new(|| {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../definitions/px4");
    let schema = support::px4(&folder).1;
    let types = Types::new(&schema);
    (schema, types)
});

static TREES: LazyLock<(Schema, Types)> = LazyLock::new(|| {
    let files = [("Tree.msg", TREE), ("Leaf.msg", LEAF), ("Empty.msg", "")];
    let schema = support::texts(Form::Msg(Dialect::Ros2), &files).1;
    let types = Types::new(&schema);
    (schema, types)
});

/// The JSON text and the violations of a message, or the error.
type Outcome = Result<(Option<String>, Vec<String>), String>;

fn typed<T: Message + Serialize, E: ToString>(message: Result<T, E>) -> Outcome {
    let message = message.map_err(|error| error.to_string())?;
    let violations = message.validate().iter().map(ToString::to_string).collect();
    Ok((serde_json::to_string(&message).ok(), violations))
}

macro_rules! dynamic {
    ($message:expr) => {
        $message.map_err(|error| error.to_string()).map(|message| {
            let violations = message.validate().iter().map(ToString::to_string).collect();
            (serde_json::to_string(&message).ok(), violations)
        })
    };
}

fn agree_on_cdr<T: Message + Serialize>(ty: MessageType<'_>, payload: &[u8]) -> Result<(), TestCaseError> {
    let expected = T::from_cdr(payload);
    // Skip text that isn't Unicode. Generated types contain Rust strings, so they can't accept such text.
    if !matches!(&expected, Err(error) if error.fault == Fault::NotUnicode) {
        let found: Outcome = dynamic!(ty.decode_cdr(payload));
        prop_assert_eq!(found, typed(expected));
    }
    let found: Outcome = dynamic!(ty.decode_cdr_strict(payload));
    prop_assert_eq!(found, typed(T::from_cdr_strict(payload)));
    Ok(())
}

fn agree_on_uorb<T: UorbMessage + Serialize>(
    ty: MessageType<'_>,
    payload: &[u8],
) -> Result<(), TestCaseError> {
    let found: Outcome = dynamic!(ty.decode_uorb(payload));
    prop_assert_eq!(found, typed(T::from_uorb(payload)));
    let found: Outcome = dynamic!(ty.view_uorb(payload));
    prop_assert_eq!(found, typed(T::from_uorb(payload)));
    let found: Outcome = dynamic!(ty.decode_uorb_strict(payload));
    prop_assert_eq!(found, typed(T::from_uorb_strict(payload)));
    if let (Ok(typed), Ok(message)) = (T::from_uorb(payload), ty.decode_uorb(payload)) {
        let payload = typed.to_uorb().as_ref().to_vec();
        prop_assert_eq!(message.to_uorb().expect("a payload"), payload);
        for order in [ByteOrder::LittleEndian, ByteOrder::BigEndian] {
            prop_assert_eq!(message.to_cdr(order).ok(), typed.to_cdr(order).ok());
        }
    }
    Ok(())
}

/// Reads a text with both types, and compares the results.
fn agree_on_json<T: Message + DeserializeOwned>(
    ty: MessageType<'_>,
    text: &str,
) -> Result<(), TestCaseError> {
    let typed = serde_json::from_str::<T>(text);
    let message = ty.from_json_text(text);
    prop_assert_eq!(typed.is_ok(), message.is_ok(), "{:?} {:?} {}", typed.err(), message.err(), text);
    if let (Ok(typed), Ok(message)) = (typed, message) {
        let order = ByteOrder::LittleEndian;
        let found = message.to_cdr(order).map_err(|error| error.to_string());
        prop_assert_eq!(found, typed.to_cdr(order).map_err(|error| error.to_string()));
        let violations = message.validate().iter().map(ToString::to_string).collect::<Vec<_>>();
        prop_assert_eq!(violations, typed.validate().iter().map(ToString::to_string).collect::<Vec<_>>());
    }
    Ok(())
}

/// Changes some bytes or the length.
fn spoil(payload: &mut Vec<u8>, draw: &mut Draw) {
    for _ in 0..draw.below(4) {
        if payload.is_empty() {
            return;
        }
        let at = draw.below(payload.len());
        match draw.below(6) {
            0 => payload.truncate(at),
            1 => payload.extend(draw.bytes(9).iter().take(at % 9)),
            2 => payload[at] = 0xff,
            3 => payload[at] = 0,
            4 => payload[at] ^= 1 << draw.below(8),
            _ => payload[at] = draw.bytes(1)[0],
        }
    }
}

/// Replaces or removes one value.
fn spoil_text(text: &str, draw: &mut Draw) -> String {
    const VALUES: [&str; 14] = [
        "null",
        "true",
        "-1",
        "0.5",
        "256",
        "1e39",
        "1e400",
        "\"\"",
        "\"abcdef\"",
        "{}",
        "{\"a\":1}",
        "18446744073709551616",
        "\"\\u0000\"",
        "3.4028235677973366e38",
    ];
    let starts: Vec<usize> =
        text.char_indices().filter(|(_, c)| ":,[".contains(*c)).map(|(at, c)| at + c.len_utf8()).collect();
    let start = starts[draw.below(starts.len())];
    let end = text[start..].find([',', ']', '}']).map_or(text.len(), |length| start + length);
    let value = VALUES[draw.below(VALUES.len())];
    format!("{}{value}{}", &text[..start], &text[end..])
}

fn agree<T: UorbMessage + Serialize + DeserializeOwned>(
    types: &Types,
    schema: &Schema,
    seed: u64,
) -> Result<(), TestCaseError> {
    let ty = types.find(T::PACKAGE, T::NAME).expect("the type");
    let message = schema.messages.iter().find(|message| message.name == T::NAME).expect("the message");
    let mut draw = Draw(seed);
    let random = draw.bytes(T::SIZE);
    agree_on_uorb::<T>(ty, &random)?;
    agree_on_uorb::<T>(ty, &random[..T::SIZE_NO_PADDING])?;
    let length = draw.below(T::SIZE + 9);
    let random = draw.bytes(length);
    agree_on_uorb::<T>(ty, &random)?;

    let json = draw.message(schema, message);
    let value = ty.from_json(&json).expect("a message");
    for order in [ByteOrder::LittleEndian, ByteOrder::BigEndian] {
        let mut payload = value.to_cdr(order).expect("a payload");
        spoil(&mut payload, &mut draw);
        agree_on_cdr::<T>(ty, &payload)?;
    }
    let text = json.to_string();
    agree_on_json::<T>(ty, &text)?;
    agree_on_json::<T>(ty, &spoil_text(&text, &mut draw))
}

/// Checks that `payload` decodes to `json` at eight consecutive offsets, which cover all alignments.
fn check_places(payload: &[u8], json: &str, read: impl Fn(&[u8]) -> String) {
    for by in 0..8 {
        let buffer = [&[0xaa; 8][..by], payload].concat();
        assert_eq!(read(&buffer[by..]), json, "{by} bytes before");
    }
}

#[test]
fn reads_payloads_at_any_alignment() {
    let text = |message: DynamicView<'_>| message.to_json_text().expect("JSON");
    for (schema, types) in [&*PX4, &*TREES] {
        for (ty, message) in types.iter().zip(&schema.messages) {
            let value = ty.from_json(&Draw(3).message(schema, message)).expect("a message");
            let json = text(value.view());
            for order in [ByteOrder::LittleEndian, ByteOrder::BigEndian] {
                let payload = value.to_cdr(order).expect("a payload");
                check_places(&payload, &json, |bytes| text(ty.decode_cdr(bytes).expect("a message").view()));
                check_places(&payload, &json, |bytes| {
                    text(ty.decode_cdr_strict(bytes).expect("a message").view())
                });
            }
            let Ok(payload) = value.to_uorb() else { continue };
            check_places(&payload, &json, |bytes| text(ty.decode_uorb(bytes).expect("a message").view()));
            check_places(&payload, &json, |bytes| text(ty.view_uorb(bytes).expect("a message")));
            check_places(&payload, &json, |bytes| {
                text(ty.decode_uorb_strict(bytes).expect("a message").view())
            });
        }
    }
}

proptest! {
    #![proptest_config(support::config(2000))]

    #[test]
    fn both_agree_on_trees(seed: u64) {
        let (schema, types) = &*TREES;
        let ty = types.find("demo", "Tree").expect("the type");
        let message = schema.messages.iter().find(|message| message.name == "Tree").expect("the message");
        let mut draw = Draw(seed);
        let json = draw.message(schema, message);
        let value = ty.from_json(&json).expect("a message");
        for order in [ByteOrder::LittleEndian, ByteOrder::BigEndian] {
            let mut payload = value.to_cdr(order).expect("a payload");
            agree_on_cdr::<Tree>(ty, &payload)?;
            for _ in 0..8 {
                spoil(&mut payload, &mut draw);
                agree_on_cdr::<Tree>(ty, &payload)?;
            }
        }
        let mut text = json.to_string();
        agree_on_json::<Tree>(ty, &text)?;
        for _ in 0..3 {
            text = spoil_text(&text, &mut draw);
            agree_on_json::<Tree>(ty, &text)?;
        }
    }
}

proptest! {
    #![proptest_config(support::config(500))]

    #[test]
    fn both_agree_on_our_definitions(seed: u64) {
        let (schema, types) = &*PX4;
        agree::<ArmingCheckReply>(types, schema, seed)?;
        agree::<ArmingCheckRequest>(types, schema, seed)?;
        agree::<BatteryStatus>(types, schema, seed)?;
        agree::<Event>(types, schema, seed)?;
        agree::<FailsafeFlags>(types, schema, seed)?;
        agree::<RegisterExtComponentReply>(types, schema, seed)?;
        agree::<RegisterExtComponentRequest>(types, schema, seed)?;
        agree::<UnregisterExtComponent>(types, schema, seed)?;
    }
}
