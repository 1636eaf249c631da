//! The answers, in the form in which JSON contains them.

use serde::Serialize;

use crate::rule_list;

/// A word with its meanings.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Explanation {
    /// The word.
    pub(crate) word: String,
    /// The meanings, the most specific first.
    pub(crate) answers: Vec<Answer>,
}

/// A meaning of a word.
#[derive(Debug, Serialize, schemars::JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub(crate) enum Answer {
    /// A rule.
    Rule(Box<rule_list::Entry>),
    /// An error code of a UAV.
    ErrorCode(ErrorCode),
    /// A hash of one or more definitions.
    Hash(Hash),
    /// A message or a service.
    Message(Box<Message>),
    /// A field, or a value of a field.
    Field(Box<Field>),
    /// A constant or a command.
    Constant(Box<Constant>),
    /// A name that occurs in several messages.
    Candidates(Candidates),
}

/// An error code.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub(crate) struct ErrorCode {
    /// The code.
    pub(crate) code: u32,
    /// The abbreviation, such as `LOWBAT`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) abbreviation: Option<String>,
    /// The class of the code.
    pub(crate) class: &'static str,
    /// The severity.
    pub(crate) severity: &'static str,
    /// The meaning, or `null` if the code has no definition.
    pub(crate) description: Option<String>,
    /// Codes for the same condition at other severities.
    pub(crate) alternatives: Vec<Code>,
    /// Codes for related conditions.
    pub(crate) see_also: Vec<Code>,
    /// The version of the protocol that introduced the code.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) since: Option<String>,
}

/// A related error code.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub(crate) struct Code {
    /// The code.
    pub(crate) code: u32,
    /// The meaning.
    pub(crate) description: String,
}

/// A hash.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub(crate) struct Hash {
    /// The digits of the hash.
    #[serde(rename = "hash")]
    pub(crate) digits: String,
    /// The form of the hash: `uorb` or `type_hash`.
    pub(crate) form: &'static str,
    /// The definitions with this hash.
    pub(crate) definitions: Vec<Hashed>,
}

/// A definition with a hash.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub(crate) struct Hashed {
    /// The full ROS name.
    pub(crate) name: String,
    /// The topics of the message.
    pub(crate) topics: Vec<String>,
    /// The releases that contain the definition.
    pub(crate) releases: Vec<String>,
    /// True if the definition is one of uavspec's documented definitions.
    pub(crate) documented: bool,
}

/// A message or a service.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub(crate) struct Message {
    /// The full ROS name.
    pub(crate) name: String,
    /// The topics of the message.
    pub(crate) topics: Vec<String>,
    /// The release that the facts are from.
    pub(crate) release: String,
    /// The version of the message.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) version: Option<u32>,
    /// The meaning.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub(crate) description: String,
    /// PX4's hash of the fields.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) uorb_hash: Option<String>,
    /// The ROS type hash.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) type_hash: Option<String>,
    /// The size in uORB memory, in bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) uorb_size: Option<usize>,
    /// The message, or the parts of the service.
    pub(crate) parts: Vec<Part>,
    #[serde(flatten)]
    pub(crate) presence: Presence,
}

/// A message, or a part of a service.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub(crate) struct Part {
    /// The name, such as `VehicleCommand_Request`.
    pub(crate) name: String,
    /// The fields.
    pub(crate) fields: Vec<Summary>,
    /// The constants.
    pub(crate) constants: Vec<Member>,
}

/// A field of a message, in short.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub(crate) struct Summary {
    /// The name.
    pub(crate) name: String,
    /// The type in the definition.
    #[serde(rename = "type")]
    pub(crate) ty: String,
    /// The unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) unit: Option<String>,
    /// The meaning.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub(crate) description: String,
}

/// A field.
#[derive(Debug, Default, Serialize, schemars::JsonSchema)]
pub(crate) struct Field {
    /// The name.
    pub(crate) name: String,
    /// The message that declares the field.
    pub(crate) message: String,
    /// The release that the facts are from.
    pub(crate) release: String,
    /// The type in the definition.
    #[serde(rename = "type")]
    pub(crate) ty: String,
    #[serde(flatten)]
    pub(crate) limits: Limits,
    /// The default value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) default: Option<String>,
    /// The meaning.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub(crate) description: String,
    /// The constants that the field may contain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) values: Option<Values>,
    /// The value in the question.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) asked: Option<Asked>,
    #[serde(flatten)]
    pub(crate) presence: Presence,
}

/// The unit and the valid values of a field or a parameter.
#[derive(Debug, Default, Serialize, schemars::JsonSchema)]
pub(crate) struct Limits {
    /// The unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) unit: Option<String>,
    /// The valid range.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) range: Option<String>,
    /// Other facts, such as the value for missing data and the frame.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) facts: Vec<String>,
}

/// The named values of a field.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub(crate) struct Values {
    /// The message that declares the constants.
    pub(crate) message: String,
    /// The prefixes of the constants.
    pub(crate) prefixes: Vec<String>,
    /// True if each value is a mask of bits.
    pub(crate) flags: bool,
    /// The source from which uavspec knows that the field uses these constants.
    pub(crate) known_from: String,
    /// True if the constants were inferred. All other sources state whether the values are masks.
    #[serde(skip)]
    pub(crate) is_inferred: bool,
    /// The constants.
    pub(crate) members: Vec<Member>,
}

/// A constant.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
pub(crate) struct Member {
    /// The name.
    pub(crate) name: String,
    /// The value.
    pub(crate) value: String,
    /// The meaning.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub(crate) description: String,
}

/// The value in the question.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub(crate) struct Asked {
    /// The value.
    pub(crate) value: String,
    /// The constants that the value denotes; for a mask, one for each bit.
    pub(crate) meaning: Vec<Member>,
    /// Bits without a meaning, special values, and reasons why the value is invalid.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) notes: Vec<String>,
    /// The constants with this value in all releases.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) by_release: Vec<Meaning>,
}

/// The meaning of a value in some releases.
#[derive(Debug, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub(crate) struct Meaning {
    /// The releases.
    pub(crate) releases: Vec<String>,
    /// The constants with this value.
    pub(crate) names: Vec<String>,
}

/// A constant, or a command with parameters.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub(crate) struct Constant {
    /// The name.
    pub(crate) name: String,
    /// The message that declares the constant.
    pub(crate) message: String,
    /// The release that the facts are from.
    pub(crate) release: String,
    /// The type.
    #[serde(rename = "type")]
    pub(crate) ty: String,
    /// The value.
    pub(crate) value: String,
    /// The meaning.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub(crate) description: String,
    /// The fields that contain the constant.
    pub(crate) fields: Vec<String>,
    /// The other values of these fields.
    pub(crate) alternatives: Vec<Member>,
    /// The parameters of a command.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) parameters: Vec<Parameter>,
    /// Other definitions with a constant of this name.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) also_in: Vec<String>,
    #[serde(flatten)]
    pub(crate) presence: Presence,
}

/// A parameter of a command.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub(crate) struct Parameter {
    /// The number of the parameter, from 1.
    pub(crate) number: usize,
    #[serde(flatten)]
    pub(crate) limits: Limits,
    /// The prefixes of the constants that the parameter may contain.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) values: Vec<String>,
    /// The meaning.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub(crate) description: String,
}

/// A name that occurs in several messages.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub(crate) struct Candidates {
    /// The name.
    pub(crate) name: String,
    /// The full names, each of which can be explained.
    pub(crate) candidates: Vec<String>,
}

/// The releases that contain a definition or an item.
#[derive(Debug, Default, Serialize, schemars::JsonSchema)]
pub(crate) struct Presence {
    /// The first release, unless it is the oldest known one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) since: Option<String>,
    /// The releases that contain it.
    pub(crate) releases: Vec<String>,
    /// The changes, from the oldest release to the newest.
    pub(crate) history: Vec<Changes>,
}

/// The changes in a release.
#[derive(Debug, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub(crate) struct Changes {
    /// The release.
    pub(crate) release: String,
    /// The changes since the release before.
    pub(crate) changes: Vec<String>,
}
