//! Converts random messages forward and back.

use proptest::prelude::*;
use serde_json::Value;
use uavspec_dynamic::Types;
use uavspec_dynamic::conversion::{Conversion, LossKind};
use uavspec_test_definitions::config;

use super::support::{Converted, convert};

/// The declaration of a field in both versions of a random message. Empty in a version without the
/// field.
fn field() -> impl Strategy<Value = (String, String)> {
    const PAIRS: &[(&str, &str)] = &[
        ("uint8", "uint8"),
        ("uint8", "uint16"),
        ("int32[3]", "int64[3]"),
        ("uint16[2]", "uint16[5]"),
        ("uint16[5]", "uint16[2]"),
        ("float32", "float64"),
        ("bool", "bool"),
        ("char[6]", "char[9]"),
        ("char[9]", "char[6]"),
        ("", "float32"),
        ("uint32", ""),
        ("Part", "Part"),
        ("Part[2]", "Part[3]"),
    ];
    proptest::sample::select(PAIRS).prop_map(|(old, new)| (old.to_owned(), new.to_owned()))
}

const HINTS: &str = "[[hint]]\nmessage = \"Glider\"\n";

/// The definitions of both versions, and hints that allow narrowing.
fn definitions(fields: &[(String, String)]) -> Converted {
    let text = |side: fn(&(String, String)) -> &String| {
        let lines = fields.iter().enumerate().filter(|(_, field)| !side(field).is_empty());
        lines.map(|(at, field)| format!("{} {}_field\n", side(field), NAMES[at])).collect::<String>()
            + "uint8 last\n"
    };
    let narrowed = fields.iter().enumerate().filter(|(_, (old, new))| {
        matches!((old.as_str(), new.as_str()), ("uint8", "uint16") | ("int32[3]", _) | ("float32", "float64"))
    });
    let narrowed: Vec<String> =
        narrowed.map(|(at, _)| format!("{}_field = \"nearest\"", NAMES[at])).collect();
    let hints = if narrowed.is_empty() {
        String::new()
    } else {
        format!("{HINTS}narrow = {{ {} }}\n", narrowed.join(", "))
    };
    let added = fields.iter().enumerate().filter(|(_, (old, new))| old.is_empty() != new.is_empty());
    let values: Vec<String> = added
        .map(|(at, (old, _))| {
            let side = if old.is_empty() { "new" } else { "old" };
            format!("{side}.{}_field = 0", NAMES[at])
        })
        .collect();
    let hints = if values.is_empty() { hints } else { format!("{hints}\n{HINTS}{}\n", values.join("\n")) };
    let part = "uint8 id\nfloat32 share\n";
    let changed = "float64 share\nuint8 id\nuint8 added\n";
    let hints = hints + "\n[[hint]]\nmessage = \"Part\"\nnarrow = { share = \"nearest\" }\n";
    convert(
        &[("Glider", &text(|field| &field.0)), ("Part", part)],
        &[("Glider", &text(|field| &field.1)), ("Part", changed)],
        &hints,
    )
}

const NAMES: [&str; 8] = ["alpha", "bravo", "charlie", "delta", "echo", "foxtrot", "golf", "hotel"];

/// The largest byte in random payloads. Bytes up to this value form only ASCII characters and finite floats, which are
/// valid.
const LARGEST_BYTE: u8 = 0x3f;

/// The message whose payload repeats `bytes`.
fn message(found: &Converted, conversion: &Conversion, bytes: &[u8]) -> Value {
    let types = Types::new(&found.schema);
    let ty = types.get(conversion.from);
    let size = ty.size().expect("a fixed size").padded;
    let payload: Vec<u8> = bytes.iter().copied().cycle().take(size).collect();
    let message = ty.decode_uorb(&payload).expect("a message");
    assert!(message.validate().is_empty());
    message.to_json().expect("JSON")
}

proptest! {
    #![proptest_config(config(200))]

    #[test]
    fn forward_and_back_loses_what_the_conversion_lists(
        fields in prop::collection::vec(field(), 1..8),
        bytes in prop::collection::vec(1..=LARGEST_BYTE, 1..64),
    ) {
        let found = definitions(&fields);
        prop_assert_eq!(found.problems(), "");
        let ways = [
            (found.forward("Glider"), found.backward("Glider")),
            (found.backward("Glider"), found.forward("Glider")),
        ];
        for (there, back) in ways {
            let original = message(&found, there, &bytes);
            let converted = found.run(there, &original);
            let types = Types::new(&found.schema);
            let read = types.get(there.to).from_json(&converted);
            prop_assert!(read.is_ok_and(|message| message.validate().is_empty()), "{converted}");
            let returned = found.run(back, &converted);
            for (at, field) in found.schema.message(there.from).fields.iter().enumerate() {
                let is_same = original[&field.name] == returned[&field.name];
                if there.keeps(at) {
                    prop_assert!(is_same, "{}: {original} {returned}", field.name);
                }
                // No byte is 0, so a dropped field, which is 0 after both conversions, differs from its original value.
                let is_dropped = there.losses.iter().any(|loss| loss.source == Some(at) && loss.kind == LossKind::Dropped);
                prop_assert!(!is_dropped || !is_same, "{}", field.name);
            }
        }
    }
}
