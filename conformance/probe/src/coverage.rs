//! The request types that a probe has sent, and the reasons why it hasn't sent the others.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;
use serde_json::Value;
use uavspec_rules::definitions::Definitions;
use uavspec_schema::json_type::Direction;

use super::commands::COMMANDS;
use super::options::Options;

/// A request type of the definitions, and its use in a probe.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct RequestType {
    /// The message type.
    #[serde(rename = "type")]
    pub name: String,
    /// The number of requests that were sent.
    pub sent: u64,
    /// The number of requests that the server answered.
    pub answered: u64,
    /// The number of answers that refused the request.
    pub refused: u64,
    /// The reason why no request was sent; absent if one was sent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_sent: Option<String>,
}

/// The coverage of all request types.
#[derive(Debug, Default)]
pub(super) struct Coverage {
    types: BTreeMap<String, RequestType>,
}

impl Coverage {
    /// Creates the coverage of all request types in the definitions.
    pub(super) fn new(definitions: &Definitions) -> Self {
        let names: BTreeSet<&str> = definitions.defined_schemas().types(Direction::Request).collect();
        let entry = |name: &str| {
            let name = name.to_owned();
            (name.clone(), RequestType { name, sent: 0, answered: 0, refused: 0, not_sent: None })
        };
        Self { types: names.into_iter().map(entry).collect() }
    }

    /// Sets the reason for the requests that the user excluded, so that a later reason doesn't replace it.
    pub(super) fn exclude(&mut self, options: &Options) {
        for entry in self.types.values_mut() {
            let name = entry.name.as_str();
            let why = match () {
                () if !options.selection.has_request(name) => "not selected",
                () if options.uavs.is_empty() && COMMANDS.contains(&name) => "needs --allow-commands",
                () if options.login.is_none() && name == "AUTH-REQ" => "needs --login",
                () => continue,
            };
            entry.not_sent = Some(why.to_owned());
        }
    }

    /// Counts a request and its answer.
    pub(super) fn sent(&mut self, name: &str, answer: Option<&Value>) {
        let Some(entry) = self.types.get_mut(name) else { return };
        entry.sent += 1;
        entry.answered += u64::from(answer.is_some());
        entry.refused += u64::from(answer.is_some_and(is_refusal));
    }

    /// The number of answers that refused a request of this type.
    pub(super) fn refused(&self, name: &str) -> u64 {
        self.types.get(name).map_or(0, |entry| entry.refused)
    }

    /// Sets the reason why requests of these types aren't sent.
    pub(super) fn not_sent(&mut self, names: &[&str], why: &str) {
        for name in names {
            if let Some(entry) = self.types.get_mut(*name) {
                entry.not_sent.get_or_insert_with(|| why.to_owned());
            }
        }
    }

    /// Returns all types. `rest` is the reason for types that weren't sent and have no other reason.
    pub(super) fn finish(self, rest: &str) -> Vec<RequestType> {
        let finished = |entry: RequestType| {
            let not_sent =
                if entry.sent > 0 { None } else { entry.not_sent.or_else(|| Some(rest.to_owned())) };
            RequestType { not_sent, ..entry }
        };
        self.types.into_values().map(finished).collect()
    }
}

fn is_refusal(answer: &Value) -> bool {
    answer["body"]["type"] == "ACK-NAK" || !answer["error"].is_null()
}
