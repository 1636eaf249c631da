//! The fingerprints of the definitions in all releases.

use std::collections::{BTreeSet, HashMap};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use uavspec_definitions::releases::{FINGERPRINTS, Release, releases};
use uavspec_dynamic::Types;
use uavspec_lint::release;
use uavspec_lint::release::age;
use uavspec_schema::fingerprint::ros_name;
use uavspec_schema::msg::Dialect;
use uavspec_schema::{MessageId, Schema, SourceMap, read};

/// The names of releases whose content still changes.
const MOVING: [&str; 2] = ["main", "rolling"];

/// A family of releases.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Family {
    /// PX4.
    Px4,
    /// The common interfaces of ROS 2.
    Ros2,
}

impl Family {
    /// All families.
    pub const ALL: [Self; 2] = [Self::Px4, Self::Ros2];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Px4 => "px4",
            Self::Ros2 => "ros2",
        }
    }

    /// The name in sentences.
    pub fn title(self) -> &'static str {
        match self {
            Self::Px4 => "PX4",
            Self::Ros2 => "ROS 2",
        }
    }

    /// The dialect of the definitions.
    pub fn dialect(self) -> Dialect {
        match self {
            Self::Px4 => Dialect::Px4,
            Self::Ros2 => Dialect::Ros2,
        }
    }

    fn of(release: Release) -> Option<Self> {
        Self::ALL.into_iter().find(|family| family.name() == release.family())
    }
}

/// A release, as an index into `Index::releases`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ReleaseId(u8);

impl ReleaseId {
    /// The number of releases from one to the other.
    pub(crate) fn distance(self, other: Self) -> u8 {
        self.0.abs_diff(other.0)
    }
}

/// A set of releases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReleaseSet(u64);

impl ReleaseSet {
    pub fn contains(self, release: ReleaseId) -> bool {
        self.0 & 1 << release.0 != 0
    }

    pub(crate) fn is_empty(self) -> bool {
        self.0 == 0
    }

    pub(crate) fn with(self, release: ReleaseId) -> Self {
        Self(self.0 | 1 << release.0)
    }

    pub(crate) fn intersection(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    pub(crate) fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// The releases from the oldest to the newest.
    pub fn iter(self) -> impl DoubleEndedIterator<Item = ReleaseId> {
        (0..64).map(ReleaseId).filter(move |release| self.contains(*release))
    }
}

/// A definition that one or more releases contain.
#[derive(Clone, Debug)]
pub struct Row {
    /// The full ROS name: `px4_msgs/msg/BatteryStatus`.
    pub name: &'static str,
    /// The releases that contain it.
    pub releases: ReleaseSet,
    /// The topics (PX4).
    pub topics: Vec<&'static str>,
    /// The hash of the layout in memory.
    pub(crate) layout: Option<u64>,
    /// The size in CDR, if it is fixed.
    pub(crate) cdr_size: Option<u64>,
    /// The hash of the keys in JSON.
    pub(crate) keys: Option<u64>,
    /// PX4's hash of the fields.
    pub hash: u32,
    /// The ROS type hash.
    pub type_hash: &'static str,
    /// The version of the message, which PX4 appends to the topic if it isn't 0.
    pub(crate) version: u32,
}

impl Row {
    /// The topics.
    pub fn owned_topics(&self) -> Vec<String> {
        self.topics.iter().map(|topic| (*topic).to_owned()).collect()
    }

    /// True if one of these releases contains the definition.
    pub(crate) fn is_in(&self, releases: ReleaseSet) -> bool {
        !self.releases.intersection(releases).is_empty()
    }
}

/// The fingerprints of the definitions in all releases, with lookup tables.
#[derive(Debug)]
pub struct Index {
    /// The releases by family, from the oldest to the newest.
    releases: Vec<(Family, Release)>,
    rows: Vec<Row>,
    /// The indices of the rows, by topic.
    by_topic: HashMap<&'static str, Vec<usize>>,
    /// The indices of the rows, by name.
    by_name: HashMap<&'static str, Vec<usize>>,
    /// The definitions that were read, by type hash. They are stored, because reading a release takes milliseconds.
    read: Mutex<HashMap<&'static str, Option<Arc<ReadDefinition>>>>,
}

/// A definition of a release.
#[derive(Debug)]
pub(crate) struct ReadDefinition {
    /// The type of the definition, and the types that it contains.
    pub(crate) types: Types,
    /// The type.
    pub(crate) id: MessageId,
}

impl Index {
    /// The built-in fingerprints, read when they are first needed.
    pub(crate) fn built_in() -> &'static Self {
        static INDEX: LazyLock<Index> = LazyLock::new(|| Index::read(FINGERPRINTS));
        &INDEX
    }

    fn read(text: &'static str) -> Self {
        let known = releases().filter_map(|release| Some((Family::of(release)?, release)));
        let mut releases: Vec<(Family, Release)> = known.collect();
        releases.sort_by_cached_key(|(family, release)| (*family, age(release.name())));
        let ids: HashMap<String, ReleaseId> = (0..)
            .zip(&releases)
            .map(|(id, (family, release))| (format!("{}@{}", family.name(), release.name()), ReleaseId(id)))
            .collect();
        // The first line is the heading.
        let rows: Vec<Row> = text.lines().skip(1).filter_map(|line| row(line, &ids)).collect();
        let (mut by_topic, mut by_name) = (HashMap::<_, Vec<usize>>::new(), HashMap::<_, Vec<usize>>::new());
        for (at, row) in rows.iter().enumerate() {
            by_name.entry(row.name).or_default().push(at);
            for topic in &row.topics {
                by_topic.entry(*topic).or_default().push(at);
            }
        }
        Self { releases, rows, by_topic, by_name, read: Mutex::default() }
    }

    /// All releases by family, from the oldest to the newest.
    pub fn releases(&self) -> impl Iterator<Item = ReleaseId> {
        (0..).map(ReleaseId).take(self.releases.len())
    }

    /// The releases of a family, from the oldest to the newest.
    pub fn releases_of(&self, family: Family) -> impl Iterator<Item = ReleaseId> {
        self.releases().filter(move |release| self.family(*release) == family)
    }

    /// The set of all releases of a family.
    pub(crate) fn all_of(&self, family: Family) -> ReleaseSet {
        self.releases_of(family).fold(ReleaseSet::default(), ReleaseSet::with)
    }

    /// The release with a name such as `px4@1.16`.
    pub fn find(&self, name: &str) -> Option<ReleaseId> {
        self.releases().find(|release| self.label(*release) == name)
    }

    pub fn family(&self, release: ReleaseId) -> Family {
        self.releases[usize::from(release.0)].0
    }

    /// The definitions of a release.
    pub fn release(&self, release: ReleaseId) -> Release {
        self.releases[usize::from(release.0)].1
    }

    /// The name on the command line: `px4@1.16`.
    pub fn label(&self, release: ReleaseId) -> String {
        format!("{}@{}", self.family(release).name(), self.release(release).name())
    }

    /// The name in sentences: `PX4 1.16`.
    pub(crate) fn title(&self, release: ReleaseId) -> String {
        format!("{} {}", self.family(release).title(), self.release(release).name())
    }

    /// True if the content of the release still changes, as on the main branch.
    pub fn is_moving(&self, release: ReleaseId) -> bool {
        MOVING.contains(&self.release(release).name())
    }

    /// The definitions of a topic.
    pub(crate) fn of_topic(&self, topic: &str) -> impl Iterator<Item = &Row> {
        self.by_topic.get(topic).into_iter().flatten().map(|at| &self.rows[*at])
    }

    /// The definitions with a full ROS name.
    pub fn of_name(&self, name: &str) -> impl Iterator<Item = &Row> {
        self.by_name.get(name).into_iter().flatten().map(|at| &self.rows[*at])
    }

    /// The definitions with a full ROS name, or the definitions of a topic. Only ROS names contain a slash.
    pub(crate) fn named(&self, name: &str) -> impl Iterator<Item = &Row> {
        self.of_name(name).chain(self.of_topic(name))
    }

    /// Reads a definition from the newest release that contains it.
    pub(crate) fn definition(&self, row: &Row) -> Option<Arc<ReadDefinition>> {
        let mut read = self.read.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = read.get(row.type_hash) {
            return found.clone();
        }
        let found = row.releases.iter().next_back().and_then(|release| {
            let text = self.release(release).text();
            let (schema, id) = read_definition(text, row.name, self.family(release).dialect())?;
            Some(Arc::new(ReadDefinition { types: Types::new(&schema), id }))
        });
        read.insert(row.type_hash, found.clone());
        found
    }

    /// All definitions, by name.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }
}

/// Reads a line of the table.
fn row(line: &'static str, ids: &HashMap<String, ReleaseId>) -> Option<Row> {
    let mut columns = line.split('\t');
    let mut next = || columns.next();
    let (name, releases, topics) = (next()?, next()?, next()?);
    let (layout, cdr_size, keys, hash, type_hash) = (next()?, next()?, next()?, next()?, next()?);
    let version = next()?.parse().ok()?;
    let releases = releases.split(' ').filter_map(|label| ids.get(label));
    Some(Row {
        name,
        releases: releases.fold(ReleaseSet::default(), |set, release| set.with(*release)),
        topics: topics.split_whitespace().collect(),
        layout: u64::from_str_radix(layout, 16).ok(),
        cdr_size: cdr_size.parse().ok(),
        keys: u64::from_str_radix(keys, 16).ok(),
        hash: u32::from_str_radix(hash, 16).ok()?,
        type_hash,
        version,
    })
}

/// The text of the definitions in the newest ROS 2 release whose content no longer changes.
pub fn newest_ros2() -> &'static str {
    let index = Index::built_in();
    let newest = index.releases_of(Family::Ros2).filter(|release| !index.is_moving(*release)).last();
    newest.map(|release| index.release(release).text()).unwrap_or_default()
}

/// Reads the definition with a full ROS name, and its nested definitions, from the text of a release.
pub fn read_schema(text: &str, name: &str, dialect: Dialect) -> Schema {
    let text = release::select(text, &BTreeSet::from([name]));
    let mut sources = SourceMap::default();
    let packages = release::packages(&text, dialect, "", &mut sources);
    read(&sources, &packages).0
}

/// Reads the definition with a full ROS name from the text of a release.
pub(super) fn read_definition(text: &str, name: &str, dialect: Dialect) -> Option<(Schema, MessageId)> {
    let schema = read_schema(text, name, dialect);
    let messages = schema.packages.iter().flat_map(|package| &package.messages);
    let id = messages.copied().find(|id| ros_name(&schema, schema.message(*id)) == name)?;
    Some((schema, id))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_definition_has_releases() {
        let index = Index::built_in();
        let labels: Vec<String> = index.releases().map(|release| index.label(release)).collect();
        assert_eq!(labels[..2], ["px4@1.13", "px4@1.14"]);
        assert!(labels.contains(&"ros2@jazzy".to_owned()), "{labels:?}");
        assert_eq!(index.find("px4@main").map(|main| index.title(main)), Some("PX4 main".to_owned()));
        assert_eq!(index.find("px4@0"), None);
        assert_eq!(index.rows().len(), FINGERPRINTS.lines().count() - 1);
        for row in index.rows() {
            assert!(!row.releases.is_empty() && row.type_hash.starts_with("RIHS01_"), "{row:?}");
        }
        let distinct = index.of_topic("vehicle_status").count();
        assert!(distinct > 3, "{distinct}");
        assert_eq!(index.of_name("px4_msgs/msg/VehicleStatus").count(), distinct);
    }
}
