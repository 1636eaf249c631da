//! Malicious bytes, text and definitions must result in an error or a value, with bounded memory.

use std::fmt::Write as _;

use uavspec_dynamic::{Defect, MessageType, Reason, Types};
use uavspec_runtime::cdr::{ByteOrder, HEADER};
use uavspec_runtime::layout::Size;
use uavspec_schema::msg::Dialect;
use uavspec_schema::{Form, Schema};
use uavspec_test_definitions as support;
use uavspec_test_definitions::extent;

use super::values::Draw;

const ROS2: Form = Form::Msg(Dialect::Ros2);

/// Messages with all kinds of length prefixes that a payload can contain.
fn schema() -> Schema {
    let files = [
        (
            "Tree.msg",
            "bool[2] a\nstring b\nwstring<=9 c\nuint64[] d\nByte[] e\nEmpty[] f\nTwig[<=3] g\nstring[] h\nTwig i\n",
        ),
        ("Twig.msg", "uint8 a\nstring<=4[<=5] b\nLeaf[] c\nLeaf[2] d\n"),
        ("Leaf.msg", "bool a\nwstring[] b\nuint16[<=6] c\n"),
        ("Byte.msg", "uint8 a\n"),
        ("Empty.msg", ""),
    ];
    support::texts(ROS2, &files).1
}

/// Decodes bytes in all forms, and converts the value to all forms.
fn read(ty: MessageType<'_>, bytes: &[u8]) {
    for message in [ty.decode_cdr(bytes), ty.decode_cdr_strict(bytes)].into_iter().flatten() {
        let max = 8 * (bytes.len() - HEADER);
        assert!(message.size_in_memory() <= max, "{} bytes of {}", message.size_in_memory(), bytes.len());
        for order in [ByteOrder::LittleEndian, ByteOrder::BigEndian] {
            let again = message.to_cdr(order).expect("a decoded message can be encoded");
            assert!(ty.decode_cdr(&again).is_ok());
        }
        message.validate();
        // JSON can't represent infinity.
        let _ = message.to_json();
    }
    if let Ok(message) = ty.decode_uorb(bytes) {
        message.to_uorb().expect("a decoded message can be encoded");
        message.validate();
        let _ = message.to_json();
    }
    let _ = ty.decode_uorb_strict(bytes);
}

/// Writes the length 2³² - 1 at every position of a payload, and optionally truncates the rest.
#[test]
fn does_not_trust_lengths() {
    let schema = schema();
    let types = Types::new(&schema);
    for message in &schema.messages {
        let ty = types.find("demo", &message.name).expect("the type");
        for seed in 0..2 {
            let value = ty.from_json(&Draw(seed).message(&schema, message)).expect("a message");
            for order in [ByteOrder::LittleEndian, ByteOrder::BigEndian] {
                let payload = value.to_cdr(order).expect("a payload");
                for at in (extent(0, HEADER)..payload.len().saturating_sub(3)).step_by(extent(4, 36)) {
                    for length in [u32::MAX, 1 << 31, 0x00ff_ffff, 7, 0] {
                        let mut payload = payload.clone();
                        let bytes = match order {
                            ByteOrder::LittleEndian => length.to_le_bytes(),
                            ByteOrder::BigEndian => length.to_be_bytes(),
                        };
                        payload[at..at + 4].copy_from_slice(&bytes);
                        read(ty, &payload);
                        read(ty, &payload[..at + 4]);
                    }
                }
            }
        }
    }
}

#[test]
fn decodes_random_bytes_to_a_value_or_an_error() {
    let schema = schema();
    let types = Types::new(&schema);
    let mut draw = Draw(7);
    let mut values = 0;
    for _ in 0..5000 {
        for ty in types.iter() {
            let length = draw.below(90);
            let mut bytes = draw.bytes(length);
            if let Some(head) = bytes.first_chunk_mut() {
                *head = [0, draw.bytes(1)[0] & 1, 0, 0];
            }
            // Use small numbers, which create plausible lengths.
            bytes.iter_mut().skip(HEADER).for_each(|byte| *byte &= [0xff, 3, 0, 1][draw.below(4)]);
            values += usize::from(ty.decode_cdr(&bytes).is_ok());
            read(ty, &bytes);
        }
    }
    assert!(values > 300, "only {values} values");
}

#[test]
fn limits_the_number_of_empty_messages_to_the_payload_size() {
    let (_, schema, _) = support::texts(ROS2, &[("Many.msg", "Empty[] all\n"), ("Empty.msg", "")]);
    let types = Types::new(&schema);
    let ty = types.find("demo", "Many").expect("the type");
    let payload = [&[0, 1, 0, 0, 100, 0, 0, 0][..], &[0; 100]].concat();
    let message = ty.decode_cdr(&payload).expect("a message");
    assert_eq!(message.to_cdr(ByteOrder::LittleEndian).as_deref(), Ok(&payload[..]));
    assert!(ty.decode_cdr(&payload[..payload.len() - 1]).is_err());
    assert!(ty.decode_cdr(&[0, 1, 0, 0, 0xff, 0xff, 0xff, 0xff]).is_err());
}

#[test]
fn does_not_allocate_large_types_for_small_payloads() {
    let count = extent(4_000_000, 400_000);
    let wide = format!("Byte[{count}] a\nstring b\n");
    let files = [
        ("Large.msg", "uint8[16000000] a\nstring b\n"),
        ("Wide.msg", wide.as_str()),
        ("Byte.msg", "uint8 a\n"),
    ];
    let (_, schema, diagnostics) = support::texts(ROS2, &files);
    assert!(diagnostics.is_empty());
    let types = Types::new(&schema);
    let wide = types.find("demo", "Wide").expect("the type");
    let payload = wide.default().to_cdr(ByteOrder::LittleEndian).expect("a payload");
    assert_eq!(payload.len(), HEADER + count + 5);
    assert_eq!(wide.decode_cdr(&payload).expect("a message").size_in_memory(), 8 * (count + 1));
    assert!(wide.decode_cdr(&[0, 1, 0, 0, 1, 2, 3]).is_err());
    let ty = types.find("demo", "Large").expect("the type");
    let error = ty.decode_cdr(&[0, 1, 0, 0, 1, 2, 3]).expect_err("refused");
    assert_eq!(error.to_string(), "a[3] at byte 4: expected 16000000 more bytes, found 3");
}

#[test]
fn limits_the_nesting_depth_of_definitions() {
    let files: Vec<(String, String)> = (0..2000)
        .map(|level| {
            let text = if level == 0 {
                "string a\n".to_owned()
            } else {
                format!("L{}[] a\nL{} b\n", level - 1, level - 1)
            };
            (format!("L{level}.msg"), text)
        })
        .collect();
    let files: Vec<(&str, &str)> = files.iter().map(|(path, text)| (&**path, &**text)).collect();
    let (_, schema, _) = support::texts(ROS2, &files);
    let types = Types::new(&schema);
    let find = |level: usize| types.find("demo", &format!("L{level}")).expect("the type");
    let error = find(33).decode_cdr(&[0, 1, 0, 0]).expect_err("refused");
    assert_eq!(error.reason, Reason::Defect(Defect::TooDeep(32)));
    assert_eq!(
        find(1999).from_json_text("{}").expect_err("refused").to_string(),
        "L1999: nests messages more than 32 levels deep"
    );
    assert!(find(1999).default().to_cdr(ByteOrder::LittleEndian).is_err());
    let deepest = find(32).default();
    let payload = deepest.to_cdr(ByteOrder::BigEndian).expect("a payload");
    assert!(find(32).decode_cdr(&payload).is_ok());
    let text = deepest.view().to_json_text().expect("JSON");
    assert!(find(32).from_json_text(&text).is_ok());
}

#[test]
fn reports_defects_of_types() {
    let files = [
        ("A.msg", "B b\n"),
        ("B.msg", "A[2] a\n"),
        ("C.msg", "uint8 a\n"),
        ("D.msg", "uint8[16000000] a\nuint8[16000000] b\nstring c\n"),
    ];
    let (_, schema, diagnostics) = support::texts(ROS2, &files);
    assert!(!diagnostics.is_empty());
    let types = Types::new(&schema);
    let defect = |name: &str| types.find("demo", name).expect("the type").defect();
    assert_eq!(defect("A"), Some(&Defect::Recursive));
    assert_eq!(defect("C"), None);
    assert!(matches!(defect("D"), Some(Defect::TooLarge(_))));
    assert_eq!(types.find("demo", "D").expect("the type").size(), None);
}

#[test]
fn returns_the_size_of_fixed_size_types() {
    let schema = schema();
    let types = Types::new(&schema);
    let byte = types.find("demo", "Byte").expect("the type");
    assert_eq!(byte.size(), Some(Size { padded: 8, no_padding: 1 }));
    let error = byte.decode_uorb(&[0; 2]).expect_err("refused");
    assert_eq!(
        error.to_string(),
        "Byte at byte 2: expected 8 bytes (1 without the trailing padding), found 2"
    );
    let error = types.find("demo", "Leaf").expect("the type").decode_uorb(&[0; 2]).expect_err("refused");
    assert_eq!(error.to_string(), "Leaf: expected a message of fixed size, found strings or sequences");
}

/// The typed codec reports the same errors.
#[test]
fn reports_the_path_and_byte_of_faults_in_messages_of_fixed_size() {
    let files = [
        ("Hollow.msg", "Empty e\nuint8 x\n"),
        ("Empty.msg", ""),
        ("Out.msg", "In[2] ins\nbool last\n"),
        ("In.msg", "uint16 x\nbool[3] flags\n"),
    ];
    let (_, schema, _) = support::texts(ROS2, &files);
    let types = Types::new(&schema);
    let ty = types.find("demo", "Hollow").expect("the type");
    for (end, expected) in [(4, "e at byte 4"), (5, "x at byte 5")] {
        let error = ty.decode_cdr(&[0, 1, 0, 0, 0, 0][..end]).expect_err("too short");
        assert_eq!(error.to_string(), format!("{expected}: expected 1 more byte, found 0"));
    }
    let ty = types.find("demo", "Out").expect("the type");
    for order in [ByteOrder::LittleEndian, ByteOrder::BigEndian] {
        let mut payload = ty.default().to_cdr(order).expect("a payload");
        payload[14..].fill(9);
        let error = ty.decode_cdr_strict(&payload).expect_err("odd");
        assert_eq!(error.to_string(), "ins[1].flags[2] at byte 14: expected 0 or 1, found 9");
    }
}

#[test]
fn reports_the_path_of_invalid_json() {
    let schema = schema();
    let types = Types::new(&schema);
    let ty = types.find("demo", "Twig").expect("the type");
    let leaf = r#"{"a":true,"b":["x"],"c":[1,2]}"#;
    let text = format!(r#"{{"a":1,"b":["x"],"c":[{leaf}],"d":[{leaf},{leaf}]}}"#);
    assert!(ty.from_json_text(&text).is_ok());
    for (from, to, expected) in [
        ("1,2", "1,70000", "c[0].c[1]: invalid value: integer `70000`, expected an integer from 0 to 65535"),
        ("true", "0", "c[0].a: invalid type: integer `0`, expected true or false"),
        (r#""a":1,"#, "", "Twig: missing field `a`"),
        (r#""a":1,"#, r#""a":1,"a":1,"#, "a: duplicate field `a`"),
        (r#""a":1,"#, r#""a":1,"z":1,"#, "Twig: unknown field `z`"),
        (r#""b":["x"]"#, r#""b":7"#, "b: invalid type: integer `7`, expected an array"),
        (r#""d":["#, r#""d":7,"x":["#, "d: invalid type: integer `7`, expected an array of 2"),
        (r#""b":["x"]"#, r#""b":["x",7]"#, "b[1]: invalid type: integer `7`, expected a string"),
        (
            r#""d":["#,
            r#""d":[[],"#,
            "d[0]: invalid type: sequence, expected an object with the fields of Leaf",
        ),
        (r#","d":"#, r#","d":[],"x":"#, "d: invalid length 0, expected an array of 2"),
    ] {
        let spoiled = text.replacen(from, to, 1);
        assert_ne!(spoiled, text);
        let error = ty.from_json_text(&spoiled).expect_err(&spoiled).to_string();
        assert!(error.starts_with(expected), "{error}\n{expected}");
        let tree = serde_json::from_str(&spoiled);
        if expected.contains("duplicate") {
            continue; // a JSON tree can't contain duplicate keys
        }
        let error = ty.from_json(&tree.expect("JSON")).expect_err(&spoiled).to_string();
        assert_eq!(error, expected);
    }
    for text in [
        "",
        "[",
        "{",
        "nul",
        "{\"a\"",
        "7",
        &"[".repeat(10_000),
        &"{\"c\":[".repeat(10_000),
        &format!("{text}]"),
    ] {
        assert!(ty.from_json_text(text).is_err(), "{text}");
    }
}

/// If a form can't represent a value, the error contains the path of the value.
#[test]
fn reports_the_path_of_values_that_a_form_cannot_represent() {
    let files = [("Outer.msg", "Inner[] all\nstring<=2[] names\n"), ("Inner.msg", "float32[2] a\n")];
    let (_, schema, _) = support::texts(ROS2, &files);
    let types = Types::new(&schema);
    let ty = types.find("demo", "Outer").expect("the type");
    let inner = types.find("demo", "Inner").expect("the type");
    let message = inner.decode_uorb(&[0, 0, 0, 0, 0, 0, 0x80, 0xff]).expect("a message");
    assert_eq!(message.to_json().expect_err("refused").to_string(), "a[1]: -inf, which JSON can't represent");
    let message = ty.from_json_text(r#"{"all":[],"names":["ab","abc"]}"#).expect("a message");
    let error = message.to_cdr(ByteOrder::LittleEndian).expect_err("refused");
    assert_eq!(error.to_string(), "names[1]: expected at most 2, found 3");
    assert_eq!(message.validate()[0].to_string(), "names[1]: length 3 exceeds the bound 2 (PX-CDR-02)");
}

#[test]
fn does_not_panic_on_invalid_paths() {
    let schema = schema();
    let types = Types::new(&schema);
    let message = types.find("demo", "Twig").expect("the type").default();
    assert!(message.get("d[1].a").is_some());
    for path in [
        "",
        ".",
        "d[",
        "d]",
        "d[]",
        "d[[1]]",
        "d[2]",
        "d[-1]",
        "d[99999999999999999999].a",
        "d.a",
        "a[0]",
        "a.a",
        "b[0]",
        "d[1].",
        "é",
    ] {
        assert!(message.get(path).is_none(), "{path}");
    }
    let mut long = String::new();
    for _ in 0..1000 {
        let _ = write!(long, "d[1].");
    }
    assert!(message.get(&long).is_none());
}
