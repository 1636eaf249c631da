//! Emitters turn a schema into files in memory, and never write to disk.
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
    Emitter::new::<rust::Options>(
        "rust",
        "Rust modules",
        &[
            ("root", "name of the root file: `mod.rs`, or `lib.rs` for a whole crate"),
            ("readme", "a Markdown file to include in the documentation of the root module"),
        ],
    ),
    Emitter::new::<json_schema::Options>(
        "json_schema",
        "JSON Schemas",
        &[("base", "the URL prefix of every `$id`; default: `https://schemas.invalid/`")],
    ),
    Emitter::new::<vectors::Options>(
        "vectors",
        "Test vectors in JSON",
        &[("base", "the URL prefix of every `$id`; default: `output.json_schema.base`")],
    ),
    Emitter::new::<docs::Configuration>(
        "docs",
        "Markdown documentation for mdBook",
        &[
            ("title", "the title of the book"),
            ("rules", "`true` to include the pages about the lint and breaking-change rules"),
            ("contents", "one or more files whose links are added to the table of contents"),
        ],
    ),
    Emitter::new::<typescript::Options>(
        "typescript",
        "TypeScript modules, including `labels` if there are translations",
        &[("form", "`source`, or `compiled` for JavaScript with type declarations")],
    ),
    Emitter::new::<python::Options>(
        "python",
        "Python modules, including `labels` if there are translations",
        &[],
    ),
];

/// Returns the emitter with this name, or an error that lists the known names.
pub fn emitter(name: &str) -> Result<&'static Emitter, String> {
    EMITTERS.iter().find(|emitter| emitter.name == name).ok_or_else(|| {
        let names: Vec<String> = EMITTERS.iter().map(|emitter| format!("`{}`", emitter.name)).collect();
        format!("unknown field `{name}`, expected one of {}", names.join(", "))
    })
}
