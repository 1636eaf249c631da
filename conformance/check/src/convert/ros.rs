//! The texts and the parameters of a log, as messages of ROS 2 (`rcl_interfaces`).

use std::borrow::Cow;
use std::sync::Arc;

use serde_json::{Value, json};
use uavspec_dynamic::event::DecodedEvent;
use uavspec_px4::event::RawEvent;
use uavspec_rules::definitions::{Definitions, Family, Library};
use uavspec_runtime::Number;
use uavspec_runtime::cdr::ByteOrder;
use uavspec_runtime::event::{LogLevel, Profile};
use uavspec_schema::MessageId;

use super::Error;
use super::information::{LogMessage, keyed};
use crate::decompressed;
use crate::limits::MAX_ROS_MESSAGE;
use crate::timeline::full_name;

/// The ids of the channels for texts and parameters, and the first id of the other channels.
pub(super) const TEXTS: u16 = 0;
pub(super) const PARAMETERS: u16 = 1;
pub(super) const FIRST_FREE: u16 = 2;

/// The node that sends the texts and the parameters, and the logger of its texts.
const NODE: &str = "px4";

/// The logger of events. A log contains them only on their topic.
const EVENTS: &str = "px4.event";

/// The logger of dropouts, and the function that marks them.
const LOGGER: &str = "px4.logger";
const DROPOUT: &str = "dropout";

/// The levels of ROS 2, each with the digit for logs.
const LEVELS: [(&str, u8); 5] =
    [("DEBUG", b'7'), ("INFO", b'6'), ("WARN", b'4'), ("ERROR", b'3'), ("FATAL", b'2')];

/// The type with the constants for the types of parameters.
const PARAMETER_TYPE: &str = "rcl_interfaces/msg/ParameterType";

/// A message type of ROS 2.
pub(super) struct RosType {
    id: MessageId,
    pub(super) name: &'static str,
    pub(super) text: String,
    pub(super) hash: String,
}

/// The message types of ROS 2 that the output contains.
pub(super) struct Ros {
    definitions: Arc<Definitions>,
    log: RosType,
    parameters: RosType,
}

/// The messages of a log that were restored from a message of ROS 2.
#[derive(Default)]
pub(super) struct Restored {
    /// Parameters at the start of the log.
    pub(super) initial: Vec<LogMessage>,
    /// Texts, dropouts and changed parameters.
    pub(super) later: Vec<LogMessage>,
    /// The parts that are left out.
    pub(super) left_out: Option<&'static str>,
}

/// A text for `/rosout`.
pub(super) struct Text<'t> {
    /// The level, as a constant of `rcl_interfaces/msg/Log`.
    level: &'static str,
    /// The logger.
    logger: Cow<'static, str>,
    message: Cow<'t, str>,
    /// The name of an event, or [`DROPOUT`].
    function: String,
    /// The duration of a dropout, in ms.
    line: u32,
}

/// A parameter.
pub(super) struct Parameter {
    name: String,
    value: Number,
}

impl Ros {
    /// The definitions of the newest release of ROS 2.
    pub(super) fn new() -> Result<Self, Error> {
        let definitions = Library::built_in().newest(Family::Ros2);
        let find = |name| -> Result<RosType, Error> {
            let id = definitions.message_of_type(name);
            let id = id.ok_or_else(|| Error::Input(format!("uavspec has no definition of {name}")))?;
            let hash = definitions.schema.message(id).type_hash.clone();
            Ok(RosType { id, name, text: definitions.bag_text(id), hash })
        };
        let (log, parameters) = (find("rcl_interfaces/msg/Log")?, find("rcl_interfaces/msg/ParameterEvent")?);
        Ok(Self { definitions, log, parameters })
    }

    /// The channels, with their types and topics.
    pub(super) fn channels(&self) -> [(u16, &RosType, &'static str); 2] {
        [(TEXTS, &self.log, "/rosout"), (PARAMETERS, &self.parameters, "/parameter_events")]
    }

    /// Encodes a text. Its stamp is 0.
    pub(super) fn text(
        &self,
        Text { level, logger, message, function, line }: &Text<'_>,
    ) -> Result<Vec<u8>, Error> {
        self.encode(
            &self.log,
            &json!({
                "stamp": {"sec": 0, "nanosec": 0},
                "level": self.constant(self.log.name, level),
                "name": logger,
                // Strings in CDR end with NUL.
                "msg": message.replace('\0', ""),
                "file": "",
                "function": function,
                "line": line,
            }),
        )
    }

    /// Encodes parameters. Their stamp is 0.
    pub(super) fn parameters(&self, parameters: &[Parameter], is_change: bool) -> Result<Vec<u8>, Error> {
        let values: Vec<Value> = parameters.iter().map(|parameter| self.parameter(parameter)).collect();
        let (new, changed) = if is_change { (Vec::new(), values) } else { (values, Vec::new()) };
        self.encode(
            &self.parameters,
            &json!({
                "stamp": {"sec": 0, "nanosec": 0},
                "node": format!("/{NODE}"),
                "new_parameters": new,
                "changed_parameters": changed,
                "deleted_parameters": [],
            }),
        )
    }

    fn parameter(&self, Parameter { name, value }: &Parameter) -> Value {
        let (kind, integer, double, text) = match value {
            Number::Int(value) => ("PARAMETER_INTEGER", *value, 0.0, String::new()),
            // JSON has no infinite numbers.
            Number::Float(value) if value.is_infinite() => ("PARAMETER_STRING", 0, 0.0, value.to_string()),
            Number::Float(value) => ("PARAMETER_DOUBLE", 0, *value, String::new()),
        };
        json!({
            "name": name,
            "value": {
                "type": self.constant(PARAMETER_TYPE, kind),
                "bool_value": false,
                "integer_value": integer,
                "double_value": double,
                "string_value": text,
                "byte_array_value": [],
                "bool_array_value": [],
                "integer_array_value": [],
                "double_array_value": [],
                "string_array_value": [],
            },
        })
    }

    /// The value of a constant.
    fn constant(&self, ty: &str, name: &str) -> i128 {
        let message = self.definitions.message_of_type(ty).map(|id| self.definitions.schema.message(id));
        let constants = message.into_iter().flat_map(|message| &message.constants);
        let number =
            constants.filter(|constant| constant.name == name).find_map(|found| found.value.number());
        match number {
            Some(Number::Int(value)) => value,
            _ => 0,
        }
    }

    /// Restores a text of a log. `utc_offset` is the difference between UTC and the vehicle's clock, in µs.
    pub(super) fn log_of_text(&self, payload: &[u8], utc_offset: i128) -> Result<Restored, String> {
        let text = self.decode(&self.log, payload)?;
        let number = |value: &Value| value.as_u64().unwrap_or(0);
        let logger = text["name"].as_str().unwrap_or_default();
        let Some(rest) = logger.strip_prefix(NODE).filter(|rest| rest.is_empty() || rest.starts_with('.'))
        else {
            return Ok(Restored { left_out: Some("texts of other nodes"), ..Restored::default() });
        };
        if logger == EVENTS {
            return Ok(Restored::default());
        }
        if logger == LOGGER && text["function"] == DROPOUT {
            let duration = u16::try_from(number(&text["line"])).unwrap_or(u16::MAX);
            let dropout = (b'O', duration.to_le_bytes().to_vec());
            return Ok(Restored { later: vec![dropout], ..Restored::default() });
        }
        let level = i128::from(number(&text["level"]));
        let reached = LEVELS.iter().rev().find(|(name, _)| level >= self.constant(self.log.name, name));
        let [seconds, nanoseconds] = ["sec", "nanosec"].map(|part| text["stamp"][part].as_i64().unwrap_or(0));
        let time = i128::from(seconds) * 1_000_000 + i128::from(nanoseconds) / 1_000 - utc_offset;
        let tag = rest.get(1..).and_then(|tag| tag.parse::<u16>().ok());
        let mut message = vec![reached.map_or(b'7', |(_, digit)| *digit)];
        message.extend(tag.into_iter().flat_map(u16::to_le_bytes));
        message.extend(u64::try_from(time).unwrap_or(0).to_le_bytes());
        message.extend_from_slice(text["msg"].as_str().unwrap_or_default().as_bytes());
        if message.len() > usize::from(u16::MAX) {
            return Err(format!("a text of a log has at most {} bytes", u16::MAX));
        }
        let kind = if tag.is_some() { b'C' } else { b'L' };
        Ok(Restored { later: vec![(kind, message)], ..Restored::default() })
    }

    /// Restores the parameters of a log.
    pub(super) fn log_of_parameters(&self, payload: &[u8]) -> Result<Restored, String> {
        let event = self.decode(&self.parameters, payload)?;
        if event["node"].as_str().is_none_or(|node| node.trim_start_matches('/') != NODE) {
            return Ok(Restored { left_out: Some("parameters of other nodes"), ..Restored::default() });
        }
        let kind = |name| self.constant(PARAMETER_TYPE, name);
        let [integer, double, text] = ["PARAMETER_INTEGER", "PARAMETER_DOUBLE", "PARAMETER_STRING"].map(kind);
        let message = |parameter: &Value| {
            let (name, value) = (parameter["name"].as_str()?, &parameter["value"]);
            let ty = i128::from(value["type"].as_u64()?);
            let payload = if ty == integer {
                keyed("int32_t", name, &i32::try_from(value["integer_value"].as_i64()?).ok()?.to_le_bytes())
            } else if ty == double {
                #[allow(clippy::cast_possible_truncation, reason = "PX4's parameters are 32-bit floats")]
                let value = value["double_value"].as_f64().unwrap_or(f64::NAN) as f32;
                keyed("float", name, &value.to_le_bytes())
            } else if ty == text {
                let value: f32 = value["string_value"].as_str()?.parse().ok()?;
                keyed("float", name, &value.to_le_bytes())
            } else {
                None
            };
            Some((b'P', payload?))
        };
        let mut left_out = None;
        let [initial, later, _] =
            ["new_parameters", "changed_parameters", "deleted_parameters"].map(|list| {
                let all = event[list].as_array().map_or(&[][..], Vec::as_slice);
                let is_kept = list != "deleted_parameters";
                let messages: Vec<LogMessage> = all.iter().filter(|_| is_kept).filter_map(message).collect();
                if messages.len() < all.len() {
                    left_out = Some("parameters that a log can't contain");
                }
                messages
            });
        Ok(Restored { initial, later, left_out })
    }

    fn decode(&self, ty: &RosType, payload: &[u8]) -> Result<Value, String> {
        let payload = decompressed(payload)?;
        if payload.len() > MAX_ROS_MESSAGE {
            return Err(format!("the message has more than {MAX_ROS_MESSAGE} bytes"));
        }
        let message = self.definitions.types().get(ty.id).decode_cdr(&payload);
        message.and_then(|message| message.to_json()).map_err(|error| error.to_string())
    }

    fn encode(&self, ty: &RosType, json: &Value) -> Result<Vec<u8>, Error> {
        let message = self.definitions.types().get(ty.id).from_json(json);
        let payload = message.and_then(|message| message.to_cdr(ByteOrder::LittleEndian));
        payload.map_err(|error| Error::Input(error.to_string()))
    }
}

impl Parameter {
    /// Reads a parameter. `None` if its type is unknown.
    pub(super) fn read(name: &str, ty: &str, value: &[u8]) -> Option<Self> {
        let bytes = value.try_into().ok()?;
        let value = match ty {
            "int32_t" => Number::Int(i32::from_le_bytes(bytes).into()),
            "float" => Number::Float(f32::from_le_bytes(bytes).into()),
            _ => return None,
        };
        Some(Self { name: name.replace('\0', ""), value })
    }
}

impl<'t> Text<'t> {
    /// A line of a log. The level is an ASCII digit.
    pub(super) fn of_log(level: u8, tag: Option<u16>, text: &'t str) -> Self {
        let level = LogLevel::ALL.get(usize::from(level.wrapping_sub(b'0'))).copied();
        let logger = tag.map_or(Cow::Borrowed(NODE), |tag| format!("{NODE}.{tag}").into());
        Self { level: severity(level), logger, message: text.into(), function: String::new(), line: 0 }
    }

    /// An event. `decoded` is `None` if its metadata is unknown.
    pub(super) fn of_event(event: &RawEvent, decoded: Option<&DecodedEvent<'_>>) -> Self {
        Self {
            level: severity(event.level()),
            logger: EVENTS.into(),
            message: decoded.map_or_else(|| event.undecoded(), |event| event.message(Profile::Normal)).into(),
            function: decoded.map(full_name).unwrap_or_default(),
            line: 0,
        }
    }

    /// A dropout.
    pub(super) fn of_dropout(milliseconds: u16) -> Self {
        let text = format!("dropout: {milliseconds} ms of messages are missing");
        Self {
            level: "WARN",
            logger: LOGGER.into(),
            message: text.into(),
            function: DROPOUT.to_owned(),
            line: milliseconds.into(),
        }
    }
}

/// The constant of `rcl_interfaces/msg/Log` for a level.
fn severity(level: Option<LogLevel>) -> &'static str {
    match level {
        Some(LogLevel::Emergency | LogLevel::Alert | LogLevel::Critical) => "FATAL",
        Some(LogLevel::Error) => "ERROR",
        Some(LogLevel::Warning) => "WARN",
        Some(LogLevel::Notice | LogLevel::Info) | None => "INFO",
        Some(LogLevel::Debug | LogLevel::Protocol | LogLevel::Disabled) => "DEBUG",
    }
}
