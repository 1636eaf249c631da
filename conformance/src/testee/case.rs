//! The test cases for testees: requests and expected responses, made from the test vectors of the definitions.

use serde_json::{Map, Value, json};
use uavspec_codegen::dynamic::{MessageType, Types};
use uavspec_codegen::emit::vectors;

use super::protocol::{Format, Hello, Op};
use super::wire::{to_base64, to_wire};
use crate::definitions::Definitions;
use crate::rules::px4::{self, Px4Rule};

/// Rules that concern the payload as a whole. A payload that violates one of these rules can't be decoded. If a payload
/// violates another rule, for example because a `bool` is 153, a codec may decode or reject it.
static PAYLOAD_RULES: [&Px4Rule; 3] = [&px4::DATA_01, &px4::CDR_01, &px4::CDR_02];

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
    /// JSON in wire encoding.
    Value(Value),
}

/// The expected responses.
#[derive(Clone, Debug, PartialEq)]
pub struct Expected {
    /// The accepted values of `ok`.
    pub ok: ExpectedResponse,
    /// True if the testee may reject the input.
    pub rejection: bool,
}

/// The accepted values of `ok`.
#[derive(Clone, Debug, PartialEq)]
pub enum ExpectedResponse {
    /// No value: the testee must reject the input.
    Nothing,
    /// Any value.
    Anything,
    /// This message, as JSON without tags.
    Message(Value),
    /// One of these byte strings.
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
    pub(crate) fn request(&self, id: u64) -> Value {
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
            Input::Value(value) => {
                request.insert("value".to_owned(), value.clone());
            }
        }
        Value::Object(request)
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
    // The emitter writes valid JSON. A file that can't be parsed would have no cases.
    files
        .filter_map(|file| serde_json::from_str(&file.text).ok())
        .flat_map(|file| cases_in_file(&file, types))
        .collect()
}

fn cases_in_file(file: &Value, types: &Types) -> Vec<Case> {
    let Some(type_name) = file["type"].as_str() else { return Vec::new() };
    let message = type_name.split_once('/').and_then(|(package, name)| types.find(package, name));
    let builder = CaseBuilder { type_name, message };
    let mut cases = builder.type_cases(file);
    for vector in file["cases"].as_array().into_iter().flatten() {
        builder.add_vector(vector, &mut cases);
    }
    cases
}

/// Builds the cases of one type.
struct CaseBuilder<'f, 't> {
    type_name: &'f str,
    message: Option<MessageType<'t>>,
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
        // Types without a PX4 hash have no memory layout, even if they have a size.
        if let Some((message, size)) =
            self.message.and_then(|it| Some((it, it.size()?))).filter(|_| file.get("hash").is_some())
        {
            let offsets: Map<String, Value> =
                message.layout().map(|field| (field.name.to_owned(), field.offset.into())).collect();
            let layout =
                json!({ "size": size.padded, "size_no_padding": size.no_padding, "offsets": offsets });
            cases.push(fact(Op::Layout, Format::Uorb, layout));
        }
        cases
    }

    fn add_vector(&self, vector: &Value, cases: &mut Vec<Case>) {
        let rule = vector["rule"].as_str();
        let has_bytes = Format::ALL.iter().any(|format| vector.get(format.name()).is_some());
        let json = vector.get("json").filter(|json| has_bytes || !is_lossy(json));
        for format in Format::ALL {
            let bytes = vector[format.name()].as_str().and_then(from_hex);
            if let Some(bytes) = &bytes {
                let wanted = json.or_else(|| vector.get("decoded"));
                let input = Input::Bytes(bytes.clone());
                cases.push(self.case(vector, Op::Decode, Some(format), input, decoded(rule, wanted)));
            }
            if let (Some(json), Some(message)) = (json, self.message) {
                let input = Input::Value(to_wire(json, Some(message)));
                let expected = bytes.as_ref().map(|bytes| self.encoded(rule, format, bytes));
                // An invalid value has no bytes. If valid messages have no bytes in this format either, there is no
                // case.
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

    fn supports(&self, format: Format) -> bool {
        format == Format::Cdr || self.message.is_some_and(|message| message.size().is_some())
    }

    /// The expected result of encoding. uORB bytes may lack the trailing padding, as in logs. CDR bytes may be padded
    /// to a multiple of four bytes, as some writers do.
    fn encoded(&self, rule: Option<&str>, format: Format, bytes: &[u8]) -> Expected {
        let mut other = bytes.to_vec();
        match (format, self.message.and_then(MessageType::size)) {
            (Format::Uorb, Some(size)) => other.truncate(size.no_padding),
            (Format::Uorb, None) => {}
            (Format::Cdr, _) => other.resize(bytes.len().next_multiple_of(4), 0),
        }
        let mut right = vec![bytes.to_vec(), other];
        right.dedup();
        Expected { ok: ExpectedResponse::Bytes(right), rejection: rule.is_some() }
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

/// The expected result of decoding.
fn decoded(rule: Option<&str>, wanted: Option<&Value>) -> Expected {
    let want = wanted.map_or(ExpectedResponse::Anything, |value| ExpectedResponse::Message(value.clone()));
    match rule {
        None => Expected::ok(want),
        Some(id) if PAYLOAD_RULES.iter().any(|known| known.rule.id == id) => Expected::REJECTED,
        Some(_) => Expected::either(want),
    }
}

/// True if parsing changed a number in the vector. Some integers below the smallest `int64` are parsed as floats and
/// rounded to exactly the smallest `int64`. Some testees read these floats as integers.
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
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn makes_cases_of_all_vectors() {
        let definitions = Definitions::built_in();
        let cases = cases(&definitions, &Types::new(&definitions.schema));
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
        assert!(find("decode-uorb/px4/BatteryStatus/connected-byte-153").expected.rejection);
        let case = find("encode-cdr/px4/BatteryStatus/voltage_v-nan");
        assert_eq!(case.request(0)["value"]["voltage_v"], json!({ "$f": "NaN" }));
        assert_eq!(find("severity/flockwave/ErrorCode/code-66").expected.ok, {
            ExpectedResponse::Exactly(json!({ "class": "warning", "severity": "warning" }))
        });
        let least = serde_json::from_str("[{\"x\": -9223372036854775809}]").expect("JSON");
        assert!(is_lossy(&least) && !is_lossy(&json!([i64::MIN, u64::MAX, 0.5])));
        let case = find("validate/px4/Event/timestamp-null");
        assert_eq!(
            (&case.request(0)["value"]["timestamp"], &case.expected),
            (&Value::Null, &Expected::REJECTED)
        );
    }
}
