//! Assembly of all files.

use uavspec_schema::source::SourceMap;
use uavspec_schema::translation::{self, Translations};
use uavspec_schema::{Interface, Package, Schema};

use super::histories::histories;
use super::options::Options;
use super::rules::Rules;
use super::site::Site;
use super::{book, error_codes, events, index, interface, json, message, picture};
use crate::file::OutputFile;

/// Creates the documentation of all listed definitions, in English and in all translations. Files are in the order of
/// the schema.
pub fn emit(
    schema: &Schema,
    translations: &Translations,
    sources: &SourceMap,
    options: &Options,
) -> Vec<OutputFile> {
    let histories = histories(schema, &options.releases);
    let site = |language| Site::new(schema, translations, sources, &options.siblings, &histories, language);
    let english = site(None);
    let rules = options.rules.then(Rules::new);
    let mut files = vec![
        book::config(options),
        book::style(),
        book::summary(&english, rules.as_ref(), &options.more_contents),
        index::overview(&english, options),
    ];
    files.extend(book::scripts());
    for package in english.packages() {
        files.push(index::package(&english, package));
        for id in &package.messages {
            files.push(message::page(&english, *id));
            files.extend(picture::file(&english, *id));
        }
        files
            .extend(package.interfaces.iter().map(|interface| interface::page(&english, package, interface)));
        files.extend(error_codes::pages(&english, package));
        files.extend(event_pages(&english, package));
        files.extend(json::Json::of(&english, package).pages());
    }
    for language in &translations.languages {
        let site = site(Some(language));
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
    files.extend(event_pages(site, package));
    files
}

/// The pages of all components that have pages in the site language.
fn event_pages(site: &Site<'_>, package: &Package) -> Vec<OutputFile> {
    let Some(index) = site.schema.packages.iter().position(|known| known.name == package.name) else {
        return Vec::new();
    };
    let components = package.components.iter().enumerate();
    let components =
        components.filter(|(_, component)| site.has_page(&translation::events_unit(package, component)));
    components.flat_map(|(component, _)| events::pages(site, index, package, component)).collect()
}
