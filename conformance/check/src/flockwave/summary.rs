//! The summary of a recorded session.

use serde::{Serialize, Serializer};
use uavspec_model::Location;
use uavspec_model::json::Tree;
use uavspec_model::text::{plural, shown, thousands};

use crate::summary::names;
use crate::{Describe, Line, MAX_LISTED, Totals};

/// The summary of a recorded session.
#[derive(Clone, Debug, Default, Serialize, schemars::JsonSchema)]
#[schemars(rename = "Flockwave")]
pub struct FlockwaveSummary {
    /// The number of connections.
    pub connections: usize,
    /// The number of requests from clients and from the server.
    pub requests: u64,
    /// The number of responses.
    pub responses: u64,
    /// The number of notifications from the server.
    pub notifications: u64,
    /// The message types that the definitions contain, by name.
    pub types: Vec<TypeCount>,
    /// The message types that the definitions lack, by name. The bodies of such messages aren't checked.
    /// Machine-readable reports list only the types that the server sent.
    #[serde(rename = "unsupported", serialize_with = "rows_of_server")]
    pub unknown: Vec<TypeCount>,
    /// The number of server messages of unknown types that are counted but not listed by name. These types have too
    /// long a name, or exceed the maximum number of types.
    pub uncounted: u64,
    /// The number of records whose `t` isn't a time, or an ambiguous time.
    #[serde(serialize_with = "count")]
    #[schemars(with = "u64")]
    pub unread_times: UnreadTimes,
}

/// Times that can't be read.
#[derive(Clone, Debug, Default)]
pub struct UnreadTimes {
    /// The number of times.
    pub count: u64,
    /// The first time, with its location.
    pub first: String,
}

impl UnreadTimes {
    pub(super) fn add(&mut self, time: &Tree<'_>, location: Location) {
        if self.count == 0 {
            self.first = format!("{time} at {location}");
        }
        self.count += 1;
    }

    /// The line of a report about these times. `None` if all times can be read.
    fn line(&self) -> Option<Line> {
        let text = format!(
            "{} can't be read, so these records have no time: expected seconds since 1970, or a date with a time zone, \
             found {}",
            plural(self.count, "time"),
            shown(&self.first)
        );
        (self.count > 0).then(|| Line::new("times", text))
    }
}

/// A message type with its counts.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[schemars(rename = "FlockwaveType")]
pub struct TypeCount {
    /// The name, e.g. `UAV-INF`.
    pub name: String,
    /// The number of messages that clients sent.
    pub from_client: u64,
    /// The number of messages that the server sent.
    pub from_server: u64,
}

impl TypeCount {
    fn total(&self) -> u64 {
        self.from_client + self.from_server
    }

    fn text(&self) -> String {
        let (from_server, from_client) = (thousands(self.from_server), thousands(self.from_client));
        format!("{}: {from_server} from the server, {from_client} from clients", shown(&self.name))
    }
}

fn count<S: Serializer>(times: &UnreadTimes, serializer: S) -> Result<S::Ok, S::Error> {
    times.count.serialize(serializer)
}

fn rows_of_server<S: Serializer>(types: &[TypeCount], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(from_server(types))
}

/// The types that the server sent. Messages from a client aren't checked, because a client may send invalid requests on
/// purpose.
fn from_server(types: &[TypeCount]) -> Vec<&TypeCount> {
    types.iter().filter(|row| row.from_server > 0).collect()
}

/// The types with the most messages.
fn frequent(types: &[TypeCount]) -> String {
    let mut rows: Vec<&TypeCount> = types.iter().collect();
    rows.sort_by_key(|row| std::cmp::Reverse(row.total()));
    let reported =
        rows.iter().take(MAX_LISTED).map(|row| format!("{} {}", shown(&row.name), thousands(row.total())));
    if rows.is_empty() { "none".to_owned() } else { reported.collect::<Vec<_>>().join(", ") }
}

impl Describe for FlockwaveSummary {
    fn facts(&self, totals: Totals) -> Vec<String> {
        vec![
            "Flockwave".to_owned(),
            plural(self.connections, "connection"),
            totals.duration(),
            plural(self.requests, "request"),
            plural(self.responses, "response"),
            plural(self.notifications, "notification"),
        ]
    }

    fn lines(&self) -> Vec<Line> {
        let text = format!("{}, the most frequent: {}", self.types.len(), frequent(&self.types));
        let details = self.types.iter().map(TypeCount::text).collect();
        let mut lines = vec![Line { details, ..Line::new("types", text) }];
        let unsupported = from_server(&self.unknown);
        if !unsupported.is_empty() || self.uncounted > 0 {
            let messages = unsupported.iter().map(|row| row.total()).sum::<u64>() + self.uncounted;
            let mut reported = Vec::new();
            if !unsupported.is_empty() {
                reported.push(names(unsupported.iter().map(|row| row.name.as_str())));
            }
            if self.uncounted > 0 {
                reported.push("types not listed by name".to_owned());
            }
            let reported = reported.join(", ");
            let text = format!("{} without a definition: {reported}", plural(messages, "message"));
            let details = unsupported.iter().map(|row| row.text()).collect();
            lines.push(Line { details, ..Line::new("unsupported", text) });
        }
        lines.extend(self.unread_times.line());
        lines
    }

    fn is_session(&self) -> bool {
        true
    }
}
