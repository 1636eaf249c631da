//! Labels: the texts of definitions in all languages.

use std::collections::BTreeMap;

use serde::Serialize;
use uavspec_codegen::internal::gist;
use uavspec_codegen::schema::{Message, MessageId, Schema};
use uavspec_codegen::translation::{Language, MessageKeys, MessageText, Translations, error_code_key};

use crate::definitions::Definitions;

/// The maximum length of a label, in characters.
const MAX_LABEL: usize = 120;

/// The first sentence of a text in the definitions, with its translations.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct Label {
    /// The text in English.
    pub text: String,
    /// The translations, by language tag.
    pub translations: BTreeMap<String, String>,
}

/// The texts of definitions. If the definitions have no text for an item, the text of the built-in definitions for the
/// item with the same name is used.
pub(crate) struct Texts {
    translations: Translations,
    built_in: Option<(Definitions, Translations)>,
}

/// An item of a message that has a label.
#[derive(Clone, Copy)]
pub(crate) enum Item<'n> {
    /// A field.
    Field(&'n str),
    /// The heading of a field's group.
    Group(&'n str),
    /// A constant.
    Constant(&'n str),
}

impl Label {
    /// A label without translations.
    pub(super) fn plain(text: &str) -> Option<Self> {
        let text = short(text);
        (!text.is_empty()).then(|| Self { text, translations: BTreeMap::new() })
    }

    /// The text in a language, or in English.
    pub(crate) fn in_language(&self, tag: &str) -> &str {
        self.translations.get(tag).unwrap_or(&self.text)
    }
}

impl Texts {
    /// The texts of the built-in definitions.
    pub(crate) const fn built_in(translations: Translations) -> Self {
        Self { translations, built_in: None }
    }

    /// The texts of other definitions.
    pub(crate) fn of(translations: Translations) -> Self {
        Self { translations, built_in: Some(Definitions::built_in_translated()) }
    }

    /// The languages other than English, each with its tag and its name.
    pub(crate) fn languages(&self) -> BTreeMap<String, String> {
        let all = self.all_languages();
        all.map(|language| (language.tag.clone(), language.name.clone())).collect()
    }

    fn all_languages(&self) -> impl Iterator<Item = &Language> {
        let built_in = self.built_in.iter().flat_map(|(_, translations)| &translations.languages);
        built_in.chain(&self.translations.languages)
    }

    /// The label of an item, if it has a text.
    pub(super) fn label(&self, id: MessageId, item: Item<'_>, definitions: &Definitions) -> Option<Label> {
        let message = definitions.schema.message(id);
        let own = Found::of(&definitions.schema, message, item);
        let built_in = self.built_in.as_ref().and_then(|(definitions, translations)| {
            let id = definitions.message_of_topic(message.topics.first()?)?;
            let found = Found::of(&definitions.schema, definitions.schema.message(id), item)?;
            Some((found, translations))
        });
        let text = own.as_ref().or(built_in.as_ref().map(|(found, _)| found))?.text.clone();
        let mut translated = BTreeMap::new();
        if let Some((found, translations)) = &built_in {
            found.translate(translations, &mut translated);
        }
        if let Some(found) = &own {
            found.translate(&self.translations, &mut translated);
        }
        Some(Label { text, translations: translated })
    }

    /// The label of an error code, if it is defined.
    pub(super) fn error_code(&self, code: u32, definitions: &Definitions) -> Option<Label> {
        let package = definitions.schema.packages.iter().find(|package| {
            package.error_tables.iter().any(|table| table.codes.iter().any(|known| known.code == code))
        })?;
        let mut codes = package.error_tables.iter().flat_map(|table| &table.codes);
        let text = short(&codes.find(|known| known.code == code)?.description);
        let key = error_code_key(package, code);
        let mut translations = BTreeMap::new();
        Found { text: text.clone(), key }.translate(&self.translations, &mut translations);
        Some(Label { text, translations })
    }
}

/// A text with its key.
struct Found {
    text: String,
    key: String,
}

impl Found {
    /// The text of an item, unless it is empty.
    fn of(schema: &Schema, message: &Message, item: Item<'_>) -> Option<Self> {
        let field = |name| message.fields.iter().position(|field| field.name == name);
        let text = match item {
            Item::Field(name) => MessageText::Field(field(name)?),
            Item::Group(name) => MessageText::Group(message.fields[field(name)?].group?),
            Item::Constant(name) => {
                MessageText::Constant(message.constants.iter().position(|constant| constant.name == name)?)
            }
        };
        let key = MessageKeys::new(schema, message).key(text);
        let text = short(text.of(message));
        (!text.is_empty()).then_some(Self { text, key })
    }

    fn translate(&self, translations: &Translations, to: &mut BTreeMap<String, String>) {
        for language in &translations.languages {
            if let Some(text) = language.get(&self.key) {
                to.insert(language.tag.clone(), short(text));
            }
        }
    }
}

/// The first sentence of a text, without its full stop.
fn short(text: &str) -> String {
    gist(text, MAX_LABEL).trim_end_matches('.').to_owned()
}
