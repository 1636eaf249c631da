//! The topics that the sources of an application name.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::Spanned;
use uavspec_model::text::{plural, terminal};
use uavspec_rules::definitions::{Library, PX4_ROS_PACKAGE};
use uavspec_schema::source::{SourceId, SourceMap};
use uavspec_schema::span::Span;
use uavspec_schema::{Failure, Schema};
use walkdir::{DirEntry, WalkDir};

use crate::dds;
use crate::lexer::Language;
use crate::limits::{MAX_FILES, MAX_PLACES, MAX_SOURCE};
use crate::source::{self, Direction, Found, Named, Topic, Version};

/// Folders that aren't part of the application: PX4's definitions and PX4's translation node, and modules of npm.
const OTHER_FOLDERS: [&str; 4] = [PX4_ROS_PACKAGE, "px4_msgs_old", "translation_node", "node_modules"];

/// Folders that colcon writes in a workspace.
const OUTPUTS: [&str; 3] = ["build", "install", "log"];

/// Files in which colcon and Cargo mark folders that they write.
const MARKS: [&str; 2] = ["COLCON_IGNORE", "CACHEDIR.TAG"];

/// Files that name topics without using them: PX4's list of topics, and the descriptions of packages.
const OTHER_FILES: [&str; 2] = [dds::FILE_NAME, "package.xml"];

/// The topics that an application names.
#[derive(Debug, Default)]
pub struct Application {
    /// The topics, in order.
    pub uses: Vec<Use>,
    /// The parts of the sources that can't be read.
    pub unread: Vec<Unread>,
    /// The number of source files.
    pub files: usize,
    /// The source files that name topics.
    pub sources: SourceMap,
}

/// A topic that an application names.
#[derive(Debug, PartialEq, Eq)]
pub struct Use {
    /// The topic.
    pub topic: Topic,
    /// The name of its type, if a source states it or definitions contain the topic.
    pub ty: Option<String>,
    /// The places that name it.
    pub places: Vec<Span>,
}

/// A part of the sources that can't be read.
#[derive(Debug, PartialEq, Eq)]
pub struct Unread {
    /// The reason.
    pub reason: String,
    /// The place; `None` for whole files, which the reason names.
    pub place: Option<Span>,
}

/// Topics that the sources use, but don't name.
#[derive(Debug, Default)]
pub struct Hints {
    path: String,
    text: String,
    topics: Vec<(Topic, TopicHint)>,
}

/// The content of a file with hints.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct HintFile {
    #[serde(default, rename = "topic")]
    topics: Vec<TopicHint>,
}

/// A topic that the sources use, but don't name.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TopicHint {
    /// The topic, such as `fmu/in/vehicle_command`.
    topic: Spanned<String>,
    /// The name of its type. By default, it is the type that the definitions give to the topic.
    #[serde(rename = "type")]
    ty: Option<String>,
}

impl Hints {
    /// Reads hints from a file.
    ///
    /// # Errors
    /// Fails if the file can't be read or contains a mistake.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let place = terminal::path(path);
        let text =
            std::fs::read_to_string(path).map_err(|error| Failure::new(format!("{place}: {error}")))?;
        let file: HintFile =
            toml::from_str(&text).map_err(|error| Failure::new(format!("{place}: {error}")))?;
        let read = |hint: TopicHint| -> Result<_, Failure> {
            let topic = hint.read().ok_or_else(|| {
                let topic = terminal::shown(hint.topic.get_ref());
                Failure::new(format!("{place}: `{topic}` is not a topic of PX4"))
                    .with_hint("write a topic such as `fmu/in/vehicle_command`")
            })?;
            Ok((topic, hint))
        };
        let topics = file.topics.into_iter().map(read).collect::<Result<_, Failure>>()?;
        Ok(Self { path: path.to_string_lossy().into_owned(), text, topics })
    }
}

impl TopicHint {
    fn read(&self) -> Option<Topic> {
        let (topic, rest) = Topic::read_full(self.topic.get_ref())?;
        (rest.is_empty() && !topic.name.is_empty()).then_some(topic)
    }
}

/// The folder of PX4's messages in a workspace: a folder `px4_msgs` that contains definitions.
pub fn definitions_in(workspace: &Path) -> Option<PathBuf> {
    let is_package = |entry: &DirEntry| entry.file_name() == PX4_ROS_PACKAGE;
    let is_searched = |entry: &DirEntry| entry.depth() == 0 || is_package(entry) || !is_other(entry);
    let folders = WalkDir::new(workspace).sort_by_file_name().into_iter().filter_entry(is_searched);
    let mut found = folders.filter_map(Result::ok).filter(is_package);
    found.find(|entry| entry.path().join("msg").is_dir()).map(DirEntry::into_path)
}

impl Application {
    /// The source files that name a topic.
    pub(crate) fn sources_of(&self, used: &Use) -> impl Iterator<Item = SourceId> {
        used.places.iter().map(|place| self.sources.source_of(*place))
    }

    /// Reads the sources in a folder. If a source doesn't state the type of a topic, it is the type that the first
    /// definitions with the topic give to it.
    ///
    /// # Errors
    /// Fails if the folder can't be read.
    pub fn read(folder: &Path, definitions: &[&Schema], hints: &Hints) -> Result<Self, Failure> {
        let library = Library::built_in();
        let released = library.index().rows().iter().filter_map(|row| row.name.strip_prefix("px4_msgs/msg/"));
        let messages = definitions.iter().flat_map(|schema| &schema.messages);
        let mut sources = Sources {
            types: messages.map(|message| message.name.as_str()).chain(released).collect(),
            ..Sources::default()
        };
        let is_source = |entry: &DirEntry| entry.depth() == 0 || !is_other(entry);
        let entries = WalkDir::new(folder).follow_links(true).sort_by_file_name().into_iter();
        for entry in entries.filter_entry(is_source) {
            let entry = match entry {
                Ok(entry) => entry,
                Err(error) if error.depth() == 0 => return Err(Failure::new(error.to_string())),
                Err(error) => {
                    sources.skip(error.to_string());
                    continue;
                }
            };
            let is_file =
                entry.file_type().is_file() && !OTHER_FILES.iter().any(|name| entry.file_name() == *name);
            if let Some(language) = Language::of(entry.path()).filter(|_| is_file) {
                if sources.files == MAX_FILES {
                    sources.skip(format!("only the first {} are read", plural(MAX_FILES, "source file")));
                    break;
                }
                sources.read(entry.path(), language);
            }
        }
        Ok(sources.complete(definitions, hints))
    }
}

/// The sources that have been read.
#[derive(Default)]
struct Sources<'t> {
    /// The names of PX4's messages.
    types: BTreeSet<&'t str>,
    /// The places that name topics. Elements of lists are separate.
    places: BTreeMap<(Topic, Option<String>, bool), Vec<Span>>,
    count: usize,
    /// The publishers and subscriptions whose topic can't be read, with the type.
    unnamed: Vec<(Option<String>, Span)>,
    unread: Vec<Unread>,
    files: usize,
    map: SourceMap,
}

impl Sources<'_> {
    fn skip(&mut self, reason: String) {
        self.unread.push(Unread { reason, place: None });
    }

    /// Reads a file.
    fn read(&mut self, path: &Path, language: Language) {
        self.files += 1;
        let name = path.strip_prefix(".").unwrap_or(path).to_string_lossy().replace('\\', "/");
        let mut bytes = Vec::new();
        let read = File::open(path).and_then(|file| file.take(MAX_SOURCE as u64 + 1).read_to_end(&mut bytes));
        match read {
            Ok(_) if bytes.len() > MAX_SOURCE => {
                if String::from_utf8_lossy(&bytes).contains("fmu/") {
                    self.skip(format!("{}: longer than {MAX_SOURCE} bytes", terminal::shown(&name)));
                }
            }
            // Topics are ASCII, so other encodings matter only in comments.
            Ok(_) => self.add(name, String::from_utf8_lossy(&bytes).replace('\u{feff}', " "), language),
            Err(error) => self.skip(format!("{}: {error}", terminal::shown(&name))),
        }
    }

    /// Adds the topics in the text of a file.
    fn add(&mut self, name: String, text: String, language: Language) {
        let found = source::read(&text, language, &self.types);
        if found == Found::default() {
            return;
        }
        self.count += found.named.len() + found.unnamed.len();
        if self.count > MAX_PLACES {
            self.skip(format!("{}: it names too many topics", terminal::shown(&name)));
            return;
        }
        let Ok(id) = self.map.add(name, text.into_bytes()) else { return };
        let file = self.map.span(id);
        for Named { topic, ty, is_listed, range } in found.named {
            self.places.entry((topic, ty, is_listed)).or_default().push(file.part(range));
        }
        self.unnamed.extend(found.unnamed.into_iter().map(|unnamed| (unnamed.ty, file.part(unnamed.range))));
    }

    /// The application. Adds the hints, and the types that definitions know.
    fn complete(mut self, definitions: &[&Schema], hints: &Hints) -> Application {
        if let Ok(id) = self.map.add(hints.path.clone(), hints.text.clone().into_bytes()) {
            let file = self.map.span(id);
            for (topic, hint) in &hints.topics {
                let places = self.places.entry((topic.clone(), hint.ty.clone(), false)).or_default();
                places.push(file.part(hint.topic.span()));
            }
        }
        // A list of topics, such as px4_ros2's list for its check of compatibility, may contain names without versions.
        let appended = self.places.keys().filter(|(topic, ..)| topic.version == Version::OfDefinition);
        let appended: BTreeSet<(Direction, String)> = appended.map(|(topic, ..)| topic.key()).collect();
        self.places.retain(|(topic, _, is_listed), _| {
            !*is_listed || topic.version != Version::Stated(0) || !appended.contains(&topic.key())
        });
        let type_of = |topic: &Topic| {
            let mut messages = definitions.iter().flat_map(|schema| &schema.messages);
            let message = messages.find(|message| message.topics.contains(&topic.name));
            message.map(|message| message.name.clone())
        };
        let mut uses: BTreeMap<(Topic, Option<String>), Vec<Span>> = BTreeMap::new();
        for ((topic, ty, _), mut places) in self.places {
            let ty = ty.or_else(|| type_of(&topic));
            uses.entry((topic, ty)).or_default().append(&mut places);
        }
        // A name may be stored in a variable. If another place names a topic of the type, that is probably it.
        let named: BTreeSet<Option<String>> = uses.keys().map(|(_, ty)| ty.clone()).collect();
        for (ty, place) in self.unnamed.into_iter().filter(|(ty, _)| ty.is_none() || !named.contains(ty)) {
            let ty = ty.map(|ty| format!(" of type `{ty}`")).unwrap_or_default();
            let reason = format!("can't read the name of this topic{ty}");
            self.unread.push(Unread { reason, place: Some(place) });
        }
        let uses = uses.into_iter().map(|((topic, ty), places)| Use { topic, ty, places });
        Application { uses: uses.collect(), unread: self.unread, files: self.files, sources: self.map }
    }
}

/// True for folders that aren't part of the application, and for hidden files.
fn is_other(entry: &DirEntry) -> bool {
    let name = entry.file_name().to_string_lossy();
    let is_output = || entry.depth() == 1 && OUTPUTS.contains(&&*name);
    let is_marked = || MARKS.iter().any(|mark| entry.path().join(mark).exists());
    let is_px4 = || entry.path().join(dds::FOLDER).is_dir();
    let is_folder = entry.file_type().is_dir();
    name.starts_with('.')
        || is_folder && (OTHER_FOLDERS.contains(&&*name) || is_output() || is_marked() || is_px4())
}
