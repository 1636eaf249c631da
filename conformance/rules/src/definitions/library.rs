//! The definitions that captures are checked against: fixed definitions, or the definitions of the release that a
//! capture matches.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use uavspec_definitions::PX4;
use uavspec_lint::release::{self, entries};
use uavspec_px4::event::EventMetadata;
use uavspec_schema::msg::Dialect;
use uavspec_schema::{Failure, Form, PackageInput, SourceMap, read, read_formats};

use super::choice::{Choice, Clues};
use super::index::{Family, Index, ReleaseId};
use super::{Definitions, LoadedRelease, SchemaError, Schemas, built_in_events};
use crate::limits::MAX_STORED;

/// The ROS package of PX4's messages.
const PX4_ROS_PACKAGE: &str = "px4_msgs";

/// The ROS package that a name denotes. The name of the PX4 family denotes the package `px4_msgs`.
pub fn ros_package(name: &str) -> &str {
    if name == Family::Px4.name() { PX4_ROS_PACKAGE } else { name }
}

/// Documented messages by name: their declarations without comments, and their files.
type Documented = HashMap<String, (String, &'static str)>;

/// The definitions for a run.
#[derive(Debug)]
pub struct Library {
    name: String,
    /// The definitions for captures that don't indicate their release, read when they are needed.
    base: OnceLock<Arc<Definitions>>,
    /// True if all captures are checked against the same definitions.
    is_fixed: bool,
    /// The release that the user requests, with its family.
    forced: Option<(Family, ReleaseId)>,
    schemas: Arc<Schemas>,
    events: Arc<EventMetadata>,
    index: OnceLock<&'static Index>,
    documented: OnceLock<Documented>,
    stored: Mutex<HashMap<Key, Arc<Definitions>>>,
}

/// Identifies the loaded definitions: for each main release, the release itself, the types that come from other
/// releases, and the undecided types.
type Key = Vec<(ReleaseId, BTreeMap<String, ReleaseId>, BTreeSet<String>)>;

impl Library {
    /// The built-in definitions. The release is chosen for each capture.
    pub fn built_in() -> Self {
        Self::new(Definitions::built_in_name(), false)
    }

    /// Definitions that apply to all captures.
    pub fn fixed(definitions: Definitions) -> Self {
        let library = Self::new(definitions.name.clone(), true);
        // The library is new, so the definitions aren't set yet.
        let _ = library.base.set(Arc::new(definitions));
        library
    }

    /// Definitions from a path, or a release such as `px4@1.16`. The dialect of the definitions at the path is detected
    /// unless it is given.
    pub fn load(text: &Path, dialect: Option<Dialect>) -> Result<Self, Failure> {
        let label = text.to_str().filter(|text| text.contains('@') && !Path::new(text).exists());
        label.map_or_else(|| Definitions::load_as(text, dialect).map(Self::fixed), Self::release)
    }

    /// The definitions of a release such as `px4@1.16`.
    pub fn release(label: &str) -> Result<Self, Failure> {
        let mut library = Self::built_in();
        let index = library.index();
        let Some(release) = index.find(label) else {
            let known: Vec<String> = index.releases().map(|release| index.label(release)).collect();
            return Err(Failure::new(format!("unknown release `{label}`"))
                .with_hint(format!("the releases are {}", known.join(", "))));
        };
        library.name = index.title(release);
        library.forced = Some((index.family(release), release));
        Ok(library)
    }

    fn new(name: String, is_fixed: bool) -> Self {
        Self {
            name,
            base: OnceLock::new(),
            is_fixed,
            forced: None,
            schemas: Arc::default(),
            events: built_in_events(),
            index: OnceLock::new(),
            documented: OnceLock::new(),
            stored: Mutex::default(),
        }
    }

    /// Loads JSON Schemas from these folders, for Flockwave message types that have no definition.
    ///
    /// # Errors
    /// Fails if a schema can't be read or used.
    pub fn with_schemas(mut self, folders: &[PathBuf]) -> Result<Self, SchemaError> {
        if !folders.is_empty() {
            self.schemas = Arc::new(Schemas::load(folders, self.base().defined_schemas())?);
            if let Some(base) = self.base.get_mut().and_then(Arc::get_mut) {
                base.schemas = Arc::clone(&self.schemas);
            }
        }
        Ok(self)
    }

    /// Uses this event metadata for captures that don't contain their own.
    #[must_use]
    pub fn with_events(mut self, events: EventMetadata) -> Self {
        self.events = Arc::new(events);
        if let Some(base) = self.base.get_mut().and_then(Arc::get_mut) {
            base.events = Arc::clone(&self.events);
        }
        self
    }

    /// The event metadata for captures that don't contain their own.
    pub fn events(&self) -> &EventMetadata {
        &self.events
    }

    /// The definitions for captures that don't indicate their release.
    pub fn base(&self) -> &Arc<Definitions> {
        self.base.get_or_init(|| {
            Arc::new(if let Some((_, release)) = self.forced {
                self.read(&[Choice::without_clues(release)])
            } else {
                let (schemas, events) = (Arc::clone(&self.schemas), Arc::clone(&self.events));
                Definitions { schemas, events, ..Definitions::built_in() }
            })
        })
    }

    /// The newest PX4 release whose content no longer changes.
    pub fn newest_px4(&self) -> Arc<Definitions> {
        let index = self.index();
        let newest = index.releases_of(Family::Px4).filter(|release| !index.is_moving(*release)).last();
        let choice = newest.map(Choice::without_clues);
        choice.map_or_else(|| Arc::clone(self.base()), |choice| Arc::new(self.read(&[choice])))
    }

    /// The paths of definitions that were left out, because they refer to other packages.
    pub fn left_out(&self) -> &[String] {
        self.base.get().map_or(&[], |base| &base.left_out)
    }

    /// True if built-in packages provide what the definitions at a path lack.
    pub fn has_built_in_packages(&self) -> bool {
        self.base.get().is_some_and(|base| !base.built_in.is_empty())
    }

    /// A name for the definitions: their path, the release that the user requests, or the built-in definitions.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// True if the definitions of a capture depend on its release.
    pub fn depends_on_capture(&self) -> bool {
        !self.is_fixed
    }

    /// True if the user specified the release of this family.
    pub fn names_release(&self, family: Family) -> bool {
        self.forced.is_some_and(|(forced, _)| forced == family)
    }

    /// The fingerprints of all releases.
    pub fn index(&self) -> &'static Index {
        self.index.get_or_init(Index::built_in)
    }

    /// True if the fingerprints of the releases were read.
    pub fn has_read_releases(&self) -> bool {
        self.index.get().is_some()
    }

    /// The releases that a capture agrees with.
    fn choices(&self, clues: &Clues) -> Vec<Choice> {
        if self.is_fixed || *clues == Clues::default() {
            return Vec::new();
        }
        let forced = |family: Family| self.forced.filter(|(forced, _)| *forced == family);
        let choose = |family| self.index().choose(clues, family, forced(family).map(|(_, release)| release));
        Family::ALL.into_iter().filter_map(choose).collect()
    }

    /// Chooses the definitions for a capture.
    pub fn choose(&self, clues: &Clues) -> Arc<Definitions> {
        let choices = self.choices(clues);
        if choices.is_empty() {
            return Arc::clone(self.base());
        }
        let parts = |choice: &Choice| (choice.release, choice.others.clone(), choice.undecided.clone());
        let key: Key = choices.iter().map(parts).collect();
        let stored = || self.stored.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = stored().get(&key) {
            return Arc::clone(known);
        }
        let definitions = Arc::new(self.read(&choices));
        let mut stored = stored();
        if stored.len() >= MAX_STORED {
            stored.clear();
        }
        stored.insert(key, Arc::clone(&definitions));
        definitions
    }

    /// Reads the definitions of releases.
    fn read(&self, choices: &[Choice]) -> Definitions {
        let index = self.index();
        let mut sources = SourceMap::default();
        let (mut packages, mut replacements) = (Vec::new(), Vec::new());
        let (mut releases, mut origins) = (Vec::new(), HashMap::new());
        for choice in choices {
            let loaded = self.loaded(choice.release);
            for package in self.packages(choice.release, None, &mut sources) {
                origins.insert(package.name.clone(), loaded.clone());
                packages.push(package);
            }
            releases.push(loaded);
            let mut by_release: BTreeMap<ReleaseId, BTreeSet<&str>> = BTreeMap::new();
            for (name, release) in &choice.others {
                by_release.entry(*release).or_default().insert(name);
            }
            for (release, names) in by_release {
                for mut package in self.packages(release, Some(&names), &mut sources) {
                    package.ros_package.get_or_insert_with(|| package.name.clone());
                    package.name =
                        format!("{}_{}", package.name, index.release(release).name.replace('.', "_"));
                    replacements.push(package.name.clone());
                    origins.insert(package.name.clone(), self.loaded(release));
                    packages.push(package);
                }
            }
        }
        // Tests ensure that the releases have no errors.
        let (schema, _) = read(&sources, &packages);
        let titles: Vec<&str> =
            releases.iter().map(|release: &LoadedRelease| release.title.as_str()).collect();
        let definitions =
            Definitions::new(titles.join(", "), sources, schema).with_replacements(&replacements);
        let undecided = choices.iter().flat_map(|choice| choice.undecided.iter().cloned()).collect();
        let (schemas, events) = (Arc::clone(&self.schemas), Arc::clone(&self.events));
        Definitions { releases, origins, undecided, schemas, events, ..definitions }
    }

    fn loaded(&self, release: ReleaseId) -> LoadedRelease {
        let index = self.index();
        LoadedRelease {
            family: index.family(release),
            label: index.label(release),
            title: index.title(release),
        }
    }

    /// The packages of a release, or only the named definitions with the definitions that they contain.
    fn packages(
        &self,
        release: ReleaseId,
        names: Option<&BTreeSet<&str>>,
        sources: &mut SourceMap,
    ) -> Vec<PackageInput> {
        let index = self.index();
        let (family, label) = (index.family(release), index.label(release));
        let text = index.release(release).corrected_text();
        let text = match names {
            Some(names) => release::select(&text, names),
            None => text,
        };
        match family {
            Family::Ros2 => release::packages(&text, Dialect::Ros2, &format!("{label}/"), sources),
            Family::Px4 => vec![px4_package(&text, &label, self.documented(), sources)],
        }
    }

    /// The built-in PX4 messages, which are documented.
    fn documented(&self) -> &Documented {
        self.documented.get_or_init(|| {
            let mut sources = SourceMap::default();
            let package = Definitions::built_in_px4(&mut sources);
            let text = release::write(&read_formats(&sources, &[package]).0);
            let documented = entries(&text).filter_map(|entry| {
                let file = PX4.get_file(format!("{}.msg", entry.name))?.contents_utf8()?;
                Some((entry.name.to_owned(), (declarations(entry.text), file)))
            });
            documented.collect()
        })
    }
}

/// The package of a PX4 release. A message that is declared like a documented message is replaced by the documented
/// message.
fn px4_package(text: &str, label: &str, documented: &Documented, sources: &mut SourceMap) -> PackageInput {
    let mut package = PackageInput::new(Family::Px4.name(), Form::Msg(Dialect::Px4), Vec::new());
    package.ros_package = Some(PX4_ROS_PACKAGE.to_owned());
    for entry in entries(text) {
        let file = documented.get(entry.name).filter(|(known, _)| *known == declarations(entry.text));
        let path = format!("{}.{}", entry.name, entry.kind.name());
        let (path, text) = match file {
            Some((_, file)) => (format!("definitions/px4/{path}"), *file),
            None => (format!("{label}/{path}"), entry.text),
        };
        package.sources.extend(sources.add(path, text.into()));
    }
    package
}

/// The lines of a definition without annotations.
fn declarations(text: &str) -> String {
    text.lines().map(|line| line.split(" # ").next().unwrap_or(line)).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use uavspec_dynamic::Types;
    use uavspec_lint::release::LayoutHashes;

    use super::*;
    use crate::definitions::FormatClue;

    /// The clues of a log that contains all topics of a release.
    fn clues(index: &Index, label: &str) -> Clues {
        let release = index.find(label).expect("a release");
        let rows = index.rows().iter().filter(|row| row.releases.contains(release));
        let formats = rows.flat_map(|row| {
            row.topics.iter().filter_map(|topic| Some((topic.clone(), FormatClue::Layout(row.layout?))))
        });
        Clues { formats: formats.collect(), ..Clues::default() }
    }

    #[test]
    fn each_release_is_chosen_and_read() {
        let library = Library::built_in();
        for release in library.index().releases_of(Family::Px4) {
            let label = library.index().label(release);
            let clues = clues(library.index(), &label);
            let (definitions, choices) = (library.choose(&clues), library.choices(&clues));
            assert_eq!(choices.len(), 1);
            assert_eq!(library.index().label(choices[0].release), label);
            assert_eq!((choices[0].matching, choices[0].others.len()), (choices[0].known, 0), "{label}");
            let types = Types::new(&definitions.schema);
            for (topic, layout) in &clues.formats {
                let id = definitions.message_of_topic(topic).expect("a definition");
                let found = LayoutHashes::default().get(types.get(id)).map(FormatClue::Layout);
                assert_eq!(found.as_ref(), Some(layout), "{label} {topic}");
            }
        }
    }

    #[test]
    fn messages_of_other_releases_replace_those_of_the_main_release() {
        let library = Library::built_in();
        let mut clues = clues(library.index(), "px4@1.14");
        let other = super::tests::clues(library.index(), "px4@1.16").formats;
        clues.formats.insert("vehicle_status".to_owned(), other["vehicle_status"].clone());
        let (definitions, choices) = (library.choose(&clues), library.choices(&clues));
        assert_eq!(choices[0].others.keys().collect::<Vec<_>>(), ["px4_msgs/msg/VehicleStatus"]);
        let id = definitions.message_of_topic("vehicle_status").expect("a definition");
        assert_eq!(definitions.message_of_type("px4_msgs/msg/VehicleStatus"), Some(id));
        assert_eq!(definitions.message_of_type("px4/VehicleStatus"), Some(id));
        let hash = LayoutHashes::default().get(definitions.types().get(id)).map(FormatClue::Layout);
        assert_eq!(hash.as_ref(), Some(&other["vehicle_status"]));
        let again = library.choose(&clues);
        assert!(Arc::ptr_eq(&definitions, &again));
    }

    #[test]
    fn documented_messages_keep_their_documentation() {
        let library = Library::load(Path::new("px4@1.15"), None).expect("a release");
        let battery = library.base().message_of_topic("battery_status").expect("a definition");
        assert_eq!(
            library.base().line(library.base().schema.message(battery).span).file,
            "definitions/px4/BatteryStatus.msg"
        );
        let airspeed = library.base().message_of_topic("airspeed").expect("a definition");
        assert_eq!(
            library.base().line(library.base().schema.message(airspeed).span).file,
            "px4@1.15/Airspeed.msg"
        );
    }

    #[test]
    fn unknown_releases_are_named() {
        let error = Library::load(Path::new("px4@1.2"), None).expect_err("an unknown release").to_string();
        assert!(
            error.starts_with("error: unknown release `px4@1.2`\n  help: the releases are px4@1.13, "),
            "{error}"
        );
    }
}
