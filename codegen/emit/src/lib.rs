//! Emitters turn a schema into files in memory, and never write to disk.
//!
//! # Design decisions
//!
//! - Generated JSON types accept any value with the right structure, and don't check ranges, lengths or patterns. A
//!   program can therefore receive an out-of-range value and report it.
//! - Generated types describe themselves to the runtime (`record!`), and all codecs, checks and strategies use this
//!   description. Derives would require more code to generate, read and compile.
//! - TypeScript and Python output includes the translated labels, so users who generate code from other definitions get
//!   labels too. Each language file contains only the text in that language; missing text falls back to English.
//! - TypeScript and Python are printed from one intermediate form (`binding`), so their names can't differ.
//! - The JSON and the verdict of a test vector come from the model, and the bytes come from [`uavspec_dynamic`]. The
//!   vector's id describes the case rather than the result, so the id is permanent.
//! - `tests/edge.rs` lists where uavspec deliberately deviates from incorrect behaviour of the reference tools, each
//!   with a reason. The test fails if one of these deviations disappears.
//!
//! ```
//! # use uavspec_schema::{Form, PackageInput, SourceMap, msg::Dialect, read};
//! # let mut sources = SourceMap::default();
//! # let id = sources.add("Wind.msg", "uint64 timestamp  # [us] Time\nfloat32 speed  # [m/s] [@range 0, 60] Speed\n".into()).unwrap();
//! # let packages = [PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])];
//! # let (schema, diagnostics) = read(&sources, &packages);
//! use uavspec_emit::json_schema;
//!
//! let files = json_schema::emit(&schema, &json_schema::Options::default());
//! let paths: Vec<&str> = files.iter().map(|file| file.path.as_str()).collect();
//! assert!(paths.contains(&"px4/Wind.schema.json"));
//! ```

#![cfg_attr(not(test), warn(clippy::disallowed_macros, clippy::disallowed_methods))]

mod binding;
pub mod docs;
pub mod emitter;
mod facts;
mod file;
pub mod identifier;
pub mod inspect;
pub mod json_schema;
mod origin;
pub mod python;
pub mod rust;
pub mod typescript;
pub mod vectors;

pub use self::emitter::{Emitter, Input, Others, Output, Table};
pub use self::file::{GENERATED_BY, OutputFile};

/// All emitters. Each row has a name, a short description, and the option keys with their meanings. The name is a key
/// of `output` in the configuration and a value of `--emit`.
pub const EMITTERS: &[Emitter] = &[
    Emitter::new::<rust::Options>("rust", "Rust modules"),
    Emitter::new::<json_schema::Options>("json_schema", "JSON Schemas"),
    Emitter::new::<vectors::Options>("vectors", "Test vectors in JSON"),
    Emitter::new::<docs::Configuration>("docs", "Markdown documentation for mdBook"),
    Emitter::new::<typescript::Options>(
        "typescript",
        "TypeScript modules, including `labels` if there are translations",
    ),
    Emitter::new::<python::Options>("python", "Python modules, including `labels` if there are translations"),
];

/// Returns the emitter with this name, or an error that lists the known names.
pub fn emitter(name: &str) -> Result<&'static Emitter, String> {
    EMITTERS.iter().find(|emitter| emitter.name == name).ok_or_else(|| {
        let names: Vec<String> = EMITTERS.iter().map(|emitter| format!("`{}`", emitter.name)).collect();
        format!("unknown field `{name}`, expected one of {}", names.join(", "))
    })
}
