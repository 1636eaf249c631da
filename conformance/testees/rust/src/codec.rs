//! Processes requests with the codecs of `uavspec-codegen`.

use serde_json::{Value, json};
use uavspec_dynamic::event::{EventError, EventValue, Events};
use uavspec_dynamic::{DynamicMessage, Error, MessageType, Types};
use uavspec_flockwave::body_schema::DefinedSchemas;
use uavspec_model::json::Tree;
use uavspec_probe::testee::{PROTOCOL, from_base64, from_wire, to_base64, to_wire};
use uavspec_runtime::cdr::ByteOrder;
use uavspec_runtime::event::Profile;
use uavspec_runtime::{ErrorClass, Severity};
use uavspec_schema::{EventComponent, Message, Package, Schema};

/// The type of error codes.
const CODE: &str = "flockwave/ErrorCode";
const LIST: &str = "flockwave/ErrorList";

/// The reason why a request has no result.
enum CodecError {
    /// The input is invalid.
    Input(String),
    /// The request itself is invalid.
    Request(&'static str),
    /// The type, op or format isn't supported.
    Unknown,
}

/// A codec for all types of the definitions.
pub(crate) struct Codec<'s> {
    /// The definitions.
    pub(crate) schema: &'s Schema,
    /// The message types.
    pub(crate) types: &'s Types,
    /// The schemas of JSON types.
    pub(crate) body_schemas: &'s DefinedSchemas,
    /// The events of each component, such as `px4_events/px4`.
    pub(crate) events: Vec<(String, Events)>,
}

/// Collects the events of each component.
pub(crate) fn events(schema: &Schema) -> Vec<(String, Events)> {
    let of_package = |package: &Package| {
        let name = |component: &EventComponent| format!("{}/{}", package.name, component.namespace);
        let events = |component| (name(component), Events::new(package.components.as_slice()));
        package.components.iter().map(events).collect::<Vec<_>>()
    };
    schema.packages.iter().flat_map(of_package).collect()
}

impl Codec<'_> {
    fn hello(&self) -> Value {
        let messages = self.types.iter().map(|message| format!("{}/{}", message.package(), message.name()));
        let types: Vec<String> = messages
            .chain([CODE.to_owned(), LIST.to_owned()])
            .chain(self.body_schemas.names().map(str::to_owned))
            .chain(self.events.iter().map(|(name, _)| name.clone()))
            .collect();
        let ops = ["decode", "encode", "roundtrip", "validate", "severity", "hash", "layout", "decode-event"];
        json!({
            "op": "hello", "protocol": PROTOCOL, "name": "reference", "version": env!("CARGO_PKG_VERSION"),
            "ops": ops, "types": types, "formats": ["uorb", "cdr"],
        })
    }

    /// Returns the response to a request. A line without an id gets no response.
    pub(crate) fn reply(&self, request: &Value) -> Option<Value> {
        if request["op"] == "hello" {
            return Some(self.hello());
        }
        let id = request.get("id")?.clone();
        let mut answer = self.answer(request).unwrap_or_else(|wrong| match wrong {
            CodecError::Input(reason) => json!({ "rejected": reason }),
            CodecError::Request(what) => json!({ "error": what }),
            CodecError::Unknown => json!({ "unsupported": true }),
        });
        answer["id"] = id;
        Some(answer)
    }

    fn answer(&self, request: &Value) -> Result<Value, CodecError> {
        let name = request["type"].as_str().ok_or(CodecError::Request("type is missing"))?;
        let op = request["op"].as_str().ok_or(CodecError::Request("op is missing"))?;
        let ok = match (name, op) {
            (CODE, "validate") => Self::code(value_of(request)?).map(|_| Value::Null)?,
            (CODE, "severity") => {
                let code = Self::code(value_of(request)?)?;
                json!({ "class": ErrorClass::of(code).name(), "severity": Severity::of(code).name() })
            }
            (_, "validate") if self.body_schemas.has_schema(name) => {
                self.check_body(name, value_of(request)?)?
            }
            (LIST, "validate") => self.list(value_of(request)?).map(|()| Value::Null)?,
            (_, "decode-event") => {
                let events = self.events.iter().find(|(of, _)| of == name);
                decode_event(&events.ok_or(CodecError::Unknown)?.1, request)?
            }
            _ => {
                let (message, of) = self.find(name).ok_or(CodecError::Unknown)?;
                answer(op, request, message, of)?
            }
        };
        Ok(json!({ "ok": ok }))
    }

    fn find(&self, name: &str) -> Option<(&Message, MessageType<'_>)> {
        let (package, name) = name.split_once('/')?;
        let mut ids = self.schema.packages.iter().filter(|it| it.name == package).flat_map(|it| &it.messages);
        let id = ids.find(|id| self.schema.message(**id).name == name)?;
        Some((self.schema.message(*id), self.types.get(*id)))
    }

    /// Checks a value against the schema with this name.
    fn check_body(&self, name: &str, value: &Value) -> Result<Value, CodecError> {
        let text = from_wire(value).to_string();
        let tree = Tree::read(&text).map_err(|error| CodecError::Input(error.to_string()))?;
        match self.body_schemas.mismatch(name, &tree).flatten() {
            None => Ok(Value::Null),
            Some(found) => Err(CodecError::Input(format!(
                "{}: expected {}, found {}",
                found.path, found.expected, found.actual
            ))),
        }
    }

    fn code(value: &Value) -> Result<u32, CodecError> {
        let code = value.as_u64().and_then(|code| u32::try_from(code).ok());
        code.ok_or_else(|| CodecError::Input("not an error code".to_owned()))
    }

    fn list(&self, value: &Value) -> Result<(), CodecError> {
        let items = value.as_array().ok_or_else(|| CodecError::Input("not a list".to_owned()))?;
        let known = || self.schema.packages.iter().flat_map(|it| &it.error_tables).flat_map(|it| &it.codes);
        for item in items {
            if Self::code(item)? == 0 {
                return Err(CodecError::Input("error code 0 means no error".to_owned()));
            }
            let alternatives = known().filter(|code| *item == code.code).flat_map(|code| &code.alternatives);
            if let Some(other) =
                alternatives.into_iter().find(|other| items.iter().any(|item| item == *other))
            {
                return Err(CodecError::Input(format!("{item} and {other} are mutually exclusive")));
            }
        }
        Ok(())
    }
}

fn answer(
    op: &str,
    request: &Value,
    message: &Message,
    message_type: MessageType<'_>,
) -> Result<Value, CodecError> {
    let invalid = |error: Error| CodecError::Input(error.to_string());
    let is_cdr = || match request["format"].as_str() {
        Some("cdr") => Ok(true),
        Some("uorb") => Ok(false),
        Some(_) => Err(CodecError::Unknown),
        None => Err(CodecError::Request("format is missing")),
    };
    let decode = || -> Result<DynamicMessage<'_>, CodecError> {
        let bytes = bytes_of(request)?;
        if is_cdr()? {
            message_type.decode_cdr_strict(&bytes)
        } else {
            message_type.decode_uorb_strict(&bytes)
        }
        .map_err(invalid)
    };
    let encode = |message: &DynamicMessage<'_>| -> Result<Value, CodecError> {
        let bytes = if is_cdr()? { message.to_cdr(ByteOrder::LittleEndian) } else { message.to_uorb() };
        bytes.map(|bytes| to_base64(&bytes).into()).map_err(invalid)
    };
    let read = || message_type.from_json(&from_wire(value_of(request)?)).map_err(invalid);
    match op {
        "decode" => Ok(to_wire(&decode()?.to_json().map_err(invalid)?, Some(message_type))),
        "encode" => encode(&read()?),
        "roundtrip" => encode(&decode()?),
        "validate" => match read()?.validate().first() {
            None => Ok(Value::Null),
            Some(violation) => Err(CodecError::Input(violation.to_string())),
        },
        "hash" if is_cdr()? => Ok(message.type_hash.clone().into()),
        "hash" => Ok(message.hash.into()),
        "layout" if is_cdr()? => Err(CodecError::Unknown),
        "layout" => {
            let size = message_type.size().ok_or_else(|| CodecError::Input("the size varies".to_owned()))?;
            let offsets =
                message_type.fields().iter().map(|field| (field.name.to_string(), field.offset.into()));
            let offsets: serde_json::Map<String, Value> = offsets.collect();
            Ok(json!({ "size": size.padded, "size_no_padding": size.no_padding, "offsets": offsets }))
        }
        _ => Err(CodecError::Unknown),
    }
}

fn decode_event(events: &Events, request: &Value) -> Result<Value, CodecError> {
    let id = request["event"].as_u64().and_then(|id| u32::try_from(id).ok());
    let id = id.ok_or(CodecError::Request("event is missing"))?;
    let bytes = bytes_of(request)?;
    let profile = Profile::ALL.into_iter().find(|profile| request["profile"] == profile.name());
    let profile = profile.ok_or(CodecError::Unknown)?;
    let event =
        events.decode(id, &bytes).map_err(|error: EventError| CodecError::Input(error.to_string()))?;
    let value = |value: &EventValue| match value {
        EventValue::Integer(value) => serde_json::Number::from_i128(*value).map(Value::Number),
        EventValue::Float(value) => Some((*value).into()),
    };
    let arguments = event.event.arguments.iter().zip(&event.values);
    let arguments: serde_json::Map<String, Value> = arguments
        .map(|(argument, found)| (argument.name.clone(), value(found).unwrap_or_default()))
        .collect();
    let decoded = json!({
        "id": id, "name": event.event.name, "arguments": arguments,
        "message": event.message(profile), "description": event.description(profile),
    });
    Ok(to_wire(&decoded, None))
}

fn bytes_of(request: &Value) -> Result<Vec<u8>, CodecError> {
    let bytes = request["bytes"].as_str().and_then(from_base64);
    bytes.ok_or(CodecError::Request("bytes is not base64"))
}

fn value_of(request: &Value) -> Result<&Value, CodecError> {
    request.get("value").ok_or(CodecError::Request("value is missing"))
}
