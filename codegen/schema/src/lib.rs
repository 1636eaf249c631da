//! Reads definitions: the text of `.msg`, `.srv` and `.action` files and of pages with tables enters, and one checked and
//! complete model leaves, the [`Schema`], with a list of all mistakes ([`Diagnostic`]).
//!
//! ```text
//!  text ──msg, table──▶ syntax tree ──resolve──▶ Schema
//! ```
//!
//! Code that uses the model can't fail because of user input. Messages refer to each other by [`MessageId`], so this
//! code needs no look-up by name. Everything is sorted, so output doesn't depend on the order of the files.
//!
//! ```
//! # use uavspec_schema::{Form, PackageInput, SourceMap, msg::Dialect, read};
//! # let mut sources = SourceMap::default();
//! # let id = sources.add("Wind.msg", "uint64 timestamp  # [us] Time\nfloat32 speed  # [m/s] [@range 0, 60] Speed\n".into()).unwrap();
//! # let packages = [PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])];
//! # let (schema, diagnostics) = read(&sources, &packages);
//! let message = &schema.messages[0];
//! assert_eq!((message.name.as_str(), message.topics[0].as_str()), ("Wind", "wind"));
//! assert_eq!(message.uorb.as_ref().map(|layout| layout.size), Some(16));
//! ```

#![cfg_attr(not(test), warn(clippy::disallowed_macros, clippy::disallowed_methods))]

pub mod bits;
pub mod characters;
mod derived;
pub mod diagnostic;
pub mod difference;
pub mod directive;
pub mod documentation;
pub mod enumeration;
pub(crate) mod error_codes;
pub mod example;
pub mod failure;
pub mod finding;
pub mod fingerprint;
mod id;
pub mod identity;
pub mod json_text;
pub mod json_type;
pub mod layout;
mod model;
pub mod msg;
pub mod name;
pub mod parallel;
pub mod path;
pub mod pattern;
pub mod prose;
pub mod read;
pub mod render;
pub mod resolve;
mod restriction;
pub mod rewrite;
pub mod source;
pub mod span;
pub mod stage;
pub mod table;
pub mod terminal;
pub mod translation;
pub mod unit;
pub mod value;
pub mod wording;

pub use self::derived::derived_from;
pub use self::diagnostic::Diagnostic;
pub use self::documentation::Docs;
pub use self::enumeration::{Enum, EnumRef, Member};
pub use self::error_codes::{ErrorCode, ErrorTable};
pub use self::failure::Failure;
pub use self::id::MessageId;
pub use self::json_type::{JsonMessage, JsonMessageId, JsonType, JsonTypeId};
pub use self::model::{
    CdrSize, Constant, Element, Field, Form, Interface, Message, Package, Parameter, Schema, Slot, Type,
    UorbLayout, shape_text,
};
pub use self::read::{PackageInput, read, read_formats};
pub use self::restriction::{Restriction, mentions_nan};
pub use self::source::{SourceId, SourceMap};
pub use crate::msg::ast::Shape;
pub use crate::msg::constraint::{Constraint, Range, Stated};
pub use crate::msg::{Dialect, Kind};
