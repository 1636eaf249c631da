//! Resolved translations.

use std::collections::{BTreeMap, BTreeSet};

/// Translations of the definitions.
///
/// ```
/// use uavspec_schema::{Form, PackageInput, SourceMap, msg::Dialect, read, translation};
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
    /// Languages sorted by tag, without the language of the definitions.
    pub languages: Vec<Language>,
}

/// The translations into one language.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Language {
    /// BCP 47 tag: `uk`, `pt-BR`.
    pub tag: String,
    /// Native name: `Українська`.
    pub name: String,
    /// Translated texts by key.
    pub(super) entries: BTreeMap<String, String>,
    /// Units with at least one translated text.
    pub(super) units: BTreeSet<String>,
}

impl Language {
    /// The translation of the text with this key. `None` means that the original text should be shown, because it has
    /// no translation or has changed since it was translated.
    pub fn get(&self, key: &str) -> Option<&str> {
        self.entries.get(key).map(String::as_str)
    }

    /// All up-to-date translations with their keys, sorted by key.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &str)> {
        self.entries.iter().map(|(key, translation)| (key.as_str(), translation.as_str()))
    }

    /// True if any text of this unit is translated; see `Text::unit`.
    pub fn covers(&self, unit: &str) -> bool {
        self.units.contains(unit)
    }
}
