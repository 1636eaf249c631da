//! Where each thing is described, and what refers to it.

use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::markdown::{code, href, link};
use super::options::Beside;
use super::words::{self, ENGLISH, Words};
use crate::emit::json_schema::{self, Target};
use crate::emit::origin::Origins;
use crate::schema::{
    Dialect, Element, Enum, EnumRef, Form, Interface, Kind, Message, MessageId, Package, Schema, UorbLayout,
};
use crate::source::{SourceMap, Span};
use crate::translation::{
    Language, MessageKeys, MessageText, SOURCE_LANGUAGE, Translations, interface_unit, message_unit,
};

/// Constants that PX4 knows by name; the facts of a message show them.
const KNOWN_CONSTANTS: [&str; 2] = ["MESSAGE_VERSION", "ORB_QUEUE_LENGTH"];

/// Names that mdBook or GitHub gives a meaning to where a page bears them.
const RESERVED_STEMS: [&str; 2] = ["readme", "index"];

/// A field of a message.
pub(super) type FieldRef = (MessageId, usize);

/// Something in a message that has a name and a place on its page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Field(usize),
    Constant(usize),
    Enum(usize),
}

/// The page that describes a message, and what its anchors there start with.
#[derive(Debug)]
struct Place {
    path: String,
    /// The path of the English page.
    english: String,
    prefix: String,
}

/// All that is described, and where.
#[derive(Debug)]
pub(super) struct Site<'s> {
    pub(super) schema: &'s Schema,
    pub(super) sources: &'s SourceMap,
    origins: Origins<'s>,
    beside: &'s Beside,
    /// By message; none for those that aren't listed.
    places: Vec<Option<Place>>,
    /// The fields that hold each message.
    holders: Vec<Vec<FieldRef>>,
    /// The fields that hold each enum.
    enum_holders: BTreeMap<EnumRef, Vec<FieldRef>>,
    /// By message, what tells its enums apart.
    enum_names: Vec<Vec<String>>,
    /// By package, what messages and topics are called.
    names: Vec<HashMap<&'s str, MessageId>>,
    /// By message, what its parts are called; gathered when first asked for.
    parts: Vec<OnceCell<HashMap<&'s str, Part>>>,
    /// All languages that definitions are translated into.
    languages: &'s [Language],
    /// The language of its pages, where that isn't English. Pages that it doesn't have are the English ones.
    pub(super) language: Option<&'s Language>,
    /// The generator's own words.
    pub(super) words: Words,
    /// By message, the keys of its texts; made when first asked for.
    keys: Vec<OnceCell<MessageKeys<'s>>>,
}

/// What a definition says, in the language of the site or else in English.
#[derive(Clone, Copy, Debug)]
pub(super) struct Said<'t> {
    pub(super) text: &'t str,
    /// Its language, where that isn't the language of the generator's words on the page.
    pub(super) tag: Option<&'t str>,
    /// Whether it is translated.
    pub(super) is_translated: bool,
}

impl<'s> Site<'s> {
    /// The site in English.
    pub(super) fn new(
        schema: &'s Schema,
        translations: &'s Translations,
        sources: &'s SourceMap,
        beside: &'s Beside,
    ) -> Self {
        Self::in_language(schema, translations, sources, beside, None)
    }

    /// The site in a language; in English, where that is none.
    pub(super) fn in_language(
        schema: &'s Schema,
        translations: &'s Translations,
        sources: &'s SourceMap,
        beside: &'s Beside,
        language: Option<&'s Language>,
    ) -> Self {
        let count = schema.messages.len();
        let mut site = Self {
            schema,
            sources,
            origins: Origins::new(schema, sources),
            beside,
            places: (0..count).map(|_| None).collect(),
            holders: vec![Vec::new(); count],
            enum_holders: BTreeMap::new(),
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
        site.gather_holders();
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
        // Messages last: where a message and a topic share a name, the message is meant.
        for id in &package.messages {
            names.extend(self.schema.message(*id).topics.iter().map(|topic| (topic.as_str(), *id)));
        }
        names.extend(package.messages.iter().map(|id| (self.schema.message(*id).name.as_str(), *id)));
    }

    fn gather_holders(&mut self) {
        for (id, message) in self.listed() {
            for (index, field) in message.fields.iter().enumerate() {
                if let Element::Message(nested) = field.ty.element {
                    self.holders[nested.0 as usize].push((id, index));
                }
                if let Some(held) = field.enumeration {
                    self.enum_holders.entry(held).or_default().push((id, index));
                }
            }
        }
    }

    /// The packages that describe anything.
    pub(super) fn packages(&self) -> impl Iterator<Item = &'s Package> + use<'s> {
        self.schema.packages.iter().filter(|package| !package.is_empty())
    }

    /// All messages that have a place, parts of services and actions too.
    fn listed(&self) -> Vec<(MessageId, &'s Message)> {
        let ids = self.schema.packages.iter().flat_map(|package| {
            package.messages.iter().chain(package.interfaces.iter().flat_map(|interface| &interface.parts))
        });
        ids.map(|id| (*id, self.schema.message(*id))).collect()
    }

    /// The page of a message; empty where it has none.
    pub(super) fn path(&self, id: MessageId) -> &str {
        self.places[id.0 as usize].as_ref().map_or("", |place| &place.path)
    }

    /// The English page of a message; empty where it has none.
    pub(super) fn english_path(&self, id: MessageId) -> &str {
        self.places[id.0 as usize].as_ref().map_or("", |place| &place.english)
    }

    /// The page of `unit` in the language of the site, where it has one, or else in English.
    pub(super) fn path_of(&self, english: &str, unit: &str) -> String {
        match self.language.filter(|language| language.covers(unit)) {
            Some(language) => path_in(english, &language.tag),
            None => english.to_owned(),
        }
    }

    /// The languages that have a page of `unit`.
    pub(super) fn languages_of(&self, unit: &str) -> impl Iterator<Item = &'s Language> {
        self.languages.iter().filter(move |language| language.covers(unit))
    }

    /// Whether the site has a page of `unit` in its own language.
    pub(super) fn has_page(&self, unit: &str) -> bool {
        self.language.is_none_or(|language| language.covers(unit))
    }

    /// What a definition says under a key, in the language of the site.
    pub(super) fn said<'t>(&'t self, key: impl FnOnce() -> String, text: &'t str) -> Said<'t> {
        let Some(language) = self.language else { return Said { text, tag: None, is_translated: false } };
        let is_english = self.words.are_english();
        match language.get(&key()) {
            Some(translation) => {
                let tag = is_english.then_some(language.tag.as_str());
                Said { text: translation, tag, is_translated: true }
            }
            None => Said { text, tag: (!is_english).then_some(SOURCE_LANGUAGE), is_translated: false },
        }
    }

    /// What a message says.
    pub(super) fn said_of(&self, id: MessageId, text: MessageText) -> Said<'_> {
        let message = self.schema.message(id);
        let keys = || self.keys[id.0 as usize].get_or_init(|| MessageKeys::new(self.schema, message));
        self.said(|| keys().key(text), text.of(message))
    }

    /// The fields that hold a message.
    pub(super) fn holders(&self, id: MessageId) -> &[FieldRef] {
        &self.holders[id.0 as usize]
    }

    /// The fields that hold an enum.
    pub(super) fn enum_holders(&self, held: EnumRef) -> &[FieldRef] {
        self.enum_holders.get(&held).map_or(&[], Vec::as_slice)
    }

    /// The message that a package knows by a name or a topic.
    pub(super) fn message_named(&self, package: usize, name: &str) -> Option<MessageId> {
        self.names[package].get(name).copied()
    }

    /// What a message calls so.
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

    /// The address of a part of a message, as seen from a page.
    pub(super) fn href(&self, from: &str, id: MessageId, part: Part) -> String {
        href(from, self.path(id), &self.anchor(id, part))
    }

    /// The memory layout of a message, where it means something: ROS has no uORB.
    pub(super) fn layout(&self, message: &'s Message) -> Option<&'s UorbLayout> {
        message.uorb.as_ref().filter(|_| message.kind == Kind::Message && self.is_px4(message))
    }

    /// Whether PX4 knows a message.
    pub(super) fn is_px4(&self, message: &Message) -> bool {
        self.schema.package_of(message).form == Form::Msg(Dialect::Px4)
    }

    /// What else is generated of `target`: what it is called, and a link to its file.
    pub(super) fn files(&self, from: &str, target: Target) -> Vec<(&'static str, String)> {
        let stem = json_schema::name(self.schema, target);
        let name = stem.rsplit('/').next().unwrap_or(&stem);
        let outputs = [
            (words::JSON_SCHEMA, &self.beside.schemas, "schema"),
            (words::TEST_VECTORS, &self.beside.vectors, "vectors"),
        ];
        let file = |(word, folder, kind): (_, &Option<String>, _)| {
            let to = href(from, &format!("{}/{stem}.{kind}.json", folder.as_ref()?), "");
            Some((self.words.get(word), link(&code(&format!("{name}.{kind}.json")), &to)))
        };
        outputs.into_iter().filter_map(file).collect()
    }

    /// The same on one line.
    pub(super) fn line_of_files(&self, from: &str, target: Target) -> String {
        let files = self.files(from, target).into_iter().map(|(name, file)| format!("{name}: {file}"));
        files.collect::<Vec<_>>().join(" · ")
    }

    /// The path of the definition that holds `span`, from the folder of its package.
    pub(super) fn source(&self, span: Span) -> &'s str {
        self.origins.path(span)
    }
}

/// The page of a service or action.
pub(super) fn interface_path(package: &Package, interface: &Interface) -> String {
    format!("{}/{}.{}.md", package.name, interface.name, interface.kind.name())
}

/// What the parts of a service or action are called.
pub(super) fn part_names(kind: Kind) -> impl Iterator<Item = &'static str> {
    kind.part_suffixes().iter().map(|suffix| suffix.trim_start_matches('_'))
}

/// Whether the facts of a message show a constant, so that no table need do so.
pub(super) fn is_fact(message: &Message, constant: usize) -> bool {
    let [version, queue_length] = KNOWN_CONSTANTS.map(|known| message.constants[constant].name == known);
    version && message.version.is_some() || queue_length && message.queue_length.is_some()
}

/// The file name of a message's page and picture, without extension.
pub(super) fn stem(name: &str) -> String {
    let is_reserved = RESERVED_STEMS.iter().any(|reserved| name.eq_ignore_ascii_case(reserved));
    if is_reserved { format!("{name}.msg") } else { name.to_owned() }
}

/// What tells each enum from the others of its message.
fn enum_names(message: &Message) -> Vec<String> {
    let mut known = BTreeSet::new();
    let name = |(index, found): (usize, &Enum)| {
        let name = found.prefixes.join("-");
        // The same constants may be held by fields of different types.
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

/// The page that says in another language what `path` says in English: it stands beside that, so that relative links
/// are the same.
pub(super) fn path_in(path: &str, tag: &str) -> String {
    format!("{}.{tag}.md", path.strip_suffix(".md").unwrap_or(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_stands_beside_the_english_one() {
        assert_eq!(path_in("px4/Wind.md", "uk"), "px4/Wind.uk.md");
        assert_eq!(path_in("px4/Tow.srv.md", "pt-BR"), "px4/Tow.srv.pt-BR.md");
    }
}
