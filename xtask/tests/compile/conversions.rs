//! Tests that generated conversions compile, and convert as their definitions and hints require.

use std::sync::Arc;

use serde_json::{Value, json};
use uavspec_dynamic::Types;
use uavspec_dynamic::conversion::{Conversion, Conversions, Converter, read_hints};
use uavspec_schema::msg::Dialect;
use uavspec_schema::{Form, PackageInput, Schema, SourceMap, read};

use super::{Crate, FEATURES};

const OLD: &str = "uint32 MESSAGE_VERSION = 0
uint8 MODE_A = 0
uint8 MODE_B = 1
uint8 MODE_C = 2
uint8 mode        # [@enum MODE]
uint8 FAULT_A = 1
uint8 FAULT_B = 2
uint8 faults      # [@flags FAULT]
uint8 count       # [@count parts] [@invalid 63]
Part[4] parts
Part part
uint16[3] grown   # [@invalid 9]
uint8[40] cut
float32[2] wide
uint8 wide_mode   # [@enum MODE]
int32 narrow
int32 neutral     # [@invalid 3]
float64 rounded
char[4] short
char[8] long
uint8[40] many
uint8 limit
float32 share
bool is_valid
uint32 num_marks  # [@count marks]
uint8[5] marks
uint32 num_seats  # [@count seats]
uint8[5] seats
uint8 num_knots   # [@count knots] [@invalid 255]
uint8[5] knots
uint32 num_ropes  # [@count ropes] [@invalid 65535]
uint8[5] ropes
uint32 num_turns  # [@count turns] [@invalid 255]
uint8[5] turns
uint8 LEG_UNKNOWN = 255
uint8 num_legs    # [@count legs] [@enum LEG]
uint8[5] legs
uint32 dropped
";

const NEW: &str = "uint32 MESSAGE_VERSION = 1
uint8 MODE_A = 0
uint8 MODE_C = 1
uint8 MODE_B = 2
uint16 mode       # [@enum MODE]
uint8 FAULT_B = 1
uint8 FAULT_A = 2
uint16 faults     # [@flags FAULT]
uint16 count      # [@count parts]
Part[3] parts
Part part
uint32[5] grown   # [@invalid 9]
uint8[2] cut
float64[2] wide
int32 wide_mode   # [@enum MODE]
int8 narrow
uint8 neutral     # [@invalid 3]
float32 rounded
char[8] short
char[3] long
uint8[50] many
uint8 limit
float32 share
bool is_valid
uint8 num_marks   # [@count marks]
uint8[2] marks
uint8 num_seats   # [@count seats]
uint8[2] seats
uint8 num_knots   # [@count knots] [@invalid 255]
uint8[2] knots
uint8 num_ropes   # [@count ropes]
uint8[2] ropes
uint8 num_turns   # [@count turns] [@invalid 255]
uint8[2] turns
uint8 LEG_UNKNOWN = 254
uint16 num_legs   # [@count legs] [@enum LEG]
uint8[2] legs
uint16[40] added
float32[2] unknown  # [m] [@invalid NaN] Unknown
char[9] tower     # [@invalid 0]
uint64 mask
int32 offset
float64 large
";

const PARTS: [&str; 2] = ["uint8 id\nint64 code\n", "int64 code\nuint16 id\nbool is_new\n"];

const HINTS: &str = r#"
[[hint]]
message = "Glider"
narrow = { narrow = "nearest", neutral = "neutral", rounded = "nearest", num_marks = "nearest", num_seats = "neutral", num_ropes = "nearest", num_turns = "neutral" }
new.limit = "if mode == old.MODE_B and not is_valid then limit - 300 else -limit + 0x10 * 2 | 1"
new.share = "share / 2 + limit"
new.is_valid = "share != share or faults & ~old.FAULT_B == 0 and is_valid == true"
new.mask = "if is_valid then 0xffffffffffffffff else 0"
new.offset = "if is_valid then -0x80000001 else ~0"
new.large = "if is_valid then -0x100000000 else 1"

[[hint]]
message = "Part"
narrow = { id = "nearest" }
"#;

/// The number of messages in each direction that are compared with the reference.
const NUM_CASES: usize = 200;

/// Random messages in JSON, each with the result of the reference conversion.
fn cases() -> Value {
    let mut sources = SourceMap::default();
    let packages = [("old", OLD, PARTS[0]), ("new", NEW, PARTS[1])].map(|(package, glider, part)| {
        let texts = [("Glider", glider), ("Part", part)];
        let ids = texts
            .map(|(name, text)| sources.add(format!("{package}/{name}.msg"), text.into()).expect("a source"));
        PackageInput::new(package, Form::Msg(Dialect::Px4), ids.to_vec())
    });
    let (schema, _) = read(&sources, &packages);
    let source = sources.add("hints.toml", HINTS.into()).expect("a source");
    let hints = read_hints(&sources, source);
    let conversions = Conversions::within(&schema, "old", "new", &hints).expect("both packages");
    let all = |conversions: &[Arc<Conversion>]| -> serde_json::Map<String, Value> {
        let decided = conversions.iter().filter(|found| found.is_decided());
        decided
            .map(|found| (schema.message(found.from).name.clone(), json!(converted(&schema, found))))
            .collect()
    };
    json!({ "forward": all(&conversions.forward), "backward": all(&conversions.backward) })
}

/// Pairs of a message and the converted message.
fn converted(schema: &Schema, conversion: &Conversion) -> Vec<(Value, Value)> {
    let types = Types::new(schema);
    let (source, target) = (types.get(conversion.from), types.get(conversion.to));
    let (size, converter) =
        (source.size().expect("a fixed size"), Converter::new(conversion, source, target));
    let mut state = 7_u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        // The mask excludes invalid text and infinite numbers, which JSON can't represent.
        state.to_le_bytes()[5] & 0x3f
    };
    let pairs = (0..NUM_CASES).map(|_| {
        let payload: Vec<u8> = (0..size.padded).map(|_| next()).collect();
        let message = source.decode_uorb(&payload).expect("a message");
        let result = converter.convert(&message).expect("a message");
        (message.to_json().expect("JSON"), result.to_json().expect("JSON"))
    });
    pairs.collect()
}

#[test]
fn conversions_compile_and_convert() {
    let package = Crate::new("conversions");
    for (at, (folder, glider)) in [("old", OLD), ("new", NEW)].into_iter().enumerate() {
        package.write(&format!("{folder}/Glider.msg"), glider);
        package.write(&format!("{folder}/Part.msg"), PARTS[at]);
    }
    package.write("ros_shared/msg/Header.msg", "string name\n");
    package.write(
        "ros_old/msg/Box.msg",
        "ros_shared/Header header\nuint8[] data\nstring[] names\nuint8[<=3] few\nPart[] parts\nstring text\nuint8[] level\n",
    );
    package.write(
        "ros_new/msg/Box.msg",
        "ros_shared/Header header\nuint8[<=2] data\nstring<=2[] names\nuint8[2] few [7, 8]\nPart[<=4] parts\nstring text\nuint8[] level\nfloat32 speed 2.5\n",
    );
    package.write("ros_old/msg/Part.msg", "uint8 id\n");
    package.write("ros_new/msg/Part.msg", "uint16 id\n");
    package.write("ros_old/srv/Tow.srv", "uint8 height\n---\nbool is_ready\n");
    package.write("ros_new/srv/Tow.srv", "uint16 height\n---\nbool is_ready\n");
    package.write("hints.toml", HINTS);
    package.write("ros.toml", "[[hint]]\nmessage = \"Part\"\nnarrow = { id = \"nearest\" }\n");
    package.write("tests/conversions.rs", include_str!("converted.rs"));
    package.write("tests/cases.json", &cases().to_string());
    let table = |name: &str, dialect: &str| {
        format!("\n[[package]]\nname = \"{name}\"\ndialect = \"{dialect}\"\ninclude = [\"{name}/**/*.*\"]\n")
    };
    let packages: String =
        [("old", "px4"), ("new", "px4"), ("ros_old", "ros2"), ("ros_new", "ros2"), ("ros_shared", "ros2")]
            .map(|(name, dialect)| table(name, dialect))
            .concat();
    let conversions = "\n[[conversion]]\nfrom = \"old\"\nto = \"new\"\nhints = \"hints.toml\"\n\n\
                       [[conversion]]\nfrom = \"ros_old\"\nto = \"ros_new\"\nhints = \"ros.toml\"\n";
    package.generate(&(packages + conversions));
    package.compiles();
    package.cargo(&["test", "--features", FEATURES]);
}
