//! The conversions from the releases of a capture to the target release.

use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use uavspec_definitions::PX4_HINTS;
use uavspec_dynamic::MessageType;
use uavspec_dynamic::conversion::{Conversion, Conversions, Converter, Hints, Version, read_hints};
use uavspec_model::text::terminal;
use uavspec_rules::definitions::{Definitions, Family, Library, LoadedRelease, versioned};
use uavspec_schema::fingerprint::ros_name;
use uavspec_schema::source::SourceId;
use uavspec_schema::{Failure, Message, MessageId, SourceMap};

use crate::topic_of;

/// The conversions of all messages of a capture's releases.
pub struct Plan {
    source: Arc<Definitions>,
    target: Arc<Definitions>,
    /// The family of the releases that are converted.
    family: Family,
    /// The target release. `None` if the messages keep their types.
    release: Option<LoadedRelease>,
    /// True if the user specifies the release of the capture.
    is_source_named: bool,
    /// The conversions of each package of the source, by its index.
    packages: BTreeMap<usize, Package>,
}

/// The conversions of a package.
struct Package {
    conversions: Conversions,
    /// True if the target is newer.
    is_forward: bool,
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
    pub(crate) conversion: &'p Conversion,
    pub(crate) converter: Converter<'p>,
    pub(crate) source: MessageType<'p>,
}

/// The compiled conversions of a capture. Topics with the same messages share a conversion, because a bag may have
/// 65,535 topics.
#[derive(Default)]
pub(super) struct Converters<'p> {
    /// The conversions, by the message of the capture and the two messages of the conversion. A conversion may belong
    /// to a twin of the capture's message.
    by_messages: HashMap<(MessageId, MessageId, MessageId), Rc<Converted<'p>>>,
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

/// Conversion hints, with the path of the file that contains the user's hints.
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

    /// Checks the hints. Fails if they contain a mistake, or if one of the user's hints is never used.
    fn check(&self, found: &[&Conversions], versions: &[(Version<'_>, Version<'_>)]) -> Result<(), Failure> {
        let mistakes = self.hints.mistakes.iter().chain(found.iter().flat_map(|found| &found.mistakes));
        let unused = self.hints.unused(found, versions);
        let is_own = |span| self.own == Some(self.sources.source_of(span));
        let first = mistakes.cloned().chain(unused).find(|mistake| is_own(mistake.span));
        first.map_or(Ok(()), |mistake| {
            let position = self.sources.position(mistake.span);
            let path = self.sources.path(self.sources.source_of(mistake.span));
            let place = format!("{path}:{}:{}", position.line, position.column);
            Err(Failure::new(format!("{place}: {}", mistake.message)).with_hint(mistake.help))
        })
    }
}

impl Plan {
    /// Plans the conversion of captures with the definitions `source` to a release, or without a release to the types that
    /// the capture already has. `library` contains the fingerprints of all releases. The user's hints take precedence over
    /// the published hints.
    pub fn new(
        source: Arc<Definitions>,
        library: &Library,
        to: Option<&Library>,
        hints: Option<&Path>,
    ) -> Result<Self, Failure> {
        let target = Arc::clone(to.map_or(&source, Library::base));
        let release = to.and_then(|_| target.releases().first().cloned());
        if to.is_some() && release.is_none() {
            return Err(Failure::new("the target is not a release"));
        }
        let family = release.as_ref().map_or(Family::Px4, |release| release.family);
        let hints = HintFiles::read(hints)?;
        let mut packages = BTreeMap::new();
        let mut versions = Vec::new();
        for (index, package) in source.schema.packages.iter().enumerate() {
            let ros_package = &package.ros_package;
            let twin = match to {
                Some(_) => target.schema.packages.iter().position(|twin| twin.ros_package == *ros_package),
                None => Some(index),
            };
            let first = package.messages.first().and_then(|id| source.release_of(*id));
            let (Some(twin), Some(from)) = (twin, first.filter(|from| from.family == family)) else {
                continue;
            };
            let index_of = |label: &str| library.index().find(label);
            let is_forward =
                release.as_ref().is_none_or(|release| index_of(&from.label) <= index_of(&release.label));
            let before = Version { schema: &source.schema, package: index };
            let after = Version { schema: &target.schema, package: twin };
            let pair = if is_forward { (before, after) } else { (after, before) };
            let conversions = Conversions::between(pair.0, pair.1, &hints.hints);
            versions.push(pair);
            packages.insert(index, Package { conversions, is_forward });
        }
        let found: Vec<&Conversions> = packages.values().map(|package| &package.conversions).collect();
        if !found.is_empty() {
            hints.check(&found, &versions)?;
        }
        let is_source_named = library.names_release(family);
        Ok(Self { source, target, family, release, is_source_named, packages })
    }

    /// The definitions of the capture.
    pub(super) fn source(&self) -> &Definitions {
        &self.source
    }

    /// The releases of the capture that are converted.
    pub(super) fn sources(&self) -> Vec<String> {
        let releases = self.source.releases().iter().filter(|release| release.family == self.family);
        releases.map(|release| release.label.clone()).collect()
    }

    /// The definitions of the target.
    pub(super) fn target(&self) -> &Definitions {
        &self.target
    }

    /// True if the messages keep their types.
    pub(super) fn keeps_types(&self) -> bool {
        self.release.is_none()
    }

    /// The label of the target release.
    pub(super) fn target_label(&self) -> Option<&str> {
        self.release.as_ref().map(|release| release.label.as_str())
    }

    fn target_title(&self) -> &str {
        self.release.as_ref().map_or("", |release| &release.title)
    }

    /// True if the type is part of the conversion.
    pub(super) fn concerns(&self, id: MessageId) -> bool {
        self.packages.contains_key(&self.source.schema.message(id).package)
    }

    /// True if neither the capture nor the user indicates the release of messages of this type without a schema.
    pub(super) fn is_release_unknown(&self, id: MessageId) -> bool {
        !self.is_source_named && self.source.is_undecided(id)
    }

    /// The treatment of messages that the source doesn't define. `is_other` is true if the target defines other messages for
    /// their topic or type.
    pub(super) fn undefined(&self, is_other: impl FnOnce(&Definitions) -> bool) -> Treatment<'_> {
        if self.packages.is_empty() || !is_other(&self.target) {
            return Treatment::Copy;
        }
        Treatment::LeaveOut(format!("only {} defines it", self.target_title()))
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
        let Some(Package { conversions, is_forward }) = self.packages.get(&message.package) else {
            return Treatment::Copy;
        };
        let all = if *is_forward { &conversions.forward } else { &conversions.backward };
        let target = |conversion: &Conversion| self.target.schema.message(conversion.to);
        let name = topic_of(topic);
        let has_topic = |conversion: &Conversion| target(conversion).topics.iter().any(|known| known == name);
        // A topic may have another message in the target.
        let find = |id| {
            let found = all.iter().filter(|conversion| conversion.from == id);
            found.max_by_key(|conversion| (has_topic(conversion), target(conversion).name == message.name))
        };
        let twin = || self.twin(message, name).and_then(find).filter(|found| has_topic(found));
        let Some(conversion) = find(id).or_else(twin) else { return self.without_conversion(message) };
        if let Some(reason) = self.undecided(conversion) {
            return Treatment::LeaveOut(reason);
        }
        let compile = || {
            let source = self.source.types().get(id);
            let converter = Converter::new(conversion, source, self.target.types().get(conversion.to));
            Rc::new(Converted { conversion, converter, source })
        };
        let messages = (id, conversion.from, conversion.to);
        Treatment::Convert(Rc::clone(converters.by_messages.entry(messages).or_insert_with(compile)))
    }

    /// The treatment of messages whose type has no conversion. Service events never have a conversion, but most
    /// services are the same in both releases.
    fn without_conversion(&self, message: &Message) -> Treatment<'_> {
        let name = ros_name(&self.source.schema, message);
        match self.target.message_of_type(&name).map(|id| self.target.schema.message(id)) {
            Some(twin) if twin.type_hash == message.type_hash => Treatment::Copy,
            Some(_) => Treatment::LeaveOut("its service fields differ in the target release".to_owned()),
            None => {
                Treatment::LeaveOut(format!("{} lacks the message {}", self.target_title(), message.name))
            }
        }
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
    pub(super) fn renamed(&self, topic: &str, conversion: &Conversion) -> Option<String> {
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
        let target = &self.target.schema.message(conversion.to).name;
        let (package, name) = ty.rsplit_once('/')?;
        (name != target).then(|| format!("{package}/{target}"))
    }

    /// The full ROS name and the type hash of a message of the target.
    pub(super) fn target_type(&self, id: MessageId) -> (String, &str) {
        let message = self.target.schema.message(id);
        (ros_name(&self.target.schema, message), &message.type_hash)
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
