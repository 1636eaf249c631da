//! Reads a `SQLite` file of rosbag2, and names ROS 1 bags.

use std::fs;
use std::io::{self, Read};
use std::path::Path;

use tempfile::{NamedTempFile, env};
use uavspec_codegen::stage::Stage;

use super::{BagContent, BagFile, BagSummary, Channels};
use crate::capture::rosbag::{CONVERT_ROS1, ROS1_MAGIC, SQLITE_MAGIC};
use crate::check::{CaptureResult, CheckRun, Kind, Source, Summary, has_magic};
use crate::definitions::Clues;
use crate::model::{Extent, Location};

/// The maximum size of a decompressed file, in bytes.
const MAX_UNPACKED: u64 = 16 << 30;

pub(in crate::check) const SQLITE: Kind = Kind {
    name: "rosbag2",
    detect: |start| has_magic(start, &SQLITE_MAGIC),
    clues: |source, _| super::clues::sqlite(source),
    check: |source, _, run| check_sqlite(source, run),
};

/// The bags of ROS 1, which aren't supported.
pub(in crate::check) const ROS1: Kind = Kind {
    name: "rosbag2",
    detect: |start| has_magic(start, &ROS1_MAGIC),
    clues: |_, _| Clues::default(),
    check: |_, _, _| CaptureResult::unknown(CONVERT_ROS1),
};

/// Checks the readable part of a `SQLite` file.
fn check_sqlite(mut source: Source<'_>, run: CheckRun<'_>) -> CaptureResult {
    let mut bag = Channels::new(run);
    let mut summary = BagSummary { storage: "sqlite3".to_owned(), num_files: 1, ..BagSummary::default() };
    let bytes = read_source(&mut source, &mut bag, BagFile::SINGLE, &mut summary.distribution);
    bag.finish(bytes, |BagContent { channels, dialects, releases, .. }| {
        Summary::Bag(BagSummary { channels, dialects, releases, ..summary })
    })
}

/// Checks the readable part of a `SQLite` file. Returns the size of the file.
pub(super) fn read_source(
    source: &mut Source<'_>,
    bag: &mut Channels<'_>,
    file: BagFile<'_>,
    distribution: &mut String,
) -> u64 {
    if let Some(path) = source.file {
        return read(path, &|| source.copy.iter().for_each(|copy| copy.hide()), bag, file, distribution);
    }
    let (copy, problem) = copy(source);
    if let Some((location, text)) = problem {
        bag.corruption(file.name, location, &text, Extent::Unreadable);
    }
    copy.map_or(0, |copy| read(copy.path(), &|| copy.hide(), bag, file, distribution))
}

/// A copy of a file in the folder for temporary files. If the run is killed, the next run removes the copy.
pub(in crate::check) struct CopiedFile {
    /// Dropped first: it is in the temporary folder.
    file: NamedTempFile,
    _stage: Stage,
}

impl CopiedFile {
    fn new() -> io::Result<Self> {
        let stage = Stage::new(&env::temp_dir())?;
        Ok(Self { file: stage.file(None)?, _stage: stage })
    }

    /// The path of the file, until it is dropped.
    pub(in crate::check) fn path(&self) -> &Path {
        self.file.path()
    }

    /// Removes the name of the file, which is open now. Nothing then remains if the run is killed.
    fn hide(&self) {
        // On other systems, open files can't be removed. Nobody can react to an error.
        if cfg!(unix) {
            let _ = fs::remove_file(self.path());
        }
    }
}

/// Copies a `SQLite` file, which is read in any order, to a temporary file. Also returns the problem that ended the copy.
pub(in crate::check) fn copy(source: &mut dyn Read) -> (Option<CopiedFile>, Option<(Location, String)>) {
    let unreadable = |error: io::Error| (Location::Byte(0), format!("the rest is unreadable: {error}"));
    let mut copy = match CopiedFile::new() {
        Ok(copy) => copy,
        Err(error) => return (None, Some(unreadable(error))),
    };
    if let Err(error) = io::copy(&mut source.take(MAX_UNPACKED), &mut copy.file) {
        return (Some(copy), Some(unreadable(error)));
    }
    if source.read(&mut [0]).is_ok_and(|read| read > 0) {
        let text = format!("the bag has more than {MAX_UNPACKED} bytes: decompress it first");
        return (None, Some((Location::Byte(MAX_UNPACKED), text)));
    }
    (Some(copy), None)
}

#[cfg(not(feature = "db3"))]
fn read(_: &Path, _: &dyn Fn(), bag: &mut Channels<'_>, file: BagFile<'_>, _: &mut String) -> u64 {
    let text = "this build of uavspec can't read SQLite files: build it with the feature `db3`";
    bag.corruption(file.name, Location::Byte(0), text, Extent::Unreadable);
    0
}

/// Reads a file, and calls `on_open` when it is open. Returns the size of the file.
#[cfg(feature = "db3")]
fn read(
    path: &Path,
    on_open: &dyn Fn(),
    bag: &mut Channels<'_>,
    file: BagFile<'_>,
    distribution: &mut String,
) -> u64 {
    let size = fs::metadata(path).map_or(0, |metadata| metadata.len());
    let mut reading = reading::SqliteFile::new(bag, file);
    match crate::capture::rosbag::sqlite::Bag::open(path) {
        Ok((database, problems)) => {
            on_open();
            for problem in problems {
                reading.report(Err(problem));
            }
            *distribution = database.distribution();
            reading.read(&database);
        }
        Err(problem) => reading.report(Err(problem)),
    }
    size
}

#[cfg(feature = "db3")]
mod reading {
    //! Passes the content of a file to the checks of its channels.

    use std::collections::{BTreeMap, BTreeSet, HashMap};

    use uavspec_codegen::schema::derived_from;

    use crate::capture::rosbag::sqlite::{Bag, Definition, Facts, Message, Problem, Topic};
    use crate::check::Logged;
    use crate::check::bag::clues::has_its_hash;
    use crate::check::bag::{BagFile, Channels, Declared, HASH};
    use crate::model::{Extent, Location};

    /// The types of the topics, by the type whose definition also defines them. The definition of a service or an action
    /// defines all types that ROS 2 derives from it. The flag is true if a topic of the type has no hash.
    struct TopicTypes<'t>(BTreeMap<&'t str, BTreeMap<&'t str, bool>>);

    impl<'t> TopicTypes<'t> {
        fn new(topics: &'t [Topic]) -> Self {
            let mut types = Self(BTreeMap::new());
            for Topic { ty, hash, .. } in topics {
                let origin = derived_from(ty).map(|(_, origin)| origin);
                for defined in [Some(ty.as_str()), origin].into_iter().flatten() {
                    *types.0.entry(defined).or_default().entry(ty).or_default() |= hash.is_empty();
                }
            }
            types
        }

        /// The types that a definition defines.
        fn of(&self, ty: &str) -> impl Iterator<Item = (&'t str, bool)> {
            self.0.get(ty).into_iter().flatten().map(|(ty, lacks_hash)| (*ty, *lacks_hash))
        }
    }

    /// A file that is being read.
    pub(super) struct SqliteFile<'c, 'd> {
        bag: &'c mut Channels<'d>,
        file: BagFile<'c>,
        /// The indices of the schemas.
        schemas: Facts<usize>,
        /// The indices of the channels, by the id of their topic.
        channels: HashMap<i64, usize>,
        /// The indices in `channels`.
        claimed: BTreeSet<usize>,
        /// The undeclared topics with messages, each reported once.
        undeclared: BTreeSet<i64>,
    }

    impl<'c, 'd> SqliteFile<'c, 'd> {
        pub(super) fn new(bag: &'c mut Channels<'d>, file: BagFile<'c>) -> Self {
            Self {
                bag,
                file,
                schemas: Facts::default(),
                channels: HashMap::new(),
                claimed: BTreeSet::new(),
                undeclared: BTreeSet::new(),
            }
        }

        /// Checks the readable part of the file.
        pub(super) fn read(&mut self, database: &Bag) {
            let mut topics = Vec::new();
            let result = database.topics(|topic| topics.push(topic));
            self.report(result);
            let types = TopicTypes::new(&topics);
            let result = database.definitions(|definition| {
                for (ty, lacks_hash) in types.of(&definition.ty) {
                    let is_verified = lacks_hash && has_its_hash(&definition);
                    self.definition(ty, &definition, is_verified);
                }
            });
            self.report(result);
            if topics.is_empty() && self.bag.has_gaps() {
                return;
            }
            for topic in topics {
                self.topic(topic);
            }
            let result = database.messages(|message| self.message(message));
            self.report(result);
            if !self.bag.has_gaps() {
                self.report(database.check_structure());
            }
        }

        pub(super) fn report(&mut self, result: Result<(), Problem>) {
            if let Err(Problem { text, extent }) = result {
                self.bag.corruption(self.file.name, Location::Byte(0), &text, extent);
            }
        }

        /// Adds the schema of a type. `is_verified` is true if its text has its type hash.
        fn definition(&mut self, ty: &str, definition: &Definition, is_verified: bool) {
            let Definition { encoding, text, hash, .. } = definition;
            match self.bag.schemas.add(ty.to_owned(), encoding.clone(), text.as_bytes()) {
                Ok(index) => {
                    if let Some(problem) = self.bag.schemas.problem(index) {
                        self.gap(Location::Byte(0), &format!("the schema of {ty} {problem}"));
                    }
                    self.schemas.add(ty, hash, is_verified, index);
                }
                Err(problem) => self.gap(Location::Byte(0), &format!("a schema: {problem}")),
            }
        }

        fn topic(&mut self, topic: Topic) {
            let schema = self.schemas.of(&topic).copied();
            let Topic { id, name, ty, encoding, hash } = topic;
            let location = Location::Channel(id.unsigned_abs());
            if self.channels.contains_key(&id) {
                let text = format!("topic {id} is declared again; the first declaration is used");
                return self.gap(location, &text);
            }
            // rosbag2 converts a type without a definition to an empty schema of an MCAP file.
            let schema = schema.map_or_else(|| self.bag.schemas.add(ty, "ros2msg".to_owned(), b""), Ok);
            let stated = self.file.encodings.and_then(|encodings| encodings.get(&name));
            let encoding = stated.cloned().unwrap_or(encoding);
            let declared = schema.and_then(|schema| {
                let metadata = [(HASH.to_owned(), hash)].into();
                let declared = Declared { schema: Some(schema), topic: name, encoding, metadata };
                self.bag.declare(&declared, location, &mut self.claimed)
            });
            match declared {
                Ok(channel) => _ = self.channels.insert(id, channel),
                Err(problem) => self.gap(location, &format!("topic {id}: {problem}")),
            }
        }

        fn message(&mut self, Message { topic, time, payload }: Message<'_>) {
            let location = Location::Message(self.bag.begin(Logged { time, sequence: None }));
            match (self.channels.get(&topic), payload) {
                (Some(channel), Ok(payload)) => self.bag.message(*channel, time, payload, location),
                (Some(channel), Err(problem)) => {
                    self.bag.lost(*channel);
                    self.gap(location, &problem);
                }
                (None, _) => {
                    if self.undeclared.insert(topic) {
                        self.gap(
                            location,
                            &format!("a message refers to topic {topic}, which the bag doesn't declare"),
                        );
                    }
                }
            }
        }

        fn gap(&mut self, location: Location, text: &str) {
            self.bag.corruption(self.file.name, location, text, Extent::WithGaps);
        }
    }
}

#[cfg(all(test, unix, feature = "db3"))]
mod tests {
    use rusqlite::Connection;

    use super::*;
    use crate::capture::rosbag::sqlite::Bag;

    /// A table with the columns that are read.
    const TOPICS: &str = "CREATE TABLE topics(id INTEGER, name TEXT, type TEXT, serialization_format TEXT)";

    /// A run that is killed would leave up to 16 GiB.
    #[test]
    fn a_copy_has_no_name_while_it_is_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("bag.db3");
        Connection::open(&path).expect("a database").execute_batch(TOPICS).expect("a table");
        let bytes = fs::read(path).expect("a file");
        let (copy, problem) = copy(&mut &bytes[..]);
        assert_eq!(problem, None);
        let copy = copy.expect("a copy");
        let (bag, _) = Bag::open(copy.path()).expect("a bag");
        copy.hide();
        assert!(!copy.path().exists());
        assert_eq!(bag.topics(|_| {}), Ok(()));
        let folder = copy.path().parent().expect("a folder").to_owned();
        drop(copy);
        assert!(!folder.exists());
    }
}
