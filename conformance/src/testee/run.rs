//! Asks a testee all cases, and names what it fails, hangs or crashes over.
//!
//! A connection to a testee that listens is a process here: it starts when it is opened, and ends when it is lost.
//!
//! Several questions are on their way at once. When the process ends or falls silent, one of those without an answer
//! is to blame: each is asked again alone, the oldest first, until one of them brings down a process that was asked
//! nothing else. So a culprit is always seen to be one; a crash that none of them leads to alone is told as such.
//! Where there was a culprit the next is often near, so after one the questions go out singly, and soon more at once again
//! if all goes well: of a testee that crashes over everything each case costs one start.

use std::collections::{BTreeSet, VecDeque};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Instant;

use uavspec_codegen::dynamic::Types;

use super::case::Case;
use super::compare::compare;
use super::link::{Link, Received};
use super::options::{Options, excerpt};
use super::outcome::{Outcome, ProtocolRemarks, Verdict};
use super::protocol::{Answer, Hello};

/// Asks a testee the selected cases (indices, which are the ids on the wire); an error where it can't be started or
/// doesn't introduce itself. `progress` gets how many are done, and how many there are.
pub fn run<'c>(
    cases: &'c [Case],
    selected: &[usize],
    types: &Types,
    options: &Options,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Outcome<'c>, String> {
    let (first, hello) = start(options, false)?;
    let (num_sent, others): (Vec<usize>, Vec<usize>) =
        selected.iter().partition(|id| cases.get(**id).is_some_and(|case| case.is_for(&hello)));
    let total = num_sent.len();
    let state = State { queue: num_sent.into(), ..State::default() };
    let shared = Shared { cases, types, options, progress, total, state: Mutex::new(state) };
    let mut first = Some(first);
    thread::scope(|scope| {
        for _ in 0..options.jobs.max(1) {
            let worker = Worker::new(&shared, first.take());
            scope.spawn(|| worker.run());
        }
    });
    let mut state = shared.state.into_inner().unwrap_or_else(PoisonError::into_inner);
    state.verdicts.extend(others.into_iter().map(|id| (id, Verdict::Unsupported)));
    state.verdicts.extend(state.queue.drain(..).map(|id| (id, Verdict::NotRun)));
    state.verdicts.sort_by_key(|(id, _)| *id);
    let verdicts = state.verdicts.into_iter().filter_map(|(id, verdict)| Some((cases.get(id)?, verdict)));
    Ok(Outcome {
        hello: Some(hello),
        verdicts: verdicts.collect(),
        protocol_remarks: state.protocol_remarks,
        restarts: state.restarts,
        gave_up: state.gave_up,
    })
}

/// Starts a process, or connects to one, and lets it introduce itself.
fn start(options: &Options, is_again: bool) -> Result<(Link, Hello), String> {
    let mut link = Link::open(options, is_again)?;
    match link.introduction(options) {
        Ok((hello, _)) => Ok((link, hello)),
        Err(wrong) => Err(format!("{} doesn't introduce itself: {wrong}", options.target)),
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
    verdicts: Vec<(usize, Verdict)>,
    protocol_remarks: ProtocolRemarks,
    restarts: u32,
    /// Those since the last case that was found to be to blame.
    futile: u32,
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
}

/// Why a process is of no more use.
#[derive(Clone, Debug)]
enum End {
    Silent,
    Ended(String),
}

/// One process after the other.
struct Worker<'s, 'r> {
    shared: &'s Shared<'r>,
    link: Option<Link>,
    /// Questions without an answer, the oldest first.
    open: VecDeque<usize>,
    /// How many questions this process was asked.
    num_sent: usize,
    /// How many questions may be on their way.
    window: usize,
    answered: BTreeSet<usize>,
    /// When a question or an answer last went over the wire.
    last: Instant,
    /// Questions to be asked alone.
    suspects: VecDeque<usize>,
    /// What they are suspected of.
    suspicion: Option<String>,
}

impl<'s, 'r> Worker<'s, 'r> {
    fn new(shared: &'s Shared<'r>, link: Option<Link>) -> Self {
        Self {
            shared,
            link,
            open: VecDeque::new(),
            num_sent: 0,
            window: shared.options.window.max(1),
            answered: BTreeSet::new(),
            last: Instant::now(),
            suspects: VecDeque::new(),
            suspicion: None,
        }
    }

    fn run(mut self) {
        // The first process of another worker is no restart.
        let mut is_restart = self.link.is_some();
        while self.has_work() {
            if self.link.is_none() && !self.start(is_restart) {
                break;
            }
            is_restart = true;
            self.send_requests();
            if !self.open.is_empty() {
                self.receive();
            }
        }
        self.end();
        // What a run that gave up leaves behind.
        self.shared.state().queue.extend(self.open.drain(..).chain(self.suspects.drain(..)));
    }

    fn has_work(&self) -> bool {
        let state = self.shared.state();
        state.gave_up.is_none()
            && !(self.open.is_empty() && self.suspects.is_empty() && state.queue.is_empty())
    }

    fn start(&mut self, is_restart: bool) -> bool {
        if is_restart {
            let mut state = self.shared.state();
            if state.futile >= self.shared.options.max_restarts {
                let why = self.suspicion.as_ref().map(|why| format!("; last {why}")).unwrap_or_default();
                let restarts = format!("{} restarts in a row without a culprit", state.futile);
                state.gave_up = Some(format!("gave up after {restarts}{why}"));
                return false;
            }
            state.restarts += 1;
            state.futile += 1;
        }
        match start(self.shared.options, true) {
            Ok((link, _)) => {
                self.link = Some(link);
                self.num_sent = 0;
                self.answered.clear();
                true
            }
            Err(error) => {
                let before =
                    self.suspicion.as_ref().map(|why| format!("; before, {why}")).unwrap_or_default();
                self.shared.state().gave_up = Some(error + &before);
                false
            }
        }
    }

    /// Sends what may be sent: suspects one by one.
    fn send_requests(&mut self) {
        if self.suspicion.is_some() {
            if self.open.is_empty()
                && let Some(id) = self.suspects.pop_front()
            {
                self.send(id);
            }
            return;
        }
        while self.open.len() < self.window {
            let Some(id) = self.shared.state().queue.pop_front() else { return };
            self.send(id);
        }
    }

    fn send(&mut self, id: usize) {
        if self.open.is_empty() {
            self.last = Instant::now();
        }
        if let (Some(link), Some(case)) = (&self.link, self.shared.cases.get(id)) {
            link.send(case.request(id as u64).to_string());
            self.open.push_back(id);
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
                return self.process_ended(End::Ended(format!("a line of more than {limit} bytes")));
            }
            Received::Closed => {
                let how = testee.ending(until);
                return self.process_ended(End::Ended(how));
            }
            Received::Lost(how) => return self.process_ended(End::Ended(how)),
        }
        // Lines that are no answers don't win time.
        if !self.open.is_empty() && Instant::now() >= self.last + self.shared.options.timeout {
            self.process_ended(End::Silent);
        }
    }

    fn line(&mut self, line: &[u8]) {
        let (id, answer) = match Answer::read_or_blame(line.trim_ascii()) {
            Ok(answer) => answer,
            Err(wrong) => return self.shared.remark(format!("{wrong}: {}", excerpt(line))),
        };
        let location = self.open.iter().position(|open| i64::try_from(*open) == Ok(id));
        let Some((id, case)) = location.and_then(|location| {
            let id = self.open.remove(location)?;
            Some((id, self.shared.cases.get(id)?))
        }) else {
            let is_repeated = usize::try_from(id).is_ok_and(|id| self.answered.contains(&id));
            let what = if is_repeated { "a second answer to" } else { "an answer without a question:" };
            return self.shared.remark(format!("{what} id {id}"));
        };
        self.answered.insert(id);
        self.last = Instant::now();
        self.window = (2 * self.window).min(self.shared.options.window.max(1));
        self.shared.decide(id, check_answer(case, &answer, self.shared.types));
        if self.suspects.is_empty()
            && self.open.is_empty()
            && let Some(what) = self.suspicion.take()
        {
            self.shared.remark(what + ", and none of them leads to that alone");
        }
    }

    /// Ends the process, and finds out over which question that happened.
    fn process_ended(&mut self, end: End) {
        let Some(mut link) = self.link.take() else { return };
        let stderr = link.kill();
        if let (1, 1, Some(id)) = (self.open.len(), self.num_sent, self.open.front().copied()) {
            self.open.clear();
            let after = self.shared.options.timeout;
            self.shared.decide(
                id,
                match end {
                    End::Silent => Verdict::TimedOut { after, stderr },
                    End::Ended(how) => Verdict::Crashed { how, stderr },
                },
            );
            (self.suspicion, self.window) = (None, 1);
            let mut state = self.shared.state();
            state.futile = 0;
            self.suspects.drain(..).rev().for_each(|id| state.queue.push_front(id));
            return;
        }
        let how = match end {
            End::Silent => "it fell silent".to_owned(),
            End::Ended(how) => how,
        };
        self.suspicion = Some(format!("{how} over {} questions on their way", self.open.len()));
        self.open.drain(..).rev().for_each(|id| self.suspects.push_front(id));
    }

    /// Closes its standard input, and looks whether it ends as it should.
    fn end(&mut self) {
        let Some(mut link) = self.link.take() else { return };
        let parted = link.part(self.shared.options.timeout, |line| {
            self.shared.remark(format!("a line after the last answer: {}", excerpt(line)));
        });
        if let Err(what) = parted {
            self.shared.remark(what);
        }
    }
}

pub(super) fn check_answer(case: &Case, answer: &Answer, types: &Types) -> Verdict {
    if *answer == Answer::Unsupported {
        return Verdict::Unsupported;
    }
    compare(case, answer, types).map_or_else(Verdict::Fail, |()| Verdict::Pass)
}
