//! Documentation as Markdown pages, for mdBook and for GitHub.
//!
//! ```text
//! README.md  SUMMARY.md  book.toml  book.css  composer.js  error-codes.js
//! <package>/README.md  <Message>.md  <Message>.svg  <Service>.srv.md  <Action>.action.md
//! <package>/error-codes.md  error-codes/<table>.md  types/<Type>.md  messages/<MESSAGE>.md
//! rules/README.md  reading.md  <rule>.md
//! ```
//!
//! Translated pages are in the same folder as the English page: `<Message>.uk.md`, `error-codes.uk.md`.
//!
//! For each item, `site` stores the page that describes it and the items that refer to it. Pages are written from top
//! to bottom with the functions of `markdown`. All definition text passes through `scope`, which turns names into
//! links, or through an escape function of `markdown`. Both use `prose`.
//!
//! ```
//! # use uavspec_schema::{Form, PackageInput, SourceMap, msg::Dialect, read};
//! # let mut sources = SourceMap::default();
//! # let id = sources.add("Wind.msg", "uint64 timestamp  # [us] Time\nfloat32 speed  # [m/s] [@range 0, 60] Speed\n".into()).unwrap();
//! # let packages = [PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])];
//! # let (schema, diagnostics) = read(&sources, &packages);
//! use uavspec_emit::docs;
//! use uavspec_schema::translation::Translations;
//!
//! let files = docs::emit(&schema, &Translations::default(), &sources, &docs::Options::default());
//! let page = files.iter().find(|file| file.path == "px4/Wind.md").unwrap();
//! assert!(page.text.contains("# Wind"));
//! ```

mod book;
mod cell;
mod commands;
mod composer;
mod configuration;
mod constants;
mod enums;
mod error_codes;
mod events;
mod fields;
mod groups;
mod histories;
mod history;
mod index;
mod interface;
mod json;
mod language;
pub mod markdown;
mod message;
mod options;
mod pages;
pub mod picture;
mod rules;
mod scope;
mod site;
#[cfg(test)]
mod tests;
mod words;

pub(super) use self::configuration::Configuration;
pub use self::options::{Options, Siblings};
pub use self::pages::emit;
