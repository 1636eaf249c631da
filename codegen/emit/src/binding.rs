//! Declarations of the JSON types, shared by the TypeScript and Python emitters.
//!
//! The schema is lowered once to named declarations with documentation. Each language prints these declarations, so
//! names are the same in both languages. All text is plain; the printers escape it.

mod declaration;
mod declare;
mod declarer;
mod event;
mod json_type;
mod labels;
mod message;
mod names;
mod text;

pub(super) use self::declaration::{
    Declaration, ERROR_CODE, ERROR_CODE_INFO, Kind, KnownCode, Module, Named, Property, SEVERITY, Type,
    float, quoted,
};
pub(super) use self::declare::modules;
pub(super) use self::event::{KnownEnum, KnownEvent, KnownEvents};
pub(super) use self::labels::{LabelLanguage, Labels, labels};
pub(super) use self::names::{identifier, is_python_keyword};
