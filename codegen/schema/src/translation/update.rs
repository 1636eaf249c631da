//! Synchronization of catalogues with the definitions, without discarding the work of translators.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::catalogue::{Catalogue, Entry, FUZZY};
use super::language;
use super::text::Text;
use crate::source::SourceMap;

/// Creates a catalogue without entries. The header is reproducible, because it contains no dates and no names of
/// people.
pub fn new_catalogue(tag: &str) -> Catalogue {
    let fields = [
        ("Project-Id-Version", "definitions"),
        ("Language", &tag.replace('-', "_")),
        ("MIME-Version", "1.0"),
        ("Content-Type", "text/plain; charset=UTF-8"),
        ("Content-Transfer-Encoding", "8bit"),
        ("X-Language-Name", language::name(tag)),
    ];
    let translation = fields.iter().map(|(name, value)| format!("{name}: {value}\n")).collect();
    Catalogue { entries: vec![Entry { translation, ..Entry::default() }], end: Vec::new() }
}

/// Updates a catalogue. The result contains an entry for each text whose unit is in `select`, or whose unit already has
/// entries in the catalogue. The entries are in the order of `texts`.
///
/// Missing entries are added without a translation. If a text has changed, its entry is marked as fuzzy and keeps the
/// text that was translated. Entries whose text no longer exists become obsolete, and are restored if the text returns.
pub fn update(
    catalogue: &Catalogue,
    sources: &SourceMap,
    texts: &[Text<'_>],
    select: &BTreeSet<String>,
) -> Catalogue {
    let entries = &catalogue.entries;
    let mut updated = Catalogue { entries: Vec::new(), end: catalogue.end.clone() };
    let mut current: BTreeMap<&str, usize> = BTreeMap::new();
    let mut obsolete: BTreeMap<&str, usize> = BTreeMap::new();
    // Entries that are already in the result.
    let mut used: BTreeSet<usize> = BTreeSet::new();
    for (index, entry) in entries.iter().enumerate() {
        if entry.is_header() {
            updated.entries.push(entry.clone());
            used.insert(index);
        } else if let Some(key) = entry.context.as_deref() {
            // If several obsolete entries have the same key, the last one is the most recent.
            let known = if entry.is_obsolete { &mut obsolete } else { &mut current };
            known.insert(key, index);
        }
    }
    let has_entry = |text: &&Text<'_>| current.contains_key(text.key.as_str());
    let started: BTreeSet<&str> = texts.iter().filter(has_entry).map(|text| text.unit.as_str()).collect();
    let is_selected = |text: &&Text<'_>| started.contains(text.unit.as_str()) || select.contains(&text.unit);
    for text in texts.iter().filter(is_selected) {
        let existing = current.get(text.key.as_str()).copied();
        let old = obsolete.get(text.key.as_str()).copied();
        let old = old.filter(|_| existing.is_none_or(|index| !has_work(&entries[index])));
        used.extend(existing.into_iter().chain(old));
        let base = old.or(existing).map(|index| entries[index].clone()).unwrap_or_default();
        updated.entries.push(bring_up_to_date(base, text, sources));
    }
    let rest: Vec<&Entry> = entries
        .iter()
        .enumerate()
        .filter(|(index, _)| !used.contains(index))
        .map(|(_, entry)| entry)
        .collect();
    updated.entries.extend(rest.iter().filter(|entry| entry.is_obsolete).map(|entry| (*entry).clone()));
    let vanished = rest.into_iter().filter(|entry| !entry.is_obsolete && has_work(entry));
    updated.entries.extend(vanished.map(make_obsolete));
    updated
}

/// True if an entry contains a translator's work.
fn has_work(entry: &Entry) -> bool {
    entry.is_translated() || !entry.comments.is_empty()
}

fn bring_up_to_date(mut entry: Entry, text: &Text<'_>, sources: &SourceMap) -> Entry {
    entry.is_obsolete = false;
    entry.context = Some(text.key.clone());
    let path = sources.path(sources.source_of(text.span));
    // Omit an absolute path, which is specific to one machine.
    entry.references = if Path::new(path).is_relative() { vec![path.to_owned()] } else { Vec::new() };
    entry.notes = if text.note.is_empty() { Vec::new() } else { vec![text.note.clone()] };
    let is_changed = entry.id != text.text;
    let before = std::mem::replace(&mut entry.id, text.text.to_owned());
    if !entry.is_translated() {
        entry.flags.retain(|flag| flag != FUZZY);
        (entry.previous_context, entry.previous_id) = (None, None);
    } else if is_changed {
        // Keep the text that was translated, even if the definition has changed twice since then.
        if !entry.is_fuzzy() || entry.previous_id.is_none() {
            entry.previous_id = Some(before);
        }
        if !entry.is_fuzzy() {
            entry.flags.insert(0, FUZZY.to_owned());
        }
    }
    entry
}

fn make_obsolete(entry: &Entry) -> Entry {
    Entry { is_obsolete: true, notes: Vec::new(), references: Vec::new(), ..entry.clone() }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::msg::Dialect;
    use crate::source::SourceId;
    use crate::translation::catalogue::{parse, print};
    use crate::translation::{resolve, texts};
    use crate::{Form, PackageInput, Schema, read};

    const GLIDER: &str =
        "# State of a glider\n\nuint64 timestamp  # [us] Time\nfloat32 sink  # [m/s] Sink rate\n";

    fn definitions(text: &str) -> (SourceMap, Schema) {
        let mut sources = SourceMap::default();
        let id = sources.add("Glider.msg", text.as_bytes().to_vec()).expect("a text");
        let form = Form::Msg(Dialect::Px4);
        let (schema, diagnostics) = read(&sources, &[PackageInput::new("demo", form, vec![id])]);
        assert!(!crate::diagnostic::has_errors(&diagnostics), "{diagnostics:?}");
        (sources, schema)
    }

    fn all(texts: &[Text<'_>]) -> BTreeSet<String> {
        texts.iter().map(|text| text.unit.clone()).collect()
    }

    /// Updates a catalogue for the definition `text`.
    fn updated(catalogue: &Catalogue, text: &str) -> Catalogue {
        let (sources, schema) = definitions(text);
        let texts = texts(&schema);
        update(catalogue, &sources, &texts, &all(&texts))
    }

    fn entry<'c>(catalogue: &'c Catalogue, key: &str) -> &'c Entry {
        let mut found = catalogue.entries.iter().filter(|entry| entry.context.as_deref() == Some(key));
        let entry = found.next().unwrap_or_else(|| panic!("no {key}"));
        assert!(found.next().is_none(), "{key} is duplicated");
        entry
    }

    /// A catalogue that translates all texts of a definition.
    fn translated(text: &str) -> Catalogue {
        let mut catalogue = updated(&new_catalogue("uk"), text);
        for entry in catalogue.entries.iter_mut().filter(|entry| !entry.is_header()) {
            entry.translation = format!("«{}»", entry.id);
        }
        catalogue
    }

    #[test]
    fn creates_an_entry_for_each_text() {
        let catalogue = updated(&new_catalogue("uk"), GLIDER);
        let keys: Vec<&str> = catalogue.entries.iter().filter_map(|entry| entry.context.as_deref()).collect();
        assert_eq!(keys, ["demo/Glider", "demo/Glider.timestamp", "demo/Glider.sink"]);
        assert_eq!(entry(&catalogue, "demo/Glider.sink").references, ["Glider.msg"]);
        assert_eq!(updated(&catalogue, GLIDER), catalogue);
    }

    #[test]
    fn marks_changed_texts_as_fuzzy_and_keeps_the_translated_text() {
        let changed = updated(&translated(GLIDER), &GLIDER.replace("Sink rate", "Sinking"));
        let sink = entry(&changed, "demo/Glider.sink");
        assert!(sink.is_fuzzy());
        assert_eq!((sink.id.as_str(), sink.translation.as_str()), ("Sinking", "«Sink rate»"));
        assert_eq!(sink.previous_id.as_deref(), Some("Sink rate"));
        // After a second change, `previous_id` is still the translated text.
        let again = updated(&changed, &GLIDER.replace("Sink rate", "How fast it sinks"));
        assert_eq!(entry(&again, "demo/Glider.sink").previous_id.as_deref(), Some("Sink rate"));
        // An entry without a translation is replaced, and not marked as fuzzy.
        let untranslated = updated(&new_catalogue("uk"), GLIDER);
        let replaced = updated(&untranslated, &GLIDER.replace("Sink rate", "Sinking"));
        assert!(!entry(&replaced, "demo/Glider.sink").is_fuzzy());
    }

    #[test]
    fn restores_obsolete_entries_when_their_text_returns() {
        let before = translated(GLIDER);
        let without = GLIDER.replace("float32 sink  # [m/s] Sink rate\n", "");
        let gone = updated(&before, &without);
        assert!(entry(&gone, "demo/Glider.sink").is_obsolete);
        assert_eq!(updated(&gone, &without), gone);
        assert_eq!(updated(&gone, GLIDER), before);
        let reworded = updated(&gone, &GLIDER.replace("Sink rate", "Sinking"));
        let sink = entry(&reworded, "demo/Glider.sink");
        assert!(sink.is_fuzzy() && sink.previous_id.as_deref() == Some("Sink rate"));
    }

    #[test]
    fn adds_only_selected_units_and_units_with_entries() {
        let (sources, schema) = definitions(GLIDER);
        let texts = texts(&schema);
        let nothing = update(&new_catalogue("uk"), &sources, &texts, &BTreeSet::new());
        assert_eq!(nothing, new_catalogue("uk"));
        let mut started = nothing;
        started.entries.push(Entry { context: Some("demo/Glider.sink".to_owned()), ..Entry::default() });
        assert_eq!(update(&started, &sources, &texts, &BTreeSet::new()).entries.len(), 4);
    }

    /// Prints and parses a catalogue. Returns the problems other than fuzzy and missing translations.
    fn mistakes(catalogue: &Catalogue, text: &str) -> Vec<&'static str> {
        let (mut sources, schema) = definitions(text);
        let id: SourceId = sources.add("uk.po", print(catalogue).into_bytes()).expect("a text");
        assert_eq!(parse(&sources, id).0, *catalogue);
        let (_, diagnostics) = resolve(&sources, &schema, &[id]);
        let codes = diagnostics.iter().map(|diagnostic| diagnostic.problem.code());
        codes.filter(|code| !matches!(*code, "translation-fuzzy" | "translation-missing")).collect()
    }

    /// Successive versions of a definition, which add, remove and reword a few fields.
    fn states() -> impl Strategy<Value = Vec<String>> {
        let field = (0..4_usize, 0..3_usize);
        let fields = prop::collection::btree_map(0..4_usize, field, 0..4);
        let state = fields.prop_map(|fields| {
            fields.iter().map(|(name, (_, text))| format!("float32 f{name}  # [m] Text {text}\n")).collect()
        });
        prop::collection::vec(state, 1..6)
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn never_loses_translations(states in states()) {
            let mut catalogue = new_catalogue("uk");
            let mut work: BTreeSet<String> = BTreeSet::new();
            for (step, text) in states.iter().enumerate() {
                catalogue = updated(&catalogue, text);
                prop_assert_eq!(&updated(&catalogue, text), &catalogue, "a second run changes nothing");
                prop_assert_eq!(mistakes(&catalogue, text), Vec::<&str>::new());
                let translations: BTreeSet<String> = catalogue.entries.iter().map(|entry| entry.translation.clone()).collect();
                prop_assert!(work.is_subset(&translations), "{work:?} {translations:?}");
                for (index, entry) in catalogue.entries.iter_mut().enumerate() {
                    if entry.translation.is_empty() {
                        entry.translation = format!("{step}.{index}");
                        work.insert(entry.translation.clone());
                    }
                }
            }
        }
    }
}
