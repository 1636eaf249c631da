//! Chooses the release that a capture matches.

use std::collections::{BTreeMap, BTreeSet};

use uavspec_capture::ulog::Log;
use uavspec_dynamic::MessageType;
use uavspec_lint::release::LayoutHashes;
use uavspec_model::json::Tree;
use uavspec_px4::json::count_differences;

use super::index::{Family, Index, ReleaseId, ReleaseSet, Row};

/// The facts in a capture that indicate its release.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Clues {
    /// The formats in a log or of JSON messages, by topic.
    pub formats: BTreeMap<String, FormatClue>,
    /// The types in a bag or of JSON messages, by full ROS name.
    pub types: BTreeMap<String, TypeClue>,
    /// The versions in the names of PX4's ROS topics, by the full ROS name of the type, or by topic if the type isn't
    /// stated. Includes topics that only have subscribers.
    pub topic_versions: BTreeMap<String, BTreeSet<u32>>,
    /// The firmware's version, as two numbers.
    pub version: Option<(u8, u8)>,
    /// The ROS distribution in a bag, such as `humble`.
    pub distribution: Option<String>,
}

impl Clues {
    /// The facts about a log: the formats of its topics, and the version of the firmware. A log that ends early may have no
    /// topics; then all formats count.
    pub(super) fn of_log(log: &Log, topics: &BTreeSet<String>, version: Option<(u8, u8)>) -> Self {
        let mut layouts = LayoutHashes::default();
        let is_topic = |format: &MessageType<'_>| topics.is_empty() || topics.contains(format.name());
        let formats =
            log.types().iter().filter(is_topic).filter_map(|format| {
                Some((format.name().to_owned(), FormatClue::Layout(layouts.get(format)?)))
            });
        Self { formats: formats.collect(), version, ..Self::default() }
    }
}

/// The format of a topic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FormatClue {
    /// The hash of the layout in memory.
    Layout(u64),
    /// A message in JSON. Not all types of its fields are known.
    Json(JsonClue),
}

impl FormatClue {
    fn agrees(&self, row: &Row) -> bool {
        match self {
            Self::Layout(hash) => row.layout == Some(*hash),
            Self::Json(message) => row.keys == Some(message.keys),
        }
    }
}

/// The facts in a JSON message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JsonClue {
    /// The hash of the keys.
    pub keys: u64,
    /// The text of the message; empty if it is too long to store.
    pub text: String,
    /// The version in the name of the topic, if PX4 exchanges the topic with applications.
    pub version: Option<u32>,
}

/// The facts about a type.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TypeClue {
    /// The type hash: stated, or calculated from the schema in the bag.
    pub type_hash: Option<String>,
    /// The size of a CDR payload.
    pub size: Option<u64>,
    /// A message in JSON.
    pub json: Option<JsonClue>,
    /// The versions in the names of the PX4 topics that carry messages of this type.
    pub versions: BTreeSet<u32>,
}

/// The release that a capture agrees with best.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Choice {
    pub(crate) release: ReleaseId,
    /// The number of topics or types that match the release.
    pub(crate) matching: usize,
    /// The number of topics or types that some release of the family defines.
    pub(crate) known: usize,
    /// The types of other releases that the capture agrees with, by full ROS name.
    pub(crate) others: BTreeMap<String, ReleaseId>,
    /// The types without a known hash whose size agrees with no definition, or with several definitions of releases
    /// that agree equally well.
    pub(crate) undecided: BTreeSet<String>,
}

impl Choice {
    /// A release that was chosen without looking at a capture.
    pub(crate) fn without_clues(release: ReleaseId) -> Self {
        Self { release, matching: 0, known: 0, others: BTreeMap::new(), undecided: BTreeSet::new() }
    }
}

/// The releases that agree with a topic or type of a capture.
struct Match<'c> {
    /// The full ROS name of the definition; for a topic without a match, its name.
    name: &'c str,
    agreeing: ReleaseSet,
    /// The releases in which a JSON message has the same keys. The lengths of arrays and the values of one message
    /// indicate the release less reliably.
    by_keys: ReleaseSet,
    /// True if the capture doesn't indicate which of several definitions is meant.
    is_undecided: bool,
    /// For each definition whose size agrees, the releases that contain it. `None` if the messages have a hash or are
    /// JSON.
    by_size: Option<Vec<ReleaseSet>>,
}

impl Match<'_> {
    /// True if only the size of the messages is known, and it doesn't show which definition in these releases is meant.
    fn is_ambiguous(&self, releases: ReleaseSet) -> bool {
        let Some(definitions) = &self.by_size else { return false };
        let in_releases = definitions.iter().filter(|found| !found.intersection(releases).is_empty()).count();
        // The definition of another release may be the only one with this size.
        if in_releases > 0 { in_releases > 1 } else { definitions.len() != 1 }
    }
}

impl Index {
    /// Chooses the release of a family that a capture matches best. `None` if the capture has no topic or type of the
    /// family, or if no release agrees with it. `forced` is the release that the user requests.
    pub(crate) fn choose(&self, clues: &Clues, family: Family, forced: Option<ReleaseId>) -> Option<Choice> {
        let own = self.all_of(family);
        let matches = self.matches(clues, own);
        let has_row = |name: &String| self.named(name).any(|row| row.is_in(own));
        if matches.is_empty() && !clues.topic_versions.keys().any(has_row) {
            return None;
        }
        let count = |release: ReleaseId| {
            matches.iter().filter(|found| !found.is_undecided && found.agreeing.contains(release)).count()
        };
        let agreement = |release: ReleaseId| (count(release), self.count_versions(clues, release));
        let rank = |release: &ReleaseId| {
            let is_stated = self.is_stated(*release, clues);
            (agreement(*release), is_stated, !self.is_moving(*release), *release)
        };
        let has_sizes = matches.iter().any(|found| found.by_size.is_some());
        let release = match forced {
            Some(release) => release,
            None => self
                .releases_of(family)
                .max_by_key(rank)
                .filter(|release| has_sizes || agreement(*release) > (0, 0))?,
        };
        let is_equal = |other: &ReleaseId| {
            *other == release || forced.is_none() && agreement(*other) == agreement(release)
        };
        let equal = if self.is_stated(release, clues) {
            ReleaseSet::default().with(release)
        } else {
            self.preferred(family, release, is_equal)
        };
        let mut choice = Choice { known: matches.len(), ..Choice::without_clues(release) };
        for found in &matches {
            if found.is_ambiguous(equal) {
                choice.undecided.insert(found.name.to_owned());
            }
            if found.agreeing.contains(release) || found.by_keys.contains(release) {
                choice.matching += 1;
            } else if let (Some(other), None) = (nearest(found.agreeing, release), forced) {
                choice.others.insert(found.name.to_owned(), other);
            }
        }
        Some(choice)
    }

    /// Compares the clues with the definitions of these releases.
    fn matches<'c>(&'c self, clues: &'c Clues, own: ReleaseSet) -> Vec<Match<'c>> {
        let mut matches = Vec::new();
        for (topic, format) in &clues.formats {
            let mut rows = self.of_topic(topic).filter(|row| row.is_in(own)).peekable();
            if rows.peek().is_none() {
                continue;
            }
            let equal: Vec<_> = rows.filter(|row| format.agrees(row)).collect();
            let message = if let FormatClue::Json(message) = format { Some(message) } else { None };
            let (equal, by_keys) = self.closest(equal, message);
            let agreeing = releases(&equal);
            let name = equal.first().map_or(topic.as_str(), |row| row.name);
            let is_undecided = matches!(format, FormatClue::Json(_)) && definitions(&equal).len() > 1;
            matches.push(Match { name, agreeing, by_keys, is_undecided, by_size: None });
        }
        for (name, clue) in &clues.types {
            let rows: Vec<_> = self.of_name(name).filter(|row| row.is_in(own)).collect();
            if rows.is_empty() {
                continue;
            }
            let has_version = |row: &&Row| {
                clue.versions.is_empty() || clue.versions.len() == 1 && clue.versions.contains(&row.version)
            };
            let agrees = |row: &&Row| match (&clue.type_hash, &clue.json, clue.size, row.cdr_size) {
                (Some(hash), ..) => *hash == row.type_hash,
                (None, Some(message), ..) => row.keys == Some(message.keys),
                _ if !has_version(row) => false,
                // Some writers pad payloads to a multiple of four bytes.
                (None, None, Some(size), Some(expected)) => {
                    size == expected || size == expected.next_multiple_of(4)
                }
                _ => true,
            };
            let equal: Vec<_> = rows.into_iter().filter(agrees).collect();
            let message = clue.json.as_ref().filter(|_| clue.type_hash.is_none());
            let (equal, by_keys) = self.closest(equal, message);
            let agreeing = releases(&equal);
            let definitions = definitions(&equal);
            let is_undecided = clue.type_hash.is_none() && definitions.len() > 1;
            let is_by_size = clue.type_hash.is_none() && clue.json.is_none() && clue.size.is_some();
            let by_size = is_by_size.then_some(definitions);
            matches.push(Match { name, agreeing, by_keys, is_undecided, by_size });
        }
        matches
    }

    /// The definitions among `rows` that are closest to a JSON message, and the releases whose messages have the same
    /// keys. All `rows` have these keys, so these are their releases. Without a message, returns all `rows` and no
    /// releases.
    fn closest<'i>(&self, rows: Vec<&'i Row>, message: Option<&JsonClue>) -> (Vec<&'i Row>, ReleaseSet) {
        let Some(message) = message else { return (rows, ReleaseSet::default()) };
        let by_keys = releases(&rows);
        if definitions(&rows).len() < 2 { (rows, by_keys) } else { (self.narrowed(rows, message), by_keys) }
    }

    /// The definitions among `rows` with the fewest differences from a JSON message. If several definitions remain, the
    /// version in the name of the topic decides.
    fn narrowed<'i>(&self, rows: Vec<&'i Row>, message: &JsonClue) -> Vec<&'i Row> {
        let rows = match Tree::read(&message.text) {
            Ok(tree) => self.least_different(rows, &tree),
            Err(_) => rows,
        };
        let has_version = |row: &&Row| Some(row.version) == message.version;
        let versioned = rows.iter().copied().filter(has_version);
        let versioned: BTreeSet<&str> = versioned.map(|row| row.type_hash).collect();
        if versioned.is_empty() {
            return rows;
        }
        rows.into_iter().filter(|row| versioned.contains(row.type_hash)).collect()
    }

    /// The definitions among `rows` with the fewest differences from a JSON message.
    fn least_different<'i>(&self, rows: Vec<&'i Row>, message: &Tree<'_>) -> Vec<&'i Row> {
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        for row in rows.iter().copied() {
            let count = || {
                let found = self.definition(row);
                found.map_or(usize::MAX, |found| count_differences(message, found.types.get(found.id)))
            };
            counts.entry(row.type_hash).or_insert_with(count);
        }
        let min = counts.values().min();
        rows.into_iter().filter(|row| counts.get(row.type_hash) == min).collect()
    }

    /// The number of types whose version in this release is a version in the names of their topics.
    fn count_versions(&self, clues: &Clues, release: ReleaseId) -> usize {
        let has_version = |name: &str, versions: &BTreeSet<u32>| {
            self.named(name).any(|row| row.releases.contains(release) && versions.contains(&row.version))
        };
        clues.topic_versions.iter().filter(|(name, versions)| has_version(name, versions)).count()
    }

    /// The releases that agree with a capture as well as `release`. Releases whose content still changes are left out
    /// if the topics rule out a fixed release and `release` is fixed.
    fn preferred(
        &self,
        family: Family,
        release: ReleaseId,
        is_equal: impl Fn(&ReleaseId) -> bool,
    ) -> ReleaseSet {
        let is_fixed = |release: &ReleaseId| !self.is_moving(*release);
        let is_narrowed = self.releases_of(family).filter(is_fixed).any(|other| !is_equal(&other));
        let is_preferred = |other: &ReleaseId| is_fixed(other) || !is_narrowed || !is_fixed(&release);
        let equal = self.releases_of(family).filter(is_equal).filter(is_preferred);
        equal.fold(ReleaseSet::default(), ReleaseSet::with)
    }

    /// True if a capture contains the name of this release: the version of the firmware, or the ROS distribution.
    fn is_stated(&self, release: ReleaseId, clues: &Clues) -> bool {
        let name = self.release(release).name();
        match self.family(release) {
            Family::Px4 => clues.version.is_some_and(|(major, minor)| name == format!("{major}.{minor}")),
            Family::Ros2 => clues.distribution.as_deref() == Some(name),
        }
    }
}

/// All releases of these definitions.
fn releases(rows: &[&Row]) -> ReleaseSet {
    rows.iter().fold(ReleaseSet::default(), |set, row| set.union(row.releases))
}

/// The releases of each definition. A definition has several rows if only its version differs.
fn definitions(rows: &[&Row]) -> Vec<ReleaseSet> {
    let mut found: BTreeMap<&str, ReleaseSet> = BTreeMap::new();
    for row in rows {
        let releases = found.entry(row.type_hash).or_default();
        *releases = releases.union(row.releases);
    }
    found.into_values().collect()
}

/// The release of a set that is nearest to another release; the newer one if two are equally near.
fn nearest(set: ReleaseSet, release: ReleaseId) -> Option<ReleaseId> {
    let newer = set.iter().find(|other| *other > release);
    let older = set.iter().rev().find(|other| *other < release);
    match (older, newer) {
        (Some(older), Some(newer)) if release.distance(older) < newer.distance(release) => Some(older),
        (older, newer) => newer.or(older),
    }
}

#[cfg(test)]
mod tests {
    use uavspec_schema::{Element, Shape};

    use super::*;

    fn layout(index: &Index, topic: &str, release: &str) -> FormatClue {
        let release = index.find(release).expect("a release");
        let row = index.of_topic(topic).find(|row| row.releases.contains(release)).expect("a topic");
        FormatClue::Layout(row.layout.expect("a layout"))
    }

    fn clues(index: &Index, topics: &[(&str, &str)]) -> Clues {
        let formats =
            topics.iter().map(|(topic, release)| ((*topic).to_owned(), layout(index, topic, release)));
        Clues { formats: formats.collect(), ..Clues::default() }
    }

    fn chosen(index: &Index, clues: &Clues) -> Option<(String, usize, usize, Vec<String>)> {
        let choice = index.choose(clues, Family::Px4, None)?;
        let others =
            choice.others.iter().map(|(name, release)| format!("{name} {}", index.label(*release))).collect();
        Some((index.label(choice.release), choice.matching, choice.known, others))
    }

    #[test]
    fn most_formats_decide() {
        let index = Index::built_in();
        let topics =
            [("vehicle_status", "px4@1.14"), ("battery_status", "px4@1.14"), ("failsafe_flags", "px4@1.16")];
        let mut clues = clues(index, &topics);
        clues.formats.insert("winch".to_owned(), FormatClue::Layout(7));
        clues.formats.insert("airspeed".to_owned(), FormatClue::Layout(7));
        clues.version = Some((1, 16));
        let others = vec!["px4_msgs/msg/FailsafeFlags px4@1.16".to_owned()];
        assert_eq!(chosen(index, &clues), Some(("px4@1.14".to_owned(), 2, 4, others)));
    }

    #[test]
    fn the_version_decides_between_equal_releases() {
        let index = Index::built_in();
        // All releases define this message in the same way.
        let mut clues = clues(index, &[("cpuload", "px4@1.13")]);
        let release = |clues: &Clues| chosen(index, clues).expect("a release").0;
        let newest = release(&clues);
        assert!(newest != "px4@main" && newest != "px4@1.14", "{newest}");
        clues.version = Some((1, 14));
        assert_eq!(release(&clues), "px4@1.14");
        clues.version = Some((1, 2));
        assert_eq!(release(&clues), newest);
    }

    #[test]
    fn captures_without_matches_have_no_release() {
        let index = Index::built_in();
        let other = |topic: &str| Clues {
            formats: [(topic.to_owned(), FormatClue::Layout(7))].into(),
            ..Clues::default()
        };
        assert_eq!(chosen(index, &other("winch")), None);
        assert_eq!(chosen(index, &other("vehicle_status")), None);
        let forced = index.find("px4@1.15");
        let choice = index.choose(&other("vehicle_status"), Family::Px4, forced).expect("a choice");
        assert_eq!((Some(choice.release), choice.matching, choice.known), (forced, 0, 1));
    }

    #[test]
    fn sizes_decide_if_there_are_no_hashes() {
        let index = Index::built_in();
        let release = index.find("px4@1.15").expect("a release");
        let row = index.of_name("px4_msgs/msg/VehicleStatus").find(|row| row.releases.contains(release));
        let name = "px4_msgs/msg/VehicleStatus".to_owned();
        let clue = |size| TypeClue { size, ..TypeClue::default() };
        let clues = |size| Clues { types: [(name.clone(), clue(size))].into(), ..Clues::default() };
        let sized = index.choose(&clues(row.expect("a row").cdr_size), Family::Px4, None).expect("a release");
        assert!(row.expect("a row").releases.contains(sized.release));
        assert_eq!(index.choose(&clues(None), Family::Px4, None), None);
    }

    #[test]
    fn sizes_of_several_definitions_are_undecided() {
        let index = Index::built_in();
        let name = |message: &str| format!("px4_msgs/msg/{message}");
        let clues = |sizes: &[(&str, u64)]| {
            let clue = |size| TypeClue { size: Some(size), ..TypeClue::default() };
            let types = sizes.iter().map(|(message, size)| (name(message), clue(*size)));
            index.choose(&Clues { types: types.collect(), ..Clues::default() }, Family::Px4, None)
        };
        // PX4 1.14 and 1.15 have different failsafe flags of the same size.
        let alone = clues(&[("FailsafeFlags", 89)]).expect("a release");
        assert_eq!(alone.undecided, [name("FailsafeFlags")].into());
        // Only PX4 1.15 has a VehicleStatus of this size.
        let decided = clues(&[("FailsafeFlags", 89), ("VehicleStatus", 86)]).expect("a release");
        assert_eq!((index.label(decided.release), decided.undecided.len()), ("px4@1.15".to_owned(), 0));
        // No release has a VehicleStatus of this size.
        let unknown = clues(&[("VehicleStatus", 86), ("CpuLoad", 7), ("Cpuload", 7)]).expect("a release");
        assert_eq!(unknown.undecided, [name("Cpuload")].into());
    }

    /// The clues come from a vehicle that reports no hashes, and whose DDS pads messages to a multiple of four bytes.
    #[test]
    fn other_topics_decide_between_definitions_of_the_same_size() {
        let index = Index::built_in();
        let clue = |size, version: Option<u32>| TypeClue {
            size: Some(size),
            versions: version.into_iter().collect(),
            ..TypeClue::default()
        };
        let choose = |types: &[(&str, u64, Option<u32>)]| {
            let name = |message: &str| format!("px4_msgs/msg/{message}");
            let versions =
                types.iter().filter_map(|(message, _, version)| Some((name(message), [(*version)?].into())));
            let clues = Clues {
                types: types
                    .iter()
                    .map(|(message, size, version)| (name(message), clue(*size, *version)))
                    .collect(),
                topic_versions: versions.collect(),
                ..Clues::default()
            };
            let choice = index.choose(&clues, Family::Px4, None).expect("a release");
            (index.label(choice.release), choice.undecided.len())
        };
        let (flags, status, battery) =
            (("FailsafeFlags", 100, None), ("VehicleStatus", 88, Some(4)), ("BatteryStatus", 180, Some(1)));
        assert_eq!(choose(&[flags, status, battery]), ("px4@1.18".to_owned(), 0));
        assert_eq!(choose(&[flags, battery]), ("px4@1.18".to_owned(), 0));
        // PX4 1.18 and the main branch have flags of this size, and no topic shows which of the two applies.
        assert_eq!(choose(&[flags, ("Cpuload", 20, None)]).1, 1);
        // No release with this status has flags of this size.
        assert_eq!(choose(&[("FailsafeFlags", 89, None), status]).1, 1);
    }

    #[test]
    fn a_stated_distribution_is_believed_unless_the_content_disagrees() {
        let index = Index::built_in();
        let name = "sensor_msgs/msg/Range";
        let hash = |label: &str| {
            let release = index.find(label).expect("a release");
            index
                .of_name(name)
                .find(|row| row.releases.contains(release))
                .expect("a type")
                .type_hash
                .to_owned()
        };
        let choose = |distribution: Option<&str>, type_hash: Option<String>| {
            let clue = TypeClue { type_hash, size: Some(60), ..TypeClue::default() };
            let time = TypeClue { size: Some(12), ..TypeClue::default() };
            let clues = Clues {
                types: [(name.to_owned(), clue), ("builtin_interfaces/msg/Time".to_owned(), time)].into(),
                distribution: distribution.map(str::to_owned),
                ..Clues::default()
            };
            let choice = index.choose(&clues, Family::Ros2, None).expect("a release");
            (index.label(choice.release), choice.undecided.len())
        };
        let jazzy = "ros2@jazzy".to_owned();
        assert_eq!(choose(None, None), (jazzy.clone(), 1));
        assert_eq!(choose(Some("humble"), None), ("ros2@humble".to_owned(), 0));
        assert_eq!(choose(Some("rolling"), None), ("ros2@rolling".to_owned(), 0));
        assert_eq!(choose(Some("foxy"), None), (jazzy.clone(), 1));
        assert_eq!(choose(Some("humble"), Some(hash("ros2@jazzy"))), (jazzy, 0));
    }

    #[test]
    fn versions_of_topics_decide() {
        let index = Index::built_in();
        let name = "px4_msgs/msg/BatteryStatus".to_owned();
        let choose = |versions: &[u32], topic_versions: &[u32]| {
            let clue = TypeClue {
                size: Some(180),
                versions: versions.iter().copied().collect(),
                ..TypeClue::default()
            };
            let topic_versions = [(name.clone(), topic_versions.iter().copied().collect())];
            let clues = Clues {
                types: [(name.clone(), clue)].into(),
                topic_versions: topic_versions.into(),
                ..Clues::default()
            };
            let choice = index.choose(&clues, Family::Px4, None).expect("a release");
            (index.label(choice.release), choice.undecided.len())
        };
        // PX4 1.15 and 1.17 have different messages of the same size.
        assert_eq!(choose(&[], &[]).1, 1);
        assert_eq!(choose(&[0], &[0]), ("px4@1.15".to_owned(), 0));
        assert_eq!(choose(&[1], &[1]), ("px4@1.18".to_owned(), 0));
        assert_eq!(choose(&[7], &[7]).1, 1);
        // A subscriber of another version doesn't change the meaning of the messages.
        assert_eq!(choose(&[0], &[0, 1]), ("px4@1.15".to_owned(), 0));
        // The messages on two topics may have different types.
        assert_eq!(choose(&[0, 1], &[0, 1]).1, 1);
    }

    #[test]
    fn lengths_and_versions_decide_between_json_messages() {
        let index = Index::built_in();
        // Until PX4 1.17, the message has eight servos.
        let row = index.of_topic("actuator_servos").next().expect("a topic");
        let choose = |servos: usize, version: Option<u32>| {
            let control = vec!["0"; servos].join(",");
            let text = match servos {
                0 => String::new(),
                _ => format!(r#"{{"timestamp":1,"timestamp_sample":1,"control":[{control}]}}"#),
            };
            let clue = JsonClue { keys: row.keys.expect("keys"), text, version };
            let formats = [("actuator_servos".to_owned(), FormatClue::Json(clue))].into();
            let choice = index.choose(&Clues { formats, ..Clues::default() }, Family::Px4, None);
            choice.map(|choice| index.label(choice.release))
        };
        for (servos, version, expected) in [
            (8, None, Some("px4@1.17")),
            (8, Some(1), Some("px4@1.17")),
            (15, None, Some("px4@1.18")),
            // The lengths of both definitions differ.
            (7, Some(0), Some("px4@1.17")),
            (7, None, None),
            // The text isn't stored.
            (0, Some(0), Some("px4@1.17")),
            (0, Some(1), Some("px4@1.18")),
            (0, Some(9), None),
        ] {
            assert_eq!(choose(servos, version).as_deref(), expected, "{servos} {version:?}");
        }
    }

    /// If a JSON message fits several definitions, the newest one applies. It accepts older messages only if its
    /// integers have the widest ranges.
    #[test]
    fn the_newest_of_similar_definitions_accepts_messages_of_older_ones() {
        let index = Index::built_in();
        let newest = |row: &Row| row.releases.iter().next_back().expect("a release");
        let mut compared = 0;
        for older in index.rows() {
            let is_newer = |row: &&Row| {
                row.keys.is_some()
                    && row.keys == older.keys
                    && row.type_hash != older.type_hash
                    && newest(row) > newest(older)
            };
            for newer in index.of_name(older.name).filter(is_newer) {
                let [old, new] = [older, newer].map(|row| index.definition(row).expect("a definition"));
                let (old, new) = (old.types.get(old.id), new.types.get(new.id));
                let count = |message: &serde_json::Value| {
                    let text = message.to_string();
                    count_differences(&Tree::read(&text).expect("JSON"), new)
                };
                let mut message = old.default().to_json().expect("a message");
                if count(&message) > 0 {
                    continue;
                }
                for field in old.fields().iter().filter(|field| field.shape == Shape::Single) {
                    if let Element::Scalar(scalar) = field.element
                        && let Some((_, high)) = scalar.integer_bounds()
                    {
                        message[&*field.name] = u64::try_from(high).expect("a number").into();
                    }
                }
                assert_eq!(count(&message), 0, "{}: {message}", older.name);
                compared += 1;
            }
        }
        assert!(compared > 3, "{compared}");
    }

    #[test]
    fn subscribers_show_a_release() {
        let index = Index::built_in();
        let choose = |name: &str, version: u32| {
            let topic_versions = [(name.to_owned(), [version].into())].into();
            let choice = index.choose(&Clues { topic_versions, ..Clues::default() }, Family::Px4, None);
            choice.map(|choice| index.label(choice.release))
        };
        assert_eq!(choose("px4_msgs/msg/ArmingCheckRequest", 0), Some("px4@1.16".to_owned()));
        assert_eq!(choose("arming_check_request", 0), Some("px4@1.16".to_owned()));
        assert_eq!(choose("px4_msgs/msg/ArmingCheckRequest", 99), None);
        assert_eq!(choose("std_msgs/msg/String", 0), None);
    }
}
