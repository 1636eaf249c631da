//! Makes UAVs safe: undoes each command that a probe has sent, until the [evidence](super::undoing) shows that it is undone.
//!
//! This happens after each step that changes UAVs, and at the end of the survey, no matter why it ends: because of the
//! time limit, a lost connection, a request to [stop](super::stop) or a panic. The probe reconnects as often as
//! necessary, until all UAVs are safe or the time limit for landing is reached.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use serde_json::{Value, json};

use super::commanded::{Effect, Reply};
use super::commands::ALTITUDE_INTERVAL;
use super::session::Session;
use super::undoing::{Evidence, REACTION_TIME, Undoing};
use super::{Probe, plain};

/// The default time limit for making UAVs safe.
pub(super) const LANDING_LIMIT: Duration = Duration::from_secs(120);

/// The maximum time to wait for an answer before the probe reconnects.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(10);

/// The minimum time between warnings.
const WARNING_INTERVAL: Duration = Duration::from_secs(10);

/// The attempts to undo effects, by effect and UAV.
type Attempts = BTreeMap<(Effect, String), Undoing>;

impl Probe<'_, '_> {
    /// Undoes all commands, regardless of the user's selection, and even if the probe must stop or its time limit has
    /// been reached. Afterwards, [`Commanded`](super::commanded::Commanded) contains the UAVs that aren't known to be
    /// safe.
    pub(super) fn make_safe(&mut self) {
        if self.is_safe() {
            return;
        }
        let _deferred = self.stop.defer();
        // After the time limit, one more attempt is made at the end of the survey.
        let (now, limit) = (self.clock.now(), self.options.landing_limit);
        let until = *self.landing_end.get_or_insert_with(|| now + limit);
        let (mut attempts, mut next_warning) = (Attempts::new(), now + REACTION_TIME);
        loop {
            self.danger = self.undo(&mut attempts).err();
            let now = self.clock.now();
            if self.is_safe() {
                (self.danger, self.landing_end) = (None, None);
                return;
            }
            if now + ALTITUDE_INTERVAL >= until {
                return;
            }
            // A UAV that lands at the first command needs no warning.
            let is_usual = !attempts.is_empty() && attempts.values().all(|attempt| attempt.commands == 1);
            if let Some(danger) = self.danger().filter(|_| !is_usual && now >= next_warning) {
                let left = until.saturating_duration_since(now).as_secs();
                let danger = self.secrets.hide(&danger);
                (self.options.warn)(&format!(
                    "{danger}. The probe keeps trying to resolve this for {left} \
                    s."
                ));
                next_warning = now + WARNING_INTERVAL;
            }
            self.listen(ALTITUDE_INTERVAL);
            self.sleep(self.clock.left(now + ALTITUDE_INTERVAL));
        }
    }

    /// Cancels the calibrations and tests that haven't ended when the survey ends early. If this request is lost, the
    /// operations end by themselves.
    pub(super) fn cancel_operations(&mut self) {
        let receipts = self.stop.commanded().take_operations();
        if receipts.is_empty() {
            return;
        }
        let _deferred = self.stop.defer();
        if let Err(why) = self.urge(&json!({ "type": "ASYNC-CANCEL", "ids": receipts })) {
            self.note(format!("a calibration or test may still be running: {why}"));
        }
    }

    /// True if no UAV is in a state into which the probe has put it.
    pub(super) fn is_safe(&self) -> bool {
        self.stop.commanded().is_safe()
    }

    /// The UAVs that aren't known to be safe, with the reason. `None` if all are safe.
    pub(super) fn danger(&self) -> Option<String> {
        let why = self.danger.as_ref().map_or_else(String::new, |why| format!(" ({why})"));
        self.stop.at_risk().map(|uavs| uavs + &why)
    }

    /// Sends the commands that are due, and requests the states of the UAVs. If a UAV isn't known to be safe, returns
    /// an error with the reason.
    fn undo(&mut self, attempts: &mut Attempts) -> Result<(), String> {
        let connection = self.ensure_session()?;
        for effect in Effect::ALL {
            self.order(effect, attempts, &connection);
        }
        // After a reconnection, the UAVs must receive the commands again.
        if let Some(session) = self.session.as_ref().filter(|session| session.is_over()) {
            return Err(session.why_over());
        }
        // An answer isn't sufficient, and a missing answer changes nothing: only the states show whether the UAVs obey.
        let states = self.states()?;
        let confirmed = self.confirm(attempts, &states);
        self.bring_back(attempts, &states);
        confirmed
    }

    /// The UAVs for which this effect may exist and can be undone now.
    fn undoable(&self, effect: Effect) -> Vec<String> {
        let mut uavs = self.stop.commanded().uavs(effect);
        if effect == Effect::MotorsOn {
            // The motors of a flying UAV must not stop.
            let airborne = self.stop.commanded().uavs(Effect::Airborne);
            uavs.retain(|uav| !airborne.contains(uav));
        }
        uavs
    }

    /// Sends the command that undoes an effect to the UAVs for which it is due.
    fn order(&mut self, effect: Effect, attempts: &mut Attempts, connection: &str) {
        let patience = self.options.progress_timeout;
        let (mut due, mut is_again) = (Vec::new(), false);
        for uav in self.undoable(effect) {
            let attempt =
                attempts.entry((effect, uav.clone())).or_insert_with(|| Undoing::new(effect, patience));
            let outcome = attempt.receipt().and_then(|receipt| self.stop.commanded().outcome(receipt));
            if attempt.is_due(connection, self.clock.now(), outcome) {
                is_again |= attempt.commands > 0;
                due.push(uav);
            }
        }
        // A server may refuse the whole request because of a single UAV.
        let size = if is_again { 1 } else { due.len().max(1) };
        for uavs in due.chunks(size) {
            if !self.send_order(effect, uavs, attempts, connection) {
                // The other UAVs follow in the next attempt, after their states have been checked.
                return;
            }
        }
    }

    /// Sends a command to UAVs. Returns true if the command was answered.
    fn send_order(
        &mut self,
        effect: Effect,
        uavs: &[String],
        attempts: &mut Attempts,
        connection: &str,
    ) -> bool {
        // The states show whether a UAV lands. If there is no answer, the states are more urgent than another attempt.
        let limit = if effect == Effect::Airborne { self.pace() } else { ANSWER_TIMEOUT };
        let answer = self.post(&effect.undo(uavs), Some(plain()), self.patience().min(limit));
        self.coverage.sent(effect.undo_type(), answer.as_ref());
        for uav in uavs {
            let reply = answer.as_ref().map(|answer| Reply::new(answer, uav));
            if let Some(Reply::Receipt(receipt)) = &reply {
                self.stop.commanded().follow(receipt);
            }
            if let Some(attempt) = attempts.get_mut(&(effect, uav.clone())) {
                attempt.sent(connection, self.clock.now(), reply);
            }
        }
        answer.is_some()
    }

    /// The states of all UAVs that may be unsafe.
    fn states(&mut self) -> Result<BTreeMap<String, Value>, String> {
        let uavs = Effect::ALL.map(|effect| self.stop.commanded().uavs(effect));
        let uavs: BTreeSet<String> = uavs.into_iter().flatten().collect();
        let uavs: Vec<String> = uavs.into_iter().collect();
        let together = self.urge(&json!({ "type": "UAV-INF", "ids": uavs }))?;
        // A server may refuse the whole request because of a single UAV.
        let is_refused = together["body"]["type"] == "ACK-NAK" && uavs.len() > 1;
        let mut states = BTreeMap::new();
        for uav in uavs {
            let single =
                if is_refused { Some(self.urge(&json!({ "type": "UAV-INF", "ids": [uav] }))?) } else { None };
            let answer = single.as_ref().unwrap_or(&together);
            states.insert(uav.clone(), answer["body"]["status"][uav.as_str()].clone());
        }
        Ok(states)
    }

    /// Records the effects that have been undone. If a UAV isn't known to be safe, returns an error with the reason.
    fn confirm(&mut self, attempts: &mut Attempts, states: &BTreeMap<String, Value>) -> Result<(), String> {
        let mut problem = Ok(());
        for effect in Effect::ALL {
            for uav in self.undoable(effect) {
                let Some(attempt) = attempts.get_mut(&(effect, uav.clone())) else { continue };
                let evidence = self.evidence(effect, &uav, attempt, states);
                match attempt.see(evidence) {
                    Ok(()) => self.stop.commanded().undone(effect, &uav),
                    Err(why) => problem = problem.and(Err(why)),
                }
            }
        }
        problem
    }

    /// Commands the UAVs that refuse to land to return.
    fn bring_back(&mut self, attempts: &mut Attempts, states: &BTreeMap<String, Value>) {
        for uav in self.undoable(Effect::Airborne) {
            let Some(attempt) = attempts.get_mut(&(Effect::Airborne, uav.clone())) else { continue };
            let evidence = self.evidence(Effect::Airborne, &uav, attempt, states);
            if attempt.must_return(evidence) {
                attempt.returned(self.clock.now());
                let answer =
                    self.post(&json!({ "type": "UAV-RTH", "ids": [uav] }), Some(plain()), self.pace());
                self.coverage.sent("UAV-RTH", answer.as_ref());
            }
        }
    }

    fn evidence<'e>(
        &'e mut self,
        effect: Effect,
        uav: &str,
        attempt: &Undoing,
        states: &'e BTreeMap<String, Value>,
    ) -> Evidence<'e> {
        let commanded = self.stop.commanded();
        let was_refused = commanded.is_refused(effect, uav);
        let outcome = attempt.receipt().and_then(|receipt| commanded.outcome(receipt));
        drop(commanded);
        Evidence {
            now: self.clock.now(),
            status: states.get(uav).unwrap_or(&Value::Null),
            flight: self.flights.get_mut(uav),
            was_refused,
            outcome,
        }
    }

    /// Reconnects if necessary. Returns the name of the connection.
    fn ensure_session(&mut self) -> Result<String, String> {
        if self.session.as_ref().is_none_or(Session::is_over) {
            self.reconnect()?;
        }
        Ok(self.session.as_ref().map(|session| session.name.clone()).unwrap_or_default())
    }

    /// Sends a request, and reconnects first if necessary. If there is no answer, the next request uses a new
    /// connection.
    fn urge(&mut self, body: &Value) -> Result<Value, String> {
        self.ensure_session()?;
        let type_name = body["type"].as_str().unwrap_or_default();
        let answer = self.post(body, Some(plain()), self.patience().min(ANSWER_TIMEOUT));
        self.coverage.sent(type_name, answer.as_ref());
        answer.ok_or_else(|| {
            let trouble = self.session.as_ref().and_then(Session::trouble);
            if let Some(session) = self.session.take() {
                session.close(&mut self.tape);
            }
            trouble.unwrap_or_else(|| format!("the server didn't answer {type_name}"))
        })
    }
}
