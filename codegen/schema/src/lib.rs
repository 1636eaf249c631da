//! Reads definitions: `.msg`, `.srv` and `.action` files, and pages with tables. The result is one complete and checked
//! model, the [`Schema`], and a list of all mistakes ([`Diagnostic`]).
//!
//! ```text
//!  text ──msg, table──▶ syntax tree ──resolve──▶ Schema
//! ```
//!
//! Code that uses the model can't fail because of user input. Messages refer to each other by [`MessageId`], so this
//! code needs no look-up by name. Everything is sorted, so output doesn't depend on the order of the files.
//!
//! # Design decisions
//!
//! - Spans count bytes across all sources of a run. A span therefore takes only eight bytes, yet identifies its file.
//! - Annotations and literals are read by the parser, not by `resolve`. Values in the syntax tree are typed and in
//!   range, and each error is reported on its line.
//! - One sorted list contains the messages of all packages. Unselected messages stay in this list, but are not in the
//!   lists of the packages.
//! - `[@enum Message.PREFIX]` refers to constants of another message. For example, `battery_warning` of `FailsafeFlags`
//!   uses the constants of `BatteryStatus`, so its enum type belongs to `BatteryStatus`.
//! - If all constants of a flags field are powers of two, the constants are masks; otherwise, they are bit numbers. The
//!   model stores masks in both cases.
//! - ROS 2 rejects names that violate its naming style, so such a name is an error in a ROS 2 definition. PX4 accepts
//!   these names, so they only cause warnings in PX4 definitions. A literal that is valid only in PX4 or only in ROS 2
//!   also causes a warning.
//! - Types and messages on pages describe JSON only. The model of `.msg` files describes memory layout and CDR, so page
//!   types have a separate model ([`json_type`]).
//! - Translations ([`translation`]) are separate from the model, with permanent keys. Emitters look up translations by
//!   key, so emitters can detect text that has no translation.
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
mod date;
mod derived;
pub mod diagnostic;
pub mod difference;
pub mod directive;
pub mod documentation;
pub mod enumeration;
pub(crate) mod error_codes;
pub mod event;
pub mod example;
pub mod failure;
pub mod finding;
pub mod fingerprint;
pub mod graph;
mod id;
pub mod identity;
pub mod json_text;
pub mod json_type;
pub mod layout;
pub mod limits;
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

pub use self::date::Date;
pub use self::derived::derived_from;
pub use self::diagnostic::Diagnostic;
pub use self::documentation::Docs;
pub use self::enumeration::{Enum, EnumRef, Member};
pub use self::error_codes::{ErrorCode, ErrorTable};
pub use self::event::{Event, EventArgument, EventComponent, EventEntry, EventEnum, EventEnumRef, EventKind};
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
