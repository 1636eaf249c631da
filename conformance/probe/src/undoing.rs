//! The attempt to undo the effect of a command on one UAV. The status of the UAV shows whether it is safe. Answers
//! are reported but not relied on, because they may be missing, null, late or wrong.

use std::time::{Duration, Instant};

use serde_json::Value;
use uavspec_types::flockwave::ErrorCode;

use super::altitude::{AIRBORNE, Descent, Flight, Touchdown, height};
use super::commanded::{Effect, Reply, has_code, is_at_rest};

/// The time within which a UAV must react to a command. Afterwards, the command is sent again.
pub(super) const REACTION_TIME: Duration = Duration::from_secs(3);

/// The time after which a UAV that refuses to land and doesn't descend is commanded to return. Also the time within
/// which it must return.
const REFUSAL_TIME: Duration = Duration::from_secs(5);
const RETURN_TIME: Duration = Duration::from_secs(30);

/// The evidence about a UAV at one time.
pub(super) struct Evidence<'e> {
    pub(super) now: Instant,
    /// The status of the UAV. Null if the server doesn't report it.
    pub(super) status: &'e Value,
    /// The flight of the UAV, if it may have taken off.
    pub(super) flight: Option<&'e mut Flight>,
    /// True if the server refused the command whose effect is being undone.
    pub(super) was_refused: bool,
    /// True if the operation that undoes the effect succeeded, and false if it failed. `None` until it ends.
    pub(super) outcome: Option<bool>,
}

/// An attempt to undo an effect.
#[derive(Debug)]
pub(super) struct Undoing {
    effect: Effect,
    /// The maximum time for an operation.
    patience: Duration,
    /// The latest command.
    sent: Option<Sent>,
    /// The number of commands that were sent.
    pub(super) commands: u32,
    /// The times since which the server has refused all commands, or accepted all commands.
    refused_since: Option<Instant>,
    accepted_since: Option<Instant>,
    descent: Descent,
    touchdown: Touchdown,
    /// The timestamp of the first status after the answer that doesn't report the effect.
    absent: Option<Value>,
    /// The timestamp of the latest status.
    timestamp: Value,
    /// The time at which the UAV was commanded to return.
    returned_at: Option<Instant>,
}

/// A command that undoes an effect.
#[derive(Debug)]
struct Sent {
    connection: String,
    at: Instant,
    /// The answer; `None` if there was none in time.
    reply: Option<Reply>,
}

impl Undoing {
    /// An attempt before its first command. `patience` is the maximum time for an operation.
    pub(super) fn new(effect: Effect, patience: Duration) -> Self {
        Self {
            effect,
            patience,
            sent: None,
            commands: 0,
            refused_since: None,
            accepted_since: None,
            descent: Descent::default(),
            touchdown: Touchdown::default(),
            absent: None,
            timestamp: Value::Null,
            returned_at: None,
        }
    }

    /// True if the command must be sent now. It is sent again on a new connection, because the server may have
    /// restarted and forgotten the command.
    pub(super) fn is_due(&self, connection: &str, now: Instant, outcome: Option<bool>) -> bool {
        let Some(sent) = &self.sent else { return true };
        // If a UAV descends, it obeys the command.
        let since = self.descent.progressed_at.map_or(sent.at, |at| at.max(sent.at));
        // A flying UAV must react to the command, whatever the state of the operation is.
        let is_pending = self.effect != Effect::Airborne && sent.receipt().is_some() && outcome.is_none();
        let limit = if is_pending { self.patience } else { REACTION_TIME };
        sent.connection != connection || now.saturating_duration_since(since) >= limit
    }

    /// Records that the command was sent, and the answer, if any.
    pub(super) fn sent(&mut self, connection: &str, now: Instant, reply: Option<Reply>) {
        let is_refused = matches!(reply, Some(Reply::Refusal(_)));
        let is_accepted = matches!(reply, Some(Reply::Success));
        self.refused_since = is_refused.then(|| self.refused_since.unwrap_or(now));
        self.accepted_since = is_accepted.then(|| self.accepted_since.unwrap_or(now));
        self.sent = Some(Sent { connection: connection.to_owned(), at: now, reply });
        self.commands += 1;
    }

    /// The receipt of the operation that undoes the effect.
    pub(super) fn receipt(&self) -> Option<&str> {
        self.sent.as_ref()?.receipt()
    }

    /// Takes evidence. If the UAV isn't known to be safe, returns an error with the reason.
    pub(super) fn see(&mut self, evidence: Evidence<'_>) -> Result<(), String> {
        match self.effect {
            Effect::Airborne => self.see_flight(evidence),
            Effect::Asleep | Effect::MotorsOn => self.see_on_ground(&evidence),
        }
    }

    /// Decides from consecutive statuses whether a UAV is on the ground.
    fn see_flight(&mut self, evidence: Evidence<'_>) -> Result<(), String> {
        let Evidence { now, status, mut flight, .. } = evidence;
        if let Some(height) = height(flight.as_deref_mut(), status) {
            self.descent.see(height, now);
        }
        let landed = self.touchdown.see(flight, status, now);
        landed.map_err(|why| match self.refusal() {
            Some(refusal) => format!("{why}; UAV-LAND was refused: {refusal}"),
            None => why,
        })
    }

    /// Decides whether a UAV on the ground is awake, or whether its motors have stopped. An unanswered command may
    /// still arrive, so the UAV then isn't known to be safe.
    fn see_on_ground(&mut self, evidence: &Evidence<'_>) -> Result<(), String> {
        let (command, status) = (self.effect.undo_type(), evidence.status);
        let Some(sent) = &self.sent else { return Err(format!("{command} was not sent")) };
        let Some(reply) = &sent.reply else { return Err(format!("{command} was not answered")) };
        let is_accepted = *reply == Reply::Success || evidence.outcome == Some(true);
        if !status.is_object() {
            let since = self.accepted_since.or(is_accepted.then_some(sent.at));
            // A server may not know the states of its UAVs.
            let is_over =
                since.is_some_and(|since| evidence.now.saturating_duration_since(since) >= REACTION_TIME);
            return if is_over { Ok(()) } else { Err("its status is unknown".to_owned()) };
        }
        if !self.effect.is_absent(status) {
            self.absent = None;
            return Err(self.refusal().unwrap_or_else(|| "its status says so".to_owned()));
        }
        let timestamp = &status["timestamp"];
        let is_new = self.absent.get_or_insert_with(|| timestamp.clone()) != timestamp;
        let is_pending = sent.receipt().is_some()
            && evidence.outcome.is_none()
            && evidence.now.saturating_duration_since(sent.at) < self.patience;
        // A UAV that refused both commands was never in this state.
        let was_never = evidence.was_refused && matches!(reply, Reply::Refusal(_));
        // A sleeping UAV sends no new status. A UAV with running motors reports them instead of being on the ground.
        let is_shown = is_new && (self.effect == Effect::Asleep || is_at_rest(status));
        match () {
            () if is_accepted || was_never => Ok(()),
            () if is_pending => Err(format!("the operation of {command} has not ended")),
            () if is_shown => Ok(()),
            () => Err(self.refusal().unwrap_or_else(|| "no new status confirms the change".to_owned())),
        }
    }

    /// True if a UAV must be commanded to return, because it refuses to land. This command would make a UAV on the
    /// ground take off, and a descending UAV climb, so evidence must exclude both.
    pub(super) fn must_return(&mut self, evidence: Evidence<'_>) -> bool {
        let Evidence { now, status, flight, .. } = evidence;
        let before = std::mem::replace(&mut self.timestamp, status["timestamp"].clone());
        let is_up = height(flight, status).is_some_and(|height| height > AIRBORNE);
        let is_busy = [ErrorCode::LANDING, ErrorCode::RTH].iter().any(|code| has_code(status, *code));
        if !is_up || is_busy || before == self.timestamp {
            return false;
        }
        let is_longer_than = |since: Option<Instant>, limit| {
            since.is_none_or(|since| now.saturating_duration_since(since) >= limit)
        };
        self.refused_since.is_some()
            && is_longer_than(self.refused_since, REFUSAL_TIME)
            && is_longer_than(self.descent.progressed_at, REFUSAL_TIME)
            && is_longer_than(self.returned_at, RETURN_TIME)
    }

    /// Records that the UAV was commanded to return.
    pub(super) fn returned(&mut self, now: Instant) {
        (self.returned_at, self.touchdown) = (Some(now), Touchdown::default());
    }

    /// The reason why the latest command was refused.
    fn refusal(&self) -> Option<String> {
        match self.sent.as_ref()?.reply.as_ref()? {
            Reply::Refusal(why) => Some(uavspec_model::text::shown(why)),
            _ => None,
        }
    }
}

impl Sent {
    fn receipt(&self) -> Option<&str> {
        match &self.reply {
            Some(Reply::Receipt(receipt)) => Some(receipt),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;
    use uavspec_model::clock::Clock;

    use super::*;
    use crate::altitude::Altitude;

    fn evidence<'e>(now: Instant, status: &'e Value, flight: Option<&'e mut Flight>) -> Evidence<'e> {
        Evidence { now, status, flight, was_refused: false, outcome: None }
    }

    /// The result for a reply to the command, followed by statuses. Each status consists of a time in seconds, error
    /// codes and a timestamp.
    fn on_ground(effect: Effect, reply: Option<Reply>, seen: &[(u64, Value, u64)]) -> Result<(), String> {
        let start = Clock::simulated().now();
        let mut undoing = Undoing::new(effect, Duration::from_secs(10));
        undoing.sent("tcp#1", start, reply);
        let mut result = Err("no state".to_owned());
        for (seconds, codes, timestamp) in seen {
            let status = match codes {
                Value::Null => Value::Null,
                codes => json!({ "errors": codes, "timestamp": timestamp }),
            };
            let now = start + Duration::from_secs(*seconds);
            result = undoing.see(evidence(now, &status, None));
        }
        result
    }

    fn refusal() -> Reply {
        Reply::Refusal("not armed".to_owned())
    }

    #[test]
    fn the_status_decides_that_motors_have_stopped() {
        let stopped = |reply, states: &[(u64, Value, u64)]| on_ground(Effect::MotorsOn, reply, states);
        // If the answer contains no information, a new status must show the result.
        for reply in [Some(Reply::Missing), Some(refusal())] {
            assert_eq!(stopped(reply.clone(), &[(0, json!([1]), 1), (1, json!([1]), 2)]), Ok(()));
            for states in [
                vec![(0, json!([1]), 1)],
                vec![(0, json!([1]), 1), (9, json!([1]), 1)],
                vec![(0, json!([1]), 1), (1, json!([8]), 2), (2, json!([1]), 3)],
                vec![(0, json!([]), 1), (1, json!([]), 2)],
                vec![(0, Value::Null, 1), (9, Value::Null, 2)],
            ] {
                assert!(stopped(reply.clone(), &states).is_err(), "{reply:?}: {states:?}");
            }
        }
        assert_eq!(stopped(Some(Reply::Success), &[(0, json!([1]), 1)]), Ok(()));
        let running = stopped(Some(Reply::Success), &[(0, json!([1, 8]), 1), (9, json!([8]), 9)]);
        assert_eq!(running, Err("its status says so".to_owned()), "the answer is wrong");
        assert!(stopped(None, &[(0, json!([1]), 1), (9, json!([1]), 9)]).is_err(), "the command may be late");
    }

    #[test]
    fn an_accepted_command_counts_if_the_server_reports_no_status() {
        let states = [(0, Value::Null, 1), (3, Value::Null, 2)];
        assert!(on_ground(Effect::MotorsOn, Some(Reply::Success), &states[..1]).is_err());
        assert_eq!(on_ground(Effect::MotorsOn, Some(Reply::Success), &states), Ok(()));
    }

    #[test]
    fn a_uav_that_reports_again_is_awake() {
        let awake = |states: &[(u64, Value, u64)]| on_ground(Effect::Asleep, Some(Reply::Missing), states);
        assert_eq!(awake(&[(0, json!([9]), 1), (1, json!([]), 2), (2, json!([66]), 3)]), Ok(()));
        assert!(awake(&[(0, json!([9]), 1), (1, json!([]), 2)]).is_err());
        let pending = Some(Reply::Receipt("r".to_owned()));
        let states = [(0, json!([1]), 1), (9, json!([1]), 2), (10, json!([1]), 3)];
        assert!(on_ground(Effect::Asleep, pending.clone(), &states[..2]).is_err(), "it has not ended");
        assert_eq!(on_ground(Effect::Asleep, pending, &states), Ok(()));
    }

    /// The seconds at which a UAV receives commands to land. `heights` are its heights in m, one for each second.
    fn commands(heights: &[i64]) -> Vec<usize> {
        let start = Clock::simulated().now();
        let mut undoing = Undoing::new(Effect::Airborne, Duration::from_secs(10));
        let mut flight = Flight::new(Altitude::AboveHome(0));
        let mut sent = Vec::new();
        for (second, height) in heights.iter().enumerate() {
            let now = start + Duration::from_secs(second as u64);
            if undoing.is_due("tcp#1", now, None) {
                undoing.sent("tcp#1", now, Some(Reply::Success));
                sent.push(second);
            }
            let status = json!({ "timestamp": second, "position": [1, 2, 3, height * 1_000], "errors": [] });
            let _ = undoing.see(evidence(now, &status, Some(&mut flight)));
        }
        sent
    }

    #[test]
    fn a_command_to_land_is_sent_again_unless_the_uav_descends() {
        assert_eq!(commands(&[9, 8, 7, 6, 5, 4, 3, 2]), [0]);
        assert_eq!(commands(&[2, 4, 6, 8, 8, 8, 8]), [0, 3, 6], "it climbs and then hovers");
        assert_eq!(commands(&[9, 8, 8, 8, 8, 8, 7, 6, 5]), [0, 4], "it pauses");
        let mut undoing = Undoing::new(Effect::Airborne, Duration::from_secs(10));
        let now = Clock::simulated().now();
        undoing.sent("tcp#1", now, None);
        assert!(undoing.is_due("tcp#2", now, None) && !undoing.is_due("tcp#1", now, None));
    }

    /// True if a UAV that refuses to land is commanded to return. `seen` contains its height in m and its error codes,
    /// for each second.
    fn returns(seen: &[(i64, Value)]) -> bool {
        let start = Clock::simulated().now();
        let mut undoing = Undoing::new(Effect::Airborne, Duration::from_secs(10));
        let mut flight = Flight::new(Altitude::AboveHome(0));
        let mut has_returned = false;
        for (second, (height, codes)) in seen.iter().enumerate() {
            let now = start + Duration::from_secs(second as u64);
            if undoing.is_due("tcp#1", now, None) {
                undoing.sent("tcp#1", now, Some(refusal()));
            }
            let status =
                json!({ "timestamp": second, "position": [1, 2, 3, height * 1_000], "errors": codes });
            let _ = undoing.see(evidence(now, &status, Some(&mut flight)));
            has_returned |= undoing.must_return(evidence(now, &status, Some(&mut flight)));
        }
        has_returned
    }

    #[test]
    fn only_a_uav_that_hovers_and_refuses_to_land_returns() {
        let constant = |height: i64, codes: Value| vec![(height, codes); 8];
        assert!(returns(&constant(9, json!([]))));
        assert!(!returns(&constant(9, json!([]))[..5]), "too early");
        assert!(!returns(&constant(1, json!([]))), "it would take off");
        assert!(!returns(&constant(9, json!([6]))), "it is landing");
        let descending: Vec<(i64, Value)> = (0..8).map(|second| (9 - second, json!([]))).collect();
        assert!(!returns(&descending));
    }
}
