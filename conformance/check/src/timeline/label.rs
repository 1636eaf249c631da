//! Labels: the texts of definitions in all languages.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;
use uavspec_codegen::load::read_definitions_translated;
use uavspec_dynamic::event::{DecodedEvent, Events};
use uavspec_px4::event::{EventMetadata, EventOrigin};
use uavspec_rules::definitions::Definitions;
use uavspec_runtime::event::Profile;
use uavspec_schema::prose::gist;
use uavspec_schema::translation::{
    Language, MessageKeys, MessageText, Translations, error_code_key, in_language,
};
use uavspec_schema::{ErrorTable, Failure, Message, MessageId, Schema};

/// The configuration file of definitions.
const CONFIGURATION: &str = "uavspec.toml";

/// The maximum length of a label, in characters.
const MAX_LABEL: usize = 120;

/// The first sentence of a text in the definitions, with its translations.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, schemars::JsonSchema)]
pub struct Label {
    /// The text in English.
    pub text: String,
    /// The translations, by language tag.
    pub translations: BTreeMap<String, String>,
}

/// The texts of definitions. If the definitions have no text for an item, the text of the built-in definitions for the
/// item with the same name is used.
pub struct Texts {
    translations: Translations,
    built_in: (Definitions, Translations),
    /// The built-in events in other languages, by tag.
    events: Vec<(String, Events)>,
}

/// An item of a message that has a label.
#[derive(Clone, Copy)]
pub enum Item<'n> {
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
    pub fn in_language(&self, tag: &str) -> &str {
        self.translations.get(tag).unwrap_or(&self.text)
    }
}

impl Texts {
    /// The texts of the definitions at a path, or of the built-in definitions.
    pub fn load(path: Option<&Path>) -> Result<Self, Failure> {
        // Only a configuration file names translation catalogues.
        let is_configured = |path: &&Path| {
            path.is_file() && path.extension().is_some_and(|extension| extension == "toml")
                || path.join(CONFIGURATION).is_file()
        };
        let Some(path) = path.filter(is_configured) else { return Ok(Self::of(Translations::default())) };
        read_definitions_translated(path).map(|(_, _, translations)| Self::of(translations))
    }

    /// The texts of definitions with these translations.
    pub fn of(translations: Translations) -> Self {
        let built_in = Definitions::built_in_translated();
        let events = Self::events(&built_in);
        Self { translations, built_in, events }
    }

    /// The built-in events in other languages.
    fn events((definitions, translations): &(Definitions, Translations)) -> Vec<(String, Events)> {
        let package = definitions.schema.packages.iter().find(|package| !package.components.is_empty());
        let translated = |language: &Language| {
            let components = package.map(|package| in_language(package, language)).unwrap_or_default();
            (language.tag.clone(), Events::new(components))
        };
        translations.languages.iter().map(translated).collect()
    }

    /// The definitions of error codes, modes and connections. If the given definitions lack them, as PX4 definitions
    /// do, returns the built-in definitions.
    pub(super) fn of_session<'t>(&'t self, definitions: &'t Definitions) -> &'t Definitions {
        if definitions.schema.json_types.is_empty() { &self.built_in.0 } else { definitions }
    }

    /// The languages other than English, each with its tag and its name.
    pub fn languages(&self) -> BTreeMap<String, String> {
        let all = self.all_languages();
        all.map(|language| (language.tag.clone(), language.name.clone())).collect()
    }

    fn all_languages(&self) -> impl Iterator<Item = &Language> {
        self.built_in.1.languages.iter().chain(&self.translations.languages)
    }

    /// The label of an item, if it has a text.
    pub fn label(&self, id: MessageId, item: Item<'_>, definitions: &Definitions) -> Option<Label> {
        let message = definitions.schema.message(id);
        let own = Found::of(&definitions.schema, message, item);
        let (definitions, translations) = &self.built_in;
        let same = message.topics.first().and_then(|topic| definitions.message_of_topic(topic));
        let built_in =
            same.and_then(|id| Found::of(&definitions.schema, definitions.schema.message(id), item));
        let text = own.as_ref().or(built_in.as_ref())?.text.clone();
        let mut translated = BTreeMap::new();
        for (found, translations) in [(&built_in, translations), (&own, &self.translations)] {
            if let Some(found) = found {
                found.translate(translations, &mut translated);
            }
        }
        Some(Label { text, translations: translated })
    }

    /// The label of a field's value in the built-in definitions. Releases of PX4 have renamed the prefixes of constants, so
    /// `name` is the name without the prefix.
    pub(super) fn built_in_value(&self, message: &Message, field: &str, name: &str) -> Option<Label> {
        let definitions = &self.built_in.0;
        let schema = &definitions.schema;
        let same = schema.message(definitions.message_of_topic(message.topics.first()?)?);
        let bound = same.fields.iter().find(|known| known.name == field)?.enumeration?;
        let member = schema.enumeration(bound).members.iter().find(|member| member.name == name)?;
        let constant = &schema.message(bound.message).constants[member.constant];
        self.label(bound.message, Item::Constant(&constant.name), definitions)
    }

    /// The label of an event: its message. The built-in messages are translated.
    pub(super) fn event(&self, event: &DecodedEvent<'_>, metadata: &EventMetadata) -> Option<Label> {
        let mut label = Label::plain(&event.message(Profile::Normal))?;
        if metadata.origin == EventOrigin::BuiltIn {
            for (tag, events) in &self.events {
                let translated = DecodedEvent::new(events, event.event.id, event.values.clone());
                let translated = translated.map(|event| event.message(Profile::Normal));
                label.translations.extend(translated.map(|text| (tag.clone(), text)));
            }
        }
        Some(label)
    }

    /// The label of an error code, if it is defined.
    pub(super) fn error_code(&self, code: u32, definitions: &Definitions) -> Option<Label> {
        let has_code = |table: &ErrorTable| table.codes.iter().any(|known| known.code == code);
        let mut packages = definitions.schema.packages.iter();
        let package = packages.find(|package| package.error_tables.iter().any(has_code))?;
        let mut codes = package.error_tables.iter().flat_map(|table| &table.codes);
        let text = short(&codes.find(|known| known.code == code)?.description);
        let found = Found { text, key: error_code_key(package, code) };
        let mut translations = BTreeMap::new();
        found.translate(&self.built_in.1, &mut translations);
        found.translate(&self.translations, &mut translations);
        Some(Label { text: found.text, translations })
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
