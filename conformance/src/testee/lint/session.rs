//! A conversation with a testee, in which what it may say is known.

use std::collections::{BTreeMap, BTreeSet};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::testee::case::Case;
use crate::testee::link::{Link, Received, remaining_stderr};
use crate::testee::options::{Options, excerpt};
use crate::testee::protocol::{Answer, Hello};

/// The first id of questions that no check chose.
const FIRST_ID: i64 = 1_000;

/// How long is waited between the parts of a line, so that they come apart.
const PAUSE: Duration = Duration::from_millis(10);

/// A conversation with a testee that has introduced itself.
pub(super) struct Session<'o> {
    link: Link,
    options: &'o Options,
    next_id: i64,
    received: ReceivedAnswers,
}

/// What was heard, and what may still come.
#[derive(Default)]
pub(super) struct ReceivedAnswers {
    /// Questions without an answer.
    open: BTreeSet<i64>,
    /// Questions that need no answer, but may have one.
    optional: BTreeSet<i64>,
    /// What was answered.
    answers: BTreeMap<i64, Answer>,
    /// How many lines with `error` and without an id may come: as many as there were lines without an id.
    refusals: usize,
    /// How many more times it may introduce itself.
    hellos_due: usize,
    /// The lines in which it did so again.
    pub(super) hellos: Vec<Vec<u8>>,
    /// The id of the first answer that belongs to no question.
    pub(super) foreign: Option<i64>,
    /// The first id that was answered more than once.
    pub(super) repeated: Option<i64>,
    /// Lines that are neither an answer nor a hello.
    pub(super) strays: Strays,
}

/// Lines that answer nothing: the first few, since a testee may say much.
#[derive(Default)]
pub(super) struct Strays {
    first: Vec<String>,
    more: usize,
}

impl Strays {
    /// Most that are kept.
    const MAX_KEPT: usize = 5;

    fn push(&mut self, what: String) {
        if self.first.len() < Self::MAX_KEPT {
            self.first.push(what);
        } else {
            self.more += 1;
        }
    }

    /// Takes those of a session.
    pub(super) fn append(&mut self, others: Self) {
        others.first.into_iter().for_each(|what| self.push(what));
        self.more += others.more;
    }

    /// All of it in words; none where there is nothing.
    pub(super) fn summary(&self) -> Option<String> {
        let more = if self.more > 0 { format!("; and {} more", self.more) } else { String::new() };
        (!self.first.is_empty()).then(|| self.first.join("; ") + &more)
    }
}

impl<'o> Session<'o> {
    pub(super) fn start(options: &'o Options) -> Result<Self, String> {
        let mut link = Link::open(options, true)?;
        link.introduction(options).map_err(|wrong| format!("it doesn't introduce itself again: {wrong}"))?;
        Ok(Self { link, options, next_id: FIRST_ID, received: ReceivedAnswers::default() })
    }

    /// An id that no question has.
    pub(super) fn fresh_id(&mut self) -> i64 {
        self.next_id += 1;
        self.next_id
    }

    /// A line that asks a case, and its id.
    pub(super) fn question(&mut self, case: &Case) -> (i64, Value) {
        let id = self.fresh_id();
        let mut question = case.request(0);
        question["id"] = id.into();
        (id, question)
    }

    /// Sends a question that must be answered.
    pub(super) fn send(&mut self, id: i64, question: &Value) {
        self.expect(id);
        self.link.send(question.to_string());
    }

    /// Asks a case.
    pub(super) fn send_case(&mut self, case: &Case) -> i64 {
        let (id, question) = self.question(case);
        self.send(id, &question);
        id
    }

    /// Notes a question that is sent by other means.
    pub(super) fn expect(&mut self, id: i64) {
        self.received.open.insert(id);
    }

    /// Sends bytes with one write.
    pub(super) fn send_bytes(&self, bytes: Vec<u8>) {
        self.link.send_bytes(bytes);
    }

    /// Sends bytes in parts that come apart.
    pub(super) fn send_parts<'p>(&self, parts: impl IntoIterator<Item = &'p [u8]>) {
        for part in parts {
            self.link.send_bytes(part.to_vec());
            thread::sleep(PAUSE);
        }
    }

    /// Sends a line that is no question: it may be answered under the id, or refused without one, or passed over.
    pub(super) fn send_malformed(&mut self, id: Option<i64>, line: &[u8]) {
        self.received.optional.extend(id);
        self.received.refusals += 1;
        self.link.send_bytes([line, b"\n"].concat());
    }

    /// Asks for one more hello, which may be given, refused or passed over.
    pub(super) fn send_hello(&mut self) {
        self.received.hellos_due += 1;
        self.received.refusals += 1;
        self.link.send(Hello::request());
    }

    /// Waits until all questions have their answers.
    pub(super) fn receive(&mut self) -> Result<(), String> {
        let mut until = Instant::now() + self.options.timeout;
        while !self.is_answered() {
            let wrong = match self.link.receive(until) {
                Received::Line(line) => {
                    // Lines that are no answers don't win time.
                    if self.received.take(&line) {
                        until = Instant::now() + self.options.timeout;
                    }
                    continue;
                }
                Received::Nothing => {
                    let after = self.options.timeout.as_secs_f32();
                    format!("no answer to {} within {after} s", self.missing())
                }
                Received::TooLong => {
                    let what = format!("a line of more than {} bytes", self.options.line_limit);
                    self.received.strays.push(what.clone());
                    what
                }
                Received::Closed => {
                    format!("{}, without an answer to {}", self.link.ending(until), self.missing())
                }
                Received::Lost(how) => format!("{how}, without an answer to {}", self.missing()),
            };
            return Err(wrong + &remaining_stderr(&self.link.kill()));
        }
        Ok(())
    }

    /// Asks a case, and waits for the answer: whatever came before has been seen, and survived.
    pub(super) fn survive(&mut self, case: &Case) -> Result<(), String> {
        self.send_case(case);
        self.receive()
    }

    /// Closes the input of the testee, and hears it out.
    pub(super) fn part(&mut self) -> Result<(), String> {
        let received = &mut self.received;
        let parted = self.link.part(self.options.timeout, |line| {
            received.take(line);
        });
        parted.map_err(|wrong| wrong + &remaining_stderr(&self.link.kill()))
    }

    /// The answer to a question.
    pub(super) fn answer(&self, id: i64) -> Option<&Answer> {
        self.received.answers.get(&id)
    }

    /// The questions without an answer, in words; the first few, where there are many.
    pub(super) fn missing(&self) -> String {
        let ids: Vec<String> = self.received.open.iter().take(3).map(|id| format!("id {id}")).collect();
        let more = self.received.open.len() - ids.len();
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        ids.join(", ") + &more
    }

    /// Whether all questions have answers.
    pub(super) fn is_answered(&self) -> bool {
        self.received.open.is_empty()
    }

    /// What was heard so far.
    pub(super) const fn received(&self) -> &ReceivedAnswers {
        &self.received
    }

    /// What was said that answers nothing.
    pub(super) fn into_strays(self) -> Strays {
        self.received.strays
    }
}

impl ReceivedAnswers {
    /// Takes a line; whether it is the answer to a question that needs one.
    fn take(&mut self, line: &[u8]) -> bool {
        match Answer::read(line.trim_ascii()) {
            Ok((id, answer)) => {
                let is_awaited = self.open.remove(&id);
                if is_awaited || self.optional.remove(&id) {
                    self.answers.insert(id, answer);
                } else if self.answers.contains_key(&id) {
                    self.repeated.get_or_insert(id);
                } else {
                    self.foreign.get_or_insert(id);
                }
                return is_awaited;
            }
            Err(_) if self.hellos_due > 0 && Hello::read(line).is_ok() => {
                self.hellos_due -= 1;
                self.hellos.push(line.to_vec());
            }
            Err(_) if self.refusals > 0 && is_refusal(line) => self.refusals -= 1,
            Err(wrong) => self.strays.push(format!("{wrong}: {}", excerpt(line))),
        }
        false
    }
}

/// Whether a line is what a question without an id may be answered with.
fn is_refusal(line: &[u8]) -> bool {
    serde_json::from_slice(line).is_ok_and(|value: Value| {
        value.get("id").is_none_or(Value::is_null)
            && (value.get("error").is_some() || value["unsupported"] == true)
    })
}
