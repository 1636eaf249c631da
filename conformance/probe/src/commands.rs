//! Sends commands to the UAVs that the caller named, in the order of a flight: tests on the ground, takeoff, flight,
//! return and landing. `UAV-RST` and `UAV-HALT` are sent only after the UAVs have been seen on the ground.

use std::time::Duration;

use serde_json::{Value, json};
use uavspec_model::json::base64;
use uavspec_rules::flockwave::trial::UNKNOWN_ID;
use uavspec_rules::flockwave::{FlockwaveRule, asy_10, asy_19, env_07};

use super::Probe;
use super::altitude::{AIRBORNE, Altitude, Flight};
use super::survey::{ids, with_unknown_id};

/// The approximate number of steps.
pub(super) const STEPS: usize = 55;

/// The time for commands, in addition to the time limit of a probe.
pub(super) const EXTRA_TIME: Duration = Duration::from_secs(60);

/// The default time limit for an operation to progress or end.
pub(super) const PROGRESS_TIMEOUT: Duration = Duration::from_secs(11);

/// The time for which a suspended operation is observed.
const SUSPENSION_TIMEOUT: Duration = Duration::from_millis(1_500);

/// The time limit for the UAVs to leave the ground.
const TAKEOFF_TIMEOUT: Duration = Duration::from_secs(15);

/// The interval between requests for the altitude.
pub(super) const ALTITUDE_INTERVAL: Duration = Duration::from_millis(500);

/// The duration of each activity in flight.
const FLIGHT: Duration = Duration::from_secs(2);

/// The flight altitude in mm above home.
const HEIGHT: i64 = 10_000;

/// The commands that are sent during a flight.
const FLIGHT_COMMANDS: [&str; 8] =
    ["UAV-TAKEOFF", "UAV-HOVER", "UAV-FLY", "UAV-RTH", "UAV-LAND", "UAV-HALT", "UAV-RST", "SHOW-CRTH-START"];

/// The types of requests that are sent only with the user's permission.
pub(super) const COMMANDS: [&str; 28] = [
    "EXT-LOAD",
    "EXT-RELOAD",
    "EXT-SETCFG",
    "EXT-UNLOAD",
    "FW-UPLOAD",
    "LOG-DATA",
    "LOG-INF",
    "OBJ-CMD",
    "PRM-GET",
    "PRM-SET",
    "PRM-SET-MANY",
    "SHOW-CRTH-PLAN",
    "SHOW-CRTH-START",
    "SHOW-SETCFG",
    "SHOW-SETLIGHTS",
    "UAV-CALIB",
    "UAV-FLY",
    "UAV-HALT",
    "UAV-HOVER",
    "UAV-LAND",
    "UAV-MOTOR",
    "UAV-RST",
    "UAV-RTH",
    "UAV-SIGNAL",
    "UAV-SLEEP",
    "UAV-TAKEOFF",
    "UAV-TEST",
    "UAV-WAKEUP",
];

impl Probe<'_, '_> {
    /// Sends commands to the UAVs that are both in this list and named by the caller.
    pub(super) fn command(&mut self, uavs: &[String]) {
        let named: Vec<String> = self.options.uavs.clone();
        if named.is_empty() {
            return;
        }
        let (known, missing): (Vec<String>, Vec<String>) =
            named.into_iter().partition(|id| uavs.contains(id));
        if !missing.is_empty() && self.must_stop().is_none() {
            let (missing, limit) =
                (uavspec_model::text::shown(&missing.join(", ")), self.options.uav_timeout.as_secs());
            self.left_out =
                Some(format!("no commands were sent to {missing}: no such UAV appeared within {limit} s"));
        }
        let Some(first) = known.first().cloned() else {
            return self.leave_out(&COMMANDS, "needs a UAV given with --uav");
        };
        self.query(json!({ "type": "SYS-TIME" }));
        self.query(json!({ "type": "SYS-TIME", "adjustment": 0 }));
        self.query(json!({ "type": "SYS-TIME" }));
        self.suspend(&first);
        self.cancel(&first);
        self.store(&known, &first);
        self.configure();
        self.put_to_sleep(&known);
        // A UAV that isn't in its usual state must not take off.
        if self.is_safe() {
            self.test(&known);
        }
        let is_on_ground = self.is_safe() && self.fly(&known, &first);
        self.restart(&known, is_on_ground);
    }

    /// Starts an operation that may be suspended until the client resumes it.
    fn suspend(&mut self, uav: &str) {
        let calibrate = json!({ "type": "UAV-CALIB", "ids": [uav, UNKNOWN_ID], "component": "compass" });
        let Some(receipt) = receipt(self.query(calibrate).as_ref()) else { return };
        let resume = json!({ "type": "ASYNC-RESUME", "ids": [receipt], "values": {} });
        self.query_for_trial(&asy_19::RULE, resume.clone());
        let is_progress = |message: &Value| message["body"]["suspended"] == true || is_end(message, &receipt);
        let message = self.wait(self.options.progress_timeout, is_progress);
        // A suspended operation must remain suspended. An operation that makes no progress may be suspended as well.
        let is_stopped = message.is_none_or(|message| !is_end(&message, &receipt))
            && self.wait(SUSPENSION_TIMEOUT, |message| is_end(message, &receipt)).is_none();
        if is_stopped {
            self.query(resume);
            self.wait(self.options.progress_timeout, |message| is_end(message, &receipt));
        }
    }

    /// Cancels an operation.
    fn cancel(&mut self, uav: &str) {
        let calibrate = json!({ "type": "UAV-CALIB", "ids": [uav], "component": "baro" });
        let Some(receipt) = receipt(self.query(calibrate).as_ref()) else { return };
        self.query(json!({ "type": "ASYNC-CANCEL", "ids": [receipt, UNKNOWN_ID] }));
        self.wait(self.options.progress_timeout, |message| is_end(message, &receipt));
    }

    /// Requests parameters and logs, and sets a parameter that doesn't exist.
    fn store(&mut self, uavs: &[String], first: &str) {
        let ids = with_unknown_id(uavs);
        self.query(json!({ "type": "PRM-GET", "ids": ids, "name": "PROBE_NONE" }));
        self.query(json!({ "type": "PRM-SET", "ids": ids, "name": "PROBE_NONE", "value": 1 }));
        self.query(json!({ "type": "PRM-SET-MANY", "ids": ids, "parameters": { "PROBE_NONE": 1 } }));
        self.query(json!({ "type": "LOG-INF", "ids": ids }));
        self.query(json!({ "type": "LOG-DATA", "uavId": first, "logId": "1" }));
    }

    /// Sends requests that change the server, with values that have no effect: unknown ids, and the current settings.
    fn configure(&mut self) {
        for kind in ["EXT-LOAD", "EXT-RELOAD", "EXT-UNLOAD"] {
            self.query(json!({ "type": kind, "ids": [UNKNOWN_ID] }));
        }
        self.query(json!({ "type": "EXT-SETCFG", "ids": { UNKNOWN_ID: {} } }));
        let blob = base64::encode(b"probe");
        self.query(json!({ "type": "FW-UPLOAD", "ids": [UNKNOWN_ID], "target": UNKNOWN_ID, "blob": blob }));
        self.query(json!({ "type": "SHOW-CRTH-PLAN", "show": blob }));
        for (get, set) in [("SHOW-CFG", "SHOW-SETCFG"), ("SHOW-LIGHTS", "SHOW-SETLIGHTS")] {
            let answer = self.query(json!({ "type": get })).unwrap_or_default();
            if let Some(current) = answer["body"].get("configuration") {
                self.query(json!({ "type": set, "configuration": current }));
            } else if self.is_unsupported(&answer, get) {
                // A server without the family has no settings.
                self.query(json!({ "type": set, "configuration": {} }));
            } else {
                self.leave_out(&[set], "needs the current settings");
            }
        }
    }

    /// Makes UAVs sleep. Sleeping UAVs don't respond, which the server must report.
    fn put_to_sleep(&mut self, uavs: &[String]) {
        self.operate(&env_07::RULE, json!({ "type": "UAV-SLEEP", "ids": uavs }));
        self.operate(
            &env_07::RULE,
            json!({ "type": "UAV-SIGNAL", "ids": uavs, "signals": ["light"], "duration": 500 }),
        );
        if self.is_safe() {
            let wake_up = json!({ "type": "UAV-WAKEUP", "ids": uavs });
            self.operate(&env_07::RULE, wake_up);
        }
        self.make_safe();
    }

    /// Tests UAVs on the ground.
    fn test(&mut self, uavs: &[String]) {
        let ids = with_unknown_id(uavs);
        let test = json!({ "type": "UAV-TEST", "ids": ids, "component": "led" });
        // A test that doesn't report its progress may take longer.
        self.operate_within(2 * self.options.progress_timeout, &asy_10::RULE, test);
        self.query(json!({ "type": "UAV-SIGNAL", "ids": ids, "signals": ["light"], "duration": 500 }));
        self.query(json!({ "type": "OBJ-CMD", "ids": ids, "command": "probe-none" }));
        let start = json!({ "type": "UAV-MOTOR", "ids": ids, "start": true });
        self.operate(&env_07::RULE, start);
        self.make_safe();
    }

    /// Makes a short flight. Returns true if all UAVs took off, and were seen on the ground afterwards.
    fn fly(&mut self, uavs: &[String], first: &str) -> bool {
        let ids = with_unknown_id(uavs);
        let Some(ground) = self.altitudes(uavs) else {
            self.leave_out(&FLIGHT_COMMANDS, "needs the altitude of each UAV");
            return false;
        };
        if ground.iter().any(|altitude| matches!(altitude, Altitude::AboveHome(height) if *height > AIRBORNE))
        {
            self.note("no UAV was commanded to fly, because a UAV is already in the air".to_owned());
            self.leave_out(&FLIGHT_COMMANDS, "a UAV is in the air");
            return false;
        }
        self.flights = uavs.iter().cloned().zip(ground.into_iter().map(Flight::new)).collect();
        self.operate(&env_07::RULE, json!({ "type": "UAV-TAKEOFF", "ids": ids }));
        let has_taken_off = !self.is_safe();
        let was_in_air = has_taken_off && self.wait_for_takeoff(uavs);
        self.query(json!({ "type": "UAV-HOVER", "ids": ids }));
        self.fly_up(first);
        self.query(json!({ "type": "UAV-RTH", "ids": ids }));
        if self.is_safe() {
            self.query(json!({ "type": "UAV-LAND", "ids": ids }));
            return false;
        }
        self.listen(FLIGHT);
        self.make_safe();
        was_in_air && self.is_safe()
    }

    /// Makes a UAV fly to a point above its current position.
    fn fly_up(&mut self, uav: &str) {
        let state = self.query(json!({ "type": "UAV-INF", "ids": [uav] }));
        let position = state.map(|answer| answer["body"]["status"][uav]["position"].clone());
        let Some([latitude, longitude, ..]) = position.as_ref().and_then(Value::as_array).map(Vec::as_slice)
        else {
            return self.leave_out(&["UAV-FLY"], "needs the position of a UAV");
        };
        let target = json!([latitude, longitude, null, HEIGHT]);
        self.query(json!({ "type": "UAV-FLY", "ids": [uav], "target": target }));
        self.listen(FLIGHT);
    }

    /// Sends the commands that would make a flying UAV fall. Leaves them out if the UAVs haven't been seen on the
    /// ground.
    fn restart(&mut self, uavs: &[String], is_on_ground: bool) {
        if !is_on_ground {
            let why = "the probe did not see the UAVs take off and land";
            return self.leave_out(&["SHOW-CRTH-START", "UAV-HALT", "UAV-RST"], why);
        }
        let all = ids(self.discover(json!({ "type": "UAV-LIST" })).as_ref());
        if !all.is_empty() && all.iter().all(|id| uavs.contains(id)) {
            self.query(json!({ "type": "SHOW-CRTH-START" }));
            self.make_safe();
        } else {
            self.leave_out(&["SHOW-CRTH-START"], "could move UAVs that are not given with --uav");
        }
        if !self.is_safe() {
            return;
        }
        // A UAV that has been shut down might not start again.
        for kind in ["UAV-RST", "UAV-HALT"] {
            self.operate(&env_07::RULE, json!({ "type": kind, "ids": with_unknown_id(uavs) }));
        }
    }

    /// Sets the reason why requests of these types aren't sent. If the probe must stop, the reason is that instead of
    /// `why`.
    fn leave_out(&mut self, names: &[&str], why: &str) {
        if let Some(reason) = self.must_stop() {
            self.coverage.not_sent(names, reason);
        } else if self.cut_short.is_none() && self.failure.is_none() {
            self.coverage.not_sent(names, why);
        }
    }

    /// Waits until all UAVs have left the ground. Returns false if one of them stays on the ground, or if its altitude
    /// is unknown.
    fn wait_for_takeoff(&mut self, uavs: &[String]) -> bool {
        let until = (self.clock.now() + TAKEOFF_TIMEOUT).min(self.end);
        loop {
            let altitudes = self.altitudes(uavs).unwrap_or_default();
            let heights: Vec<Option<i64>> = uavs
                .iter()
                .zip(altitudes)
                .map(|(uav, altitude)| self.flights.get_mut(uav)?.see(altitude))
                .collect();
            if !heights.is_empty() && heights.iter().all(|up| up.is_some_and(|up| up > AIRBORNE)) {
                return true;
            }
            if self.clock.now() >= until || self.stop.is_due() {
                return false;
            }
            if self.session.is_some() {
                self.listen(ALTITUDE_INTERVAL);
            } else {
                self.sleep(ALTITUDE_INTERVAL);
            }
        }
    }

    /// The altitudes of UAVs. `None` if at least one of them is unknown.
    fn altitudes(&mut self, uavs: &[String]) -> Option<Vec<Altitude>> {
        let answer = self.discover(json!({ "type": "UAV-INF", "ids": uavs }))?;
        uavs.iter().map(|id| Altitude::of(&answer["body"]["status"][id.as_str()])).collect()
    }

    /// Sends a command, and waits for the end of its first operation.
    fn operate(&mut self, rule: &'static FlockwaveRule, body: Value) {
        self.operate_within(self.options.progress_timeout, rule, body);
    }

    fn operate_within(&mut self, limit: Duration, rule: &'static FlockwaveRule, body: Value) {
        if let Some(receipt) = receipt(self.query_for_trial(rule, body).as_ref()) {
            self.wait(limit, |message| is_end(message, &receipt));
        }
    }

    /// Waits for a message.
    fn wait(&mut self, time: Duration, is_wanted: impl Fn(&Value) -> bool) -> Option<Value> {
        let until = (self.clock.now() + time).min(self.end);
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

/// True if a message reports the end of the operation with this receipt.
fn is_end(message: &Value, receipt: &str) -> bool {
    let body = &message["body"];
    match body["type"].as_str() {
        Some("ASYNC-RESP") => body["id"] == receipt,
        Some("ASYNC-TIMEOUT") => body["ids"].as_array().is_some_and(|ids| ids.iter().any(|id| id == receipt)),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use uavspec_rules::flockwave::trial::{self, Step};

    use super::*;

    /// Trials also run without permission to send commands, and nothing would undo their commands.
    #[test]
    fn trials_send_no_commands() {
        let uavs = ["07".to_owned(), "08".to_owned()];
        let mut texts: Vec<String> =
            trial::requests(&uavs).into_iter().map(|(_, request)| request.body.to_string()).collect();
        for url in ["tcp://a:1", "udp://a:1", "http://a:1", "socketio://a:1"] {
            let endpoint = url.parse().expect("a URL");
            for step in trial::attempts(&endpoint).into_iter().flat_map(|(_, attempt)| attempt.steps) {
                match step {
                    Step::Send(sent) | Step::Pieces(sent, ..) => {
                        texts.push(String::from_utf8_lossy(&sent.text).into());
                    }
                    Step::Together(all) => {
                        texts.extend(all.iter().map(|sent| String::from_utf8_lossy(&sent.text).into_owned()));
                    }
                    Step::Packet(text) => texts.push(text),
                }
            }
        }
        assert!(texts.len() > 100, "{}", texts.len());
        let is_sent = |name: &&&str| texts.iter().any(|text| text.contains(&format!("\"{name}\"")));
        let sent: BTreeSet<&&str> = COMMANDS.iter().filter(is_sent).collect();
        assert_eq!(sent, BTreeSet::new());
    }
}
