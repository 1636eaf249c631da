//! Makes UAVs safe: undoes each command that a probe has sent, and confirms that it is undone.
//!
//! This happens after each step that changes UAVs, and at the end of the survey, whatever ended it: the time limit, a
//! lost connection, a request to [stop](super::stop) or a panic. The probe connects again as often as necessary, until
//! all UAVs are safe or the time limit for landing is reached.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use uavspec::flockwave::ErrorCode;

use super::altitude::Touchdown;
use super::commanded::{Effect, Reply, has_code};
use super::commands::{ALTITUDE_INTERVAL, is_end};
use super::session::Session;
use super::{Probe, plain};

/// The default time limit for making UAVs safe.
pub(super) const LANDING_LIMIT: Duration = Duration::from_secs(120);

/// The maximum time to wait for an answer before the probe connects again.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(10);

/// The problem of an answer that doesn't mention a UAV.
const MISSING: &str = "the answer doesn't mention the UAV";

/// The decisions that UAVs are on the ground.
type Touchdowns = BTreeMap<String, Touchdown>;

/// The delay between attempts.
const RETRY_INTERVAL: Duration = Duration::from_millis(500);

/// The time after which a command to land is sent again, and the time until a UAV that refuses to land must be on the
/// ground.
const DESCENT_TIMEOUT: Duration = Duration::from_secs(30);
const REFUSAL_TIMEOUT: Duration = Duration::from_secs(5);

impl Probe<'_, '_> {
    /// Undoes all commands, whatever the user selected, and even if the probe must stop or its time limit is reached.
    /// Afterwards, [`Commanded`](super::commanded::Commanded) contains the UAVs that aren't known to be safe.
    pub(super) fn make_safe(&mut self) {
        if self.is_safe() {
            return;
        }
        let _deferred = self.stop.defer();
        // After the time limit, there is one more attempt at the end of the survey.
        let limit = self.options.landing_limit;
        let until = *self.landing_end.get_or_insert_with(|| Instant::now() + limit);
        // A server may close connections sooner than a UAV is known to be on the ground.
        let mut touchdowns = Touchdowns::new();
        loop {
            // If a UAV can't be woken, others must still land.
            let attempts = Effect::ALL.map(|effect| self.undo(effect, &mut touchdowns, until));
            let before = std::mem::replace(&mut self.danger, attempts.into_iter().find_map(Result::err));
            if self.is_safe() {
                (self.danger, self.landing_end) = (None, None);
                return;
            }
            if Instant::now() + RETRY_INTERVAL >= until {
                return;
            }
            if let Some(danger) = self.danger().filter(|_| self.danger != before) {
                let left = until.saturating_duration_since(Instant::now()).as_secs();
                let danger = self.secrets.hide(&danger);
                (self.options.warn)(&format!("{danger}. The probe tries to change that for {left} s."));
            }
            self.stop.sleep(RETRY_INTERVAL);
        }
    }

    /// Cancels the calibrations and tests that haven't ended, after the survey ended early. They end by themselves if
    /// the request is lost.
    pub(super) fn cancel_operations(&mut self) {
        let receipts = self.stop.commanded().take_operations();
        if receipts.is_empty() {
            return;
        }
        let _deferred = self.stop.defer();
        if let Err(why) = self.urge(&json!({ "type": "ASYNC-CANCEL", "ids": receipts })) {
            self.note(format!("a calibration or test may still run: {why}"));
        }
    }

    /// True if no UAV is in a state into which the probe has put it.
    pub(super) fn is_safe(&self) -> bool {
        self.stop.commanded().is_safe()
    }

    /// The UAVs that aren't known to be safe, and the reason.
    pub(super) fn danger(&self) -> Option<String> {
        let why = self.danger.as_ref().map_or_else(String::new, |why| format!(" ({why})"));
        self.stop.at_risk().map(|uavs| uavs + &why)
    }

    /// Undoes one kind of effect. Returns the reason if a UAV isn't known to be safe.
    fn undo(&mut self, effect: Effect, touchdowns: &mut Touchdowns, until: Instant) -> Result<(), String> {
        let mut uavs = self.stop.commanded().uavs(effect);
        if effect == Effect::MotorsOn {
            // The motors of a flying UAV must not stop.
            let airborne = self.stop.commanded().uavs(Effect::Airborne);
            uavs.retain(|uav| !airborne.contains(uav));
        }
        match effect {
            _ if uavs.is_empty() => Ok(()),
            Effect::Airborne => self.land(&uavs, touchdowns, until),
            Effect::Asleep | Effect::MotorsOn => self.reverse(effect, &uavs),
        }
    }

    /// Stops motors or wakes UAVs.
    fn reverse(&mut self, effect: Effect, uavs: &[String]) -> Result<(), String> {
        let answer = self.urge(&effect.undo(uavs))?;
        let mut problem = Ok(());
        let (mut receipts, mut refusing) = (Vec::new(), Vec::new());
        for uav in uavs {
            match Reply::new(&answer, uav) {
                Reply::Success => self.stop.commanded().undone(effect, uav),
                Reply::Receipt(receipt) => receipts.push((receipt, uav.clone())),
                // A UAV that refused both commands was never in this state, unless it only failed to respond.
                Reply::Refusal(why) if self.stop.commanded().is_refused(effect, uav) => {
                    refusing.push((uav, why));
                }
                Reply::Refusal(why) => problem = Err(crate::text::shown(&why)),
                Reply::Missing => problem = Err(MISSING.to_owned()),
            }
        }
        if !refusing.is_empty() {
            let ids: Vec<&String> = refusing.iter().map(|(uav, _)| *uav).collect();
            let states = self.urge(&json!({ "type": "UAV-INF", "ids": ids }))?;
            for (uav, why) in refusing {
                if effect.is_absent(&states["body"]["status"][uav.as_str()]) {
                    self.stop.commanded().undone(effect, uav);
                } else {
                    problem = Err(crate::text::shown(&why));
                }
            }
        }
        for uav in self.finish_operations(receipts)? {
            self.stop.commanded().undone(effect, &uav);
        }
        problem
    }

    /// Waits for the ends of operations, each with its UAV. Returns the UAVs whose operation succeeded. UAVs may share an
    /// operation.
    fn finish_operations(&mut self, mut receipts: Vec<(String, String)>) -> Result<Vec<String>, String> {
        let until = Instant::now() + self.options.progress_timeout;
        let mut succeeded = Vec::new();
        while !receipts.is_empty() {
            let is_wanted = |message: &Value| receipts.iter().any(|(receipt, _)| is_end(message, receipt));
            let Some(session) = &mut self.session else { break };
            let Some(message) = session.find(&mut self.tape, until, is_wanted) else { break };
            let body = &message["body"];
            let has_succeeded =
                body["type"] == "ASYNC-RESP" && body["error"].is_null() && body["result"] != false;
            receipts.retain(|(receipt, uav)| {
                let is_ended = is_end(&message, receipt);
                if is_ended && has_succeeded {
                    succeeded.push(uav.clone());
                }
                !is_ended
            });
        }
        if receipts.is_empty() {
            return Ok(succeeded);
        }
        // Over HTTP, for example, the end of an operation isn't reported.
        let left: Vec<String> = receipts.into_iter().map(|(_, uav)| uav).collect();
        let states = self.urge(&json!({ "type": "UAV-INF", "ids": left }))?;
        succeeded.extend(left.into_iter().filter(|uav| is_at_rest(&states["body"]["status"][uav.as_str()])));
        Ok(succeeded)
    }

    /// Lands UAVs, and waits until they are on the ground.
    fn land(&mut self, uavs: &[String], touchdowns: &mut Touchdowns, until: Instant) -> Result<(), String> {
        let answer = self.urge(&Effect::Airborne.undo(uavs))?;
        let refusal = |uav: &String| match Reply::new(&answer, uav) {
            Reply::Refusal(why) => Some(why),
            Reply::Missing => Some(MISSING.to_owned()),
            Reply::Success | Reply::Receipt(_) => None,
        };
        let Some(why) = uavs.iter().find_map(refusal) else {
            return self.wait_on_ground(uavs, touchdowns, until.min(Instant::now() + DESCENT_TIMEOUT));
        };
        // Servers also refuse to land a UAV that is on the ground.
        let landed = self.wait_on_ground(uavs, touchdowns, until.min(Instant::now() + REFUSAL_TIMEOUT));
        let in_air = self.stop.commanded().uavs(Effect::Airborne);
        let refusing: Vec<&String> = in_air.iter().filter(|uav| refusal(uav).is_some()).collect();
        if refusing.is_empty() || Instant::now() >= until {
            return landed;
        }
        // A UAV that doesn't land may return. From the ground, it takes off.
        touchdowns.clear();
        self.urge(&json!({ "type": "UAV-RTH", "ids": refusing }))?;
        let returned = self.wait_on_ground(&in_air, touchdowns, until.min(Instant::now() + DESCENT_TIMEOUT));
        returned.map_err(|state| format!("{state}; UAV-LAND was refused: {}", crate::text::shown(&why)))
    }

    /// Waits until UAVs are seen on the ground. Returns the reason if one of them isn't.
    fn wait_on_ground(
        &mut self,
        uavs: &[String],
        touchdowns: &mut Touchdowns,
        until: Instant,
    ) -> Result<(), String> {
        let mut waiting: Vec<&String> = uavs.iter().collect();
        loop {
            // The UAVs must receive the command to land again on a new connection.
            if let Some(session) = self.session.as_ref().filter(|session| session.is_over()) {
                return Err(session.why_over());
            }
            let answer = self.urge(&json!({ "type": "UAV-INF", "ids": uavs }))?;
            let mut problem = None;
            waiting.retain(|uav| {
                let status = &answer["body"]["status"][uav.as_str()];
                let touchdown = touchdowns.entry((*uav).clone()).or_default();
                let seen = touchdown.see(self.flights.get_mut(*uav), status, Instant::now());
                match seen {
                    Ok(()) => self.stop.commanded().undone(Effect::Airborne, uav),
                    Err(why) => {
                        problem.get_or_insert(why);
                        return true;
                    }
                }
                false
            });
            match problem {
                None => return Ok(()),
                Some(why) if Instant::now() >= until => return Err(why),
                Some(_) => self.listen(ALTITUDE_INTERVAL),
            }
        }
    }

    /// Sends a request, after connecting again if necessary. If there is no answer, the next request uses a new
    /// connection.
    fn urge(&mut self, body: &Value) -> Result<Value, String> {
        if self.session.as_ref().is_none_or(Session::is_over) {
            self.reconnect()?;
        }
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

/// True if the status says that the UAV is on the ground, awake and without running motors.
fn is_at_rest(status: &Value) -> bool {
    let has = |code: ErrorCode| has_code(status, code);
    has(ErrorCode::GROUND) && !has(ErrorCode::MOTORS) && !has(ErrorCode::SLEEP)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_uav_that_is_awake_on_the_ground_is_at_rest() {
        let is_at_rest = |codes: Value| is_at_rest(&json!({ "errors": codes }));
        assert!(is_at_rest(json!([1])) && is_at_rest(json!([66, 1])));
        for codes in [json!([]), json!(null), json!([8]), json!([1, 8]), json!([9, 1]), json!(["1"])] {
            assert!(!is_at_rest(codes.clone()), "{codes}");
        }
    }
}
