//! Messages whose definitions are known only when the program runs, such as those that logs and bags
//! bring with them: the codecs and checks of generated types, driven by the model.
//!
//! ```
//! use uavspec_codegen::{PackageInput, SourceMap, dynamic::Types, msg::Dialect, read, schema::Form};
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
//! # Ok::<(), uavspec_codegen::dynamic::Error>(())
//! ```
//!
//! # How it works
//!
//! A message is one buffer. Its fields lie in it as in uORB, so a message of fixed size is its own memory
//! form, and a payload of uORB or `ULog` can be looked at where it is ([`DynamicView`]). Strings and
//! sequences have a slot of eight bytes there, which says where behind the fields their bytes or
//! elements start, and how many there are. For CDR, a type is a list of steps, mostly copies of
//! numbers that lie side by side in both forms.
//!
//! Nothing panics on any input, and no payload asks for more room than it has the right to: a message
//! takes at most eight times as many bytes as its CDR payload, or as the text of its JSON. (Eight is what
//! an array of messages with one `uint8` each comes to.) Payloads that are refused take no more than
//! that; JSON takes the fixed size of each message as soon as it begins. The vectors that hold all this
//! may have twice the room. Messages nest at most 32 deep.

mod bytes;
mod cdr;
mod codec;
mod compile;
mod error;
mod initial;
mod json;
pub mod members;
mod message;
mod packed;
mod plan;
mod step;
mod trail;
mod types;
mod ulog;
mod uorb;
mod validate;
mod view;
mod walk;

pub use self::bytes::sequence;
pub use self::error::{Defect, Error, Reason};
pub use self::message::DynamicMessage;
pub use self::types::{MessageType, Placed, PlacedElement, Types};
pub use self::ulog::{FormatError, FormatProblem, ULOG_PACKAGE};
pub use self::validate::Violation;
pub use self::view::{DynamicView, Elements, Value};
