//! Reads arbitrary bytes as messages whose types are known only at run time: as uORB, as CDR, as JSON, or with the
//! formats from a log. The first byte selects the encoding, and the second byte selects the type.

use std::sync::LazyLock;

use uavspec_dynamic::{DynamicMessage, MessageType, Reason, Types, ULOG_PACKAGE};
use uavspec_runtime::Fault;
use uavspec_runtime::cdr::{ByteOrder, HEADER};
use uavspec_schema::msg::Dialect;
use uavspec_schema::{Form, PackageInput, SourceMap, read};

const FILES: [(&str, &str); 6] = [
    (
        "Tree.msg",
        "bool[2] a\nstring b 'x'\nwstring<=9 c\nuint64[] d\nByte[] e\nEmpty[] f\nTwig[<=3] g\nstring[] h\nTwig i\n",
    ),
    ("Twig.msg", "uint8 a\nstring<=4[<=5] b\nLeaf[] c\nLeaf[2] d\nint16[2] e [1, -1]\n"),
    ("Leaf.msg", "bool a\nwstring[] b\nuint16[<=6] c\nfloat32 d # [@range 0, 1]\n"),
    ("Fixed.msg", "bool a\nByte[3] b\nfloat64[2] c\nint64 d\nchar[5] e\nEmpty f\n"),
    ("Byte.msg", "uint8 a\n"),
    ("Empty.msg", ""),
];

static TYPES: LazyLock<Types> = LazyLock::new(|| {
    let mut packages = Vec::new();
    let mut sources = SourceMap::default();
    for (name, dialect, files) in [("demo", Dialect::Ros2, &FILES[..]), ("px4", Dialect::Px4, &FILES[3..])] {
        let ids = files.iter().filter_map(|(path, text)| sources.add(*path, text.as_bytes().to_vec()).ok());
        packages.push(PackageInput::new(name, Form::Msg(dialect), ids.collect()));
    }
    Types::new(&read(&sources, &packages).0)
});

/// Selects the encoding and the type, and reads the rest of the input.
pub(crate) fn dynamic(data: &[u8]) {
    let [what, which, data @ ..] = data else { return };
    if what % 4 == 3 {
        return log(data);
    }
    let index = usize::from(*which) % TYPES.iter().len();
    let Some(of) = TYPES.iter().nth(index) else { return };
    match what % 4 {
        0 => cdr(of, data),
        1 => uorb(of, data),
        _ => json(of, data),
    }
}

fn cdr(of: MessageType<'_>, data: &[u8]) {
    let message = of.decode_cdr(data);
    assert!(
        message.is_ok() || of.decode_cdr_strict(data).is_err(),
        "the strict decoder must reject these bytes too"
    );
    let Ok(message) = message else { return };
    assert!(message.size_in_memory() <= 8 * (data.len() - HEADER), "the message uses too much memory");
    for order in [ByteOrder::LittleEndian, ByteOrder::BigEndian] {
        let payload = message.to_cdr(order).expect("a decoded message can be encoded");
        let again = of.decode_cdr(&payload).expect("an encoded message can be decoded");
        assert_eq!(again.to_cdr(order).as_ref(), Ok(&payload));
        // The encoder normalizes `bool`s, but keeps invalid text.
        if let Err(error) = of.decode_cdr_strict(&payload) {
            assert_eq!(error.reason, Reason::Fault(Fault::NotUnicode), "{error}");
        }
    }
    use_all(&message);
}

fn uorb(of: MessageType<'_>, data: &[u8]) {
    let message = of.decode_uorb(data);
    assert!(
        message.is_ok() || of.decode_uorb_strict(data).is_err(),
        "the strict decoder must reject these bytes too"
    );
    let Ok(message) = message else { return };
    let payload = message.to_uorb().expect("a decoded message can be encoded");
    let again = of.decode_uorb_strict(&payload).expect("an encoded message can be decoded");
    assert_eq!(again.to_uorb().as_ref(), Ok(&payload));
    use_all(&message);
}

fn json(of: MessageType<'_>, data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let Ok(message) = of.from_json_text(text) else { return };
    assert!(message.size_in_memory() <= 8 * text.len().max(1), "the message uses too much memory");
    use_all(&message);
}

/// Reads formats, one per line, and then a payload. The byte 0xff, which never occurs in text, precedes the payload.
fn log(data: &[u8]) {
    let mut parts = data.splitn(2, |byte| *byte == 0xff);
    let (text, payload) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
    let Ok(text) = std::str::from_utf8(text) else { return };
    let (types, _) = Types::from_ulog_formats(text.lines().filter_map(|line| line.split_once(':')));
    for of in types.iter() {
        assert_eq!(of.package(), ULOG_PACKAGE);
        let message = of.default();
        assert!(message.size_in_memory() <= 65_533, "longer than the maximum data message");
        uorb(of, payload);
    }
}

/// Validates a message, converts it to JSON and, if possible, reads the JSON back.
fn use_all(message: &DynamicMessage<'_>) {
    for violation in message.validate() {
        assert!(message.get(&violation.path).is_some(), "no value at {}", violation.path);
    }
    if let Ok(text) = message.view().to_json_text() {
        let again = message.message_type().from_json_text(&text).expect("an encoded message can be decoded");
        assert_eq!(again.view().to_json_text().as_ref(), Ok(&text));
    }
    assert_eq!(message.to_json().is_ok(), message.view().to_json_text().is_ok());
}
