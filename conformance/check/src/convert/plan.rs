//! The conversions from the definitions of a capture to the target.

use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use uavspec_definitions::PX4_HINTS;
use uavspec_dynamic::MessageType;
use uavspec_dynamic::conversion::{
    Applied, Conversion, Conversions, Converter, Hints, Mistake, Undecided, Version, read_hints,
};
use uavspec_model::text::terminal;
use uavspec_px4::memory::FieldCounts;
use uavspec_rules::definitions::{
    Definitions, Family, Library, LoadedRelease, Stated, plain_name, versioned,
};
use uavspec_schema::fingerprint::{ros_name, type_hash};
use uavspec_schema::msg::{Dialect, Kind};
use uavspec_schema::source::SourceId;
use uavspec_schema::{Failure, Form, Message, MessageId, Package, SourceMap};

use super::report::Problems;
use crate::limits::MAX_BAG_FIELDS;
use crate::{StatedType, digest, topic_of};

/// The conversions of all messages of a capture.
pub struct Plan {
    source: Arc<Definitions>,
    target: Arc<Definitions>,
    /// The target. `None` if the messages keep their types.
    to: Option<To>,
    /// True if the user specifies the definitions of the capture.
    is_source_named: bool,
    hints: HintFiles,
    /// The conversions of each package of the source, by its index.
    packages: BTreeMap<usize, Vec<Arc<Conversion>>>,
    /// The hints that these conversions use.
    applied: Applied,
}

/// The target of a conversion.
struct To {
    /// The release, such as `px4@1.16`, or the path of the definitions.
    label: String,
    /// The name in text.
    title: String,
    /// The release. `None` for definitions at a path.
    release: Option<LoadedRelease>,
}

/// The treatment of the messages of a type.
pub(crate) enum Treatment<'p> {
    /// The messages are copied, because their type isn't part of the conversion.
    Copy,
    /// The messages are left out, because they have no counterpart, or because the definitions don't determine their
    /// conversion; contains the reason.
    LeaveOut(String),
    /// The messages are converted.
    Convert(Rc<Converted<'p>>),
}

/// The conversion of the messages of a type.
pub(crate) struct Converted<'p> {
    pub(crate) conversion: Arc<Conversion>,
    pub(crate) converter: Converter<'p>,
    source: SourceType<'p>,
}

/// The type of the messages before the conversion.
enum SourceType<'p> {
    /// A type in the definitions of the capture.
    Defined(MessageType<'p>),
    /// The type in a schema of the capture.
    Stated(Arc<Stated>),
}

impl Converted<'_> {
    /// The type of the messages before the conversion.
    pub(crate) fn source(&self) -> MessageType<'_> {
        match &self.source {
            SourceType::Defined(ty) => *ty,
            SourceType::Stated(stated) => stated.root(),
        }
    }
}

/// The compiled conversions of a capture. Topics with the same messages share a conversion, because a bag may have
/// 65,535 topics.
#[derive(Default)]
pub(super) struct Converters<'p> {
    /// The conversions, by the message of the capture and the two messages of the conversion. A conversion may belong
    /// to a twin of the capture's message.
    by_messages: HashMap<(MessageId, MessageId, MessageId), Rc<Converted<'p>>>,
    /// The conversions from types in schemas, or the reasons why there is none, by the digest of the schema.
    by_schema: HashMap<u64, Result<Rc<Converted<'p>>, String>>,
    /// The number of fields in these types.
    num_fields: usize,
    /// The hints that these conversions use, and the mistakes in them.
    applied: Applied,
    mistakes: Vec<Mistake>,
}

/// True if two messages have the same fields and constants.
fn is_declared_alike(one: &Message, other: &Message) -> bool {
    let fields = |message: &Message| -> Vec<_> {
        message.fields.iter().map(|field| (field.name.clone(), field.ty)).collect()
    };
    let constants = |message: &Message| -> Vec<_> {
        message.constants.iter().map(|known| (known.name.clone(), known.value.clone())).collect()
    };
    fields(one) == fields(other) && constants(one) == constants(other)
}

/// Conversion hints, and the file that contains the user's hints.
struct HintFiles {
    sources: SourceMap,
    hints: Hints,
    own: Option<SourceId>,
}

impl HintFiles {
    fn read(path: Option<&Path>) -> Result<Self, Failure> {
        let mut sources = SourceMap::default();
        let mut hints = Hints::default();
        // Tests ensure that the published hints contain no mistakes.
        if let Ok(id) = sources.add("definitions/hints/px4.toml", PX4_HINTS.as_bytes().to_vec()) {
            hints = read_hints(&sources, id);
        }
        let Some(path) = path else { return Ok(Self { sources, hints, own: None }) };
        let name = terminal::path(path);
        let text = fs::read(path).map_err(|error| Failure::new(format!("{name}: {error}")))?;
        let id = sources
            .add(name.clone(), text)
            .map_err(|diagnostic| Failure::new(format!("{name}: {}", diagnostic.problem)))?;
        let own = read_hints(&sources, id);
        Ok(Self { hints: hints.with(own), sources, own: Some(id) })
    }

    /// Fails if one of these mistakes is in the user's hints.
    fn check<'m>(&self, mistakes: impl IntoIterator<Item = &'m Mistake>) -> Result<(), Failure> {
        let first = mistakes.into_iter().find(|mistake| self.is_own(mistake));
        first.map_or(Ok(()), |mistake| {
            let message = format!("{}: {}", self.place(mistake), mistake.message);
            Err(Failure::new(message).with_hint(&mistake.help))
        })
    }

    /// True if a mistake is in the user's hints.
    fn is_own(&self, mistake: &Mistake) -> bool {
        self.own == Some(self.sources.source_of(mistake.span))
    }

    /// The location of a mistake.
    fn place(&self, mistake: &Mistake) -> String {
        let position = self.sources.position(mistake.span);
        let path = self.sources.path(self.sources.source_of(mistake.span));
        format!("{path}:{}:{}", position.line, position.column)
    }

    /// The conversions from a package to another. `is_forward` is true if the other package is newer. If this is unknown, a
    /// hint describes the change to the other package, unless it only applies in the opposite direction. Adds the hints that
    /// are used, and the mistakes in them.
    fn conversions(
        &self,
        from: Version<'_>,
        to: Version<'_>,
        is_forward: Option<bool>,
        applied: &mut Applied,
        mistakes: &mut Vec<Mistake>,
    ) -> Vec<Arc<Conversion>> {
        let mut between = |old, new| {
            let found = Conversions::between(old, new, &self.hints);
            applied.merge(&found.applied);
            found
        };
        if is_forward == Some(false) {
            let mut found = between(to, from);
            mistakes.append(&mut found.mistakes);
            return found.backward;
        }
        let Conversions { forward: mut found, mistakes: added, .. } = between(from, to);
        mistakes.extend(added);
        let is_open = |conversion: &Arc<Conversion>| conversion.uses_hints || !conversion.is_decided();
        if is_forward.is_some() || (self.own.is_none() && !found.iter().any(is_open)) {
            return found;
        }
        // In this direction, hints may only seem to contain mistakes.
        let reversed = between(to, from);
        let plain = Conversions::between(from, to, &Hints::default());
        for conversion in &mut found {
            let ids = (conversion.from, conversion.to);
            if type_hash(from.schema, ids.0) == type_hash(to.schema, ids.1) {
                // Equal types need no hints.
                if let Some(plain) = plain.find(ids.0, ids.1, true) {
                    *conversion = Arc::clone(plain);
                }
                continue;
            }
            let Some(other) = reversed.find(ids.0, ids.1, false).filter(|other| other.uses_hints) else {
                continue;
            };
            if !conversion.uses_hints {
                *conversion = Arc::clone(other);
            } else if format!("{:?}", conversion.steps) != format!("{:?}", other.steps) {
                let message = "the hints apply in both directions, with different results".to_owned();
                let help = "remove the hints for the direction that isn't needed".to_owned();
                let span = to.schema.message(ids.1).span;
                Arc::make_mut(conversion).undecided.push(Undecided { span, old: None, message, help });
            }
        }
        let is_new = |other: &Arc<Conversion>| {
            !found.iter().any(|known| (known.from, known.to) == (other.from, other.to))
        };
        let added: Vec<_> = reversed.backward.into_iter().filter(is_new).collect();
        found.extend(added);
        found
    }
}

impl To {
    fn new(library: &Library, target: &Definitions) -> Self {
        let release = target.releases().first().cloned();
        let label = release.as_ref().map_or_else(|| library.name(), |release| &release.label).to_owned();
        let title = release.as_ref().map_or_else(|| library.name(), |release| &release.title).to_owned();
        Self { label, title, release }
    }

    /// The family of the releases that are converted. Messages that keep their types are PX4 messages.
    fn family(to: Option<&Self>) -> Family {
        to.and_then(|to| to.release.as_ref()).map_or(Family::Px4, |release| release.family)
    }
}

impl Plan {
    /// Plans the conversion of captures with the definitions `source` to the definitions `to`, or without `to` to the types
    /// that the capture already has. `library` contains the fingerprints of all releases. The user's hints take precedence
    /// over the published hints.
    pub fn new(
        source: Arc<Definitions>,
        library: &Library,
        to: Option<&Library>,
        hints: Option<&Path>,
    ) -> Result<Self, Failure> {
        let target = Arc::clone(to.map_or(&source, Library::base));
        let to = to.map(|library| To::new(library, &target));
        let hints = HintFiles::read(hints)?;
        hints.check(&hints.hints.mistakes)?;
        let mut plan = Self {
            is_source_named: source.is_given || library.names_release(To::family(to.as_ref())),
            source,
            target,
            to,
            hints,
            packages: BTreeMap::new(),
            applied: Applied::default(),
        };
        plan.check_packages()?;
        plan.add_packages(library)?;
        if !plan.converts_schemas() {
            let unused = plan.unused_hints(&Applied::default());
            plan.hints.check(&unused)?;
        }
        Ok(plan)
    }

    /// Fails if the target contains several versions of a package.
    fn check_packages(&self) -> Result<(), Failure> {
        let defined = self.target.schema.packages.iter().filter(|package| self.target.defines(package));
        let mut known: BTreeMap<&str, &str> = BTreeMap::new();
        for package in defined.filter(|_| self.to.as_ref().is_some_and(|to| to.release.is_none())) {
            if let Some(other) = known.insert(&package.ros_package, &package.name) {
                let Package { name, ros_package, .. } = package;
                let message =
                    format!("`{other}` and `{name}` are both versions of the package `{ros_package}`");
                return Err(Failure::new(message).with_hint("specify the path of one version"));
            }
        }
        Ok(())
    }

    /// Adds the conversions of all packages. Fails if the user's hints contain a mistake.
    fn add_packages(&mut self, library: &Library) -> Result<(), Failure> {
        let (source, target) = (Arc::clone(&self.source), Arc::clone(&self.target));
        for (index, package) in source.schema.packages.iter().enumerate() {
            let release = package.messages.first().and_then(|id| source.release_of(*id));
            let is_converted = match release {
                Some(release) => self.converts(release.family),
                None => source.is_given && source.defines(package),
            };
            let twin = match &self.to {
                Some(_) => self.target_package(&package.ros_package),
                None => Some(index),
            };
            let Some(twin) = twin.filter(|_| is_converted) else { continue };
            let newer = self.to.as_ref().and_then(|to| to.release.as_ref());
            let order = release.zip(newer).map(|(old, new)| {
                let index_of = |release: &LoadedRelease| library.index().find(&release.label);
                index_of(old) <= index_of(new)
            });
            let before = Version { schema: &source.schema, package: index };
            let after = Version { schema: &target.schema, package: twin };
            let mut mistakes = Vec::new();
            let found = self.hints.conversions(before, after, order, &mut self.applied, &mut mistakes);
            self.hints.check(&mistakes)?;
            self.packages.insert(index, found);
        }
        Ok(())
    }

    /// True if messages of the releases of this family are converted.
    fn converts(&self, family: Family) -> bool {
        match &self.to {
            Some(To { release: None, .. }) => true,
            to => To::family(to.as_ref()) == family,
        }
    }

    /// The package of the target that corresponds to a package of the capture. Packages that only provide nested messages
    /// don't count.
    fn target_package(&self, ros_package: &str) -> Option<usize> {
        let find = |name: &str| {
            let is_found = |package: &Package| package.ros_package == name && self.target.defines(package);
            self.target.schema.packages.iter().position(is_found)
        };
        self.hints.hints.counterparts(ros_package).find_map(find)
    }

    /// True if schemas of a capture may describe the messages before the conversion. In PX4's definitions, comments
    /// contain units and values, so a schema without comments doesn't determine a conversion.
    fn converts_schemas(&self) -> bool {
        let is_ros =
            |package: &Package| package.form == Form::Msg(Dialect::Ros2) && self.target.defines(package);
        self.to.is_some() && self.target.schema.packages.iter().any(is_ros)
    }

    /// Fails if the user's hints contain a mistake that a finished run detected. Notes the hints that it never used, because
    /// another bag may need them.
    pub(super) fn check_hints(
        &self,
        converters: &Converters<'_>,
        problems: &mut Problems,
    ) -> Result<(), Failure> {
        self.hints.check(&converters.mistakes)?;
        if self.converts_schemas() {
            let unused = self.unused_hints(&converters.applied);
            for mistake in unused.iter().filter(|mistake| self.hints.is_own(mistake)) {
                problems.note(&format!("{}: this hint isn't used", self.hints.place(mistake)));
            }
        }
        Ok(())
    }

    /// The hints that neither the releases nor the schemas of a capture need. `applied` contains the hints that the schemas
    /// need.
    fn unused_hints(&self, applied: &Applied) -> Vec<Mistake> {
        if self.packages.is_empty() && !self.converts_schemas() {
            return Vec::new();
        }
        let mut all = self.applied.clone();
        all.merge(applied);
        let version = |schema, package| Version { schema, package };
        let versions = self.packages.keys().filter_map(|at| {
            let package = &self.source.schema.packages[*at];
            let twin = self.target_package(&package.ros_package)?;
            Some((version(&self.source.schema, *at), version(&self.target.schema, twin)))
        });
        self.hints.hints.unused(&all, &versions.collect::<Vec<_>>())
    }

    /// The definitions of the capture.
    pub(super) fn source(&self) -> &Definitions {
        &self.source
    }

    /// The releases of the capture that are converted, or the path of its definitions.
    pub(super) fn sources(&self) -> Vec<String> {
        if self.source.is_given {
            return vec![self.source.name.clone()];
        }
        let releases = self.source.releases().iter().filter(|release| self.converts(release.family));
        releases.map(|release| release.label.clone()).collect()
    }

    /// The definitions of the target.
    pub(super) fn target(&self) -> &Definitions {
        &self.target
    }

    /// True if the messages keep their types.
    pub(super) fn keeps_types(&self) -> bool {
        self.to.is_none()
    }

    /// The target release, or the path of the target's definitions.
    pub(super) fn target_label(&self) -> Option<&str> {
        self.to.as_ref().map(|to| to.label.as_str())
    }

    fn target_title(&self) -> &str {
        self.to.as_ref().map_or("", |to| &to.title)
    }

    /// True if the type is part of the conversion.
    pub(super) fn concerns(&self, id: MessageId) -> bool {
        self.packages.contains_key(&self.source.schema.message(id).package)
    }

    /// True if neither the capture nor the user indicates the release of messages of this type without a schema.
    pub(super) fn is_release_unknown(&self, id: MessageId) -> bool {
        !self.is_source_named && self.source.is_undecided(id)
    }

    /// The treatment of messages that the source doesn't define. `stated` compares their type with the definition of their
    /// topic or type in the target. It returns `None` if the target defines neither.
    pub(super) fn undefined(&self, stated: impl FnOnce(&Definitions) -> Option<StatedType>) -> Treatment<'_> {
        if self.packages.is_empty() && !self.converts_schemas() {
            return Treatment::Copy;
        }
        match stated(&self.target) {
            Some(StatedType::Other) => {
                Treatment::LeaveOut(format!("only {} defines it", self.target_title()))
            }
            Some(StatedType::Unknown) if self.converts_schemas() => Treatment::LeaveOut(
                "the capture doesn't contain its definition; specify the definitions with --from".to_owned(),
            ),
            _ => Treatment::Copy,
        }
    }

    /// The treatment of messages whose fields differ from the definition of their type.
    pub(super) fn differs(&self, id: MessageId) -> Treatment<'_> {
        if self.keeps_types() {
            return Treatment::Copy;
        }
        let release = self.source.release_of(id).map_or("", |release| &release.title);
        Treatment::LeaveOut(format!("its fields differ from {release}"))
    }

    /// The treatment of messages of an unknown release.
    pub(super) fn unknown_release() -> Treatment<'static> {
        let reason = "there is no usable schema or type hash, and the size of the messages doesn't identify their \
                      release; specify it with --from";
        Treatment::LeaveOut(reason.to_owned())
    }

    /// The treatment of the messages of a type, on a topic. `converters` contains the conversions of the other topics.
    pub(super) fn treatment<'p>(
        &'p self,
        id: MessageId,
        topic: &str,
        converters: &mut Converters<'p>,
    ) -> Treatment<'p> {
        let message = self.source.schema.message(id);
        let Some(all) = self.packages.get(&message.package) else { return Treatment::Copy };
        let target = |conversion: &Conversion| self.target.schema.message(conversion.to);
        let name = topic_of(topic);
        let has_topic =
            |conversion: &Arc<Conversion>| target(conversion).topics.iter().any(|known| known == name);
        // A topic may have another message in the target.
        let find = |id| {
            let found = all.iter().filter(|conversion| conversion.from == id);
            found.max_by_key(|conversion| (has_topic(conversion), target(conversion).name == message.name))
        };
        let twin = || self.twin(message, name).and_then(find).filter(|found| has_topic(found));
        let Some(conversion) = find(id).or_else(twin) else {
            return Treatment::LeaveOut(self.lacks(&message.name));
        };
        if let Some(reason) = self.undecided(conversion) {
            return Treatment::LeaveOut(reason);
        }
        let compile = || {
            let source = self.source.types().get(id);
            let converter = Converter::new(conversion, source, self.target.types().get(conversion.to));
            let conversion = Arc::clone(conversion);
            Rc::new(Converted { conversion, converter, source: SourceType::Defined(source) })
        };
        let messages = (id, conversion.from, conversion.to);
        Treatment::Convert(Rc::clone(converters.by_messages.entry(messages).or_insert_with(compile)))
    }

    /// The treatment of messages whose type is in this schema of the capture. `None` if the type isn't part of the
    /// conversion.
    pub(super) fn of_schema<'p>(
        &'p self,
        (name, text): (&str, &[u8]),
        converters: &mut Converters<'p>,
    ) -> Option<Treatment<'p>> {
        let name = &plain_name(name);
        let (ros_package, _) = name.split_once('/').filter(|_| self.to.is_some())?;
        let package = self.target_package(ros_package)?;
        let twin = &self.target.schema.packages[package];
        // An empty text is an empty message, or an unknown definition.
        let is_empty = || {
            let found = self.target.message_of_type(&name.replacen(ros_package, &twin.ros_package, 1));
            found.is_some_and(|id| self.target.schema.message(id).fields.is_empty())
        };
        if twin.form != Form::Msg(Dialect::Ros2) || text.is_empty() && !is_empty() {
            return None;
        }
        let digest = digest(&(name, text));
        if !converters.by_schema.contains_key(&digest) {
            let found = self.compile_schema((name, text), package, converters);
            converters.by_schema.insert(digest, found);
        }
        Some(match converters.by_schema.get(&digest)? {
            Ok(converted) => Treatment::Convert(Rc::clone(converted)),
            Err(reason) => Treatment::LeaveOut(reason.clone()),
        })
    }

    /// Compiles the conversion from the type in a schema to a package of the target. The error is the reason why there is
    /// none.
    fn compile_schema<'p>(
        &'p self,
        (name, text): (&str, &[u8]),
        package: usize,
        converters: &mut Converters<'p>,
    ) -> Result<Rc<Converted<'p>>, String> {
        let stated = self.source.shared.stated(name, text);
        let stated = stated.map_err(|problem| format!("its schema is invalid: {problem}"))?;
        let is_message = stated.schema.message(stated.id).kind == Kind::Message;
        if is_message && ["/srv/", "/action/"].iter().any(|folder| name.contains(folder)) {
            return Err("its schema doesn't contain the text of its service or action".to_owned());
        }
        let num_fields = FieldCounts::default().of(stated.root());
        if num_fields > MAX_BAG_FIELDS - converters.num_fields {
            return Err(format!("the types of the schemas have more than {MAX_BAG_FIELDS} fields"));
        }
        converters.num_fields += num_fields;
        let message = stated.schema.message(stated.id);
        let before = Version { schema: &stated.schema, package: message.package };
        let after = Version { schema: &self.target.schema, package };
        let Converters { applied, mistakes, .. } = converters;
        let found = self.hints.conversions(before, after, None, applied, mistakes);
        let target = |conversion: &Conversion| self.target.schema.message(conversion.to);
        let is_same = |conversion: &&Arc<Conversion>| {
            (&target(conversion).name, target(conversion).kind) == (&message.name, message.kind)
        };
        // Messages with similar fields may be unrelated, so only a hint renames a message.
        let all = || found.iter().filter(|conversion| conversion.from == stated.id);
        let is_hinted =
            |conversion: &&Arc<Conversion>| self.hints.hints.renames(&message.name, &target(conversion).name);
        let conversion = all().find(is_same).or_else(|| all().find(is_hinted));
        let Some(conversion) = conversion else {
            let similar = all().next().map(|other| target(other).name.as_str());
            let similar = similar.map(|name| format!("; if {name} replaces it, write a hint"));
            return Err(self.lacks(&message.name) + &similar.unwrap_or_default());
        };
        if let Some(reason) = self.undecided(conversion) {
            return Err(reason);
        }
        let converter = Converter::new(conversion, stated.root(), self.target.types().get(conversion.to));
        let conversion = Arc::clone(conversion);
        Ok(Rc::new(Converted { conversion, converter, source: SourceType::Stated(stated) }))
    }

    /// The reason to leave out messages that the target lacks.
    fn lacks(&self, name: &str) -> String {
        format!("{} lacks the message {name}", self.target_title())
    }

    /// Finds a message of the source that has the same declaration as `message`, and the name of the topic's message in
    /// the target. Releases before PX4 1.14 repeat a message for each of its topics.
    fn twin(&self, message: &Message, topic: &str) -> Option<MessageId> {
        let target = self.target.schema.message(self.target.message_of_topic(topic)?);
        let all = &self.source.schema.packages.get(message.package)?.messages;
        all.iter().copied().find(|id| {
            let other = self.source.schema.message(*id);
            other.name == target.name && is_declared_alike(message, other)
        })
    }

    /// The reason why a conversion can't be used.
    fn undecided(&self, conversion: &Conversion) -> Option<String> {
        if conversion.is_decided() {
            return None;
        }
        let more = conversion.undecided.len().saturating_sub(1);
        let more = if more > 0 { format!(" (and {more} more)") } else { String::new() };
        let own = conversion.undecided.first().map(|found| format!("{}{more}", found.message));
        let nested = || {
            let name = conversion.blocked_by.map(|id| self.target.schema.message(id).name.as_str());
            format!("the conversion of the nested message {} is undecided", name.unwrap_or_default())
        };
        Some(format!("undecided: {}", own.unwrap_or_else(nested)))
    }

    /// The name of a topic in the output, if it changes. The names of PX4's topics for ROS 2 end with the version of
    /// the message.
    pub(super) fn renamed(&self, topic: &str, converted: &Converted<'_>) -> Option<String> {
        let SourceType::Defined(_) = converted.source else { return None };
        let conversion = &converted.conversion;
        let source = self.source.schema.message(conversion.from);
        let target = self.target.schema.message(conversion.to);
        let name = topic_of(topic);
        let (before, after) = (source.version.unwrap_or(0), target.version.unwrap_or(0));
        let is_versioned = before != after && topic.contains("/fmu/");
        let unversioned = match before {
            1.. if is_versioned => name.strip_suffix(&format!("_v{before}"))?,
            _ => name,
        };
        let renamed = self.counterpart(unversioned, source, target);
        let renamed = versioned(renamed, is_versioned.then_some(after));
        let start = topic.rfind(name).filter(|_| renamed != name)?;
        Some([&topic[..start], &renamed, &topic[start + name.len()..]].concat())
    }

    /// The name of a topic in the target. If a message has only one topic, the topic is renamed with the message,
    /// unless both releases have this topic, or the source also has the new topic. All other topics keep their names,
    /// because the definitions don't indicate which of several topics replaces another.
    fn counterpart<'t>(&self, topic: &'t str, source: &Message, target: &'t Message) -> &'t str {
        let is_renamed = source.name != target.name && source.topics == [topic];
        let is_known = target.topics.iter().any(|known| known == topic);
        let new = target.topics.first().filter(|_| is_renamed && !is_known);
        new.filter(|new| self.source.message_of_topic(new).is_none()).map_or(topic, String::as_str)
    }

    /// The name of a type in the output, if it changes. The notation stays the same.
    pub(super) fn renamed_type(&self, ty: &str, conversion: &Conversion) -> Option<String> {
        let target = self.target.schema.message(conversion.to);
        let source = &self.source.schema.package_of(self.source.schema.message(conversion.from)).ros_package;
        let (package, _) = ty.rsplit_once('/')?;
        let package = match package.split_once('/').unwrap_or((package, "")) {
            (own, rest) if own == source => {
                let separator = if rest.is_empty() { "" } else { "/" };
                format!("{}{separator}{rest}", self.target.schema.package_of(target).ros_package)
            }
            _ => package.to_owned(),
        };
        Some(format!("{package}/{}", target.name)).filter(|renamed| renamed != ty)
    }

    /// The full ROS name and the type hash of a message of the target, as captures contain them.
    pub(super) fn target_type(&self, id: MessageId) -> (String, String) {
        let message = self.target.schema.message(id);
        (ros_name(&self.target.schema, message), self.target.captured_hash(message))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn topics_with_the_same_messages_share_a_conversion() {
        let release = Library::release("px4@1.16").expect("a release");
        let plan = Plan::new(Arc::clone(release.base()), &Library::built_in(), Some(&release), None);
        let plan = plan.expect("a plan");
        let mut converters = Converters::default();
        let mut conversion = |name: &str, topic: &str| {
            let id = plan.source().message_of_topic(name).expect("a message");
            match plan.treatment(id, topic, &mut converters) {
                Treatment::Convert(converted) => converted,
                Treatment::Copy | Treatment::LeaveOut(_) => panic!("{name} isn't converted"),
            }
        };
        let [first, second] =
            ["/fmu/out/cpuload", "/vehicle_1/fmu/out/cpuload"].map(|topic| conversion("cpuload", topic));
        let other = conversion("vehicle_attitude", "/fmu/out/vehicle_attitude");
        assert!(Rc::ptr_eq(&first, &second) && !Rc::ptr_eq(&first, &other));
        assert_eq!(converters.by_messages.len(), 2);
    }
}
