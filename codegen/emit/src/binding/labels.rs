//! Labels: the text of definitions in all languages, for user interfaces.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};

use uavspec_schema::translation::{
    MessageKeys, MessageText, SOURCE_LANGUAGE, Translations, is_right_to_left, language_name, texts,
};
use uavspec_schema::{EnumRef, MessageId, Package, Schema};

/// The texts of all languages, and the enums of fields.
pub(crate) struct Labels<'s> {
    /// The languages: first the language of the definitions, which is always complete, then the others, sorted by tag.
    pub(crate) languages: Vec<LabelLanguage<'s>>,
    /// For each enum used by a field, the values with their text keys. If several names share a value, only the first
    /// name is included.
    pub(crate) enumerations: Vec<Vec<(i128, String)>>,
    /// Indexes into `enumerations`, by field key.
    pub(crate) fields: BTreeMap<String, usize>,
}

/// A language with its texts.
pub(crate) struct LabelLanguage<'s> {
    pub(crate) tag: &'s str,
    pub(crate) name: &'s str,
    pub(crate) is_right_to_left: bool,
    /// Texts by key.
    pub(crate) texts: BTreeMap<String, &'s str>,
}

impl LabelLanguage<'_> {
    /// True for the language of the definitions, which is the fallback for missing text.
    pub(crate) fn is_source(&self) -> bool {
        self.tag == SOURCE_LANGUAGE
    }
}

/// Collects the labels of all languages. Returns no labels if there are no translations, because the modules already
/// contain the original text.
pub(crate) fn labels<'s>(schema: &'s Schema, translations: &'s Translations) -> Option<Labels<'s>> {
    if translations.languages.is_empty() {
        return None;
    }
    let source = texts(schema).into_iter().map(|text| (text.key, text.text));
    let mut languages = vec![language(SOURCE_LANGUAGE, language_name(SOURCE_LANGUAGE), source)];
    languages.extend(translations.languages.iter().map(|found| {
        let texts = found.iter().map(|(key, translation)| (key.to_owned(), translation));
        language(&found.tag, &found.name, texts)
    }));
    let mut labels = Labels { languages, enumerations: Vec::new(), fields: BTreeMap::new() };
    labels.add_enumerations(schema);
    Some(labels)
}

fn language<'s>(
    tag: &'s str,
    name: &'s str,
    texts: impl Iterator<Item = (String, &'s str)>,
) -> LabelLanguage<'s> {
    LabelLanguage { tag, name, is_right_to_left: is_right_to_left(tag), texts: texts.collect() }
}

impl Labels<'_> {
    fn add_enumerations(&mut self, schema: &Schema) {
        let mut known: BTreeMap<EnumRef, usize> = BTreeMap::new();
        for id in schema.packages.iter().flat_map(Package::all_messages) {
            self.add_fields(schema, id, &mut known);
        }
    }

    fn add_fields(&mut self, schema: &Schema, id: MessageId, known: &mut BTreeMap<EnumRef, usize>) {
        let message = schema.message(id);
        let keys = MessageKeys::new(schema, message);
        for (index, field) in message.fields.iter().enumerate() {
            let Some(reference) = field.enumeration else { continue };
            let number = match known.entry(reference) {
                Entry::Occupied(entry) => *entry.get(),
                Entry::Vacant(entry) => {
                    self.enumerations.push(members(schema, reference));
                    *entry.insert(self.enumerations.len() - 1)
                }
            };
            self.fields.insert(keys.key(MessageText::Field(index)), number);
        }
    }
}

fn members(schema: &Schema, reference: EnumRef) -> Vec<(i128, String)> {
    let owner = schema.message(reference.message);
    let keys = MessageKeys::new(schema, owner);
    let mut values = BTreeSet::new();
    let members = owner.enums[reference.index].members.iter().filter(|member| values.insert(member.value));
    members.map(|member| (member.value, keys.key(MessageText::Constant(member.constant)))).collect()
}
