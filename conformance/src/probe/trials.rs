//! Runs trials, each on a separate connection, so that they don't influence each other.

use std::time::Duration;

use super::Probe;
use super::selection::Selection;
use super::session::Session;
use super::tape::Tape;
use crate::flockwave::record::Trial;
use crate::flockwave::transport::endpoint::Endpoint;
use crate::model::Rule;
use crate::rules::flockwave::trial::{self, Attempt, Step};

/// The minimum time limit for late answers.
const LATE_ANSWER_TIME: Duration = Duration::from_millis(400);

/// The delay between messages. The delay ensures that each message is sent in a separate segment.
const SEND_INTERVAL: Duration = Duration::from_millis(20);

/// The trials for a server that the user selected, in order of execution.
pub(super) fn selected(endpoint: &Endpoint, selection: &Selection) -> Vec<(&'static Rule, Attempt)> {
    let mut attempts = trial::attempts(endpoint);
    attempts.retain(|(rule, attempt)| selection.has_trial(rule, &attempt.how, None));
    attempts
}

impl Probe<'_, '_> {
    /// Runs all trials.
    pub(super) fn run_trials(&mut self, attempts: &[(&'static Rule, Attempt)]) {
        if attempts.is_empty() {
            return;
        }
        if self.must_stop().is_none() {
            self.test_witness();
        }
        for (at, (rule, attempt)) in attempts.iter().enumerate() {
            if self.failure.is_some() || self.cut_short.is_some() || self.must_stop().is_some() {
                self.unsent.1 = attempts.len() - at;
                return;
            }
            self.ensure_witness();
            self.attempt(rule, attempt);
        }
    }

    /// Runs a trial on a separate connection.
    fn attempt(&mut self, rule: &'static Rule, attempt: &Attempt) {
        let Attempt { how, endpoint, steps } = attempt;
        self.step();
        self.catch_up();
        let trial = Trial { rule, how };
        match self.connect(endpoint.as_ref()) {
            Ok(session) => self.session = Some(session),
            // Some trials test whether the server accepts a connection to a different endpoint.
            Err(error) if endpoint.is_some() => return self.refused(endpoint.as_ref(), &error, Some(trial)),
            Err(error) => {
                self.refused(None, &error, None);
                return self.cut_short(format!("can't connect for a trial: {error}"));
            }
        }
        self.log_in();
        let Some(mut session) = self.session.take() else { return };
        if self.cut_short.is_some() {
            return self.close(session);
        }
        let is_served = self.carry_out(&mut session, steps, trial);
        self.close(session);
        // If the server has crashed, further trials are meaningless.
        if !is_served && !self.stop.is_due() {
            let colon = if how.is_empty() { "" } else { ", " };
            self.recover(&format!("{}{}{colon}{how}", trial::AFTER_TRIAL, rule.id));
        }
    }

    /// Performs the steps of a trial, and waits for the answers. Returns true if the last request was answered.
    fn carry_out(&mut self, session: &mut Session, steps: &[Step], trial: Trial<'_>) -> bool {
        let grace = LATE_ANSWER_TIME.max(self.slowest * 4);
        for (at, step) in steps.iter().enumerate() {
            if self.stop.is_due() {
                return true;
            }
            // The server should process and answer each step before the next message arrives.
            match at {
                0 => {}
                _ if session.is_waiting() => session.settle(&mut self.tape, self.clock.now() + grace),
                _ => self.sleep(SEND_INTERVAL),
            }
            perform(session, &mut self.tape, step, trial);
        }
        let ids: Vec<&str> = steps.iter().filter_map(Step::id).collect();
        // Over UDP, some of the requests or answers may be lost.
        let needed = if session.is_lossy() { &ids[..] } else { &ids[ids.len().saturating_sub(1)..] };
        let pace = self.pace();
        let mut until = self.clock.now() + pace;
        let is_open =
            |session: &Session| !needed.is_empty() && !needed.iter().any(|id| session.has_answer(id));
        while is_open(session) && session.is_waiting() && self.clock.now() < until {
            let before = session.num_waiting();
            if session.receive(&mut self.tape, until).is_none() {
                break;
            }
            // A server may handle one request after the other.
            if session.num_waiting() < before {
                until = self.clock.now() + pace;
            }
        }
        // Answers to earlier requests may arrive in any order.
        if session.is_waiting() && !is_open(session) {
            session.settle(&mut self.tape, until.min(self.clock.now() + grace));
        }
        if is_open(session) && !session.is_over() {
            self.silences += 1;
        }
        !is_open(session)
    }
}

fn perform(session: &mut Session, tape: &mut Tape<'_>, step: &Step, trial: Trial<'_>) {
    // A finding already reports that an earlier message has no answer.
    if session.is_over() {
        return;
    }
    match step {
        Step::Send(sent) => session.send(tape, &sent.text, sent.id(), Some(trial)),
        Step::Together(all) if !session.is_stream() => {
            for sent in all {
                session.send(tape, &sent.text, sent.id(), Some(trial));
            }
        }
        Step::Together(all) => {
            let mut bytes = Vec::new();
            for sent in all {
                session.note(tape, &sent.text, sent.id(), Some(trial));
                bytes.extend_from_slice(&sent.text);
                bytes.push(b'\n');
            }
            session.send_raw(tape, &bytes);
        }
        Step::Pieces(sent, count, pause) => {
            session.note(tape, &sent.text, sent.id(), Some(trial));
            let line = [&sent.text[..], b"\n"].concat();
            for (at, piece) in line.chunks(line.len().div_ceil(*count)).enumerate() {
                if at > 0 {
                    session.pause(*pause);
                }
                session.send_raw(tape, piece);
            }
        }
        Step::Packet(text) => {
            session.note(tape, text.as_bytes(), None, None);
            session.send_raw(tape, text.as_bytes());
        }
    }
}
