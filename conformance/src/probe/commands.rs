//! Sends commands to the UAVs that the caller named. They take off, return home, land, run tests and calibrations,
//! sleep and wake up. Commands that could make a UAV fall (UAV-HALT) or restart (UAV-RST) are never sent.

use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::Probe;
use super::survey::with_unknown_id;
use crate::rules::flockwave::trial::UNKNOWN_ID;
use crate::rules::flockwave::{FlockwaveRule, asy_10, asy_19, env_07};

/// The approximate number of steps.
pub(super) const STEPS: usize = 25;

/// The additional time allowed for commands.
pub(super) const EXTRA_TIME: Duration = Duration::from_secs(45);

/// The time limit for an operation to progress or end.
const PROGRESS_TIMEOUT: Duration = Duration::from_secs(11);

/// The time limit of a short operation.
const SHORT_TIMEOUT: Duration = Duration::from_secs(20);

/// The time for which a suspended operation is observed.
const SUSPENSION_TIMEOUT: Duration = Duration::from_millis(1_500);

/// The duration of each activity in flight.
const FLIGHT: Duration = Duration::from_secs(1);

/// The flight altitude in mm above home.
const HEIGHT: u32 = 10_000;

impl Probe<'_, '_> {
    /// Sends commands to the UAVs that are both in this list and named by the caller.
    pub(super) fn command(&mut self, uavs: &[String]) {
        let named: Vec<String> = self.options.uavs.clone();
        if named.is_empty() {
            return;
        }
        let (known, missing): (Vec<String>, Vec<String>) =
            named.into_iter().partition(|id| uavs.contains(id));
        if !missing.is_empty() {
            self.note(format!("commands were not sent to these unknown UAVs: {}", missing.join(", ")));
        }
        let Some(first) = known.first().cloned() else { return };
        self.query(json!({ "type": "SYS-TIME" }));
        self.query(json!({ "type": "SYS-TIME", "adjustment": 0 }));
        self.query(json!({ "type": "SYS-TIME" }));
        self.suspend(&first);
        self.cancel(&first);
        self.store(&known, &first);
        self.sleep(&known);
        self.fly(&known, &first);
    }

    /// Starts an operation that may be suspended until the client resumes it.
    fn suspend(&mut self, uav: &str) {
        let calibrate = json!({ "type": "UAV-CALIB", "ids": [uav, UNKNOWN_ID], "component": "compass" });
        let Some(receipt) = receipt(self.query(calibrate).as_ref()) else { return };
        let resume = json!({ "type": "ASYNC-RESUME", "ids": [receipt], "values": {} });
        self.query_for_trial(&asy_19::RULE, resume.clone());
        let is_progress = |message: &Value| message["body"]["suspended"] == true || is_end(message, &receipt);
        let message = self.wait(PROGRESS_TIMEOUT, is_progress);
        // A suspended operation must stay suspended. An operation without progress may also be suspended.
        let is_stopped = message.is_none_or(|message| !is_end(&message, &receipt))
            && self.wait(SUSPENSION_TIMEOUT, |message| is_end(message, &receipt)).is_none();
        if is_stopped {
            self.query(resume);
            self.wait(PROGRESS_TIMEOUT, |message| is_end(message, &receipt));
        }
    }

    /// Cancels an operation.
    fn cancel(&mut self, uav: &str) {
        let calibrate = json!({ "type": "UAV-CALIB", "ids": [uav], "component": "baro" });
        let Some(receipt) = receipt(self.query(calibrate).as_ref()) else { return };
        self.query(json!({ "type": "ASYNC-CANCEL", "ids": [receipt, UNKNOWN_ID] }));
        self.wait(PROGRESS_TIMEOUT, |message| is_end(message, &receipt));
    }

    /// Requests parameters and logs.
    fn store(&mut self, uavs: &[String], first: &str) {
        let ids = with_unknown_id(uavs);
        self.query(json!({ "type": "PRM-GET", "ids": ids, "name": "PROBE_NONE" }));
        self.query(json!({ "type": "PRM-SET-MANY", "ids": ids, "parameters": { "PROBE_NONE": 1 } }));
        self.query(json!({ "type": "LOG-INF", "ids": ids }));
        self.query(json!({ "type": "LOG-DATA", "uavId": first, "logId": "1" }));
    }

    /// Makes a short flight.
    fn fly(&mut self, uavs: &[String], first: &str) {
        let ids = with_unknown_id(uavs);
        let test = json!({ "type": "UAV-TEST", "ids": ids, "component": "led" });
        self.operate(&asy_10::RULE, SHORT_TIMEOUT, test);
        self.query(json!({ "type": "UAV-SIGNAL", "ids": ids, "signals": ["light"], "duration": 500 }));
        self.operate(&env_07::RULE, PROGRESS_TIMEOUT, json!({ "type": "UAV-TAKEOFF", "ids": ids }));
        self.listen(FLIGHT);
        let state = self.query(json!({ "type": "UAV-INF", "ids": [first] }));
        let position = state.map(|answer| answer["body"]["status"][first]["position"].clone());
        if let Some([latitude, longitude, ..]) =
            position.as_ref().and_then(Value::as_array).map(Vec::as_slice)
        {
            let target = json!([latitude, longitude, null, HEIGHT]);
            self.query(json!({ "type": "UAV-FLY", "ids": [first], "target": target }));
            self.listen(FLIGHT);
        }
        for kind in ["UAV-HOVER", "UAV-RTH"] {
            self.query(json!({ "type": kind, "ids": ids }));
        }
        self.operate(&env_07::RULE, PROGRESS_TIMEOUT, json!({ "type": "UAV-LAND", "ids": ids }));
    }

    /// Makes UAVs sleep. Sleeping UAVs don't respond, which the server must report.
    fn sleep(&mut self, uavs: &[String]) {
        self.operate(&env_07::RULE, PROGRESS_TIMEOUT, json!({ "type": "UAV-SLEEP", "ids": uavs }));
        self.operate(
            &env_07::RULE,
            PROGRESS_TIMEOUT,
            json!({ "type": "UAV-SIGNAL", "ids": uavs, "signals": ["light"], "duration": 500 }),
        );
        self.operate(&env_07::RULE, PROGRESS_TIMEOUT, json!({ "type": "UAV-WAKEUP", "ids": uavs }));
    }

    /// Sends a command, and waits for the end of its first operation.
    fn operate(&mut self, rule: &'static FlockwaveRule, limit: Duration, body: Value) {
        if let Some(receipt) = receipt(self.query_for_trial(rule, body).as_ref()) {
            self.wait(limit, |message| is_end(message, &receipt));
        }
    }

    /// Waits for a message.
    fn wait(&mut self, time: Duration, is_wanted: impl Fn(&Value) -> bool) -> Option<Value> {
        let until = Instant::now() + time.min(self.left());
        self.session.as_mut()?.find(&mut self.tape, until, is_wanted)
    }
}

/// The first receipt in an answer.
fn receipt(answer: Option<&Value>) -> Option<String> {
    match &answer?["body"]["receipt"] {
        Value::String(receipt) => Some(receipt.clone()),
        Value::Object(receipts) => receipts.values().find_map(|receipt| Some(receipt.as_str()?.to_owned())),
        _ => None,
    }
}

/// True if a message reports the end of an operation.
fn is_end(message: &Value, receipt: &str) -> bool {
    let body = &message["body"];
    match body["type"].as_str() {
        Some("ASYNC-RESP") => body["id"] == receipt,
        Some("ASYNC-TIMEOUT") => body["ids"].as_array().is_some_and(|ids| ids.iter().any(|id| id == receipt)),
        _ => false,
    }
}
