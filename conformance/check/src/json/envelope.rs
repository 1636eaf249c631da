//! The envelope of a message. The envelope names the message's type or topic.

use std::collections::HashMap;

use uavspec_model::json::{Tokens, Tree, Unclear};
use uavspec_px4::json::{Clean, Plans};
use uavspec_schema::MessageId;

use crate::coverage::Tally;
use crate::run::Subscribers;

/// The rosbridge operations that may name the type of a topic.
const ADVERTISE: &str = "advertise";
const SUBSCRIBE: &str = "subscribe";

/// The way in which an envelope identifies its message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NameKind {
    /// `{"type": "px4/FailsafeFlags", "message": {…}}`.
    Type,
    /// rosbridge: `{"op": "publish", "topic": "/fmu/out/failsafe_flags", "msg": {…}}`.
    Topic,
}

impl NameKind {
    /// The key of the name.
    pub(crate) const fn name_key(self) -> &'static str {
        match self {
            Self::Type => "type",
            Self::Topic => "topic",
        }
    }

    /// The key of the message.
    pub(crate) const fn key(self) -> &'static str {
        match self {
            Self::Type => "message",
            Self::Topic => "msg",
        }
    }
}

/// A topic or type in the capture.
#[derive(Debug)]
pub(super) struct Open {
    /// The name without its namespace.
    pub(super) name: String,
    /// The name with its namespace.
    pub(super) full_name: String,
    /// The definition and the channel index.
    pub(super) defined: Option<(MessageId, usize)>,
    /// The key of the message in the envelope, if messages have an envelope.
    pub(super) key: Option<&'static str>,
    /// True if the definition, or its absence, is final.
    pub(super) is_decided: bool,
    /// True if the message that decided the definition has the keys of the definition.
    pub(super) has_keys: bool,
    pub(super) subscribers: Subscribers,
    pub(super) tally: Tally,
    /// The size of the messages in memory, in bytes; 0 if it varies, or if no rule needs their values.
    pub(super) num_bytes: usize,
    /// The line of the message that decided the definition.
    pub(super) line: u64,
}

/// All topics and types in the capture.
#[derive(Debug, Default)]
pub(super) struct Channels {
    /// The channel of all values, if the caller set a type.
    pub(super) only: Option<usize>,
    pub(super) open: Vec<Open>,
    names: Names,
}

/// The indices of topics and types, by name. There is a map for each kind of name.
pub(crate) type Names = [HashMap<String, usize>; 2];

impl Channels {
    pub(super) fn get(&self, which: NameKind, name: &str) -> Option<usize> {
        self.names[which as usize].get(name).copied()
    }

    /// The channel with this name, if its definition is decided.
    pub(super) fn decided(&self, which: NameKind, name: &str) -> Option<usize> {
        self.get(which, name).filter(|at| self.open[*at].is_decided)
    }

    /// Adds a channel, or replaces an undecided one. Returns its index.
    pub(super) fn insert(&mut self, which: NameKind, name: &str, open: Open) -> usize {
        let at = *self.names[which as usize].entry(name.to_owned()).or_insert(self.open.len());
        match self.open.get_mut(at) {
            Some(known) => *known = Open { tally: known.tally, ..open },
            None => self.open.push(open),
        }
        at
    }
}

/// The form of a parsed value.
pub(crate) enum Form<'t> {
    Message(NameKind, &'t str, &'t Tree<'t>),
    /// A rosbridge message that specifies the type of a topic.
    Advertised(&'t str, &'t str),
    /// Any other rosbridge message.
    Skipped,
    /// An unknown form, with an error message.
    Unknown(&'static str),
}

/// Determines the form of a value.
pub(crate) fn form<'t>(tree: &'t Tree<'t>) -> Form<'t> {
    let Tree::Object(members) = tree else {
        return Form::Unknown("expected an object that names its message type");
    };
    let is_repeated = |key: &&str| members.iter().filter(|(known, _)| known == key).count() > 1;
    if ["op", "topic", "msg", "type", "message"].iter().any(is_repeated) {
        return Form::Unknown(
            "duplicate key: `op`, `topic`, `msg`, `type` and `message` may appear only once",
        );
    }
    let text = |key| tree.get(key).and_then(Tree::as_str);
    if tree.get("op").is_some() {
        return match (text("op"), text("topic"), tree.get("msg")) {
            (Some("publish"), Some(topic), Some(message)) => Form::Message(NameKind::Topic, topic, message),
            (Some("publish"), ..) => Form::Unknown("rosbridge `publish` without `topic` or `msg`"),
            (Some(ADVERTISE | SUBSCRIBE), Some(topic), _) => {
                text("type").map_or(Form::Skipped, |ty| Form::Advertised(topic, ty))
            }
            (Some(_), ..) => Form::Skipped,
            (None, ..) => Form::Unknown("`op`: expected a string"),
        };
    }
    match (text("type"), tree.get("message")) {
        (Some(ty), Some(message)) => Form::Message(NameKind::Type, ty, message),
        _ => Form::Unknown(
            "unknown message type: expected `type` and `message`, or rosbridge's `op`, `topic` and `msg`; \
             otherwise, set the type with --type",
        ),
    }
}

/// The result of reading a value in a single pass.
pub(super) enum Fast {
    /// A message of this channel without findings.
    Clean(usize, Clean),
    Skipped,
    /// A message of this channel, which has no definition.
    Undefined(usize),
    /// A value that has findings, or belongs to a new or undecided channel. Such a value needs the slow path.
    Unclear,
}

/// Reads a value without building a tree. Stores the field values in `values` if the channel needs them.
pub(super) fn read(text: &str, channels: &Channels, plans: &Plans<'_>, values: &mut Vec<u8>) -> Fast {
    values.clear();
    let mut tokens = Tokens::new(text);
    let only = channels.only.and_then(|at| Some((at, channels.open[at].defined?)));
    let fast = match only {
        Some((at, (id, _))) => {
            values.resize(channels.open[at].num_bytes, 0);
            plans.read(id, &mut tokens, false, values).map(|clean| Fast::Clean(at, clean))
        }
        None => Envelope { channels, plans, values, is_published: false, channel: None, found: None }
            .read(&mut tokens),
    };
    fast.ok().filter(|_| tokens.end().is_ok()).unwrap_or(Fast::Unclear)
}

/// A partially read record. The type must precede the message, which is the usual order. [`form`] accepts any order.
struct Envelope<'c> {
    channels: &'c Channels,
    plans: &'c Plans<'c>,
    values: &'c mut Vec<u8>,
    is_published: bool,
    channel: Option<usize>,
    found: Option<Fast>,
}

impl Envelope<'_> {
    fn read(mut self, tokens: &mut Tokens<'_>) -> Result<Fast, Unclear> {
        tokens.object(|tokens| {
            if matches!(self.found, Some(Fast::Skipped)) {
                tokens.skip_key()?;
                return tokens.skip();
            }
            let key = tokens.key()?;
            self.member(&key, tokens)
        })?;
        self.found.ok_or(Unclear)
    }

    fn member(&mut self, key: &str, tokens: &mut Tokens<'_>) -> Result<(), Unclear> {
        match (key, self.channel) {
            ("op", None) if !self.is_published => match &*tokens.text()? {
                ADVERTISE | SUBSCRIBE => return Err(Unclear),
                "publish" => self.is_published = true,
                _ => self.found = Some(Fast::Skipped),
            },
            ("topic", None) if self.is_published => self.channel = self.known(NameKind::Topic, tokens)?,
            ("type", None) if !self.is_published => self.channel = self.known(NameKind::Type, tokens)?,
            ("message", Some(at)) if self.found.is_none() && !self.is_published => {
                self.message(at, tokens)?;
            }
            ("msg", Some(at)) if self.found.is_none() && self.is_published => self.message(at, tokens)?,
            ("op" | "topic" | "type" | "message" | "msg", _) => return Err(Unclear),
            _ => tokens.skip()?,
        }
        Ok(())
    }

    /// Reads a name, and looks up its channel.
    fn known(&self, which: NameKind, tokens: &mut Tokens<'_>) -> Result<Option<usize>, Unclear> {
        let channel = self.channels.decided(which, &tokens.text()?);
        if channel.is_some() { Ok(channel) } else { Err(Unclear) }
    }

    fn message(&mut self, at: usize, tokens: &mut Tokens<'_>) -> Result<(), Unclear> {
        let open = &self.channels.open[at];
        self.found = Some(if let Some((id, _)) = open.defined {
            self.values.resize(open.num_bytes, 0);
            Fast::Clean(at, self.plans.read(id, tokens, self.is_published, self.values)?)
        } else {
            tokens.skip()?;
            Fast::Undefined(at)
        });
        Ok(())
    }
}
