//! Chooses the next request to the server. This module doesn't send anything, so the same messages at the same times
//! result in the same requests. At most one request for states is pending at a time.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::message::{Content, Message};
use super::roster::Roster;

/// The interval between requests for the list of UAVs. Servers report when a UAV leaves, but not when a UAV joins.
const LIST_PERIOD: Duration = Duration::from_secs(5);

/// The interval between requests for the server's clock.
const TIME_PERIOD: Duration = Duration::from_secs(60);

/// The maximum time without a report from a UAV. After this time, the UAV's state is requested. Servers that report
/// states without requests do so at least once per second.
const SILENCE: Duration = Duration::from_secs(2);

/// The maximum time to wait for a response.
const ANSWER_LIMIT: Duration = Duration::from_secs(3);

/// The interval between searches for UAVs without recent reports.
const SEARCH_INTERVAL: Duration = Duration::from_millis(50);

/// The maximum number of UAVs per request. The response must fit into a datagram.
const CHUNK: usize = 50;

/// The maximum total length of the ids in a request, in bytes.
const CHUNK_BYTES: usize = 4 << 10;

/// Chooses requests for the state of a fleet.
pub(super) struct Poller {
    is_one_shot: bool,
    /// The UAVs, with the time of the last request or report for each.
    roster: Roster<Option<Instant>>,
    waiting: VecDeque<Value>,
    /// The id of the pending request for states, and its deadline.
    pending: Option<(String, Instant)>,
    next_list: Instant,
    next_time: Instant,
    next_search: Instant,
    /// The number of requests that have been sent.
    count: u64,
}

impl Poller {
    /// Creates a poller for a new connection. `is_one_shot` is true if the server sends only responses.
    pub(super) fn new(is_one_shot: bool, now: Instant) -> Self {
        Self {
            is_one_shot,
            roster: Roster::default(),
            waiting: VecDeque::from([json!({ "type": "SYS-VER" })]),
            pending: None,
            next_list: now,
            next_time: now,
            next_search: now,
            count: 0,
        }
    }

    /// The next request that is due.
    pub(super) fn next(&mut self, now: Instant) -> Option<String> {
        if let Some(body) = self.waiting.pop_front() {
            return Some(self.request(&body));
        }
        if self.next_time <= now {
            self.next_time = now + TIME_PERIOD;
            return Some(self.request(&json!({ "type": "SYS-TIME" })));
        }
        if self.next_list <= now {
            self.next_list = now + LIST_PERIOD;
            return Some(self.request(&json!({ "type": "UAV-LIST" })));
        }
        self.pending = self.pending.take().filter(|(_, until)| *until > now);
        if self.pending.is_some() || self.next_search > now {
            return None;
        }
        self.next_search = now + SEARCH_INTERVAL;
        let ids = self.overdue(now);
        if ids.is_empty() {
            return None;
        }
        let request = self.request(&json!({ "type": "UAV-INF", "ids": ids }));
        self.pending = Some((self.id(), now + ANSWER_LIMIT));
        Some(request)
    }

    /// Processes a message.
    pub(super) fn take(&mut self, message: &Message, now: Instant) {
        let is_response = self.pending.as_ref().is_some_and(|(id, _)| match &message.refs {
            Some(refs) => refs == id,
            // A response without an envelope doesn't identify its request.
            None => self.is_one_shot && matches!(message.content, Content::States(_) | Content::Refused(_)),
        });
        if is_response {
            self.pending = None;
            self.next_search = now;
        }
        match &message.content {
            Content::List(list) => {
                self.roster.update(list, now);
            }
            Content::States(states) => {
                for (id, state) in states {
                    let known = if state.is_ok() { self.roster.admit(id) } else { None };
                    if let Some(member) = known {
                        member.value = Some(now);
                        if message.refs.is_none() {
                            member.last_reported = Some(now);
                        }
                    }
                }
            }
            Content::Gone(ids) => {
                for id in ids {
                    self.roster.members.remove(id);
                }
            }
            _ => {}
        }
    }

    /// The UAVs whose states to request next. UAVs whose states haven't been requested yet come first.
    fn overdue(&mut self, now: Instant) -> Vec<String> {
        let is_due = |last: Option<Instant>| last.is_none_or(|last| now.duration_since(last) >= SILENCE);
        let mut due: Vec<(Option<Instant>, &str)> = self
            .roster
            .members
            .iter()
            .map(|(id, member)| (member.value, id.as_str()))
            .filter(|(last, _)| is_due(*last))
            .collect();
        due.sort_unstable();
        let mut bytes = 0;
        let due = due.into_iter().take(CHUNK).take_while(|(_, id)| {
            bytes += id.len();
            bytes <= CHUNK_BYTES
        });
        let ids: Vec<String> = due.map(|(_, id)| id.to_owned()).collect();
        for id in &ids {
            if let Some(member) = self.roster.members.get_mut(id) {
                member.value = Some(now);
            }
        }
        ids
    }

    fn request(&mut self, body: &Value) -> String {
        self.count += 1;
        json!({ "$fw.version": "1.0", "id": self.id(), "body": body }).to_string()
    }

    /// The id of the latest request.
    fn id(&self) -> String {
        format!("watch-{}", self.count)
    }
}

#[cfg(test)]
mod tests {
    use uavspec_model::clock::Clock;

    use super::*;

    /// The types of all due requests, and the number of UAVs in each request.
    fn requested(poller: &mut Poller, now: Instant) -> Vec<(String, usize)> {
        let requests = std::iter::from_fn(|| poller.next(now));
        let body = |text: String| serde_json::from_str::<Value>(&text).expect("JSON")["body"].take();
        let summary = |body: Value| {
            let count = body["ids"].as_array().map_or(0, Vec::len);
            (body["type"].as_str().expect("a type").to_owned(), count)
        };
        requests.map(body).map(summary).collect()
    }

    fn receive(poller: &mut Poller, text: &str, now: Instant) {
        poller.take(&Message::read(text.as_bytes()), now);
    }

    fn list(count: usize) -> String {
        let ids: Vec<String> = (0..count).map(|number| format!("glider-{number:03}")).collect();
        json!({ "type": "UAV-LIST", "ids": ids }).to_string()
    }

    fn states(refs: Option<&str>, ids: std::ops::Range<usize>) -> String {
        let states = ids.map(|number| (format!("glider-{number:03}"), json!({})));
        let states: serde_json::Map<_, _> = states.collect();
        let mut message = json!({ "body": { "type": "UAV-INF", "status": states } });
        if let Some(refs) = refs {
            message["refs"] = json!(refs);
        }
        message.to_string()
    }

    fn named(all: &[(&str, usize)]) -> Vec<(String, usize)> {
        all.iter().map(|(kind, count)| ((*kind).to_owned(), *count)).collect()
    }

    #[test]
    fn requests_a_large_fleet_in_parts() {
        let now = Clock::simulated().now();
        let mut poller = Poller::new(false, now);
        assert_eq!(requested(&mut poller, now), named(&[("SYS-VER", 0), ("SYS-TIME", 0), ("UAV-LIST", 0)]));
        receive(&mut poller, &list(120), now);
        let now = now + SEARCH_INTERVAL;
        assert_eq!(requested(&mut poller, now), named(&[("UAV-INF", 50)]));
        // A notification is not a response.
        receive(&mut poller, &states(None, 0..1), now);
        assert_eq!(requested(&mut poller, now + SEARCH_INTERVAL), []);
        receive(&mut poller, &states(Some("watch-4"), 0..50), now);
        assert_eq!(requested(&mut poller, now), named(&[("UAV-INF", 50)]));
        // The response was lost, or can't be identified because it has no envelope.
        receive(&mut poller, &states(None, 0..1), now);
        assert_eq!(requested(&mut poller, now + SEARCH_INTERVAL), []);
        let now = now + ANSWER_LIMIT;
        assert_eq!(requested(&mut poller, now), named(&[("UAV-INF", 50)]));
    }

    #[test]
    fn accepts_responses_without_an_envelope_over_http() {
        let now = Clock::simulated().now();
        let mut poller = Poller::new(true, now);
        requested(&mut poller, now);
        receive(&mut poller, &list(60), now);
        let now = now + SEARCH_INTERVAL;
        assert_eq!(requested(&mut poller, now), named(&[("UAV-INF", 50)]));
        receive(&mut poller, &states(None, 0..50), now);
        assert_eq!(requested(&mut poller, now), named(&[("UAV-INF", 10)]));
    }

    #[test]
    fn does_not_request_recently_reported_uavs() {
        let now = Clock::simulated().now();
        let mut poller = Poller::new(false, now);
        requested(&mut poller, now);
        receive(&mut poller, &list(3), now);
        for half in 1..8 {
            let now = now + SILENCE / 2 * half;
            receive(&mut poller, &states(None, 0..3), now);
            assert!(requested(&mut poller, now).iter().all(|(kind, _)| kind != "UAV-INF"));
        }
        let now = now + SILENCE * 6;
        assert_eq!(requested(&mut poller, now), named(&[("UAV-LIST", 0), ("UAV-INF", 3)]));
        receive(&mut poller, r#"{"type": "OBJ-DEL", "ids": ["glider-000"]}"#, now);
        let now = now + ANSWER_LIMIT;
        assert_eq!(requested(&mut poller, now), named(&[("UAV-INF", 2)]));
    }

    #[test]
    fn requests_lists_periodically() {
        let start = Clock::simulated().now();
        let mut poller = Poller::new(false, start);
        let seconds = 0..120;
        let all: Vec<_> =
            seconds.flat_map(|second| requested(&mut poller, start + Duration::from_secs(second))).collect();
        let count = |kind: &str| all.iter().filter(|(requested, _)| requested == kind).count();
        assert_eq!((count("SYS-VER"), count("SYS-TIME"), count("UAV-LIST")), (1, 2, 24));
    }
}
