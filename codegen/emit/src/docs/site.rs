//! Index of the documentation: the page of each item, and the references between items.

use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet, HashMap};

use uavspec_schema::source::{SourceMap, Span};
use uavspec_schema::translation::{
    Language, MessageKeys, MessageText, SOURCE_LANGUAGE, Translations, interface_unit, message_unit,
};
use uavspec_schema::{
    Dialect, Element, Enum, EnumRef, Form, Interface, Kind, Message, MessageId, Package, Schema, UorbLayout,
};

use super::histories::Histories;
use super::markdown::{code, href, link};
use super::options::Siblings;
use super::words::{self, ENGLISH, Words};
use crate::json_schema::{self, Target};
use crate::origin::Origins;

/// Constants with a special meaning in PX4. Pages show them as facts about the message.
const KNOWN_CONSTANTS: [&str; 2] = ["MESSAGE_VERSION", "ORB_QUEUE_LENGTH"];

/// File names that are special in mdBook or on GitHub.
const RESERVED_STEMS: [&str; 2] = ["readme", "index"];

/// A field of a message.
pub(super) type FieldRef = (MessageId, usize);

/// A named part of a message with an anchor on its page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Field(usize),
    Constant(usize),
    Enum(usize),
}

/// The page of a message, and the prefix of its anchors.
#[derive(Debug)]
struct Place {
    path: String,
    /// Path of the English page.
    english: String,
    prefix: String,
}

/// Index of all documented items.
#[derive(Debug)]
pub(super) struct Site<'s> {
    pub(super) schema: &'s Schema,
    pub(super) sources: &'s SourceMap,
    origins: Origins<'s>,
    siblings: &'s Siblings,
    /// The history of each definition in the releases.
    pub(super) histories: &'s Histories,
    /// Page locations, by message. `None` for messages that aren't listed.
    places: Vec<Option<Place>>,
    /// For each message, the fields that have this message as their type.
    users: Vec<Vec<FieldRef>>,
    /// For each enum, the fields that use it.
    enum_users: BTreeMap<EnumRef, Vec<FieldRef>>,
    /// The unique enum names of each message.
    enum_names: Vec<Vec<String>>,
    /// The messages of each package, by name and by topic.
    names: Vec<HashMap<&'s str, MessageId>>,
    /// The parts of each message, by name. Filled lazily.
    parts: Vec<OnceCell<HashMap<&'s str, Part>>>,
    /// All languages with translations.
    languages: &'s [Language],
    /// The language of the site, or `None` for English. A unit without a translation uses the English page.
    pub(super) language: Option<&'s Language>,
    /// Fixed text for pages.
    pub(super) words: Words,
    /// The text keys of each message. Filled lazily.
    keys: Vec<OnceCell<MessageKeys<'s>>>,
}

/// A text of a definition, translated if possible.
#[derive(Clone, Copy, Debug)]
pub(super) struct Localized<'t> {
    pub(super) text: &'t str,
    /// Language of the text, or `None` if it is also the language of the fixed strings on the page.
    pub(super) tag: Option<&'t str>,
    /// True if the text is a translation.
    pub(super) is_translated: bool,
}

impl<'s> Site<'s> {
    /// Creates the site in `language`, or in English if `language` is `None`.
    pub(super) fn new(
        schema: &'s Schema,
        translations: &'s Translations,
        sources: &'s SourceMap,
        siblings: &'s Siblings,
        histories: &'s Histories,
        language: Option<&'s Language>,
    ) -> Self {
        let count = schema.messages.len();
        let mut site = Self {
            schema,
            sources,
            origins: Origins::new(schema, sources),
            siblings,
            histories,
            places: (0..count).map(|_| None).collect(),
            users: vec![Vec::new(); count],
            enum_users: BTreeMap::new(),
            enum_names: schema.messages.iter().map(enum_names).collect(),
            names: vec![HashMap::new(); schema.packages.len()],
            parts: vec![OnceCell::new(); count],
            languages: &translations.languages,
            language,
            words: language.map_or(ENGLISH, |language| Words::of(&language.tag)),
            keys: vec![OnceCell::new(); count],
        };
        for (index, package) in schema.packages.iter().enumerate() {
            site.place(index, package);
        }
        site.gather_users();
        site
    }

    fn place(&mut self, index: usize, package: &'s Package) {
        let folder = &package.name;
        for id in &package.messages {
            let name = &self.schema.message(*id).name;
            let english = format!("{folder}/{}.md", stem(name));
            let path = self.path_of(&english, &message_unit(self.schema, self.schema.message(*id)));
            self.places[id.0 as usize] = Some(Place { path, english, prefix: String::new() });
        }
        for interface in &package.interfaces {
            for (id, part) in interface.parts.iter().zip(part_names(interface.kind)) {
                let prefix = format!("{}-", part.to_ascii_lowercase());
                let english = interface_path(package, interface);
                let path = self.path_of(&english, &interface_unit(package, interface));
                self.places[id.0 as usize] = Some(Place { path, english, prefix });
            }
        }
        let names = &mut self.names[index];
        // Messages come last, so a name shared by a message and a topic refers to the message.
        for id in &package.messages {
            names.extend(self.schema.message(*id).topics.iter().map(|topic| (topic.as_str(), *id)));
        }
        names.extend(package.messages.iter().map(|id| (self.schema.message(*id).name.as_str(), *id)));
    }

    fn gather_users(&mut self) {
        for (id, message) in self.listed() {
            for (index, field) in message.fields.iter().enumerate() {
                if let Element::Message(nested) = field.ty.element {
                    self.users[nested.0 as usize].push((id, index));
                }
                if let Some(reference) = field.enumeration {
                    self.enum_users.entry(reference).or_default().push((id, index));
                }
            }
        }
    }

    /// Packages that contain definitions.
    pub(super) fn packages(&self) -> impl Iterator<Item = &'s Package> + use<'s> {
        self.schema.packages.iter().filter(|package| !package.is_empty())
    }

    /// All documented messages, including parts of services and actions.
    fn listed(&self) -> Vec<(MessageId, &'s Message)> {
        let ids = self.schema.packages.iter().flat_map(Package::all_messages);
        ids.map(|id| (id, self.schema.message(id))).collect()
    }

    /// The page of a message, or an empty string if it has none.
    pub(super) fn path(&self, id: MessageId) -> &str {
        self.places[id.0 as usize].as_ref().map_or("", |place| &place.path)
    }

    /// The English page of a message, or an empty string if it has none.
    pub(super) fn english_path(&self, id: MessageId) -> &str {
        self.places[id.0 as usize].as_ref().map_or("", |place| &place.english)
    }

    /// The page of `unit` in the site language, or the English page if there is no translation.
    pub(super) fn path_of(&self, english: &str, unit: &str) -> String {
        match self.language.filter(|language| language.covers(unit)) {
            Some(language) => path_in(english, &language.tag),
            None => english.to_owned(),
        }
    }

    /// The languages that have a page for `unit`.
    pub(super) fn languages_of(&self, unit: &str) -> impl Iterator<Item = &'s Language> {
        self.languages.iter().filter(move |language| language.covers(unit))
    }

    /// True if the site has a page for `unit` in the site language.
    pub(super) fn has_page(&self, unit: &str) -> bool {
        self.language.is_none_or(|language| language.covers(unit))
    }

    /// The text for this key in the site language.
    pub(super) fn localized<'t>(&'t self, key: impl FnOnce() -> String, text: &'t str) -> Localized<'t> {
        let Some(language) = self.language else {
            return Localized { text, tag: None, is_translated: false };
        };
        let is_english = self.words.are_english();
        match language.get(&key()) {
            Some(translation) => {
                let tag = is_english.then_some(language.tag.as_str());
                Localized { text: translation, tag, is_translated: true }
            }
            None => Localized { text, tag: (!is_english).then_some(SOURCE_LANGUAGE), is_translated: false },
        }
    }

    /// A text of a message in the site language.
    pub(super) fn localized_of(&self, id: MessageId, text: MessageText) -> Localized<'_> {
        let message = self.schema.message(id);
        let keys = || self.keys[id.0 as usize].get_or_init(|| MessageKeys::new(self.schema, message));
        self.localized(|| keys().key(text), text.of(message))
    }

    /// The fields with this message type.
    pub(super) fn users(&self, id: MessageId) -> &[FieldRef] {
        &self.users[id.0 as usize]
    }

    /// The fields with this enum.
    pub(super) fn enum_users(&self, reference: EnumRef) -> &[FieldRef] {
        self.enum_users.get(&reference).map_or(&[], Vec::as_slice)
    }

    /// The message with this name or topic in a package.
    pub(super) fn message_named(&self, package: usize, name: &str) -> Option<MessageId> {
        self.names[package].get(name).copied()
    }

    /// The part of a message with this name.
    pub(super) fn part_named(&self, id: MessageId, name: &str) -> Option<Part> {
        self.parts[id.0 as usize].get_or_init(|| parts(self.schema.message(id))).get(name).copied()
    }

    /// The anchor of a part of a message.
    pub(super) fn anchor(&self, id: MessageId, part: Part) -> String {
        let message = self.schema.message(id);
        let prefix = self.places[id.0 as usize].as_ref().map_or("", |place| &place.prefix);
        let (kind, name) = match part {
            Part::Field(index) => ("field", message.fields[index].name.clone()),
            Part::Constant(index) => ("constant", message.constants[index].name.clone()),
            Part::Enum(index) => ("enum", self.enum_names[id.0 as usize][index].clone()),
        };
        format!("{prefix}{kind}-{}", name.to_ascii_lowercase())
    }

    /// The URL of a part of a message, relative to the page `from`.
    pub(super) fn href(&self, from: &str, id: MessageId, part: Part) -> String {
        href(from, self.path(id), &self.anchor(id, part))
    }

    /// The memory layout of a message, or `None` for a ROS message.
    pub(super) fn layout(&self, message: &'s Message) -> Option<&'s UorbLayout> {
        message.uorb.as_ref().filter(|_| message.kind == Kind::Message && self.is_px4(message))
    }

    /// True if the message is defined by PX4.
    pub(super) fn is_px4(&self, message: &Message) -> bool {
        self.schema.package_of(message).form == Form::Msg(Dialect::Px4)
    }

    /// The other files generated for `target`: labels and links.
    pub(super) fn files(&self, from: &str, target: Target) -> Vec<(&'static str, String)> {
        let stem = json_schema::name(self.schema, target);
        let name = stem.rsplit('/').next().unwrap_or(&stem);
        let outputs = [
            (words::JSON_SCHEMA, &self.siblings.schemas, "schema"),
            (words::TEST_VECTORS, &self.siblings.vectors, "vectors"),
        ];
        let file = |(word, folder, kind): (_, &Option<String>, _)| {
            let to = href(from, &format!("{}/{stem}.{kind}.json", folder.as_ref()?), "");
            Some((self.words.get(word), link(&code(&format!("{name}.{kind}.json")), &to)))
        };
        outputs.into_iter().filter_map(file).collect()
    }

    /// The links of [`Self::files`] on one line.
    pub(super) fn line_of_files(&self, from: &str, target: Target) -> String {
        let files = self.files(from, target).into_iter().map(|(name, file)| format!("{name}: {file}"));
        files.collect::<Vec<_>>().join(" · ")
    }

    /// Path of the definition that contains `span`, relative to the package folder.
    pub(super) fn source(&self, span: Span) -> &'s str {
        self.origins.path(span)
    }
}

/// The page path of a service or action.
pub(super) fn interface_path(package: &Package, interface: &Interface) -> String {
    format!("{}/{}.{}.md", package.name, interface.name, interface.kind.name())
}

/// The part names of a service or action.
pub(super) fn part_names(kind: Kind) -> impl Iterator<Item = &'static str> {
    kind.part_suffixes().iter().map(|suffix| suffix.trim_start_matches('_'))
}

/// True if the page shows the constant as a fact about the message, and therefore not in a table.
pub(super) fn is_fact(message: &Message, constant: usize) -> bool {
    let [version, queue_length] = KNOWN_CONSTANTS.map(|known| message.constants[constant].name == known);
    version && message.version.is_some() || queue_length && message.queue_length.is_some()
}

/// The file name of a message's page and picture, without extension.
pub(super) fn stem(name: &str) -> String {
    let is_reserved = RESERVED_STEMS.iter().any(|reserved| name.eq_ignore_ascii_case(reserved));
    if is_reserved { format!("{name}.msg") } else { name.to_owned() }
}

/// Unique names of the enums of a message.
fn enum_names(message: &Message) -> Vec<String> {
    let mut known = BTreeSet::new();
    let name = |(index, found): (usize, &Enum)| {
        let name = found.prefixes.join("-");
        // Number equal names, because fields of different types may use the same constants.
        if known.insert(name.clone()) { name } else { format!("{name}-{}", index + 1) }
    };
    message.enums.iter().enumerate().map(name).collect()
}

fn parts(message: &Message) -> HashMap<&str, Part> {
    let enums = message.enums.iter().enumerate().rev();
    let enums = enums
        .flat_map(|(index, found)| found.prefixes.iter().map(move |name| (name.as_str(), Part::Enum(index))));
    let constants = message.constants.iter().enumerate().filter(|(index, _)| !is_fact(message, *index));
    let constants = constants.map(|(index, constant)| (constant.name.as_str(), Part::Constant(index)));
    let fields = message.fields.iter().enumerate();
    let fields = fields.map(|(index, field)| (field.name.as_str(), Part::Field(index)));
    enums.chain(constants).chain(fields).collect()
}

/// The path of the translated version of the page `path`. Both versions are in the same folder, so relative links stay
/// the same.
pub(super) fn path_in(path: &str, tag: &str) -> String {
    format!("{}.{tag}.md", path.strip_suffix(".md").unwrap_or(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn puts_translated_pages_next_to_the_english_page() {
        assert_eq!(path_in("px4/Wind.md", "uk"), "px4/Wind.uk.md");
        assert_eq!(path_in("px4/Tow.srv.md", "pt-BR"), "px4/Tow.srv.pt-BR.md");
    }
}
