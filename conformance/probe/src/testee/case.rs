//! The test cases for testees: requests and expected responses, made from the test vectors of the definitions.

use serde_json::{Map, Value, json};
use uavspec_dynamic::{DynamicMessage, Field, MessageType, Types};
use uavspec_emit::vectors;
use uavspec_rules::definitions::Definitions;
use uavspec_rules::px4::{self, Px4Rule};
use uavspec_runtime::Scalar;
use uavspec_runtime::cdr::ByteOrder;
use uavspec_schema::{Element, Shape};

use super::protocol::{Format, Hello, Op};
use super::wire::{FLOAT, to_base64, to_wire};

/// The rules about the payload as a whole. If a payload violates one of them, it can't be decoded. If a payload
/// violates another rule, for example because a `bool` is 153, a codec may reject it or decode it leniently.
static PAYLOAD_RULES: [&Px4Rule; 3] = [&px4::DATA_01, &px4::CDR_01, &px4::CDR_02];

/// A number whose encoding has no byte in common with the encoding of NaN, neither as a `float32` nor as a `float64`.
/// If it replaces NaN in a message, exactly the bytes of the float change.
pub(super) const UNLIKE_NAN: f64 = 1.1;

/// The offset of the second options byte in the encapsulation header of a CDR payload.
const CDR_OPTIONS: usize = 3;

/// A request and its expected responses.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// The requested operation.
    pub op: Op,
    /// The binary format; `None` if the request and the response contain no bytes.
    pub format: Option<Format>,
    /// The name of the message type, such as `px4/Event`.
    pub type_name: String,
    /// An id that is unique for the op, format and type.
    pub id: String,
    /// A description for people.
    pub description: String,
    /// The rule that the input violates.
    pub rule: Option<String>,
    /// The input of the request.
    pub input: Input,
    /// The expected responses.
    pub expected: Expected,
}

/// The input of a request.
#[derive(Clone, Debug, PartialEq)]
pub enum Input {
    /// No input: the request names only a type.
    Nothing,
    /// A payload.
    Bytes(Vec<u8>),
    /// An event, and the profile of the reader.
    Event {
        /// The id of the event.
        id: u64,
        /// The bytes of its arguments.
        arguments: Vec<u8>,
        /// The name of the profile.
        profile: String,
    },
    /// JSON in wire encoding.
    Value(Value),
}

/// The expected responses.
#[derive(Clone, Debug, PartialEq)]
pub struct Expected {
    /// The accepted values of `ok`.
    pub ok: ExpectedResponse,
    /// True if the testee may also reject the input.
    pub rejection: bool,
}

/// The accepted values of `ok`.
#[derive(Clone, Debug, PartialEq)]
pub enum ExpectedResponse {
    /// No value: the testee must reject the input.
    Nothing,
    /// Any value.
    Anything,
    /// This message, as JSON. Infinities are tagged.
    Message(Value),
    /// One of these byte strings, the usual one first. In responses to [`Op::Encode`], a NaN may have any bit pattern.
    Bytes(Vec<Vec<u8>>),
    /// This JSON value.
    Exactly(Value),
}

impl Case {
    /// The full name: op, format, type and id, such as `decode-uorb/px4/Event/typical`.
    pub fn name(&self) -> String {
        format!("{}/{}/{}", self.action(), self.type_name, self.id)
    }

    /// The op and format, such as `decode-uorb`.
    pub fn action(&self) -> String {
        let format = self.format.map(|format| format!("-{}", format.name()));
        self.op.name().to_owned() + &format.unwrap_or_default()
    }

    /// The request with this id, as JSON.
    pub fn request(&self, id: u64) -> Value {
        let mut request = Map::new();
        request.insert("id".to_owned(), id.into());
        request.insert("op".to_owned(), self.op.name().into());
        request.insert("type".to_owned(), self.type_name.clone().into());
        if let Some(format) = self.format {
            request.insert("format".to_owned(), format.name().into());
        }
        match &self.input {
            Input::Nothing => {}
            Input::Bytes(bytes) => {
                request.insert("bytes".to_owned(), to_base64(bytes).into());
            }
            Input::Event { id, arguments, profile } => {
                request.insert("event".to_owned(), (*id).into());
                request.insert("bytes".to_owned(), to_base64(arguments).into());
                request.insert("profile".to_owned(), profile.clone().into());
            }
            Input::Value(value) => {
                request.insert("value".to_owned(), value.clone());
            }
        }
        Value::Object(request)
    }

    /// The message type; `None` for types that are defined as JSON.
    pub(super) fn message_type<'t>(&self, types: &'t Types) -> Option<MessageType<'t>> {
        self.type_name.split_once('/').and_then(|(package, name)| types.find(package, name))
    }

    /// True if the testee supports the op, type and format of this case.
    pub(crate) fn is_for(&self, hello: &Hello) -> bool {
        hello.ops.contains(&self.op)
            && hello.types.contains(&self.type_name)
            && self.format.is_none_or(|format| hello.formats.contains(&format))
    }
}

impl Expected {
    const fn ok(want: ExpectedResponse) -> Self {
        Self { ok: want, rejection: false }
    }

    const fn either(want: ExpectedResponse) -> Self {
        Self { ok: want, rejection: true }
    }

    const REJECTED: Self = Self { ok: ExpectedResponse::Nothing, rejection: true };
}

/// All cases from the definitions, grouped by type.
pub fn cases(definitions: &Definitions, types: &Types) -> Vec<Case> {
    let files = vectors::emit(&definitions.schema, &vectors::Options::default());
    let files = files.iter().filter(|file| file.path.ends_with(".vectors.json"));
    // The emitter writes valid JSON. If a file couldn't be parsed, it would have no cases.
    files
        .filter_map(|file| serde_json::from_str(&file.text).ok())
        .flat_map(|file| cases_in_file(&file, types))
        .collect()
}

fn cases_in_file(file: &Value, types: &Types) -> Vec<Case> {
    let Some(type_name) = file["type"].as_str() else { return Vec::new() };
    let message = type_name.split_once('/').and_then(|(package, name)| types.find(package, name));
    // The vectors contain a PX4 hash only for types with uORB payloads. Types in other dialects have no memory layout,
    // even if they have a size.
    let builder = CaseBuilder { type_name, message, has_uorb: file.get("hash").is_some() };
    let mut cases = builder.type_cases(file);
    for vector in file["cases"].as_array().into_iter().flatten() {
        builder.add_vector(vector, &mut cases);
    }
    builder.add_infinities(file, &mut cases);
    cases
}

/// Builds the cases of one type.
struct CaseBuilder<'f, 't> {
    type_name: &'f str,
    message: Option<MessageType<'t>>,
    /// True if messages of the type have uORB payloads.
    has_uorb: bool,
}

impl CaseBuilder<'_, '_> {
    /// The cases about the type itself: its hashes and memory layout.
    fn type_cases(&self, file: &Value) -> Vec<Case> {
        let fact = |op: Op, format, value| {
            let head = json!({ "id": op.name(), "description": "the hash or memory layout of the type" });
            self.case(&head, op, Some(format), Input::Nothing, Expected::ok(ExpectedResponse::Exactly(value)))
        };
        let mut cases = Vec::new();
        for (name, format) in [("hash", Format::Uorb), ("type_hash", Format::Cdr)] {
            cases.extend(file.get(name).map(|value| fact(Op::Hash, format, value.clone())));
        }
        if let Some((message, size)) =
            self.message.and_then(|it| Some((it, it.size()?))).filter(|_| self.has_uorb)
        {
            let offsets: Map<String, Value> =
                message.fields().iter().map(|field| (field.name.to_string(), field.offset.into())).collect();
            let layout =
                json!({ "size": size.padded, "size_no_padding": size.no_padding, "offsets": offsets });
            cases.push(fact(Op::Layout, Format::Uorb, layout));
        }
        cases
    }

    /// Adds cases that decode an event: one for each profile whose texts differ from those of the previous profile.
    fn add_event(&self, vector: &Value, arguments: &[u8], cases: &mut Vec<Case>) {
        let texts = vector["texts"].as_object();
        let mut previous = None;
        for (profile, texts) in texts.into_iter().flatten() {
            if previous == Some(texts) {
                continue;
            }
            previous = Some(texts);
            let mut event = vector["json"].clone();
            event["message"] = texts["message"].clone();
            event["description"] = texts["description"].clone();
            let input = Input::Event {
                id: event["id"].as_u64().unwrap_or_default(),
                arguments: arguments.to_vec(),
                profile: profile.clone(),
            };
            let mut head = vector.clone();
            head["id"] = format!("{}-{profile}", vector["id"].as_str().unwrap_or_default()).into();
            let expected = Expected::ok(ExpectedResponse::Exactly(to_wire(&event, None)));
            cases.push(self.case(&head, Op::DecodeEvent, None, input, expected));
        }
    }

    fn add_vector(&self, vector: &Value, cases: &mut Vec<Case>) {
        if let Some(arguments) = vector["arguments"].as_str().and_then(from_hex) {
            return self.add_event(vector, &arguments, cases);
        }
        let rule = vector["rule"].as_str();
        let has_bytes = Format::ALL.iter().any(|format| vector.get(format.name()).is_some());
        let json = vector.get("json").filter(|json| has_bytes || !is_lossy(json));
        for format in Format::ALL {
            let bytes = vector[format.name()].as_str().and_then(from_hex);
            if let Some(bytes) = &bytes {
                let wanted = json.or_else(|| vector.get("decoded"));
                let expected = self.decoded(rule, format, bytes, wanted);
                let input = Input::Bytes(bytes.clone());
                cases.push(self.case(vector, Op::Decode, Some(format), input, expected));
            }
            if let (Some(json), Some(message)) = (json, self.message) {
                let input = Input::Value(to_wire(json, Some(message)));
                let expected = bytes.as_ref().map(|bytes| self.encoded(rule, format, bytes));
                // An invalid value has no bytes. If valid messages have no bytes in this format either, no case is
                // added.
                let expected = expected
                    .or_else(|| (rule.is_some() && self.supports(format)).then_some(Expected::REJECTED));
                cases.extend(
                    expected.map(|expected| self.case(vector, Op::Encode, Some(format), input, expected)),
                );
            }
            if let (Some(bytes), true, None) = (bytes, json.is_some(), rule) {
                let expected = self.encoded(None, format, &bytes);
                cases.push(self.case(vector, Op::Roundtrip, Some(format), Input::Bytes(bytes), expected));
            }
        }
        if let Some(json) = json {
            let input = Input::Value(to_wire(json, self.message));
            let expected =
                if rule.is_none() { Expected::ok(ExpectedResponse::Anything) } else { Expected::REJECTED };
            cases.push(self.case(vector, Op::Validate, None, input.clone(), expected));
            if let Some(class) = vector.get("class") {
                let class = json!({ "class": class, "severity": vector["severity"] });
                cases.push(self.case(
                    vector,
                    Op::Severity,
                    None,
                    input,
                    Expected::ok(ExpectedResponse::Exactly(class)),
                ));
            }
        }
    }

    /// Adds cases that decode an infinity in the first field of each float type. JSON can't represent infinities, so no
    /// vector contains one, and a codec may reject it.
    fn add_infinities(&self, file: &Value, cases: &mut Vec<Case>) {
        let mut vectors = file["cases"].as_array().into_iter().flatten();
        let zero = vectors.find(|vector| vector["id"] == "zero").and_then(|zero| zero["json"].as_object());
        let (Some(message), Some(zero)) = (self.message, zero) else { return };
        for scalar in [Scalar::Float32, Scalar::Float64] {
            let is_float =
                |field: &&Field| field.shape == Shape::Single && field.element == Element::Scalar(scalar);
            let Some(field) = message.fields().iter().find(is_float) else { continue };
            for number in [f32::INFINITY, f32::NEG_INFINITY] {
                let bytes = match scalar {
                    Scalar::Float32 => number.to_le_bytes().to_vec(),
                    _ => f64::from(number).to_le_bytes().to_vec(),
                };
                let text = number.to_string();
                self.add_infinity(message, (zero, &*field.name), (text.as_str(), bytes.as_slice()), cases);
            }
        }
    }

    /// Adds cases that decode the message `zero` with an infinity in one field. `text` and `bytes` represent this
    /// infinity.
    fn add_infinity(
        &self,
        message: MessageType<'_>,
        (zero, field): (&Map<String, Value>, &str),
        (text, bytes): (&str, &[u8]),
        cases: &mut Vec<Case>,
    ) {
        let with = |value: Value| {
            let mut json = zero.clone();
            json.insert(field.to_owned(), value);
            Value::Object(json)
        };
        let (nan, other) = (with(Value::Null), with(UNLIKE_NAN.into()));
        for format in Format::ALL.into_iter().filter(|format| self.supports(*format)) {
            let Some(payload) = with_float(message, format, (&nan, &other), bytes) else { continue };
            let violated = decode(message, format, &payload)
                .and_then(|decoded| decoded.validate().first().map(|found| found.kind.id()));
            let head = json!({
                "id": format!("{field}-{}", text.replace('-', "minus-")),
                "description": format!("{field}: {text}"),
                "rule": violated,
            });
            let expected = Expected::either(ExpectedResponse::Message(with(json!({ FLOAT: text }))));
            cases.push(self.case(&head, Op::Decode, Some(format), Input::Bytes(payload), expected));
        }
    }

    fn supports(&self, format: Format) -> bool {
        match format {
            Format::Uorb => self.has_uorb && self.message.is_some_and(|message| message.size().is_some()),
            Format::Cdr => true,
        }
    }

    /// The expected result of encoding. uORB bytes may lack the trailing padding, as in logs. CDR bytes may have
    /// trailing padding, and their header may contain its length.
    fn encoded(&self, rule: Option<&str>, format: Format, bytes: &[u8]) -> Expected {
        let mut right = vec![bytes.to_vec()];
        match (format, self.message.and_then(MessageType::size)) {
            (Format::Uorb, Some(size)) => right.extend(bytes.get(..size.no_padding).map(<[u8]>::to_vec)),
            (Format::Uorb, None) => {}
            (Format::Cdr, _) => right.extend(padded_cdr(bytes)),
        }
        right.dedup();
        Expected { ok: ExpectedResponse::Bytes(right), rejection: rule.is_some() }
    }

    /// The expected result of decoding. Some vectors contain only bytes, because encoders never write these bytes. A
    /// codec may then return the same result as a lenient codec.
    fn decoded(&self, rule: Option<&str>, format: Format, bytes: &[u8], wanted: Option<&Value>) -> Expected {
        if rule.is_some_and(|id| PAYLOAD_RULES.iter().any(|known| known.rule.id == id)) {
            return Expected::REJECTED;
        }
        let read = || decode(self.message?, format, bytes)?.to_json().ok();
        let want = match wanted.cloned().or_else(read) {
            Some(message) => ExpectedResponse::Message(message),
            // The message can't be represented in JSON, for example because a text isn't UTF-8.
            None => ExpectedResponse::Anything,
        };
        if rule.is_some() { Expected::either(want) } else { Expected::ok(want) }
    }

    fn case(&self, vector: &Value, op: Op, format: Option<Format>, input: Input, expected: Expected) -> Case {
        let text = |name: &str| vector[name].as_str().map(str::to_owned);
        Case {
            op,
            format,
            type_name: self.type_name.to_owned(),
            id: text("id").unwrap_or_default(),
            description: text("description").unwrap_or_default(),
            rule: text("rule"),
            input,
            expected,
        }
    }
}

/// Encodes a message in little-endian order. Returns `None` if it can't be encoded in this format.
pub(super) fn encode(message: MessageType<'_>, format: Format, json: &Value) -> Option<Vec<u8>> {
    let message = message.from_json(json).ok()?;
    match format {
        Format::Uorb => message.to_uorb().ok(),
        Format::Cdr => message.to_cdr(ByteOrder::LittleEndian).ok(),
    }
}

/// Decodes a message leniently: a `bool` is true unless its byte is 0.
pub(super) fn decode<'t>(
    message: MessageType<'t>,
    format: Format,
    bytes: &[u8],
) -> Option<DynamicMessage<'t>> {
    match format {
        Format::Uorb => message.decode_uorb(bytes).ok(),
        Format::Cdr => message.decode_cdr(bytes).ok(),
    }
}

/// Encodes a message in which the bytes of a float are replaced by `float`. In the two JSON messages, this float is NaN
/// and [`UNLIKE_NAN`].
fn with_float(
    message: MessageType<'_>,
    format: Format,
    (nan, other): (&Value, &Value),
    float: &[u8],
) -> Option<Vec<u8>> {
    let (nan, mut payload) = (encode(message, format, nan)?, encode(message, format, other)?);
    let at = nan.iter().zip(&payload).position(|(nan, other)| nan != other)?;
    payload.get_mut(at..at + float.len())?.copy_from_slice(float);
    Some(payload)
}

/// The other valid forms of a CDR payload whose length isn't a multiple of four: with padding bytes at the end, with
/// their number in the two low bits of the header's options (DDS-XTypes 1.3, section 7.6.3.1.2), or with both.
fn padded_cdr(bytes: &[u8]) -> Vec<Vec<u8>> {
    let length = bytes.len().next_multiple_of(4);
    let Ok(padding @ 1..) = u8::try_from(length - bytes.len()) else { return Vec::new() };
    let padded = |bytes: &[u8]| {
        let mut bytes = bytes.to_vec();
        bytes.resize(length, 0);
        bytes
    };
    let mut counted = bytes.to_vec();
    if let Some(options) = counted.get_mut(CDR_OPTIONS) {
        *options |= padding;
    }
    vec![padded(bytes), padded(&counted), counted]
}

/// True if parsing changed a number in the vector. Some integers below the smallest `int64` are parsed as floats, and
/// are rounded to exactly the smallest `int64`. Some testees read these floats as integers.
#[allow(clippy::float_cmp, clippy::cast_precision_loss)] // an exact comparison is intended
fn is_lossy(value: &Value) -> bool {
    match value {
        Value::Number(number) => number.is_f64() && number.as_f64() == Some(i64::MIN as f64),
        Value::Array(items) => items.iter().any(is_lossy),
        Value::Object(members) => members.values().any(is_lossy),
        Value::Null | Value::Bool(_) | Value::String(_) => false,
    }
}

fn from_hex(text: &str) -> Option<Vec<u8>> {
    let pairs = text.as_bytes().chunks(2).map(|pair| std::str::from_utf8(pair).ok());
    pairs.map(|pair| u8::from_str_radix(pair?, 16).ok()).collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use std::collections::BTreeSet;
    use std::sync::LazyLock;

    use uavspec_schema::MessageId;
    use uavspec_test_support::extent;

    use super::*;

    /// The PX4 messages that always have cases.
    const MESSAGES: [&str; 3] = ["BatteryStatus", "Event", "RegisterExtComponentRequest"];

    /// The built-in definitions. In quick mode, many types have no cases.
    pub(crate) static DEFINITIONS: LazyLock<Definitions> = LazyLock::new(|| {
        let mut definitions = Definitions::built_in();
        if extent(true, false) {
            return definitions;
        }
        let schema = &definitions.schema;
        let messages = schema.packages.iter().flat_map(|package| &package.messages).copied();
        let kept: BTreeSet<MessageId> =
            messages.filter(|id| MESSAGES.contains(&schema.message(*id).name.as_str())).collect();
        for package in &mut definitions.schema.packages {
            package.messages.retain(|id| kept.contains(id));
            package.json_types = package.json_types.iter().copied().step_by(8).collect();
            package.json_messages = package.json_messages.iter().copied().step_by(8).collect();
        }
        definitions
    });

    /// The cases of these definitions.
    pub(crate) static CASES: LazyLock<Vec<Case>> =
        LazyLock::new(|| cases(&DEFINITIONS, &Types::new(&DEFINITIONS.schema)));

    #[test]
    fn makes_cases_of_all_vectors() {
        let cases = &*CASES;
        let names: BTreeSet<String> = cases.iter().map(Case::name).collect();
        assert_eq!(names.len(), cases.len());
        for op in Op::ALL {
            assert!(cases.iter().any(|case| case.op == op), "{}", op.name());
        }
        let find = |name: &str| cases.iter().find(|case| case.name() == name).expect(name);
        let case = find("decode-uorb/px4/Event/uorb.short");
        assert_eq!(case.expected, Expected::REJECTED);
        let request = case.request(3);
        assert_eq!(
            (&request["id"], &request["op"], &request["format"]),
            (&3.into(), &"decode".into(), &"uorb".into())
        );
        for format in ["uorb", "cdr"] {
            // If a codec doesn't reject such a `bool`, it must read it as true.
            let expected = &find(&format!("decode-{format}/px4/BatteryStatus/connected-byte-153")).expected;
            let ExpectedResponse::Message(message) = &expected.ok else { panic!("{expected:?}") };
            assert!(expected.rejection && message["connected"] == true, "{message}");
        }
        let case = find("encode-cdr/px4/BatteryStatus/voltage_v-nan");
        assert_eq!(case.request(0)["value"]["voltage_v"], json!({ "$f": "NaN" }));
        assert_eq!(find("severity/flockwave/ErrorCode/code-66").expected.ok, {
            ExpectedResponse::Exactly(json!({ "class": "warning", "severity": "warning" }))
        });
        let min = serde_json::from_str("[{\"x\": -9223372036854775809}]").expect("JSON");
        assert!(is_lossy(&min) && !is_lossy(&json!([i64::MIN, u64::MAX, 0.5])));
        let case = find("validate/px4/Event/timestamp-null");
        assert_eq!(
            (&case.request(0)["value"]["timestamp"], &case.expected),
            (&Value::Null, &Expected::REJECTED)
        );
    }

    #[test]
    fn accepts_padding_of_cdr_with_or_without_its_length() {
        let [plain, counted]: [&[u8]; 2] = [&[0, 1, 0, 0, 7], &[0, 1, 0, 3, 7]];
        let [padded, both]: [&[u8]; 2] = [&[0, 1, 0, 0, 7, 0, 0, 0], &[0, 1, 0, 3, 7, 0, 0, 0]];
        assert_eq!(padded_cdr(plain), [padded, both, counted]);
        assert!(padded_cdr(padded).is_empty());
        let (mut num_plain, mut num_padded) = (0, 0);
        for case in &*CASES {
            let ExpectedResponse::Bytes(right) = &case.expected.ok else { continue };
            if case.format == Some(Format::Cdr) {
                // Messages show the first form.
                assert_eq!(right[0][..4], ByteOrder::LittleEndian.header(), "{}", case.name());
                let is_padded = !right[0].len().is_multiple_of(4);
                assert_eq!(right.len(), if is_padded { 4 } else { 1 }, "{}", case.name());
                *(if is_padded { &mut num_padded } else { &mut num_plain }) += 1;
            }
        }
        assert!(num_plain > 0 && num_padded > 0, "{num_plain} {num_padded}");
    }

    #[test]
    fn makes_cases_with_infinities() {
        for (name, bytes, float) in [
            ("decode-uorb/px4/BatteryStatus/voltage_v-inf", [0_u8, 0, 0x80, 0x7f], "inf"),
            ("decode-cdr/px4/BatteryStatus/voltage_v-minus-inf", [0, 0, 0x80, 0xff], "-inf"),
        ] {
            let case = CASES.iter().find(|case| case.name() == name).expect(name);
            let Input::Bytes(payload) = &case.input else { panic!("{case:?}") };
            assert!(payload.windows(4).any(|window| window == bytes), "{payload:?}");
            let ExpectedResponse::Message(message) = &case.expected.ok else { panic!("{case:?}") };
            assert_eq!(
                (&message["voltage_v"], case.expected.rejection, &case.rule),
                (&json!({ "$f": float }), true, &None)
            );
        }
    }

    #[test]
    fn makes_uorb_cases_only_for_types_with_uorb_payloads() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("uavspec.toml");
        let config = "[[package]]\nname = \"demo\"\ndialect = \"ros2\"\ninclude = [\"*.msg\"]\n";
        std::fs::write(&path, config).expect("a file");
        std::fs::write(folder.path().join("Wind.msg"), "float32 speed\n").expect("a file");
        let definitions = Definitions::load(&path).expect("definitions");
        let cases = cases(&definitions, definitions.types());
        assert!(cases.iter().any(|case| case.name() == "encode-cdr/demo/Wind/typical"));
        assert!(cases.iter().any(|case| case.op == Op::Encode && case.expected == Expected::REJECTED));
        let uorb: Vec<String> =
            cases.iter().filter(|case| case.format == Some(Format::Uorb)).map(Case::name).collect();
        assert_eq!(uorb, [""; 0]);
    }
}
