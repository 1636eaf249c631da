//! Whether a topic of an application works with a release of PX4.

use std::collections::{BTreeMap, BTreeSet};

use schemars::JsonSchema;
use serde::Serialize;
use uavspec_definitions::releases::old_versions;
use uavspec_px4::comparison::compare_texts;
use uavspec_rules::definitions::versioned;
use uavspec_schema::fingerprint::hashed_text;
use uavspec_schema::source::SourceId;
use uavspec_schema::{Message, Schema};

use crate::application::{Application, Use};
use crate::dds::DdsTopics;
use crate::source::{Direction, Version};

/// Whether a topic of an application works with a release.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Verdict {
    /// The verdict.
    pub verdict: Kind,
    /// The reason; empty if the topic works.
    pub reason: String,
    /// The highest number of messages that PX4 sends in a second, if PX4 limits it.
    pub rate: Option<f64>,
    /// True if PX4's topic has a different version in its name.
    #[serde(skip)]
    has_other_name: bool,
}

/// The kinds of verdicts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// The application and PX4 understand each other.
    Works,
    /// The sources that name the topic also name a version that works better.
    Unused,
    /// The application and PX4 understand each other if PX4's message translation node runs.
    Translated,
    /// The application and PX4 exchange no messages, or decode them as garbage.
    Breaks,
    /// PX4 doesn't have the topic.
    Absent,
    /// PX4 has the topic, but doesn't offer it over DDS.
    NotOffered,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 6] =
        [Self::Works, Self::Unused, Self::Translated, Self::Breaks, Self::Absent, Self::NotOffered];

    /// The verdict in a table.
    pub fn text(self) -> &'static str {
        match self {
            Self::Works => "works",
            Self::Unused => "unused",
            Self::Translated => "translated",
            Self::Breaks => "breaks",
            Self::Absent => "absent",
            Self::NotOffered => "not offered",
        }
    }

    /// True if the application doesn't work without changes.
    pub fn is_problem(self) -> bool {
        self > Self::Translated
    }
}

/// A version of PX4 with which an application is compared.
#[derive(Debug)]
pub struct Side<'s> {
    /// Its name, such as `px4@1.16`.
    pub name: String,
    /// Its messages.
    pub schema: &'s Schema,
    /// The topics that it offers over DDS, if they are known.
    pub dds: Option<DdsTopics>,
}

/// The versions of PX4's messages. The message translation node converts between the versions of a message.
#[derive(Debug, Default)]
pub struct History(BTreeSet<PastVersion>);

/// A version of a message: the name of the message, the version, the name that the message had, and PX4's hash of the
/// fields.
type PastVersion = (String, u32, String, u32);

impl History {
    /// The versions that no release contains.
    pub fn between_releases() -> Self {
        let old =
            old_versions().map(|old| (old.message.to_owned(), old.version, old.name.to_owned(), old.hash));
        Self(old.collect())
    }

    /// Adds the messages of a version of PX4.
    pub fn add(&mut self, schema: &Schema) {
        for message in &schema.messages {
            let Some(version) = message.version else { continue };
            // PX4's package `px4_msgs_old` contains earlier versions, such as `VehicleStatusV2`.
            let name = message.name.strip_suffix(&format!("V{version}")).unwrap_or(&message.name);
            self.0.insert((name.to_owned(), version, name.to_owned(), message.hash));
        }
    }

    /// True if a version of a message has this definition.
    fn contains(&self, message: &Message, version: u32, definition: &Message) -> bool {
        self.0.contains(&(message.name.clone(), version, definition.name.clone(), definition.hash))
    }
}

impl Verdict {
    fn new(verdict: Kind, reason: impl Into<String>) -> Self {
        Self { verdict, reason: reason.into(), rate: None, has_other_name: false }
    }

    fn of_use(used: &Use, own: &Schema, px4: &Side<'_>, history: &History) -> Self {
        let verdict = Self::of_type(used, own, px4.schema, history);
        let Some(dds) = px4.dds.as_ref().filter(|_| verdict.verdict != Kind::Absent) else { return verdict };
        match dds.rate(&used.topic) {
            Some(rate) => Self { rate, ..verdict },
            None => Self::new(Kind::NotOffered, "PX4 doesn't offer the topic over DDS"),
        }
    }

    fn of_type(used: &Use, own: &Schema, px4: &Schema, history: &History) -> Self {
        let topic = &used.topic.name;
        let offered = px4.messages.iter().find(|message| message.topics.contains(topic));
        let defined = used.ty.as_ref().and_then(|ty| message(own, ty));
        let (offered, defined) = match (offered, defined) {
            (Some(offered), Some(defined)) => (offered, defined),
            (Some(offered), None) => {
                let ty = used.ty.as_ref().unwrap_or(&offered.name);
                return Self::new(Kind::Breaks, format!("the application has no definition of {ty}"));
            }
            (None, _) => return Self::new(Kind::Absent, absence(used, defined, px4)),
        };
        let own_version = match used.topic.version {
            Version::Stated(version) => version,
            Version::OfDefinition => defined.version.unwrap_or(0),
        };
        let px4_version = offered.version.unwrap_or(0);
        let [own_fields, px4_fields] = [hashed_text(own, defined), hashed_text(px4, offered)];
        if (own_version, &own_fields, &defined.name) == (px4_version, &px4_fields, &offered.name) {
            return Self::new(Kind::Works, "");
        }
        let ty = &defined.name;
        if own_version != px4_version
            && history.contains(offered, own_version, defined)
            && history.contains(offered, px4_version, offered)
        {
            let reason =
                format!("the application uses version {own_version}, and PX4 uses version {px4_version}");
            return Self { has_other_name: true, ..Self::new(Kind::Translated, reason) };
        }
        if offered.name != *ty {
            let reason = format!("the type of PX4's topic is {}, not {ty}", offered.name);
            return Self::new(Kind::Breaks, reason);
        }
        let mut reasons = Vec::new();
        if own_version != px4_version {
            let [own, px4] = [own_version, px4_version].map(|version| versioned(topic, Some(version)));
            reasons.push(format!("the name of PX4's topic is `{px4}`, not `{own}`"));
        }
        if own_fields != px4_fields {
            let differences = compare_texts(&own_fields, &px4_fields).to_string();
            let order = if differences.is_empty() { "another order of fields" } else { "" };
            reasons.push(format!("the application's {ty} differs from PX4's: {differences}{order}"));
        }
        Self { has_other_name: own_version != px4_version, ..Self::new(Kind::Breaks, reasons.join("; ")) }
    }
}

/// Compares each topic of an application with each version of PX4. `own` are the definitions of the application.
pub fn compare(
    application: &Application,
    own: &Schema,
    px4: &[Side<'_>],
    history: &History,
) -> Vec<Vec<Verdict>> {
    let uses = &application.uses;
    let of_use = |used| px4.iter().map(|side| Verdict::of_use(used, own, side, history)).collect();
    let mut verdicts: Vec<Vec<Verdict>> = uses.iter().map(of_use).collect();
    for side in 0..px4.len() {
        // A source may name several versions of a topic, to work with several releases.
        let mut best: BTreeMap<((Direction, String), SourceId), Kind> = BTreeMap::new();
        for (used, verdicts) in uses.iter().zip(&verdicts) {
            for source in application.sources_of(used) {
                let kind = best.entry((used.topic.key(), source)).or_insert(Kind::Breaks);
                *kind = verdicts[side].verdict.min(*kind);
            }
        }
        for (used, verdicts) in uses.iter().zip(&mut verdicts) {
            let verdict = &mut verdicts[side];
            let is_better = |source| best[&(used.topic.key(), source)] < verdict.verdict;
            if verdict.has_other_name && application.sources_of(used).all(is_better) {
                *verdict = Verdict { rate: verdict.rate, ..Verdict::new(Kind::Unused, "") };
            }
        }
    }
    verdicts
}

/// The reason why PX4 doesn't have a topic.
fn absence(used: &Use, defined: Option<&Message>, px4: &Schema) -> String {
    let topic = &used.topic.name;
    let same = |known: &&Message| {
        defined.is_some_and(|defined| known.hash == defined.hash && known.name != defined.name)
    };
    let same: Vec<&Message> = px4.messages.iter().filter(same).collect();
    match (&used.ty, &same[..]) {
        (Some(ty), [renamed]) if message(px4, ty).is_none() => {
            format!("PX4 has neither the topic `{topic}` nor {ty}; {} has the same fields", renamed.name)
        }
        (Some(ty), _) if message(px4, ty).is_none() => {
            format!("PX4 has neither the topic `{topic}` nor {ty}")
        }
        _ => format!("PX4 has no topic `{topic}`"),
    }
}

/// The message with a name.
fn message<'s>(schema: &'s Schema, name: &str) -> Option<&'s Message> {
    schema.messages.iter().find(|message| message.name == name)
}
