//! The resolved model of all definitions, checked and complete.
//!
//! Code that uses the model can't fail because of user input. Messages refer to each other by [`MessageId`], so this
//! code needs no look-up by name. Everything is sorted, so output doesn't depend on the order of the files.
//!
//! ```
//! # use uavspec_codegen::{PackageInput, SourceMap, msg::Dialect, read, schema::Form};
//! # let mut sources = SourceMap::default();
//! # let id = sources.add("Wind.msg", "uint64 timestamp  # [us] Time\nfloat32 speed  # [m/s] [@range 0, 60] Speed\n".into()).unwrap();
//! # let packages = [PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])];
//! # let (schema, diagnostics) = read(&sources, &packages);
//! let message = &schema.messages[0];
//! assert_eq!((message.name.as_str(), message.topics[0].as_str()), ("Wind", "wind"));
//! assert_eq!(message.uorb.as_ref().map(|layout| layout.size), Some(16));
//! ```

pub(crate) mod bits;
mod derived;
pub(crate) mod documentation;
pub(crate) mod enumeration;
pub(crate) mod error_codes;
pub mod fingerprint;
mod id;
pub mod json_type;
pub(crate) mod layout;
mod model;
mod restriction;

pub use self::derived::derived_from;
pub use self::documentation::Docs;
pub use self::enumeration::{Enum, EnumRef, Member};
pub use self::error_codes::{ErrorCode, ErrorTable};
pub use self::id::MessageId;
pub use self::json_type::{JsonMessage, JsonMessageId, JsonType, JsonTypeId};
pub use self::model::{
    CdrSize, Constant, Element, Field, Form, Interface, Message, Package, Parameter, Schema, Slot, Type,
    UorbLayout, shape_text,
};
pub use self::restriction::Restriction;
pub(crate) use self::restriction::mentions_nan;
pub use crate::msg::ast::Shape;
pub use crate::msg::constraint::{Constraint, Range, Stated};
pub use crate::msg::{Dialect, Kind};
