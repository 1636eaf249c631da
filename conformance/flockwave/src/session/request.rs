//! Requests.

use std::collections::BTreeSet;

use uavspec_model::json::Tree;
use uavspec_model::{Location, Rule};

use super::exchange::message_excerpt;
use super::{Exchange, MAX_ID, parts};
use crate::limits::MAX_REQUEST_IDS;

/// A request.
#[derive(Clone, Debug)]
pub struct SentRequest {
    /// The type of the request, if present.
    pub type_name: Option<String>,
    /// The requested objects, if the request lists them as strings within the limits.
    pub objects: Option<BTreeSet<String>>,
    /// An object that is listed twice.
    pub repeated: Option<String>,
    /// The object types in the request's filter, if there is one; empty if the filter isn't a list of strings.
    pub filter: Option<BTreeSet<String>>,
    /// True if the request changes a setting (the RTK source or the time) instead of querying it.
    pub is_setting: bool,
    /// The time when the request was sent.
    pub time: Option<f64>,
    /// The location.
    pub location: Location,
    /// For an unanswered request: the time from the request to the latest server message, in seconds.
    pub waited: Option<f64>,
    /// The reason why the server's answer over HTTP isn't a message.
    pub failure: Option<String>,
    /// True if the request has a version and a type, as every Flockwave request must.
    pub is_sound: bool,
    /// The start of the request's text.
    pub excerpt: String,
    /// The tested rule and the description of the test.
    pub trial: Option<(&'static Rule, String)>,
    /// True if the request's id was already in use, so that answers are ambiguous.
    pub(super) is_ambiguous: bool,
    /// The number of pending requests with this id.
    pub(super) count: u64,
}

impl SentRequest {
    pub(super) fn new(exchange: &Exchange<'_>) -> Self {
        let parts = exchange.type_name.and_then(parts);
        // If subtrees are included, the response lists the subscriptions that were removed, not the requested paths.
        let includes_subtrees = exchange.field("includeSubtrees") == Some(&Tree::Bool(true));
        let parts = parts.filter(|_| !includes_subtrees);
        let objects = parts.and_then(|parts| strings(exchange.field(parts.request_field)));
        let repeated = objects.as_deref().and_then(repeated);
        let objects: Option<BTreeSet<String>> = objects.map(BTreeSet::from_iter);
        let filter = exchange.field("filter").map(|filter| strings(Some(filter)).unwrap_or_default());
        let is_setting = match exchange.type_name {
            Some("RTK-SOURCE") => exchange.field("id").is_some(),
            Some("SYS-TIME") => exchange.field("adjustment").is_some_and(|by| *by != Tree::Int(0)),
            _ => false,
        };
        Self {
            type_name: exchange.type_name.filter(|name| name.len() <= MAX_ID).map(str::to_owned),
            repeated,
            objects,
            filter: filter.map(BTreeSet::from_iter),
            is_setting,
            time: exchange.time,
            location: exchange.record.location,
            waited: None,
            failure: None,
            is_sound: exchange.is_sound(),
            excerpt: exchange
                .record
                .value
                .map_or_else(|| exchange.excerpt(), |message| message_excerpt(message, "/body")),
            trial: exchange.record.trial.map(|trial| (trial.rule, trial.how.to_owned())),
            is_ambiguous: false,
            count: 1,
        }
    }

    /// True if the other request is the same message.
    pub(super) fn is_repeated_by(&self, other: &Self) -> bool {
        self.type_name == other.type_name
            && self.objects == other.objects
            && self.filter == other.filter
            && self.is_setting == other.is_setting
            && self.excerpt == other.excerpt
    }

    /// True if the request adjusts the server's clock.
    pub(super) fn is_adjustment(&self) -> bool {
        self.is_setting && self.type_name.as_deref() == Some("SYS-TIME")
    }

    /// The approximate size, in bytes.
    pub(super) fn size(&self) -> usize {
        let object_size = |object: &String| object.len() + 64;
        let trial_size = self.trial.as_ref().map_or(0, |(_, how)| how.len());
        MAX_ID
            + self.excerpt.len()
            + trial_size
            + self.objects.iter().chain(&self.filter).flatten().map(object_size).sum::<usize>()
    }
}

/// The first repeated string.
fn repeated(texts: &[String]) -> Option<String> {
    let mut seen = BTreeSet::new();
    texts.iter().find(|text| !seen.insert(*text)).cloned()
}

/// The strings of a list. `None` if the value isn't a list of strings, or exceeds the limits.
pub(super) fn strings(list: Option<&Tree<'_>>) -> Option<Vec<String>> {
    let Some(Tree::List(values)) = list else { return None };
    let short = |value: &Tree<'_>| Some(value.as_str()?.to_owned()).filter(|text| text.len() <= MAX_ID);
    if values.len() > MAX_REQUEST_IDS { None } else { values.iter().map(short).collect() }
}
