//! Runs cases, and finds the cases that fail, time out or crash the testee.
//!
//! If the testee listens on a port, connections are used instead of processes.
//!
//! Several requests are pending at a time. If the process ends or stops responding, one of the pending requests is the
//! probable cause. Each pending request is repeated alone, the oldest first, until a process ends after receiving only
//! one request. A case therefore counts as crashed only if it crashes the testee by itself. Other crashes become
//! remarks.
//!
//! Neighbouring cases often fail together. After a crash, requests are therefore sent one at a time, and the limit on
//! pending requests doubles with each response. If every case crashes the testee, each case needs only one process
//! start.
//!
//! If the testee doesn't work, a run ends early: after a few timeouts, after many crashes, or after many bytes of wrong
//! responses.

use std::collections::{BTreeSet, VecDeque};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Instant;

use uavspec_dynamic::Types;

use super::case::Case;
use super::compare::compare;
use super::link::{Link, Received};
use super::options::{Options, excerpt};
use super::outcome::{Outcome, ProtocolRemarks, Verdict};
use super::protocol::{Hello, Response};
use super::timeouts::Timeouts;
use crate::limits::MAX_CRASHES;

/// Runs the selected cases, which are given as indices. On the wire, the index of a case is its id. Fails if the testee
/// can't be started, or sends no valid hello. `progress` receives the number of finished cases and the total number.
pub fn run<'c>(
    cases: &'c [Case],
    selected: &[usize],
    types: &Types,
    options: &Options,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Outcome<'c>, String> {
    let (first, hello) = start(options, false)?;
    let (supported, others): (Vec<usize>, Vec<usize>) =
        selected.iter().partition(|id| cases.get(**id).is_some_and(|case| case.is_for(&hello)));
    let total = supported.len();
    let state = State { queue: supported.into(), ..State::default() };
    let shared = Shared { cases, types, options, progress, total, state: Mutex::new(state) };
    let mut first = Some(first);
    thread::scope(|scope| {
        for _ in 0..options.jobs.max(1) {
            let worker = Worker::new(&shared, first.take());
            scope.spawn(|| worker.run());
        }
    });
    let mut state = shared.state.into_inner().unwrap_or_else(PoisonError::into_inner);
    let gave_up = state.gave_up.take().map(|why| why + &unanswered(&state, total));
    state.verdicts.extend(others.into_iter().map(|id| (id, Verdict::Unsupported)));
    state.verdicts.extend(state.queue.drain(..).map(|id| (id, Verdict::NotRun)));
    state.verdicts.sort_by_key(|(id, _)| *id);
    let verdicts = state.verdicts.into_iter().filter_map(|(id, verdict)| Some((cases.get(id)?, verdict)));
    Ok(Outcome {
        hello: Some(hello),
        verdicts: verdicts.collect(),
        protocol_remarks: state.protocol_remarks,
        restarts: state.restarts,
        gave_up,
    })
}

/// The numbers of unanswered requests, as the last part of the reason why a run ended early.
fn unanswered(state: &State, total: usize) -> String {
    let is_response =
        |verdict: &Verdict| !matches!(verdict, Verdict::TimedOut { .. } | Verdict::Crashed { .. });
    let responses = state.verdicts.iter().filter(|(_, verdict)| is_response(verdict)).count();
    let sent = state.sent.len();
    let (unanswered, unsent) = (sent.saturating_sub(responses), total.saturating_sub(sent));
    format!("; requests without a response: {unanswered}, requests that were not sent: {unsent}")
}

/// Starts a process or opens a connection, and requests a hello.
fn start(options: &Options, is_reconnect: bool) -> Result<(Link, Hello), String> {
    let mut link = Link::open(options, is_reconnect)?;
    match link.introduction(options) {
        Ok((hello, _)) => Ok((link, hello)),
        Err(wrong) => Err(format!("no valid hello from {}: {wrong}", options.target)),
    }
}

struct Shared<'r> {
    cases: &'r [Case],
    types: &'r Types,
    options: &'r Options,
    progress: &'r (dyn Fn(usize, usize) + Sync),
    total: usize,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    queue: VecDeque<usize>,
    /// The requests that have been sent at least once.
    sent: BTreeSet<usize>,
    verdicts: Vec<(usize, Verdict)>,
    /// The number of bytes in lines that aren't correct responses.
    wrong_bytes: usize,
    protocol_remarks: ProtocolRemarks,
    restarts: u32,
    gave_up: Option<String>,
}

impl Shared<'_> {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn decide(&self, id: usize, verdict: Verdict) {
        let mut state = self.state();
        state.verdicts.push((id, verdict));
        (self.progress)(state.verdicts.len(), self.total);
    }

    fn remark(&self, what: String) {
        self.state().protocol_remarks.remark(what);
    }

    /// Ends the run early. Only the first reason is kept.
    fn give_up(&self, why: String) {
        self.state().gave_up.get_or_insert(why);
    }

    /// Counts the bytes of a line that isn't a correct response.
    fn count_wrong(&self, length: usize) {
        let limit = self.options.wrong_limit();
        let mut state = self.state();
        state.wrong_bytes = state.wrong_bytes.saturating_add(length);
        let is_over = state.wrong_bytes > limit;
        drop(state);
        if is_over {
            self.give_up(format!("gave up after {limit} bytes of wrong responses and other lines"));
        }
    }
}

/// The reason why a process can no longer be used.
#[derive(Clone, Debug)]
enum End {
    Silent,
    Ended(String),
}

/// Runs cases, one process at a time.
struct Worker<'s, 'r> {
    shared: &'s Shared<'r>,
    link: Option<Link>,
    /// Pending requests, the oldest first.
    pending: VecDeque<usize>,
    /// The number of requests sent to this process.
    num_sent: usize,
    /// The maximum number of pending requests.
    window: usize,
    answered: BTreeSet<usize>,
    /// The time of the last request or response.
    last: Instant,
    /// The requests to repeat alone.
    suspects: VecDeque<usize>,
    /// The reason why suspected requests are repeated.
    suspicion: Option<String>,
    /// The number of restarts since this worker last attributed a crash to a case. Each worker has a separate count,
    /// because each needs some restarts to find a case.
    futile: u32,
    timeouts: Timeouts,
    /// The number of cases that crashed the testee since its last response.
    crashes: u32,
    /// The number of bytes since the last response.
    stray_bytes: usize,
}

impl<'s, 'r> Worker<'s, 'r> {
    fn new(shared: &'s Shared<'r>, link: Option<Link>) -> Self {
        Self {
            shared,
            link,
            pending: VecDeque::new(),
            num_sent: 0,
            window: shared.options.window.max(1),
            answered: BTreeSet::new(),
            last: shared.options.clock.now(),
            suspects: VecDeque::new(),
            suspicion: None,
            futile: 0,
            timeouts: Timeouts::default(),
            crashes: 0,
            stray_bytes: 0,
        }
    }

    fn run(mut self) {
        // The first process of an additional worker doesn't count as a restart.
        let mut is_restart = self.link.is_some();
        while self.has_work() {
            if self.link.is_none() && !self.start(is_restart) {
                break;
            }
            is_restart = true;
            self.send_requests();
            if !self.pending.is_empty() {
                self.receive();
            }
        }
        self.end();
        // Cases that were not run because the run ended early.
        self.shared.state().queue.extend(self.pending.drain(..).chain(self.suspects.drain(..)));
    }

    fn has_work(&self) -> bool {
        let state = self.shared.state();
        state.gave_up.is_none()
            && !(self.pending.is_empty() && self.suspects.is_empty() && state.queue.is_empty())
    }

    fn start(&mut self, is_restart: bool) -> bool {
        if is_restart {
            if self.futile >= self.shared.options.max_restarts {
                let why =
                    self.suspicion.as_ref().map(|why| format!("; the last time, {why}")).unwrap_or_default();
                let restarts =
                    format!("{} consecutive restarts without finding the case that causes them", self.futile);
                self.shared.give_up(format!("gave up after {restarts}{why}"));
                return false;
            }
            self.shared.state().restarts += 1;
            self.futile += 1;
        }
        match start(self.shared.options, true) {
            Ok((link, _)) => {
                self.link = Some(link);
                self.num_sent = 0;
                self.stray_bytes = 0;
                self.answered.clear();
                true
            }
            Err(error) => {
                let before = self
                    .suspicion
                    .as_ref()
                    .map(|why| format!("\n  note: before that, {why}"))
                    .unwrap_or_default();
                self.shared.give_up(error + &before);
                false
            }
        }
    }

    /// Sends the requests that may be sent now. Requests suspected of causing a crash are sent one at a time.
    fn send_requests(&mut self) {
        if self.suspicion.is_some() {
            if self.pending.is_empty()
                && let Some(id) = self.suspects.pop_front()
            {
                self.send(id);
            }
            return;
        }
        while self.pending.len() < self.window {
            let Some(id) = self.shared.state().queue.pop_front() else { return };
            self.send(id);
        }
    }

    fn send(&mut self, id: usize) {
        if self.pending.is_empty() {
            self.last = self.shared.options.clock.now();
        }
        if let (Some(link), Some(case)) = (&self.link, self.shared.cases.get(id)) {
            link.send(case.request(id as u64).to_string());
            self.shared.state().sent.insert(id);
            self.pending.push_back(id);
            self.num_sent += 1;
        }
    }

    fn receive(&mut self) {
        let until = self.last + self.shared.options.timeout;
        let Some(testee) = &mut self.link else { return };
        match testee.receive(until) {
            Received::Line(line) => self.line(&line),
            Received::Nothing => return self.process_ended(End::Silent),
            Received::TooLong => {
                let limit = self.shared.options.line_limit;
                self.shared.count_wrong(limit);
                return self
                    .process_ended(End::Ended(format!("the testee sent a line longer than {limit} bytes")));
            }
            Received::Closed => {
                let how = testee.ending(until);
                return self.process_ended(End::Ended(how));
            }
            Received::Lost(how) => return self.process_ended(End::Ended(how)),
        }
        let limit = self.shared.options.stray_limit();
        if self.stray_bytes > limit {
            let how = format!("the testee sent more than {limit} bytes without a response");
            return self.process_ended(End::Ended(how));
        }
        // Lines other than responses don't extend the time limit.
        if !self.pending.is_empty()
            && self.shared.options.clock.now() >= self.last + self.shared.options.timeout
        {
            self.process_ended(End::Silent);
        }
    }

    fn line(&mut self, line: &[u8]) {
        let (id, answer) = match Response::read_lenient(line.trim_ascii()) {
            Ok(answer) => answer,
            Err(wrong) => return self.stray(line, format!("{wrong}: {}", excerpt(line))),
        };
        let location = self.pending.iter().position(|pending| i64::try_from(*pending) == Ok(id));
        let Some((id, case)) = location.and_then(|location| {
            let id = self.pending.remove(location)?;
            Some((id, self.shared.cases.get(id)?))
        }) else {
            let is_repeated = usize::try_from(id).is_ok_and(|id| self.answered.contains(&id));
            let what = if is_repeated { "duplicate" } else { "unexpected" };
            return self.stray(line, format!("{what} response with id {id}"));
        };
        self.answered.insert(id);
        self.timeouts.answered();
        (self.crashes, self.stray_bytes) = (0, 0);
        self.last = self.shared.options.clock.now();
        self.window = (2 * self.window).min(self.shared.options.window.max(1));
        let verdict = check_answer(case, &answer, self.shared.types);
        if verdict.is_failure() {
            self.shared.count_wrong(line.len());
        }
        self.shared.decide(id, verdict);
        if self.suspects.is_empty()
            && self.pending.is_empty()
            && let Some(what) = self.suspicion.take()
        {
            self.shared.remark(what + ", but none of them causes this on its own");
        }
    }

    /// Adds a remark on a line that isn't a response to a pending request.
    fn stray(&mut self, line: &[u8], what: String) {
        self.shared.remark(what);
        // Line ends count as well, so empty lines can't continue forever.
        self.stray_bytes += line.len() + 1;
        self.shared.count_wrong(line.len() + 1);
    }

    /// Stops using the process, and determines which request caused its end.
    fn process_ended(&mut self, end: End) {
        let Some(mut link) = self.link.take() else { return };
        let stderr = link.kill();
        if matches!(end, End::Silent)
            && let Some(why) = self.timeouts.count(self.shared.options)
        {
            self.shared.give_up(why);
        }
        if let (1, 1, Some(id)) = (self.pending.len(), self.num_sent, self.pending.front().copied()) {
            self.pending.clear();
            let after = self.shared.options.timeout;
            self.crashes += u32::from(matches!(end, End::Ended(_)));
            if self.crashes >= MAX_CRASHES {
                self.shared.give_up(format!("gave up after {MAX_CRASHES} consecutive crashes"));
            }
            self.shared.decide(
                id,
                match end {
                    End::Silent => Verdict::TimedOut { after, stderr },
                    End::Ended(how) => Verdict::Crashed { how, stderr },
                },
            );
            (self.suspicion, self.window, self.futile) = (None, 1, 0);
            let mut state = self.shared.state();
            self.suspects.drain(..).rev().for_each(|id| state.queue.push_front(id));
            return;
        }
        let how = match end {
            End::Silent => "the testee stopped responding".to_owned(),
            End::Ended(how) => how,
        };
        self.suspicion = Some(format!("{how} with {} pending requests", self.pending.len()));
        self.pending.drain(..).rev().for_each(|id| self.suspects.push_front(id));
    }

    /// Closes standard input, and checks that the testee ends properly.
    fn end(&mut self) {
        let Some(mut link) = self.link.take() else { return };
        if self.shared.state().gave_up.is_some() {
            return;
        }
        let finished = link.finish(self.shared.options.timeout, |line| {
            self.shared.remark(format!("a line after the last response: {}", excerpt(line)));
        });
        if let Err(what) = finished {
            self.shared.remark(what);
        }
    }
}

pub(super) fn check_answer(case: &Case, answer: &Response, types: &Types) -> Verdict {
    if *answer == Response::Unsupported {
        return Verdict::Unsupported;
    }
    compare(case, answer, types).map_or_else(Verdict::Fail, |()| Verdict::Pass)
}
