//! Answers by the codecs of `uavspec-codegen`.

use serde_json::{Value, json};
use uavspec_codegen::dynamic::{DynamicMessage, Error, MessageType, Types};
use uavspec_codegen::schema::{Message, Schema};
use uavspec_conformance::testee::wire::{from_base64, from_wire, to_base64, to_wire};
use uavspec_runtime::cdr::ByteOrder;
use uavspec_runtime::{ErrorClass, Severity};

/// The types of error codes.
const CODE: &str = "flockwave/ErrorCode";
const LIST: &str = "flockwave/ErrorList";

pub(crate) struct Codec<'s> {
    pub(crate) schema: &'s Schema,
    pub(crate) types: &'s Types,
}

impl Codec<'_> {
    pub(crate) fn hello(&self) -> Value {
        let messages = self.types.iter().map(|message| format!("{}/{}", message.package(), message.name()));
        let types: Vec<String> = messages.chain([CODE.to_owned(), LIST.to_owned()]).collect();
        let ops = ["decode", "encode", "roundtrip", "validate", "severity", "hash", "layout"];
        json!({ "op": "hello", "name": "reference", "version": env!("CARGO_PKG_VERSION"), "ops": ops, "types": types })
    }

    pub(crate) fn answer(&self, request: &Value) -> Value {
        let result = match request["type"].as_str() {
            Some(CODE) => Self::code(&request["value"], request["op"] == "severity"),
            Some(LIST) => self.list(&request["value"]),
            Some(name) => match self.find(name) {
                Some((message, of)) => answer(request, message, of),
                None => return json!({ "unsupported": true }),
            },
            None => return json!({ "error": "no type" }),
        };
        match result {
            Ok(value) => json!({ "ok": value }),
            Err(reason) => json!({ "rejected": reason }),
        }
    }

    fn find(&self, name: &str) -> Option<(&Message, MessageType<'_>)> {
        let (package, name) = name.split_once('/')?;
        let mut ids = self.schema.packages.iter().filter(|it| it.name == package).flat_map(|it| &it.messages);
        let id = ids.find(|id| self.schema.message(**id).name == name)?;
        Some((self.schema.message(*id), self.types.get(*id)))
    }

    fn code(value: &Value, is_asked: bool) -> Result<Value, String> {
        let code = value.as_u64().and_then(|code| u32::try_from(code).ok()).ok_or("no code")?;
        let class = || json!({ "class": ErrorClass::of(code).name(), "severity": Severity::of(code).name() });
        Ok(if is_asked { class() } else { Value::Null })
    }

    fn list(&self, value: &Value) -> Result<Value, String> {
        let items = value.as_array().ok_or("no list")?;
        let known = || self.schema.packages.iter().flat_map(|it| &it.error_tables).flat_map(|it| &it.codes);
        for item in items {
            Self::code(item, false)?;
            if *item == 0 {
                return Err("0 is no error".to_owned());
            }
            let alternatives = known().filter(|code| *item == code.code).flat_map(|code| &code.alternatives);
            if let Some(other) =
                alternatives.into_iter().find(|other| items.iter().any(|item| item == *other))
            {
                return Err(format!("{item} and {other} are alternatives"));
            }
        }
        Ok(Value::Null)
    }
}

fn answer(request: &Value, message: &Message, of: MessageType<'_>) -> Result<Value, String> {
    let said = |error: Error| error.to_string();
    let is_cdr = request["format"] == "cdr";
    let decode = || -> Result<DynamicMessage<'_>, String> {
        let bytes = request["bytes"].as_str().and_then(from_base64).ok_or("no base64")?;
        if is_cdr { of.decode_cdr_strict(&bytes) } else { of.decode_uorb_strict(&bytes) }.map_err(said)
    };
    let encode = |message: &DynamicMessage<'_>| -> Result<Value, String> {
        let bytes = if is_cdr { message.to_cdr(ByteOrder::LittleEndian) } else { message.to_uorb() };
        bytes.map(|bytes| to_base64(&bytes).into()).map_err(said)
    };
    let read = || of.from_json(&from_wire(&request["value"])).map_err(said);
    match request["op"].as_str() {
        Some("decode") => Ok(to_wire(&decode()?.to_json().map_err(said)?, Some(of))),
        Some("encode") => encode(&read()?),
        Some("roundtrip") => encode(&decode()?),
        Some("validate") => match read()?.validate().first() {
            None => Ok(Value::Null),
            Some(violation) => Err(violation.to_string()),
        },
        Some("hash") if is_cdr => Ok(message.type_hash.clone().into()),
        Some("hash") => Ok(message.hash.into()),
        Some("layout") => {
            let size = of.size().ok_or("its size varies")?;
            let offsets = of.layout().map(|field| (field.name.to_owned(), field.offset.into()));
            let offsets: serde_json::Map<String, Value> = offsets.collect();
            Ok(json!({ "size": size.padded, "size_no_padding": size.no_padding, "offsets": offsets }))
        }
        _ => Err("no such op".to_owned()),
    }
}
