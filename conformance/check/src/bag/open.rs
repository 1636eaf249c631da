//! A channel: its state during the check, and its summary.

use std::rc::Rc;
use std::sync::Arc;

use serde::Serialize;
use uavspec_model::{Channel, Findings, Location};
use uavspec_px4::comparison::{Comparison, Differences};
use uavspec_px4::json::{Plans, SharedFields};
use uavspec_rules::definitions::Definitions;
use uavspec_schema::MessageId;

use super::Declared;
use super::cdr::CdrChecker;
use crate::coverage::{PartResult, Parts, Share, Tally};
use crate::release::ComparedTopic;
use crate::run::Subscribers;
use crate::topic::topic_of;

/// A channel, with the result of comparing its schema with the definition.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
#[schemars(rename = "McapChannel")]
pub struct BagChannel {
    /// The topic.
    pub topic: String,
    /// The encoding of the channel's messages, e.g. `cdr`.
    pub encoding: String,
    /// The name of the channel's schema.
    pub schema: Option<String>,
    /// The encoding of the channel's schema, e.g. `ros2msg`.
    pub schema_encoding: Option<String>,
    /// The number of messages.
    pub messages: u64,
    /// The number of messages in unsupported CDR encodings: parameter lists and CDR version 2.
    pub other_cdr: u64,
    /// The result of comparing the channel's schema with the definition.
    pub result: ChannelResult,
    /// The differences, or the reason why there was no comparison; may be empty.
    pub message: String,
    /// The extent to which the channel was checked.
    #[serde(skip)]
    pub status: CheckStatus,
    /// The release of the definition that the messages were checked against, such as `px4@1.16`.
    #[serde(skip)]
    pub release: Option<String>,
    /// The mean number of messages per second, with three decimals.
    #[serde(skip)]
    pub rate: Option<f64>,
}

/// The result of comparing the schema of a channel with its definition.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ChannelResult {
    /// The fields have the same types and the same order.
    Equal,
    /// Something differs.
    Differs,
    /// There is no comparable schema. The schema name or the topic identifies the definition.
    #[serde(rename = "by name")]
    ByName,
    /// There is no known definition for the channel. Its messages were checked against its own schema.
    #[serde(rename = "own schema")]
    OwnSchema,
    /// There is no known definition for the channel.
    Undefined,
    /// The channel's messages are neither CDR nor JSON.
    Unsupported,
}

/// The extent to which a channel was checked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CheckStatus {
    /// The messages were checked against the definition.
    Checked(Basis),
    /// Neither the channel's schema nor its topic names a definition. The messages were checked against the schema in the
    /// file.
    OwnSchema,
    /// Neither the channel's schema nor its topic names a definition.
    Undefined,
    /// The messages are neither CDR nor JSON.
    Unsupported,
}

/// The comparison of a channel's schema with the definition.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Basis {
    /// The schema was compared. Channels with the same schema share the result.
    Compared(Arc<Comparison>),
    /// There is no schema, or it has no fields.
    NoSchema,
    /// The schema is only the name of the type.
    OnlyName,
    /// The encoding of the schema isn't supported, e.g. `ros2idl`.
    Encoding(String),
    /// The schema is invalid; contains the reason.
    Unreadable(String),
    /// The schema is too long.
    TooLong,
    /// The defined type can't be used with the encoding of the messages; contains the reason. The channel wasn't
    /// checked.
    Unusable(String),
    /// Neither a usable schema nor a type hash indicates the release, and the size of the messages fits no definition,
    /// or several. The channel wasn't checked.
    Undecided,
    /// There is no usable schema, and the type hash differs from the hash of the definition. The channel wasn't
    /// checked.
    OtherHash,
    /// The channels have too many fields. This channel wasn't checked.
    TooMany,
}

impl CheckStatus {
    /// The differences between the schema of the channel and the definition.
    pub fn differences(&self) -> Option<&Differences> {
        let Self::Checked(Basis::Compared(comparison)) = self else { return None };
        match &**comparison {
            Comparison::Differs(differences) => Some(differences),
            Comparison::Equal | Comparison::Undefined => None,
        }
    }
}

impl From<&CheckStatus> for PartResult {
    fn from(status: &CheckStatus) -> Self {
        match status {
            CheckStatus::Checked(Basis::Compared(comparison)) => (&**comparison).into(),
            CheckStatus::Checked(Basis::Unusable(_)) | CheckStatus::Unsupported => Self::Unsupported,
            CheckStatus::Checked(Basis::TooMany) => Self::TooMany,
            CheckStatus::OwnSchema => Self::OwnSchema,
            CheckStatus::Undefined | CheckStatus::Checked(Basis::Undecided | Basis::OtherHash) => {
                Self::Undefined
            }
            CheckStatus::Checked(_) => Self::Checked,
        }
    }
}

impl Basis {
    /// The reason why there is no comparison.
    pub fn problem(&self) -> Option<String> {
        match self {
            Self::Compared(_) => None,
            Self::NoSchema => Some("no schema with fields".to_owned()),
            Self::OnlyName => Some("the schema contains only the name of the type".to_owned()),
            Self::Encoding(encoding) => Some(format!("the schema encoding `{encoding}` isn't supported")),
            Self::Unreadable(error) => Some(format!("invalid schema: {error}")),
            Self::TooLong => Some("the schema is too long".to_owned()),
            Self::Unusable(defect) => Some(format!("not checked: its definition {defect}")),
            Self::Undecided => Some(
                "not checked: there is no usable schema or type hash, and the size of the messages doesn't identify \
                 their release"
                    .to_owned(),
            ),
            Self::OtherHash => Some(
                "not checked: there is no usable schema, and the type hash differs from the definition".to_owned(),
            ),
            Self::TooMany => Some("not checked: the channels have too many fields".to_owned()),
        }
    }
}

/// The identity of a channel for findings and rules.
pub(super) struct Identity {
    pub(super) index: usize,
    pub(super) name: String,
    /// The name with its namespace.
    pub(super) topic: String,
    pub(super) definition: Option<MessageId>,
    pub(super) version: Option<u32>,
    pub(super) location: Location,
}

/// A channel with its state.
pub(super) struct Open {
    pub(super) identity: Identity,
    encoding: String,
    pub(super) schema: Option<(String, String)>,
    pub(super) reading: Reading,
    pub(super) subscribers: Subscribers,
    pub(super) tally: Tally,
    /// The fields that the messages and the definition share, if the messages are read.
    pub(super) fields: Option<Share>,
    /// True if both the hash and the schema of the channel differ from the definition.
    pub(super) has_other_hash: bool,
    pub(super) status: CheckStatus,
    /// The reason why the channel's own schema wasn't used in the absence of a definition, or a remark on the schema.
    pub(super) remark: Option<String>,
}

/// The reader for the messages of a channel.
pub(super) enum Reading {
    Skipped,
    Cdr(Box<CdrChecker>),
    /// JSON messages with this definition. If the schema of the channel differs from the definition, only the contained
    /// fields are checked.
    Json(MessageId, Option<Rc<SharedFields>>),
    /// JSON messages whose channel name suggests this type. The first non-empty message decides whether the channel has
    /// this type.
    Guess(MessageId, Box<Declared>),
}

impl Identity {
    pub(super) fn channel(&self) -> Channel<'_> {
        Channel {
            index: self.index,
            topic: &self.name,
            full_topic: &self.topic,
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
        index: usize,
    ) -> Self {
        let is_known = matches!(declared.encoding.as_str(), "cdr" | "json");
        let escaped = |text: &str| text.escape_debug().to_string();
        Self {
            identity: Identity {
                index,
                name: escaped(topic_of(&declared.topic)),
                topic: escaped(&declared.topic),
                definition,
                version: None,
                location,
            },
            encoding: escaped(&declared.encoding),
            schema: schema.map(|(name, encoding)| (escaped(name), escaped(encoding))),
            reading: Reading::Skipped,
            subscribers: Subscribers::default(),
            tally: Tally::default(),
            fields: None,
            has_other_hash: false,
            remark: None,
            status: if is_known { CheckStatus::Undefined } else { CheckStatus::Unsupported },
        }
    }

    /// The channel, compared with its definition.
    pub(super) fn compared(&self) -> ComparedTopic<'_> {
        let is_equal = match &self.status {
            CheckStatus::Checked(Basis::Compared(comparison)) => **comparison == Comparison::Equal,
            // The hash or the size of the messages matches the definition.
            CheckStatus::Checked(Basis::NoSchema | Basis::OnlyName | Basis::Encoding(_)) => true,
            _ => false,
        };
        ComparedTopic { topic: &self.identity.topic, definition: self.identity.definition, is_equal }
    }

    /// The differences between the channel's schema and the definition.
    pub(super) fn differences(&self) -> Option<&Differences> {
        self.status.differences()
    }

    /// The result of the comparison with the definition, and the differences, or the reason why there was no comparison.
    fn result(&self) -> (ChannelResult, String) {
        let remark = || self.remark.clone().unwrap_or_default();
        match &self.status {
            CheckStatus::Checked(Basis::Compared(comparison)) => match &**comparison {
                Comparison::Differs(differences) => {
                    let hash = if self.has_other_hash { "; its hash differs as well" } else { "" };
                    (ChannelResult::Differs, format!("{differences}{hash}"))
                }
                Comparison::Equal | Comparison::Undefined => (ChannelResult::Equal, String::new()),
            },
            CheckStatus::Checked(basis) => (ChannelResult::ByName, basis.problem().unwrap_or_default()),
            CheckStatus::OwnSchema => (ChannelResult::OwnSchema, remark()),
            CheckStatus::Undefined => (ChannelResult::Undefined, remark()),
            CheckStatus::Unsupported => (ChannelResult::Unsupported, String::new()),
        }
    }

    /// Adds the coverage of rules, and returns the summary.
    pub(super) fn close(
        self,
        plans: Option<&Plans<'_>>,
        definitions: &Definitions,
        findings: &mut Findings,
        parts: &mut Parts,
    ) -> BagChannel {
        let Tally { records, decoded, checked, .. } = self.tally;
        let release = self.identity.definition.and_then(|id| definitions.release_of(id));
        let (channel_result, message) = self.result();
        let mut other_cdr = 0;
        match (self.reading, plans) {
            (Reading::Cdr(check), _) => other_cdr = check.close(findings),
            (Reading::Json(message_id, shared), Some(plans)) => {
                plans.count(message_id, shared.as_deref(), checked, findings);
            }
            _ => {}
        }
        let mut result = PartResult::from(&self.status);
        if other_cdr > 0 {
            result = result.max(PartResult::Unsupported);
        }
        // A message is decoded but not checked only if it doesn't indicate the type of its channel.
        if decoded > checked {
            result = result.max(PartResult::Keyless);
        }
        parts.add(
            &self.identity.topic,
            result,
            self.tally,
            self.fields.unwrap_or_default().times(checked, records),
        );
        let (schema, schema_encoding) = self.schema.unzip();
        BagChannel {
            topic: self.identity.topic,
            encoding: self.encoding,
            schema,
            schema_encoding,
            messages: records,
            other_cdr,
            result: channel_result,
            message,
            status: self.status,
            release: release.map(|release| release.label.clone()),
            rate: self.tally.rate(),
        }
    }
}
