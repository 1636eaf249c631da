//! What stands around a message and says what it is.

use std::collections::HashMap;

use uavspec_codegen::schema::MessageId;

use crate::json::{Tokens, Tree, Unclear};
use crate::px4::json::{Clean, Plans};

/// The operations of rosbridge that may name the type of a topic.
const ADVERTISE: &str = "advertise";
const SUBSCRIBE: &str = "subscribe";

/// How a message says what it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NameKind {
    /// `{"type": "px4/FailsafeFlags", "message": {…}}`.
    Type,
    /// rosbridge: `{"op": "publish", "topic": "/fmu/out/failsafe_flags", "msg": {…}}`.
    Topic,
}

impl NameKind {
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
    pub(super) num_bytes: usize,
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
    pub(super) fn get(&self, which: NameKind, name: &str) -> Option<usize> {
        match which {
            NameKind::Type => self.by_type.get(name).copied(),
            NameKind::Topic => self.by_topic.get(name).copied(),
        }
    }

    pub(super) fn insert(&mut self, which: NameKind, name: &str, open: Open) {
        let names = match which {
            NameKind::Type => &mut self.by_type,
            NameKind::Topic => &mut self.by_topic,
        };
        names.insert(name.to_owned(), self.open.len());
        self.open.push(open);
    }
}

/// What a value is, from its tree.
pub(super) enum Form<'t> {
    Message(NameKind, &'t str, &'t Tree<'t>),
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
            (Some("publish"), Some(topic), Some(message)) => Form::Message(NameKind::Topic, topic, message),
            (Some("publish"), ..) => Form::Unknown("rosbridge's `publish` without `topic` or `msg`"),
            (Some(ADVERTISE | SUBSCRIBE), Some(topic), _) => {
                text("type").map_or(Form::Skipped, |ty| Form::Advertised(topic, ty))
            }
            (Some(_), ..) => Form::Skipped,
            (None, ..) => Form::Unknown("`op` is no string"),
        };
    }
    match (text("type"), tree.get("message")) {
        (Some(ty), Some(message)) => Form::Message(NameKind::Type, ty, message),
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

/// Reads a value without a tree. `values` gets what the message says, if its channel needs that.
pub(super) fn read(text: &str, channels: &Channels, plans: &Plans, values: &mut Vec<u8>) -> Fast {
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

/// A record up to some member. Only the usual order is accepted: what a message is, then the message; [`form`] accepts any.
struct Envelope<'c> {
    channels: &'c Channels,
    plans: &'c Plans,
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

    /// The channel of this name.
    fn known(&self, which: NameKind, tokens: &mut Tokens<'_>) -> Result<Option<usize>, Unclear> {
        let channel = self.channels.get(which, &tokens.text()?);
        if channel.is_some() { Ok(channel) } else { Err(Unclear) }
    }

    fn message(&mut self, at: usize, tokens: &mut Tokens<'_>) -> Result<(), Unclear> {
        let open = &self.channels.open[at];
        self.found = Some(if let Some((id, _)) = open.defined {
            self.values.resize(open.num_bytes, 0);
            Fast::Clean(at, self.plans.read(id, tokens, self.is_published, self.values)?)
        } else {
            tokens.skip()?;
            Fast::Undefined
        });
        Ok(())
    }
}
