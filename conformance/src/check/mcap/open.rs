//! A channel, while it is read and when it was.

use std::sync::Arc;

use uavspec_codegen::schema::MessageId;

use super::Declared;
use super::cdr::CdrChecker;
use crate::check::topic::topic_of;
use crate::model::{Channel, Findings, Location};
use crate::px4::comparison::{Comparison, Differences};
use crate::px4::json::Plans;

/// A channel of a file.
#[derive(Clone, Debug)]
pub struct McapChannel {
    /// Its topic.
    pub topic: String,
    /// How its messages are written, such as `cdr`.
    pub encoding: String,
    /// The name of its schema and in what that is written, where it has one.
    pub schema: Option<(String, String)>,
    /// How many messages it has.
    pub messages: u64,
    /// How many of them are CDR of other kinds than those that are judged: parameter lists, or version 2.
    pub other_cdr: u64,
    /// Whether it states another hash than that of the definition, as its schema differs, too.
    pub has_other_hash: bool,
    /// What it was judged by.
    pub status: CheckStatus,
}

/// What came of a channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CheckStatus {
    /// Its messages were judged by the definition.
    Checked(Basis),
    /// Neither its schema nor its topic names a definition.
    Undefined,
    /// Its messages are neither CDR nor JSON.
    Unsupported,
}

/// What the schema of a channel is beside the definition.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Basis {
    /// It was compared; channels of one schema share what came of it.
    Compared(Arc<Comparison>),
    /// There is none, or it says nothing.
    NoSchema,
    /// It is written in something that isn't read here, such as `ros2idl`.
    Encoding(String),
    /// It can't be read, and why.
    Unreadable(String),
    /// It has too many bytes to be kept.
    TooLong,
    /// The definition is one whose messages can't be handled, and why: nothing was judged.
    Unusable(String),
    /// There are too many channels before it: nothing was judged.
    TooMany,
}

impl CheckStatus {
    /// What differs between the schema of the channel and the definition, if anything does.
    pub fn differences(&self) -> Option<&Differences> {
        let Self::Checked(Basis::Compared(comparison)) = self else { return None };
        match &**comparison {
            Comparison::Differs(differences) => Some(differences),
            Comparison::Equal | Comparison::Undefined => None,
        }
    }
}

impl Basis {
    /// Why nothing could be compared, where that is so.
    pub fn problem(&self) -> Option<String> {
        match self {
            Self::Compared(_) => None,
            Self::NoSchema => Some("no schema that names fields".to_owned()),
            Self::Encoding(encoding) => Some(format!("a schema in `{encoding}`, which isn't read")),
            Self::Unreadable(error) => Some(format!("a schema that can't be read: {error}")),
            Self::TooLong => Some("a schema with too many bytes".to_owned()),
            Self::Unusable(defect) => Some(format!("not judged, as its definition {defect}")),
            Self::TooMany => Some("not judged, as there are too many channels".to_owned()),
        }
    }
}

/// What findings and rules know of a channel.
pub(super) struct Identity {
    pub(super) index: usize,
    pub(super) name: String,
    pub(super) definition: Option<MessageId>,
    pub(super) version: Option<u32>,
    pub(super) location: Location,
}

/// A channel that is being read.
pub(super) struct Open {
    pub(super) identity: Identity,
    topic: String,
    encoding: String,
    pub(super) schema: Option<(String, String)>,
    /// What tells it from another of the same id.
    pub(super) digest: u64,
    pub(super) reading: Reading,
    pub(super) messages: u64,
    /// How many messages of JSON were judged.
    pub(super) checked: u64,
    pub(super) has_other_hash: bool,
    pub(super) status: CheckStatus,
}

/// How messages are read.
pub(super) enum Reading {
    Skipped,
    Cdr(Box<CdrChecker>),
    Json(MessageId),
}

impl Identity {
    pub(super) fn channel(&self) -> Channel<'_> {
        Channel {
            index: self.index,
            topic: &self.name,
            multi_id: None,
            definition: self.definition,
            version: self.version,
            location: self.location,
        }
    }
}

impl Open {
    pub(super) fn new(
        declared: &Declared,
        schema: Option<(&str, &str)>,
        definition: Option<MessageId>,
        location: Location,
        digest: u64,
        index: usize,
    ) -> Self {
        let is_known = matches!(declared.encoding.as_str(), "cdr" | "json");
        let escaped = |text: &str| text.escape_debug().to_string();
        Self {
            identity: Identity {
                index,
                name: escaped(topic_of(&declared.topic)),
                definition,
                version: None,
                location,
            },
            topic: escaped(&declared.topic),
            encoding: escaped(&declared.encoding),
            schema: schema.map(|(name, encoding)| (escaped(name), escaped(encoding))),
            digest,
            reading: Reading::Skipped,
            messages: 0,
            checked: 0,
            has_other_hash: false,
            status: if is_known { CheckStatus::Undefined } else { CheckStatus::Unsupported },
        }
    }

    /// What differs between its schema and the definition, if anything does.
    pub(super) fn differences(&self) -> Option<&Differences> {
        self.status.differences()
    }

    /// Counts what its messages exercised.
    pub(super) fn close(self, plans: Option<&Plans>, findings: &mut Findings) -> McapChannel {
        let mut other_cdr = 0;
        match (self.reading, plans) {
            (Reading::Cdr(check), _) => other_cdr = check.close(findings),
            (Reading::Json(of), Some(plans)) => plans.count(of, self.checked, findings),
            _ => {}
        }
        McapChannel {
            topic: self.topic,
            encoding: self.encoding,
            schema: self.schema,
            messages: self.messages,
            other_cdr,
            has_other_hash: self.has_other_hash,
            status: self.status,
        }
    }
}
