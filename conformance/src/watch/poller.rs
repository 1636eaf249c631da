//! What a server is to be asked, and when. Nothing is sent here: the same answers at the same times lead to the same
//! questions, and to no more than one at a time that is about states.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::message::{Message, News};
use super::roster::Roster;

/// How often it is asked which UAVs there are. Servers tell when one leaves, but not when one comes.
const LIST_PERIOD: Duration = Duration::from_secs(5);

/// How often it is asked for the time of the server.
const TIME_PERIOD: Duration = Duration::from_secs(60);

/// How long a UAV may be silent until it is asked for. Servers tell of their fleet once a second or more often,
/// where they tell of it by themselves.
const SILENCE: Duration = Duration::from_secs(2);

/// How long an answer is waited for before something else is asked.
const ANSWER_LIMIT: Duration = Duration::from_secs(3);

/// How often it is looked who has been silent for too long.
const CHECK_INTERVAL: Duration = Duration::from_millis(50);

/// For how many UAVs it is asked at once, and how many bytes their ids may have: the answer has to fit into a
/// datagram.
const CHUNK: usize = 50;
const CHUNK_BYTES: usize = 4 << 10;

/// What is kept of the open request for states.
struct Open {
    id: String,
    until: Instant,
}

/// Asks a server for its fleet.
pub(super) struct Poller {
    is_one_shot: bool,
    /// The UAVs, and when each was asked for or told of last.
    roster: Roster<Option<Instant>>,
    waiting: VecDeque<Value>,
    open: Option<Open>,
    next_list: Instant,
    next_time: Instant,
    next_look: Instant,
    /// How many requests were made.
    count: u64,
}

impl Poller {
    /// One for a connection that has just been opened; over one where nothing comes but answers, `is_one_shot`.
    pub(super) fn new(is_one_shot: bool, now: Instant) -> Self {
        Self {
            is_one_shot,
            roster: Roster::default(),
            waiting: VecDeque::from([json!({ "type": "SYS-VER" })]),
            open: None,
            next_list: now,
            next_time: now,
            next_look: now,
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
        self.open = self.open.take().filter(|open| open.until > now);
        if self.open.is_some() || self.next_look > now {
            return None;
        }
        self.next_look = now + CHECK_INTERVAL;
        let ids = self.silent(now);
        if ids.is_empty() {
            return None;
        }
        let request = self.request(&json!({ "type": "UAV-INF", "ids": ids }));
        self.open = Some(Open { id: self.id(), until: now + ANSWER_LIMIT });
        Some(request)
    }

    /// Takes what came.
    pub(super) fn take(&mut self, message: &Message, now: Instant) {
        let is_answer = self.open.as_ref().is_some_and(|open| match &message.refs {
            Some(refs) => *refs == open.id,
            // Without its envelope an answer doesn't say what it answers.
            None => self.is_one_shot && matches!(message.news, News::States(_) | News::Refused(_)),
        });
        if is_answer {
            self.open = None;
            self.next_look = now;
        }
        match &message.news {
            News::List(list) => {
                self.roster.update(list, now);
            }
            News::States(states) => {
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
            News::Gone(ids) => ids.iter().for_each(|id| self.roster.remove(id)),
            _ => {}
        }
    }

    /// The UAVs that are to be asked for next: those first that were never asked for.
    fn silent(&mut self, now: Instant) -> Vec<String> {
        let is_due = |last: Option<Instant>| last.is_none_or(|last| now.duration_since(last) >= SILENCE);
        let mut due: Vec<(Option<Instant>, &str)> = self
            .roster
            .iter()
            .map(|(id, member)| (member.value, id))
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
            if let Some(member) = self.roster.get_mut(id) {
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
    use super::*;

    /// All that is asked now: types, and of how many UAVs.
    fn requested(poller: &mut Poller, now: Instant) -> Vec<(String, usize)> {
        let requests = std::iter::from_fn(|| poller.next(now));
        let body = |text: String| serde_json::from_str::<Value>(&text).expect("JSON")["body"].take();
        let in_short = |body: Value| {
            let count = body["ids"].as_array().map_or(0, Vec::len);
            (body["type"].as_str().expect("a type").to_owned(), count)
        };
        requests.map(body).map(in_short).collect()
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
    fn requests_a_large_fleet_in_consecutive_parts() {
        let now = Instant::now();
        let mut poller = Poller::new(false, now);
        assert_eq!(requested(&mut poller, now), named(&[("SYS-VER", 0), ("SYS-TIME", 0), ("UAV-LIST", 0)]));
        receive(&mut poller, &list(120), now);
        let now = now + CHECK_INTERVAL;
        assert_eq!(requested(&mut poller, now), named(&[("UAV-INF", 50)]));
        // A notification is no answer.
        receive(&mut poller, &states(None, 0..1), now);
        assert_eq!(requested(&mut poller, now + CHECK_INTERVAL), []);
        receive(&mut poller, &states(Some("watch-4"), 0..50), now);
        assert_eq!(requested(&mut poller, now), named(&[("UAV-INF", 50)]));
        // The answer gets lost, or comes without its envelope, so that it could be anything.
        receive(&mut poller, &states(None, 0..1), now);
        assert_eq!(requested(&mut poller, now + CHECK_INTERVAL), []);
        let now = now + ANSWER_LIMIT;
        assert_eq!(requested(&mut poller, now), named(&[("UAV-INF", 50)]));
    }

    #[test]
    fn over_http_an_answer_needs_no_envelope() {
        let now = Instant::now();
        let mut poller = Poller::new(true, now);
        requested(&mut poller, now);
        receive(&mut poller, &list(60), now);
        let now = now + CHECK_INTERVAL;
        assert_eq!(requested(&mut poller, now), named(&[("UAV-INF", 50)]));
        receive(&mut poller, &states(None, 0..50), now);
        assert_eq!(requested(&mut poller, now), named(&[("UAV-INF", 10)]));
    }

    #[test]
    fn does_not_request_recently_reported_uavs() {
        let now = Instant::now();
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
        let start = Instant::now();
        let mut poller = Poller::new(false, start);
        let seconds = 0..120;
        let all: Vec<_> =
            seconds.flat_map(|second| requested(&mut poller, start + Duration::from_secs(second))).collect();
        let count = |kind: &str| all.iter().filter(|(requested, _)| requested == kind).count();
        assert_eq!((count("SYS-VER"), count("SYS-TIME"), count("UAV-LIST")), (1, 2, 24));
    }
}
