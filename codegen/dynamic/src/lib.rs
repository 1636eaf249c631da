//! Messages whose definitions are known only at run time, such as the messages in logs and bags. The codecs and checks
//! behave like the codecs and checks of generated types, but are driven by the schema. The input is a schema and the
//! bytes or the JSON text of a message. The output is values, violations and other encodings. [`mod@breaking`] compares
//! two schemas, and [`conversion`] converts messages from one to the other.
//!
//! A conversion matches messages like a comparison, but copies a renamed field only if its comment is the same. A wrong
//! match causes a misleading finding in a comparison, but wrong data in a conversion.
//!
//! ```
//! use uavspec_schema::{Form, PackageInput, SourceMap, msg::Dialect, read};
//! use uavspec_dynamic::Types;
//! use uavspec_runtime::cdr::ByteOrder;
//!
//! let mut sources = SourceMap::default();
//! let text = "uint64 timestamp\nfloat32[2] speed  # [@range 0, 60] Over ground\n";
//! let id = sources.add("Wind.msg", text.into()).unwrap();
//! let (schema, _) = read(&sources, &[PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])]);
//!
//! let types = Types::new(&schema);
//! let wind = types.find("px4", "Wind").unwrap();
//! let message = wind.from_json_text(r#"{"timestamp": 7, "speed": [1.5, null]}"#)?;
//! let payload = message.to_cdr(ByteOrder::LittleEndian)?;
//! let message = wind.decode_cdr(&payload)?;
//! assert_eq!(message.get("speed[0]").unwrap().number().unwrap().to_string(), "1.5");
//! assert_eq!(message.validate()[0].to_string(), "speed[1]: NaN is not allowed here (PX-NAN-01)");
//! # Ok::<(), uavspec_dynamic::Error>(())
//! ```
//!
//! # How it works
//!
//! A message is one buffer. The fields are laid out as in uORB. A uORB or `ULog` payload of a fixed-size message is
//! therefore already in memory form, and can be read in place ([`DynamicView`]). A string or sequence has an eight-byte
//! slot among the fields. The bytes of the string or the elements of the sequence follow the fields, and the slot
//! contains their offset and count. A string that is not Unicode stays unchanged.
//!
//! No input causes a panic, and memory use is bounded. In memory, a message takes at most eight times as many bytes as
//! its CDR payload or JSON text. The worst case is an array of messages that contain one `uint8` each. The limit also
//! applies to rejected payloads. The JSON reader allocates the fixed-size part of each message when it reads the start
//! of the message. The capacity of the vectors may be up to twice the limit. Messages nest at most 32 levels deep.

#![cfg_attr(not(test), warn(clippy::disallowed_macros, clippy::disallowed_methods))]

pub mod breaking;
mod bytes;
mod cdr;
mod check;
mod codec;
mod compile;
pub mod conversion;
mod error;
pub mod event;
mod initial;
mod json;
pub mod limits;
pub mod members;
mod message;
mod plan;
mod text;
mod trail;
mod types;
mod ulog;
mod uorb;
mod validate;
mod view;
mod walk;

pub use self::bytes::sequence;
pub(crate) use self::bytes::{number_bytes, part};
pub use self::check::{Leaf, ValueType, Violation, number, whole};
pub use self::error::{Defect, Error, Reason};
pub use self::message::DynamicMessage;
pub use self::plan::Field;
pub(crate) use self::plan::SLOT;
pub(crate) use self::text::characters;
pub use self::types::{MessageType, Types};
pub use self::ulog::{FormatError, FormatProblem, ULOG_PACKAGE};
pub use self::validate::ViolationAt;
pub use self::view::{DynamicView, Elements, Value};
