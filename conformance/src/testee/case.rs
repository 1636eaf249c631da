//! What testees are asked, and what they should say: the test vectors of the definitions, op by op.

use serde_json::{Map, Value, json};
use uavspec_codegen::dynamic::{MessageType, Types};
use uavspec_codegen::emit::vectors;

use super::protocol::{Format, Hello, Op};
use super::wire::{to_base64, to_wire};
use crate::definitions::Definitions;
use crate::rules::px4::{self, Px4Rule};

/// Rules that a payload breaks as a whole: no message comes of it, so decoding must fail. Of payloads that break
/// others, such as a `bool` of 153, codecs may make something, or refuse them.
static PAYLOAD_RULES: [&Px4Rule; 3] = [&px4::DATA_01, &px4::CDR_01, &px4::CDR_02];

/// A question, and its right answers.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// What is asked.
    pub op: Op,
    /// In which form; none where there are no bytes.
    pub format: Option<Format>,
    /// Of which type, such as `px4/Event`.
    pub type_name: String,
    /// Tells it from the others of its op, form and type.
    pub id: String,
    /// What is tried, in words.
    pub description: String,
    /// The rule that the input breaks.
    pub rule: Option<String>,
    /// What is sent.
    pub input: Input,
    /// What should come.
    pub expected: Expected,
}

/// What is sent.
#[derive(Clone, Debug, PartialEq)]
pub enum Input {
    /// The type says it all.
    Nothing,
    /// A payload.
    Bytes(Vec<u8>),
    /// JSON as it travels.
    Value(Value),
}

/// What should come.
#[derive(Clone, Debug, PartialEq)]
pub struct Expected {
    /// What may stand in `ok`.
    pub ok: ExpectedAnswer,
    /// Whether a rejection is right.
    pub rejection: bool,
}

/// What may stand in `ok`.
#[derive(Clone, Debug, PartialEq)]
pub enum ExpectedAnswer {
    /// Nothing: it must not come to that.
    Nothing,
    /// Anything.
    Anything,
    /// This message, as JSON without tags.
    Message(Value),
    /// One of these.
    Bytes(Vec<Vec<u8>>),
    /// This JSON.
    Exactly(Value),
}

impl Case {
    /// Its name: op, form, type and id, such as `decode-uorb/px4/Event/typical`.
    pub fn name(&self) -> String {
        format!("{}/{}/{}", self.action(), self.type_name, self.id)
    }

    /// Op and form, such as `decode-uorb`.
    pub fn action(&self) -> String {
        let format = self.format.map(|format| format!("-{}", format.name()));
        self.op.name().to_owned() + &format.unwrap_or_default()
    }

    /// The line that asks.
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

    /// Whether a testee said that it knows what this asks.
    pub(crate) fn is_for(&self, hello: &Hello) -> bool {
        hello.ops.contains(&self.op)
            && hello.types.contains(&self.type_name)
            && self.format.is_none_or(|format| hello.formats.contains(&format))
    }
}

impl Expected {
    const fn ok(want: ExpectedAnswer) -> Self {
        Self { ok: want, rejection: false }
    }

    const fn either(want: ExpectedAnswer) -> Self {
        Self { ok: want, rejection: true }
    }

    const REJECTED: Self = Self { ok: ExpectedAnswer::Nothing, rejection: true };
}

/// All cases of the definitions, type by type.
pub fn cases(definitions: &Definitions, types: &Types) -> Vec<Case> {
    let files = vectors::emit(&definitions.schema, &vectors::Options::default());
    let files = files.iter().filter(|file| file.path.ends_with(".vectors.json"));
    // The emitter writes JSON, and this says so once more: what can't be read has no cases.
    files
        .filter_map(|file| serde_json::from_str(&file.text).ok())
        .flat_map(|file| cases_in_file(&file, types))
        .collect()
}

fn cases_in_file(file: &Value, types: &Types) -> Vec<Case> {
    let Some(type_name) = file["type"].as_str() else { return Vec::new() };
    let message = type_name.split_once('/').and_then(|(package, name)| types.find(package, name));
    let maker = Maker { type_name, message };
    let mut cases = maker.facts(file);
    for vector in file["cases"].as_array().into_iter().flatten() {
        maker.vector(vector, &mut cases);
    }
    cases
}

/// Makes the cases of a type.
struct Maker<'f, 't> {
    type_name: &'f str,
    message: Option<MessageType<'t>>,
}

impl Maker<'_, '_> {
    /// What is asked of the type itself.
    fn facts(&self, file: &Value) -> Vec<Case> {
        let fact = |op: Op, format, value| {
            let head = json!({ "id": op.name(), "description": "of the type itself" });
            self.case(&head, op, Some(format), Input::Nothing, Expected::ok(ExpectedAnswer::Exactly(value)))
        };
        let mut cases = Vec::new();
        for (name, format) in [("hash", Format::Uorb), ("type_hash", Format::Cdr)] {
            cases.extend(file.get(name).map(|value| fact(Op::Hash, format, value.clone())));
        }
        // Those without PX4's hash don't lie in memory, whatever their size.
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

    fn vector(&self, vector: &Value, cases: &mut Vec<Case>) {
        let rule = vector["rule"].as_str();
        let is_held = Format::ALL.iter().any(|format| vector.get(format.name()).is_some());
        let json = vector.get("json").filter(|json| is_held || !is_blurred(json));
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
                // What no message can hold has no bytes; a format that a valid message doesn't have is not asked for.
                let expected =
                    expected.or_else(|| (rule.is_some() && self.has(format)).then_some(Expected::REJECTED));
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
                if rule.is_none() { Expected::ok(ExpectedAnswer::Anything) } else { Expected::REJECTED };
            cases.push(self.case(vector, Op::Validate, None, input.clone(), expected));
            if let Some(class) = vector.get("class") {
                let class = json!({ "class": class, "severity": vector["severity"] });
                cases.push(self.case(
                    vector,
                    Op::Severity,
                    None,
                    input,
                    Expected::ok(ExpectedAnswer::Exactly(class)),
                ));
            }
        }
    }

    fn has(&self, format: Format) -> bool {
        format == Format::Cdr || self.message.is_some_and(|message| message.size().is_some())
    }

    /// What encoding should give. The padding at the end may be left out in memory, as logs have it, and CDR may be
    /// filled up to a multiple of four bytes, as some writers do.
    fn encoded(&self, rule: Option<&str>, format: Format, bytes: &[u8]) -> Expected {
        let mut other = bytes.to_vec();
        match (format, self.message.and_then(MessageType::size)) {
            (Format::Uorb, Some(size)) => other.truncate(size.no_padding),
            (Format::Uorb, None) => {}
            (Format::Cdr, _) => other.resize(bytes.len().next_multiple_of(4), 0),
        }
        let mut right = vec![bytes.to_vec(), other];
        right.dedup();
        Expected { ok: ExpectedAnswer::Bytes(right), rejection: rule.is_some() }
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

/// What decoding should give.
fn decoded(rule: Option<&str>, wanted: Option<&Value>) -> Expected {
    let want = wanted.map_or(ExpectedAnswer::Anything, |value| ExpectedAnswer::Message(value.clone()));
    match rule {
        None => Expected::ok(want),
        Some(id) if PAYLOAD_RULES.iter().any(|known| known.rule.id == id) => Expected::REJECTED,
        Some(_) => Expected::either(want),
    }
}

/// Whether a number was lost when the vector was read: one below the least `int64` comes out as that, but as a
/// float, and it depends on the testee whether that is an integer.
#[allow(clippy::float_cmp, clippy::cast_precision_loss)] // it is exactly that
fn is_blurred(value: &Value) -> bool {
    match value {
        Value::Number(number) => number.is_f64() && number.as_f64() == Some(i64::MIN as f64),
        Value::Array(items) => items.iter().any(is_blurred),
        Value::Object(members) => members.values().any(is_blurred),
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
    fn all_vectors_become_cases() {
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
            ExpectedAnswer::Exactly(json!({ "class": "warning", "severity": "warning" }))
        });
        let least = serde_json::from_str("[{\"x\": -9223372036854775809}]").expect("JSON");
        assert!(is_blurred(&least) && !is_blurred(&json!([i64::MIN, u64::MAX, 0.5])));
        let case = find("validate/px4/Event/timestamp-null");
        assert_eq!(
            (&case.request(0)["value"]["timestamp"], &case.expected),
            (&Value::Null, &Expected::REJECTED)
        );
    }
}
