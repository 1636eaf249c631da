//! Passes the content of a file to the checks of its channels.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::ops::ControlFlow;
use std::sync::Arc;

use uavspec_capture::rosbag::sqlite::{Bag, Definition, Facts, Message, Problem, Topic};
use uavspec_model::{Extent, Location};
use uavspec_rules::definitions::Shared;
use uavspec_schema::derived_from;

use crate::Logged;
use crate::bag::clues::has_its_hash;
use crate::bag::{BagFile, Channels, Declared, HASH};

/// The types of the topics, grouped by the type whose definition also defines them: the definition of a service or an
/// action defines all types that ROS 2 derives from it. The flag is true if a topic of the type has no hash.
fn types_of(topics: &[Topic]) -> BTreeMap<&str, BTreeMap<&str, bool>> {
    let mut types: BTreeMap<&str, BTreeMap<&str, bool>> = BTreeMap::new();
    for Topic { ty, hash, .. } in topics {
        let origin = derived_from(ty).map(|(_, origin)| origin);
        for defined in [Some(ty.as_str()), origin].into_iter().flatten() {
            *types.entry(defined).or_default().entry(ty).or_default() |= hash.is_empty();
        }
    }
    types
}

/// Passes the definitions of the topics' types to `take`, with the type. The flag is true if a topic of this type has no hash,
/// and the hash in the file matches the text.
pub(crate) fn definitions_of(
    database: &Bag,
    topics: &[Topic],
    shared: &Shared,
    mut take: impl FnMut(&str, &Definition, bool),
) -> Result<(), Problem> {
    let types = types_of(topics);
    database.definitions(|definition| {
        for (ty, lacks_hash) in types.get(definition.ty.as_str()).into_iter().flatten() {
            take(ty, &definition, *lacks_hash && has_its_hash(&definition, shared));
        }
    })
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
    /// The topics that have messages but no declaration. Each is reported only once.
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
        let shared = Arc::clone(&self.bag.run.definitions.shared);
        let result = definitions_of(database, &topics, &shared, |ty, definition, is_verified| {
            self.definition(ty, definition, is_verified);
        });
        self.report(result);
        if topics.is_empty() && self.bag.has_gaps() {
            return;
        }
        for topic in topics {
            self.topic(topic);
        }
        let result = database.messages(|message| {
            self.message(message);
            ControlFlow::Continue(())
        });
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

    /// Adds the schema of a type. `is_verified` is true if the type hash matches the text.
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
        let Topic { id, name, ty, encoding, hash, .. } = topic;
        let location = Location::Channel(id.unsigned_abs());
        if self.channels.contains_key(&id) {
            let text = format!("topic {id} is declared again; the first declaration is used");
            return self.gap(location, &text);
        }
        // For a type without a definition, rosbag2 writes an empty schema when it converts the file to MCAP.
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
                self.bag.open[*channel].tally.records += 1;
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
