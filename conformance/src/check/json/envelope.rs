//! What stands around a message and says what it is.

use std::borrow::Cow;
use std::collections::HashMap;
use std::fmt;

use serde::Deserializer as _;
use serde::de::{DeserializeSeed, Error, IgnoredAny, MapAccess, Visitor};
use uavspec_codegen::schema::MessageId;

use crate::json::Tree;
use crate::px4::json::{Clean, MessageSeed, Plans};

/// The operations of rosbridge that may name the type of a topic.
const ADVERTISE: &str = "advertise";
const SUBSCRIBE: &str = "subscribe";

/// How a message says what it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Which {
    /// `{"type": "px4/FailsafeFlags", "message": {…}}`.
    Type,
    /// rosbridge: `{"op": "publish", "topic": "/fmu/out/failsafe_flags", "msg": {…}}`.
    Topic,
}

impl Which {
    /// The key of the message.
    pub(super) const fn key(self) -> &'static str {
        match self {
            Self::Type => "message",
            Self::Topic => "msg",
        }
    }
}

/// A topic or type that was met.
#[derive(Debug)]
pub(super) struct Open {
    /// What findings call it.
    pub(super) name: String,
    /// The definition, and the number of the channel.
    pub(super) defined: Option<(MessageId, usize)>,
    /// The key of its messages, where they have something around them.
    pub(super) key: Option<&'static str>,
    pub(super) messages: u64,
    /// How many bytes its messages take in memory, where a rule wants their values; otherwise none.
    pub(super) kept: usize,
    /// Where it was met first.
    pub(super) line: u64,
}

/// All that were met.
#[derive(Debug)]
pub(super) struct Channels {
    /// The one that all values belong to, where that was said.
    pub(super) only: Option<usize>,
    pub(super) open: Vec<Open>,
    pub(super) by_type: HashMap<String, usize>,
    pub(super) by_topic: HashMap<String, usize>,
}

impl Channels {
    pub(super) fn get(&self, which: Which, name: &str) -> Option<usize> {
        match which {
            Which::Type => self.by_type.get(name).copied(),
            Which::Topic => self.by_topic.get(name).copied(),
        }
    }

    pub(super) fn insert(&mut self, which: Which, name: &str, open: Open) {
        let names = match which {
            Which::Type => &mut self.by_type,
            Which::Topic => &mut self.by_topic,
        };
        names.insert(name.to_owned(), self.open.len());
        self.open.push(open);
    }
}

/// What a value is, from its tree.
pub(super) enum Form<'t> {
    Message(Which, &'t str, &'t Tree<'t>),
    /// rosbridge says which type a topic has.
    Advertised(&'t str, &'t str),
    /// rosbridge says something else.
    Skipped,
    /// It can't be said, and why.
    Unknown(&'static str),
}

/// Looks for what says what a value is.
pub(super) fn form<'t>(tree: &'t Tree<'t>) -> Form<'t> {
    let Tree::Object(members) = tree else {
        return Form::Unknown("it is no object, so nothing says what message it is");
    };
    let is_repeated = |key: &&str| members.iter().filter(|(known, _)| known == key).count() > 1;
    if ["op", "topic", "msg", "type", "message"].iter().any(is_repeated) {
        return Form::Unknown("a key that says what message it is stands twice");
    }
    let text = |key| tree.get(key).and_then(Tree::as_str);
    if tree.get("op").is_some() {
        return match (text("op"), text("topic"), tree.get("msg")) {
            (Some("publish"), Some(topic), Some(message)) => Form::Message(Which::Topic, topic, message),
            (Some("publish"), ..) => Form::Unknown("rosbridge's `publish` without `topic` or `msg`"),
            (Some(ADVERTISE | SUBSCRIBE), Some(topic), _) => {
                text("type").map_or(Form::Skipped, |ty| Form::Advertised(topic, ty))
            }
            (Some(_), ..) => Form::Skipped,
            (None, ..) => Form::Unknown("`op` is no string"),
        };
    }
    match (text("type"), tree.get("message")) {
        (Some(ty), Some(message)) => Form::Message(Which::Type, ty, message),
        _ => Form::Unknown(
            "nothing says what message it is: expected `type` and `message`, or rosbridge's `op`, `topic` and \
             `msg`; or say it with --type",
        ),
    }
}

/// What a value is, read once.
pub(super) enum Fast {
    /// A message of this channel with which nothing is wrong.
    Clean(usize, Clean),
    Skipped,
    /// A message without a definition.
    Undefined,
    /// Something is wrong, or its channel is new.
    Unclear,
}

/// Reads a value without a tree. `values` gets what the message says, where its channel wants that.
pub(super) fn read(text: &str, channels: &Channels, plans: &Plans, values: &mut Vec<u8>) -> Fast {
    let mut reader = serde_json::Deserializer::from_str(text);
    values.clear();
    let fast = match channels.only.and_then(|at| Some((at, channels.open[at].defined?))) {
        Some((at, (id, _))) => {
            values.resize(channels.open[at].kept, 0);
            let seed = MessageSeed::new(plans, id, false, values);
            seed.deserialize(&mut reader).map(|clean| Fast::Clean(at, clean))
        }
        None => reader.deserialize_map(Envelope { channels, plans, values }),
    };
    match (fast, reader.end()) {
        (Ok(fast), Ok(())) => fast,
        _ => Fast::Unclear,
    }
}

struct Envelope<'c> {
    channels: &'c Channels,
    plans: &'c Plans,
    values: &'c mut Vec<u8>,
}

impl<'de> Visitor<'de> for Envelope<'_> {
    type Value = Fast;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a message with what says what it is")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Fast, A::Error> {
        let unclear = || A::Error::custom("unclear");
        let (mut is_published, mut channel, mut found) = (false, None, None);
        // Only the usual order is read here: what a message is, then the message. `form` reads any.
        while let Some(key) = map.next_key_seed(KeySeed)? {
            match (key, channel) {
                (Key::Op, None) if !is_published => {
                    let op: Cow<'de, str> = map.next_value()?;
                    if op == ADVERTISE || op == SUBSCRIBE {
                        return Err(unclear());
                    }
                    if op != "publish" {
                        while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
                        return Ok(Fast::Skipped);
                    }
                    is_published = true;
                }
                (Key::Topic, None) if is_published => {
                    channel = Some(map.next_value_seed(NameSeed(self.channels, Which::Topic))?);
                }
                (Key::Type, None) if !is_published => {
                    channel = Some(map.next_value_seed(NameSeed(self.channels, Which::Type))?);
                }
                (Key::Message(which), Some(at))
                    if found.is_none() && is_published == (which == Which::Topic) =>
                {
                    found = Some(if let Some((id, _)) = self.channels.open[at].defined {
                        self.values.resize(self.channels.open[at].kept, 0);
                        let seed = MessageSeed::new(self.plans, id, is_published, self.values);
                        Fast::Clean(at, map.next_value_seed(seed)?)
                    } else {
                        map.next_value::<IgnoredAny>()?;
                        Fast::Undefined
                    });
                }
                (Key::Other, _) => _ = map.next_value::<IgnoredAny>()?,
                _ => return Err(unclear()),
            }
        }
        found.ok_or_else(unclear)
    }
}

#[derive(Clone, Copy)]
enum Key {
    Op,
    Topic,
    Type,
    Message(Which),
    Other,
}

struct KeySeed;

impl<'de> DeserializeSeed<'de> for KeySeed {
    type Value = Key;

    fn deserialize<D: serde::Deserializer<'de>>(self, deserializer: D) -> Result<Key, D::Error> {
        deserializer.deserialize_identifier(self)
    }
}

impl Visitor<'_> for KeySeed {
    type Value = Key;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a key")
    }

    fn visit_str<E: Error>(self, key: &str) -> Result<Key, E> {
        Ok(match key {
            "op" => Key::Op,
            "topic" => Key::Topic,
            "type" => Key::Type,
            "message" => Key::Message(Which::Type),
            "msg" => Key::Message(Which::Topic),
            _ => Key::Other,
        })
    }
}

/// Reads a name as the channel that it means.
struct NameSeed<'c>(&'c Channels, Which);

impl<'de> DeserializeSeed<'de> for NameSeed<'_> {
    type Value = usize;

    fn deserialize<D: serde::Deserializer<'de>>(self, deserializer: D) -> Result<usize, D::Error> {
        deserializer.deserialize_str(self)
    }
}

impl Visitor<'_> for NameSeed<'_> {
    type Value = usize;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a topic or a type")
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<usize, E> {
        self.0.get(self.1, name).ok_or_else(|| E::custom("unclear"))
    }
}
