//! Matches the entries of catalogues with the texts of the definitions.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::catalogue::{Catalogue, Entry, Places, parse};
use super::language::{self, SOURCE_LANGUAGE, is_tag};
use super::text::{Text, texts};
use super::translations::{Language, Translations};
use crate::Schema;
use crate::diagnostic::{Diagnostic, Problem, has_errors};
use crate::source::{SourceId, SourceMap, Span, stem};

/// Maximum number of missing translations named in a message. Further missing translations are only counted.
const MAX_NAMED: usize = 3;

/// Reads catalogues, which are named after their languages, and compares them with the definitions.
///
/// A catalogue may omit whole messages, services, actions and sets of error codes, which then stay in English. For an
/// omitted item, no translations are reported as missing.
pub fn resolve(
    sources: &SourceMap,
    schema: &Schema,
    catalogues: &[SourceId],
) -> (Translations, Vec<Diagnostic>) {
    let mut translations = Translations::default();
    let mut diagnostics = Vec::new();
    if catalogues.is_empty() {
        return (translations, diagnostics);
    }
    let texts = texts(schema);
    let by_key: HashMap<&str, &Text<'_>> = texts.iter().map(|text| (text.key.as_str(), text)).collect();
    let mut known = BTreeMap::new();
    for id in catalogues {
        let place = sources.span(*id).part(0..0);
        let stem = stem(sources.path(*id));
        let tag = if is_tag(stem) && stem != SOURCE_LANGUAGE { stem } else { "" };
        if tag.is_empty() {
            diagnostics.push(Diagnostic::new(Problem::CatalogueName { stem: stem.to_owned() }, place));
        } else if let Some(first) = known.insert(tag.to_ascii_lowercase(), place) {
            let problem = Problem::DuplicateCatalogue { tag: tag.to_owned() };
            diagnostics.push(Diagnostic::new(problem, place).with_related(first, "first catalogue"));
        }
        let (catalogue, places, mut found) = parse(sources, *id);
        check_header(sources, &catalogue, &places, tag, place, &mut found);
        let reader = Reader { by_key: &by_key, texts: &texts, catalogue: &catalogue, places: &places, tag };
        if !has_errors(&found) {
            translations.languages.push(reader.read(&mut found));
        }
        diagnostics.append(&mut found);
    }
    translations.languages.sort_by(|left, right| left.tag.cmp(&right.tag));
    (translations, diagnostics)
}

fn check_header(
    sources: &SourceMap,
    catalogue: &Catalogue,
    places: &[Places],
    tag: &str,
    start: Span,
    diagnostics: &mut Vec<Diagnostic>,
) {
    let Some(header) = catalogue.header() else {
        // If an entry is unreadable, it may be the header, so don't report a missing header.
        if diagnostics.is_empty() {
            diagnostics.push(Diagnostic::new(Problem::CatalogueHeader, start));
        }
        return;
    };
    let place = |name| line_of(sources, places[0].translation, name);
    let content = header.header_field("Content-Type").unwrap_or_default();
    let charset = content.split_once("charset=").map_or("", |(_, charset)| charset.trim());
    if !charset.eq_ignore_ascii_case("UTF-8") {
        let charset = if charset.is_empty() { "?" } else { charset };
        let problem = Problem::CatalogueEncoding { charset: charset.to_owned() };
        diagnostics.push(Diagnostic::new(problem, place("Content-Type")));
    }
    // gettext writes `sr_RS@latin` where BCP 47 writes `sr-Latn-RS`. Only the language part is compared.
    let found = header.header_field("Language").unwrap_or_default();
    let language =
        |text: &str| text.split(['_', '-', '@', '.']).next().unwrap_or_default().to_ascii_lowercase();
    if !found.is_empty() && !tag.is_empty() && language(found) != language(tag) {
        let problem = Problem::CatalogueLanguage { found: found.to_owned(), tag: tag.to_owned() };
        diagnostics.push(Diagnostic::new(problem, place("Language")));
    }
}

/// The location of a field in a catalogue's header, or of the whole header if the field is missing.
fn line_of(sources: &SourceMap, header: Span, name: &str) -> Span {
    let text = sources.slice(header);
    let Some(start) = text.find(&format!("{name}:")) else { return header };
    let end = text[start..].find(['\n', '\r', '\\', '"']).map_or(text.len(), |len| start + len);
    header.part(start..end)
}

struct Reader<'r, 's> {
    by_key: &'r HashMap<&'r str, &'r Text<'s>>,
    texts: &'r [Text<'s>],
    catalogue: &'r Catalogue,
    places: &'r [Places],
    tag: &'r str,
}

impl Reader<'_, '_> {
    fn read(&self, diagnostics: &mut Vec<Diagnostic>) -> Language {
        let header_name = self.catalogue.header().and_then(|header| header.header_field("X-Language-Name"));
        let name = header_name.filter(|name| !name.is_empty()).unwrap_or_else(|| language::name(self.tag));
        let mut language = Language {
            tag: self.tag.to_owned(),
            name: name.to_owned(),
            entries: BTreeMap::new(),
            units: BTreeSet::new(),
        };
        let mut known: HashMap<&str, usize> = HashMap::new();
        let entries = self.catalogue.entries.iter().enumerate();
        for (index, entry) in entries.filter(|(_, entry)| !entry.is_header() && !entry.is_obsolete) {
            let place = self.places[index];
            let key = entry.context.as_deref().unwrap_or_default();
            let Some(text) = self.by_key.get(key) else {
                diagnostics.push(unknown(key, place));
                continue;
            };
            if let Some(first) = known.get(key) {
                let problem = Problem::DuplicateTranslation { key: key.to_owned() };
                let first = self.places[*first].context;
                diagnostics.push(Diagnostic::new(problem, place.context).with_related(first, "first entry"));
                continue;
            }
            known.insert(key, index);
            if let Some(diagnostic) = problem(entry, place, text) {
                diagnostics.push(diagnostic);
            } else if entry.is_translated() {
                language.entries.insert(key.to_owned(), entry.translation.clone());
                language.units.insert(text.unit.clone());
            }
        }
        self.missing(&known, diagnostics);
        language
    }

    /// Reports the missing translations of each unit that has at least one entry.
    fn missing(&self, known: &HashMap<&str, usize>, diagnostics: &mut Vec<Diagnostic>) {
        for in_unit in self.texts.chunk_by(|left, right| left.unit == right.unit) {
            let entry = |text: &Text<'_>| known.get(text.key.as_str()).copied();
            let Some(first) = in_unit.iter().filter_map(entry).min() else { continue };
            let is_missing = |text: &&Text<'_>| {
                entry(text).is_none_or(|index| !self.catalogue.entries[index].is_translated())
            };
            let missing: Vec<&Text<'_>> = in_unit.iter().filter(is_missing).collect();
            if missing.is_empty() {
                continue;
            }
            let named = missing.iter().take(MAX_NAMED).map(|text| format!("`{}`", text.key));
            let more = missing.len().checked_sub(MAX_NAMED).filter(|more| *more > 0);
            let more = more.map(|more| format!(" and {more} more")).unwrap_or_default();
            let some = named.collect::<Vec<_>>().join(", ") + &more;
            let empty = missing.iter().filter_map(|text| entry(text)).min();
            let place = empty.map_or(self.places[first].context, |index| self.places[index].translation);
            let problem = Problem::TranslationMissing {
                tag: self.tag.to_owned(),
                unit: in_unit[0].unit.clone(),
                missing: missing.len(),
                all: in_unit.len(),
                some,
            };
            diagnostics.push(Diagnostic::new(problem, place).with_related(missing[0].span, "not translated"));
        }
    }
}

/// The reason why the translation of an entry is not used, if it has one.
fn problem(entry: &Entry, place: Places, text: &Text<'_>) -> Option<Diagnostic> {
    let key = text.key.clone();
    if entry.is_translated() && entry.id != text.text {
        let diagnostic = Diagnostic::new(Problem::TranslationStale { key }, place.id);
        return Some(diagnostic.with_related(text.span, "current text"));
    }
    let is_unusable = entry.is_translated() && entry.is_fuzzy();
    is_unusable.then(|| Diagnostic::new(Problem::TranslationFuzzy { key }, place.translation))
}

fn unknown(key: &str, place: Places) -> Diagnostic {
    let problem = |what: String| Diagnostic::new(Problem::UnknownTranslation { what }, place.context);
    if key.is_empty() {
        let hint = "add a `msgctxt` with the key of the translated text, such as `px4/Wind.speed`";
        return problem("an entry without `msgctxt`".to_owned()).with_hint(hint);
    }
    problem(format!("`{key}`"))
}
