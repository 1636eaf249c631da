//! Runs trials, each on a separate connection, so that they don't influence each other.

use std::time::Duration;

use uavspec_flockwave::record::Trial;
use uavspec_flockwave::transport::endpoint::Endpoint;
use uavspec_model::Rule;
use uavspec_rules::flockwave::env_27;
use uavspec_rules::flockwave::trial::{self, Attempt, SENT_ALONE, Sent, Step};

use super::Probe;
use super::selection::Selection;
use super::session::Session;
use super::tape::Tape;

/// The minimum waiting time for late answers.
const LATE_ANSWER_TIME: Duration = Duration::from_millis(400);

/// The delay between messages. It ensures that each message is sent in a separate segment.
const SEND_INTERVAL: Duration = Duration::from_millis(20);

/// The trials that the user selected and that apply to the server, in order of execution.
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
        let Some(mut session) = self.open(endpoint.as_ref(), trial) else { return };
        let is_served = self.carry_out(&mut session, steps, Some(trial));
        let suspects = suspects(&session, steps);
        self.close(session);
        // If the server has crashed, further trials are meaningless.
        if !is_served && !self.stop.is_due() {
            let colon = if how.is_empty() { "" } else { ", " };
            let after = format!("{}{}{colon}{how}", trial::AFTER_TRIAL, rule.id);
            let stops = self.stops;
            if self.recover(&after) && self.stops > stops && suspects.len() > 1 {
                self.isolate(&suspects, &format!("{after}{SENT_ALONE}"));
            }
        }
    }

    /// Opens a connection for a trial, and logs in.
    fn open(&mut self, endpoint: Option<&Endpoint>, trial: Trial<'_>) -> Option<Session> {
        match self.connect(endpoint) {
            Ok(session) => self.session = Some(session),
            // Some trials test whether the server accepts a connection to a different endpoint.
            Err(error) if endpoint.is_some() => {
                self.refused(endpoint, &error, Some(trial));
                return None;
            }
            Err(error) => {
                self.refused(None, &error, None);
                self.cut_short(format!("can't connect for a trial: {error}"));
                return None;
            }
        }
        self.log_in();
        let session = self.session.take()?;
        if self.cut_short.is_some() {
            self.close(session);
            return None;
        }
        Some(session)
    }

    /// Sends each of these messages alone, until one of them ends the service again. Requires a server that is serving.
    fn isolate(&mut self, suspects: &[&Sent], after: &str) {
        let stops = self.stops;
        for sent in suspects {
            if self.stops > stops || self.must_stop().is_some() {
                return;
            }
            self.ensure_witness();
            let trial = Trial { rule: &env_27::RULE.rule, how: after };
            let Some(mut session) = self.open(None, trial) else { return };
            // The rule of the trial has already checked these messages.
            self.carry_out(&mut session, &[Step::Send((*sent).clone()), Step::request("alone")], None);
            self.close(session);
            if self.stop.is_due() || !self.recover(after) {
                return;
            }
        }
    }

    /// Performs the steps of a trial, and waits for the answers. Returns true if the last message was answered.
    fn carry_out(&mut self, session: &mut Session, steps: &[Step], trial: Option<Trial<'_>>) -> bool {
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
            // A server may handle requests one after the other.
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
        // If the last message can't be answered, it is unknown whether the server still serves.
        !needed.is_empty() && !is_open(session)
    }
}

/// The messages that may have ended the service: all messages after the latest answered request.
fn suspects<'s>(session: &Session, steps: &'s [Step]) -> Vec<&'s Sent> {
    let sent: Vec<&Sent> = steps.iter().flat_map(Step::messages).collect();
    let is_answered = |sent: &&Sent| sent.id().is_some_and(|id| session.has_answer(id));
    let first = sent.iter().rposition(is_answered).map_or(0, |at| at + 1);
    sent.into_iter().skip(first).filter(|sent| !sent.is_control).collect()
}

fn perform(session: &mut Session, tape: &mut Tape<'_>, step: &Step, trial: Option<Trial<'_>>) {
    // Another finding already reports that an earlier message has no answer.
    if session.is_over() {
        return;
    }
    match step {
        Step::Send(sent) => session.send(tape, &sent.text, sent.id(), trial),
        Step::Together(all) if !session.is_stream() => {
            for sent in all {
                session.send(tape, &sent.text, sent.id(), trial);
            }
        }
        Step::Together(all) => {
            let mut bytes = Vec::new();
            for sent in all {
                session.note(tape, &sent.text, sent.id(), trial);
                bytes.extend_from_slice(&sent.text);
                bytes.push(b'\n');
            }
            session.send_raw(tape, &bytes);
        }
        Step::Pieces(sent, count, pause) => {
            session.note(tape, &sent.text, sent.id(), trial);
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
