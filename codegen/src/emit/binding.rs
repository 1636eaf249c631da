//! What TypeScript and Python have in common: declarations of the JSON that definitions describe.
//!
//! The model is lowered once to declarations with names and texts, and each language prints them. So the same things
//! bear the same names in both. Texts are plain here; whoever prints them escapes them.

mod declaration;
mod declare;
mod declarer;
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
pub(super) use self::labels::{LabelLanguage, Labels, labels};
pub(super) use self::names::{identifier, is_python_keyword};
