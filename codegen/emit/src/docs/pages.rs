//! Assembly of all files.

use uavspec_schema::source::SourceMap;
use uavspec_schema::translation::{self, Translations};
use uavspec_schema::{Interface, Package, Schema};

use super::histories::Histories;
use super::options::Options;
use super::rules::Rules;
use super::site::Site;
use super::{book, error_codes, index, interface, json, message, picture};
use crate::file::OutputFile;

/// Creates the documentation of all listed definitions, in English and in all translations. Files are in the order of
/// the schema.
pub fn emit(
    schema: &Schema,
    translations: &Translations,
    sources: &SourceMap,
    options: &Options,
) -> Vec<OutputFile> {
    let histories = Histories::new(schema, &options.releases);
    let site = Site::new(schema, translations, sources, &options.siblings, &histories);
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
        let site =
            Site::in_language(schema, translations, sources, &options.siblings, &histories, Some(language));
        site.packages().for_each(|package| files.append(&mut translated(&site, package)));
    }
    files.extend(rules.iter().flat_map(Rules::pages));
    files
}

/// The pages of a package in the site language.
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
