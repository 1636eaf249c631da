//! Documentation: Markdown pages that an mdBook takes as they are and that read well on GitHub.
//!
//! ```text
//! README.md  SUMMARY.md  book.toml  book.css  composer.js  error-codes.js
//! <package>/README.md  <Message>.md  <Message>.svg  <Service>.srv.md  <Action>.action.md
//! <package>/error-codes.md  error-codes/<table>.md  types/<Type>.md  messages/<MESSAGE>.md
//! rules/README.md  reading.md  <rule>.md
//! ```
//!
//! What is translated into `uk` stands beside the English page: `<Message>.uk.md`, `error-codes.uk.md`.
//!
//! `site` knows where everything is described and what refers to it; a page is written from top to
//! bottom with the vocabulary of `markdown`. All text of definitions goes through `scope`, which makes
//! links of the names in it, or one of the escapes of `markdown`; both rely on `emit::prose`.

mod book;
mod commands;
mod composer;
mod constants;
mod enums;
mod error_codes;
mod fields;
mod index;
mod interface;
mod json;
mod language;
pub mod markdown;
mod message;
mod picture;
mod rules;
mod scope;
mod site;
#[cfg(test)]
mod tests;
mod words;

use self::rules::Rules;
use self::site::Site;
use super::{GENERATED_BY, OutputFile};
use crate::schema::{Interface, Package, Schema};
use crate::source::SourceMap;
use crate::translation::{self, Translations};

/// What the definitions don't say.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Options {
    /// Title of the book and of its first page.
    pub title: String,
    /// Whether the rules of uavspec itself are described, too.
    pub rules: bool,
    /// What stands at the end of the table of contents: a Markdown list of pages that others write.
    pub more_contents: String,
    /// The folders of what is generated beside the documentation, as seen from its own.
    pub beside: Beside,
}

/// Folders of other output, with `/` between the parts of their paths; none where there is no such output.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Beside {
    /// Of the JSON Schemas.
    pub schemas: Option<String>,
    /// Of the test vectors.
    pub vectors: Option<String>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            title: "Interface definitions".to_owned(),
            rules: false,
            more_contents: String::new(),
            beside: Beside::default(),
        }
    }
}

/// Describes all that `schema` lists, and beside that in each language what it is translated into. The order of the
/// files is that of the schema.
pub fn emit(
    schema: &Schema,
    translations: &Translations,
    sources: &SourceMap,
    options: &Options,
) -> Vec<OutputFile> {
    let site = Site::new(schema, translations, sources, &options.beside);
    let rules = options.rules.then(Rules::new);
    let mut files = vec![
        book::config(options),
        book::style(),
        book::summary(&site, rules.as_ref(), &options.more_contents),
        index::overview(&site, options),
    ];
    files.extend(book::scripts());
    for package in site.packages() {
        files.push(index::package(&site, package));
        for id in &package.messages {
            files.push(message::page(&site, *id));
            files.extend(picture::file(&site, *id));
        }
        files.extend(package.interfaces.iter().map(|interface| interface::page(&site, package, interface)));
        files.extend(error_codes::pages(&site, package));
        files.extend(json::Json::of(&site, package).pages());
    }
    for language in &translations.languages {
        let site = Site::in_language(schema, translations, sources, &options.beside, Some(language));
        site.packages().for_each(|package| files.append(&mut translated(&site, package)));
    }
    files.extend(rules.iter().flat_map(Rules::pages));
    files
}

/// The pages of a package in the language of the site.
fn translated(site: &Site<'_>, package: &Package) -> Vec<OutputFile> {
    let messages = package
        .messages
        .iter()
        .filter(|id| site.has_page(&translation::message_unit(site.schema, site.schema.message(**id))));
    let mut files: Vec<OutputFile> = messages.map(|id| message::page(site, *id)).collect();
    let has_page = |interface: &&Interface| site.has_page(&translation::interface_unit(package, interface));
    let interfaces = package.interfaces.iter().filter(has_page);
    files.extend(interfaces.map(|interface| interface::page(site, package, interface)));
    if site.has_page(&translation::error_codes_unit(package)) {
        files.extend(error_codes::pages(site, package));
    }
    files
}

/// The line that every file begins with, between the marks of its kind of comment.
fn notice() -> String {
    format!("{GENERATED_BY} from definitions. Do not edit: run `cargo xtask codegen`.")
}
