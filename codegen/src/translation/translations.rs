//! Definitions in other languages.

use std::collections::{BTreeMap, BTreeSet};

/// The definitions in other languages.
///
/// ```
/// use uavspec_codegen::{PackageInput, SourceMap, msg::Dialect, read, schema::Form, translation};
///
/// let mut sources = SourceMap::default();
/// let id = sources.add("Wind.msg", "float32 speed  # [m/s] How fast it blows\n".into()).unwrap();
/// let (schema, _) = read(&sources, &[PackageInput::new("demo", Form::Msg(Dialect::Px4), vec![id])]);
/// let catalogue = r#"
/// msgid ""
/// msgstr ""
/// "Language: de\n"
/// "Content-Type: text/plain; charset=UTF-8\n"
///
/// msgctxt "demo/Wind.speed"
/// msgid "How fast it blows"
/// msgstr "Wie schnell er weht"
/// "#;
/// let id = sources.add("de.po", catalogue.into()).unwrap();
/// let (translations, diagnostics) = translation::resolve(&sources, &schema, &[id]);
/// assert!(diagnostics.is_empty());
/// let german = &translations.languages[0];
/// assert_eq!((german.tag.as_str(), german.name.as_str()), ("de", "Deutsch"));
/// assert_eq!(german.get("demo/Wind.speed"), Some("Wie schnell er weht"));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Translations {
    /// The languages, by tag. That of the definitions themselves is not among them.
    pub languages: Vec<Language>,
}

/// A language, and all that is translated into it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Language {
    /// Its tag, as BCP 47 writes it: `uk`, `pt-BR`.
    pub tag: String,
    /// What it calls itself: `Українська`.
    pub name: String,
    /// By key.
    pub(super) entries: BTreeMap<String, Translated>,
    /// Messages, services, actions and sets of error codes of which anything is translated.
    pub(super) units: BTreeSet<String>,
}

/// A text and its translation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Translated {
    pub(super) source: String,
    pub(super) translation: String,
}

impl Language {
    /// The translation of a text, by its key. Where there is none, or none that fits what the definition says
    /// today, the text itself is to be shown.
    pub fn get(&self, key: &str) -> Option<&str> {
        self.entries.get(key).map(|entry| entry.translation.as_str())
    }

    /// All translations that fit, by key: the key, what the definition says, and the translation.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &str, &str)> {
        self.entries
            .iter()
            .map(|(key, entry)| (key.as_str(), entry.source.as_str(), entry.translation.as_str()))
    }

    /// Whether anything of a message, service, action or set of error codes is translated; see `Text::unit`.
    pub fn covers(&self, unit: &str) -> bool {
        self.units.contains(unit)
    }
}
