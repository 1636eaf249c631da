//! The definitions that captures are checked against: fixed definitions, or the definitions of the release that a
//! capture matches.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock, Weak};

use uavspec_capture::ulog::{Compiled, Log};
use uavspec_definitions::{File, PX4};
use uavspec_lint::release::{self, entries};
use uavspec_model::Recent;
use uavspec_px4::event::EventMetadata;
use uavspec_schema::fingerprint::add_hashes;
use uavspec_schema::msg::Dialect;
use uavspec_schema::{Failure, Form, PackageInput, SourceMap, read_formats};

use super::choice::{Choice, Clues};
use super::index::{Family, Index, ReleaseId};
use super::{Definitions, LoadedRelease, SchemaError, Schemas, Shared, built_in_events};
use crate::limits::MAX_STORED;

/// The ROS package of PX4's messages.
pub const PX4_ROS_PACKAGE: &str = "px4_msgs";

/// The ROS package that a name denotes. The name of the PX4 family denotes the package `px4_msgs`.
pub fn ros_package(name: &str) -> &str {
    if name == Family::Px4.name() { PX4_ROS_PACKAGE } else { name }
}

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
    stored: Recent<(Key, Arc<Definitions>), MAX_STORED>,
    logs: Recent<LogChoice, MAX_STORED>,
    shared: Arc<Shared>,
}

/// The definitions that were chosen for a log, and the facts that decided.
#[derive(Debug)]
struct LogChoice {
    compiled: Weak<Compiled>,
    topics: BTreeSet<String>,
    version: Option<(u8, u8)>,
    definitions: Arc<Definitions>,
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
        let library =
            Self { shared: Arc::clone(&definitions.shared), ..Self::new(definitions.name.clone(), true) };
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
            stored: Recent::default(),
            logs: Recent::default(),
            shared: Arc::default(),
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
                self.sharing(Definitions::built_in())
            })
        })
    }

    /// Adds the data that all definitions of the library share.
    fn sharing(&self, definitions: Definitions) -> Definitions {
        Definitions {
            schemas: Arc::clone(&self.schemas),
            events: Arc::clone(&self.events),
            shared: Arc::clone(&self.shared),
            ..definitions
        }
    }

    /// The newest release of a family whose content no longer changes.
    pub fn newest(&self, family: Family) -> Arc<Definitions> {
        let index = self.index();
        let newest = index.releases_of(family).filter(|release| !index.is_moving(*release)).last();
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
        let make = || (key.clone(), Arc::new(self.read(&choices)));
        Arc::clone(&self.stored.get(|(known, _)| *known == key, make).1)
    }

    /// The data that the captures of the run share.
    pub fn shared(&self) -> &Shared {
        &self.shared
    }

    /// An empty log that shares its formats with the other logs of the run.
    pub fn log(&self) -> Log {
        Log::sharing(&self.shared.formats)
    }

    /// Chooses the definitions for a log, from its formats and subscriptions and the version of the firmware.
    pub fn choose_for_log(&self, log: &Log, version: Option<(u8, u8)>) -> Arc<Definitions> {
        let topics: BTreeSet<String> =
            log.subscriptions().map(|subscription| subscription.topic.clone()).collect();
        let is_same = |known: &LogChoice| {
            known.compiled.as_ptr() == Arc::as_ptr(log.compiled())
                && (&known.topics, known.version) == (&topics, version)
        };
        let make = || LogChoice {
            compiled: Arc::downgrade(log.compiled()),
            topics: topics.clone(),
            version,
            definitions: self.choose(&Clues::of_log(log, &topics, version)),
        };
        Arc::clone(&self.logs.get(is_same, make).definitions)
    }

    /// Reads the definitions of releases.
    fn read(&self, choices: &[Choice]) -> Definitions {
        let index = self.index();
        let mut sources = SourceMap::default();
        let (mut packages, mut replacements) = (Vec::new(), Vec::new());
        let (mut releases, mut origins) = (Vec::new(), HashMap::new());
        for choice in choices {
            for package in self.packages(choice.release, None, &mut sources) {
                origins.insert(package.name.clone(), choice.release);
                packages.push(package);
            }
            releases.push(self.loaded(choice.release));
            let mut by_release: BTreeMap<ReleaseId, BTreeSet<&str>> = BTreeMap::new();
            for (name, release) in &choice.others {
                by_release.entry(*release).or_default().insert(name);
            }
            for (release, names) in by_release {
                for mut package in self.packages(release, Some(&names), &mut sources) {
                    package.ros_package.get_or_insert_with(|| package.name.clone());
                    package.name =
                        format!("{}_{}", package.name, index.release(release).name().replace('.', "_"));
                    replacements.push(package.name.clone());
                    origins.insert(package.name.clone(), release);
                    packages.push(package);
                }
            }
        }
        // Tests ensure that the releases have no errors.
        let (mut schema, _) = read_formats(&sources, &packages);
        add_hashes(&mut schema, |package, name| {
            let release = *origins.get(&package.name)?;
            let row = index.of_name(name).find(|row| row.releases.contains(release))?;
            Some((row.hash, row.type_hash.to_owned()))
        });
        let titles: Vec<&str> =
            releases.iter().map(|release: &LoadedRelease| release.title.as_str()).collect();
        let definitions =
            Definitions::new(titles.join(", "), sources, schema).with_replacements(&replacements);
        let undecided = choices.iter().flat_map(|choice| choice.undecided.iter().cloned()).collect();
        let origins = origins.into_iter().map(|(name, release)| (name, self.loaded(release))).collect();
        self.sharing(Definitions { releases, origins, undecided, ..definitions })
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
            Some(names) => release::select(&text, names).into(),
            None => text,
        };
        match family {
            Family::Ros2 => release::packages(&text, Dialect::Ros2, &format!("{label}/"), sources),
            Family::Px4 => vec![px4_package(&text, &label, sources)],
        }
    }
}

/// The package of a PX4 release. A built-in message replaces a message with the same declarations, because it is documented.
fn px4_package(text: &str, label: &str, sources: &mut SourceMap) -> PackageInput {
    let mut package = PackageInput::new(Family::Px4.name(), Form::Msg(Dialect::Px4), Vec::new());
    package.ros_package = Some(PX4_ROS_PACKAGE.to_owned());
    for entry in entries(text) {
        let path = format!("{}.{}", entry.name, entry.kind.name());
        let built_in = PX4.get_file(&path).and_then(File::contents_utf8);
        let (path, text) =
            match built_in.filter(|built_in| declarations(built_in).eq(declarations(entry.text))) {
                Some(text) => (format!("definitions/px4/{path}"), text),
                None => (format!("{label}/{path}"), entry.text),
            };
        package.sources.extend(sources.add(path, text.into()));
    }
    package
}

/// The declarations in a definition, without spaces and comments. The topics are part of the declarations.
fn declarations(text: &str) -> impl Iterator<Item = String> {
    let lines = text.lines().map(|line| match line.strip_prefix("# TOPICS") {
        Some(topics) => topics,
        None => line.split('#').next().unwrap_or_default(),
    });
    lines.map(|line| line.split_whitespace().collect::<String>()).filter(|line| !line.is_empty())
}

#[cfg(test)]
mod tests {
    use uavspec_dynamic::Types;
    use uavspec_lint::release::LayoutHashes;
    use uavspec_schema::fingerprint::type_hash;

    use super::*;
    use crate::definitions::FormatClue;

    /// The clues of a log that contains all topics of a release.
    fn clues(index: &Index, label: &str) -> Clues {
        let release = index.find(label).expect("a release");
        let rows = index.rows().iter().filter(|row| row.releases.contains(release));
        let formats = rows.flat_map(|row| {
            row.topics.iter().filter_map(|topic| Some(((*topic).to_owned(), FormatClue::Layout(row.layout?))))
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
            for id in definitions.schema.packages.iter().flat_map(|package| &package.messages) {
                let message = definitions.schema.message(*id);
                assert_eq!(
                    message.type_hash,
                    type_hash(&definitions.schema, *id),
                    "{label} {}",
                    message.name
                );
            }
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
