//! The initial content of messages, and access to values by name and index.

use serde_json::json;
use uavspec_dynamic::{Types, Value};
use uavspec_runtime::cdr::ByteOrder;
use uavspec_schema::Form;
use uavspec_schema::msg::Dialect;
use uavspec_test_definitions as support;

#[test]
fn a_new_message_contains_the_defaults_of_its_definition() {
    let files = [
        (
            "Outer.msg",
            "uint8 first\nbool on true\nuint16 x 300\nfloat32 y 1.5\nfloat64[3] z [1, 2.5, -3]\nint16[] list [4, -5]\n\
             string name \"né\"\nstring[2] names [\"a\", \"bc\"]\nInner inner\nInner[2] inners\n",
        ),
        ("Inner.msg", "uint8 a\nint64 b -7\n"),
        ("Named.msg", "string name \"a\"\n"),
        ("Zeros.msg", "int32 a 0\nfloat64 b -0.0\nstring c \"\"\nbool d\n"),
    ];
    let (_, schema, _) = support::texts(Form::Msg(Dialect::Ros2), &files);
    let types = Types::new(&schema);
    let new = |name: &str| types.find("demo", name).expect("the type").default();
    let inner = json!({ "a": 0, "b": -7 });
    assert_eq!(
        new("Outer").to_json().expect("JSON"),
        json!({
            "first": 0, "on": true, "x": 300, "y": 1.5, "z": [1.0, 2.5, -3.0], "list": [4, -5], "name": "né",
            "names": ["a", "bc"], "inner": inner, "inners": [inner, inner],
        })
    );
    assert_eq!(new("Named").to_json().expect("JSON"), json!({ "name": "a" }));
    let zeros = new("Zeros");
    assert_eq!(zeros.view().to_json_text().expect("JSON"), r#"{"a":0,"b":-0.0,"c":"","d":false}"#);
}

#[test]
fn values_are_accessible_by_path_and_index() {
    let files =
        [("Outer.msg", "uint8 a\nInner[2] inners\nint16[] list\n"), ("Inner.msg", "uint16 x\nstring name\n")];
    let (_, schema, _) = support::texts(Form::Msg(Dialect::Ros2), &files);
    let types = Types::new(&schema);
    let ty = types.find("demo", "Outer").expect("the type");
    let inner = |x: u16, name: &str| json!({ "x": x, "name": name });
    let message = ty
        .from_json(&json!({ "a": 7, "inners": [inner(1, "p"), inner(2, "q")], "list": [-3] }))
        .expect("a message");
    let text = |path: &str| message.get(path).map(|value| format!("{value:?}"));
    assert_eq!(text("inners[1].x").as_deref(), Some("UInt(2)"));
    assert_eq!(text("inners[1].name").as_deref(), Some("String([113])"));
    assert_eq!(text("list[1]"), None);
    let Some(Value::Array(list)) = message.get("list") else { panic!("an array") };
    assert_eq!((list.len(), list.is_empty(), list.get(1).is_none()), (1, false, true));
    let empty = ty.default();
    assert!(matches!(empty.get("list"), Some(Value::Array(list)) if list.is_empty()));
    assert_eq!(
        format!("{message:?}"),
        "Outer { a: UInt(7), inners: Array([Message(Inner { x: UInt(1), name: String([112]) }), \
         Message(Inner { x: UInt(2), name: String([113]) })]), list: Array([Int(-3)]) }"
    );
    assert_eq!((message.message_type().name(), message.memory().len()), ("Outer", message.size_in_memory()));
    assert!(message.size_in_memory() > ty.default().size_in_memory());
}

#[test]
fn text_of_fixed_size_is_a_string() {
    let (_, schema, _) =
        support::texts(Form::Msg(Dialect::Px4), &[("Named.msg", "uint64 timestamp\nchar[4] name\n")]);
    let types = Types::new(&schema);
    let ty = types.find("demo", "Named").expect("the type");
    let error = ty.from_json(&json!({ "timestamp": 0, "name": 7 })).expect_err("refused");
    assert_eq!(error.to_string(), "name: invalid type: integer `7`, expected a string of at most 4 bytes");
}

/// The strict decoder rejects strings that are not Unicode, but captures of real programs contain them.
#[test]
fn strings_that_are_not_unicode_are_kept() {
    let (_, schema, _) = support::texts(
        Form::Msg(Dialect::Ros2),
        &[("Named.msg", "string<=4[2] names\nwstring<=2[] wides\nuint8 last\n")],
    );
    let types = Types::new(&schema);
    let ty = types.find("demo", "Named").expect("the type");
    let valid =
        ty.from_json(&json!({ "names": ["a", "bcd"], "wides": ["é"], "last": 7 })).expect("a message");
    for order in [ByteOrder::LittleEndian, ByteOrder::BigEndian] {
        let valid = valid.to_cdr(order).expect("a payload");
        let at = valid.windows(3).position(|bytes| bytes == b"bcd").expect("the name");
        let mut payload = valid.clone();
        payload[at + 1] = 0xff;
        let message = ty.decode_cdr(&payload).expect("a message");
        assert!(matches!(message.get("names[1]"), Some(Value::String(b"b\xffd"))), "{message:?}");
        assert!(matches!(message.get("last"), Some(Value::UInt(7))), "{message:?}");
        assert_eq!(message.to_cdr(order).as_deref(), Ok(&*payload));
        let violations: Vec<String> = message.validate().iter().map(ToString::to_string).collect();
        assert_eq!(violations, ["names[1]: invalid UTF-8 at byte 1 (PX-STR-01)"]);
        let error = message.to_json().expect_err("refused");
        assert_eq!(error.to_string(), "names[1]: invalid utf-8 sequence of 1 bytes from index 1");
        let error = ty.decode_cdr_strict(&payload).expect_err("refused");
        let strict = format!("names[1] at byte {}: expected a Unicode string, found invalid bytes", at - 4);
        assert_eq!(error.to_string(), strict);

        // Replace the code unit of é with an unpaired surrogate.
        let unit: [u8; 4] = if order == ByteOrder::LittleEndian { [0xe9, 0, 0, 0] } else { [0, 0, 0, 0xe9] };
        let at = valid.windows(4).position(|bytes| bytes == unit).expect("the unit");
        let mut payload = valid;
        payload[if order == ByteOrder::LittleEndian { at + 1 } else { at + 2 }] = 0xd8;
        let message = ty.decode_cdr(&payload).expect("a message");
        assert!(matches!(message.get("wides[0]"), Some(Value::String(b"\xed\xa3\xa9"))), "{message:?}");
        assert_eq!(message.to_cdr(order).as_deref(), Ok(&*payload));
        let violations: Vec<String> = message.validate().iter().map(ToString::to_string).collect();
        assert_eq!(violations, ["wides[0]: unpaired surrogate at code unit 0 (PX-STR-01)"]);
        assert!(message.to_json().is_err() && ty.decode_cdr_strict(&payload).is_err());
    }
}

/// Each byte that isn't part of a character counts as one character.
#[test]
fn bounds_of_strings_apply_to_invalid_text() {
    let (_, schema, _) = support::texts(Form::Msg(Dialect::Ros2), &[("Named.msg", "string<=2 name\n")]);
    let types = Types::new(&schema);
    let ty = types.find("demo", "Named").expect("the type");
    let payload = |text: &[u8]| {
        let length = u32::try_from(text.len() + 1).expect("a length");
        [&[0, 1, 0, 0][..], &length.to_le_bytes(), text, &[0]].concat()
    };
    assert!(ty.decode_cdr(&payload("éé".as_bytes())).is_ok());
    assert!(ty.decode_cdr(&payload(b"\xc3\xa9\xff")).is_ok());
    let error = ty.decode_cdr(&payload(b"a\xff\xff")).expect_err("refused");
    assert_eq!(error.to_string(), "name at byte 4: expected at most 2, found 3");
}

/// In memory, `c` and `nested` are adjacent. In CDR, there is padding between them.
#[test]
fn fields_that_are_adjacent_in_memory_only_are_read_separately() {
    let files = [("Outer.msg", "uint8 a\nuint32 b\nuint8[3] c\nInner nested\n"), ("Inner.msg", "uint64 x\n")];
    let (_, schema, _) = support::texts(Form::Msg(Dialect::Px4), &files);
    let types = Types::new(&schema);
    let ty = types.find("demo", "Outer").expect("the type");
    let json = json!({ "a": 1, "b": 2, "c": [3, 4, 5], "nested": { "x": 6 } });
    let message = ty.from_json(&json).expect("a message");
    for order in [ByteOrder::LittleEndian, ByteOrder::BigEndian] {
        let payload = message.to_cdr(order).expect("a payload");
        assert_eq!(payload.len(), 4 + 16 + 8);
        assert_eq!(ty.decode_cdr(&payload).expect("a message").to_json().expect("JSON"), json);
        let last = if order == ByteOrder::LittleEndian { 20 } else { 27 };
        assert_eq!(payload[last], 6);
    }
}
