//! Sends commands to the UAVs that the caller named, in the order of a flight: tests on the ground, takeoff, flight,
//! return and landing. `UAV-HALT` and `UAV-RST` follow only after the UAVs were seen on the ground.

use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::Probe;
use super::survey::{ids, with_unknown_id};
use crate::json::base64;
use crate::rules::flockwave::trial::UNKNOWN_ID;
use crate::rules::flockwave::{FlockwaveRule, asy_10, asy_19, env_07};

/// The approximate number of steps.
pub(super) const STEPS: usize = 55;

/// The additional time allowed for commands.
pub(super) const EXTRA_TIME: Duration = Duration::from_secs(60);

/// The time limit for an operation to progress or end.
const PROGRESS_TIMEOUT: Duration = Duration::from_secs(11);

/// The time limit of a short operation.
const SHORT_TIMEOUT: Duration = Duration::from_secs(20);

/// The time for which a suspended operation is observed.
const SUSPENSION_TIMEOUT: Duration = Duration::from_millis(1_500);

/// The time limits for the UAVs to leave the ground, and to be on the ground again.
const TAKEOFF_TIMEOUT: Duration = Duration::from_secs(15);
const LANDING_TIMEOUT: Duration = Duration::from_secs(30);

/// The interval between requests for the altitude.
const ALTITUDE_INTERVAL: Duration = Duration::from_millis(500);

/// The duration of each activity in flight.
const FLIGHT: Duration = Duration::from_secs(2);

/// The flight altitude in mm above home.
const HEIGHT: i64 = 10_000;

/// The height in mm above which a UAV is in the air, and the height below which it is on the ground. The altitude of a
/// UAV on the ground varies.
const AIRBORNE: i64 = 1_500;
const LANDED: i64 = 700;

/// The change of the altitude in mm, in [`ALTITUDE_INTERVAL`], below which a UAV isn't descending.
const STILL: i64 = 50;

/// The number of times that a command to land is sent.
const MAX_ATTEMPTS: u32 = 4;

/// The commands of a flight.
const FLIGHT_COMMANDS: [&str; 8] =
    ["UAV-TAKEOFF", "UAV-HOVER", "UAV-FLY", "UAV-RTH", "UAV-LAND", "UAV-HALT", "UAV-RST", "SHOW-CRTH-START"];

/// The altitude of a UAV, in mm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Altitude {
    AboveHome(i64),
    AboveSea(i64),
}

/// The heights of UAVs above earlier altitudes, in mm. `None` if the altitudes have different references.
fn heights(now: &[Altitude], before: &[Altitude]) -> Option<Vec<i64>> {
    let height = |(now, before): (&Altitude, &Altitude)| match (now, before) {
        (Altitude::AboveHome(now), Altitude::AboveHome(before))
        | (Altitude::AboveSea(now), Altitude::AboveSea(before)) => Some(now - before),
        _ => None,
    };
    now.iter().zip(before).map(height).collect()
}

/// The types that are sent only with the permission of the user.
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
            return self.coverage.not_sent(&COMMANDS, "needs --allow-commands");
        }
        let (known, missing): (Vec<String>, Vec<String>) =
            named.into_iter().partition(|id| uavs.contains(id));
        if !missing.is_empty() {
            self.note(format!("commands were not sent to these unknown UAVs: {}", missing.join(", ")));
        }
        let Some(first) = known.first().cloned() else {
            return self.coverage.not_sent(&COMMANDS, "needs a UAV that --uav names");
        };
        self.query(json!({ "type": "SYS-TIME" }));
        self.query(json!({ "type": "SYS-TIME", "adjustment": 0 }));
        self.query(json!({ "type": "SYS-TIME" }));
        self.suspend(&first);
        self.cancel(&first);
        self.store(&known, &first);
        self.configure();
        self.sleep(&known);
        self.test(&known);
        let is_on_ground = self.fly(&known, &first);
        self.restart(&known, is_on_ground);
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

    /// Requests parameters and logs, and sets a parameter that doesn't exist.
    fn store(&mut self, uavs: &[String], first: &str) {
        let ids = with_unknown_id(uavs);
        self.query(json!({ "type": "PRM-GET", "ids": ids, "name": "PROBE_NONE" }));
        self.query(json!({ "type": "PRM-SET", "ids": ids, "name": "PROBE_NONE", "value": 1 }));
        self.query(json!({ "type": "PRM-SET-MANY", "ids": ids, "parameters": { "PROBE_NONE": 1 } }));
        self.query(json!({ "type": "LOG-INF", "ids": ids }));
        self.query(json!({ "type": "LOG-DATA", "uavId": first, "logId": "1" }));
    }

    /// Sends requests that change the server, with values that change nothing: unknown ids, and the current settings.
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
                self.coverage.not_sent(&[set], "needs the current settings");
            }
        }
    }

    /// Makes UAVs sleep. Sleeping UAVs don't respond, which the server must report.
    fn sleep(&mut self, uavs: &[String]) {
        let sent_before = self.requests;
        self.operate(&env_07::RULE, PROGRESS_TIMEOUT, json!({ "type": "UAV-SLEEP", "ids": uavs }));
        let is_asleep = self.requests > sent_before;
        self.operate(
            &env_07::RULE,
            PROGRESS_TIMEOUT,
            json!({ "type": "UAV-SIGNAL", "ids": uavs, "signals": ["light"], "duration": 500 }),
        );
        let wake_up = json!({ "type": "UAV-WAKEUP", "ids": uavs });
        if is_asleep {
            self.undo(wake_up);
        } else {
            self.operate(&env_07::RULE, PROGRESS_TIMEOUT, wake_up);
        }
    }

    /// Tests UAVs on the ground.
    fn test(&mut self, uavs: &[String]) {
        let ids = with_unknown_id(uavs);
        let test = json!({ "type": "UAV-TEST", "ids": ids, "component": "led" });
        self.operate(&asy_10::RULE, SHORT_TIMEOUT, test);
        self.query(json!({ "type": "UAV-SIGNAL", "ids": ids, "signals": ["light"], "duration": 500 }));
        self.query(json!({ "type": "OBJ-CMD", "ids": ids, "command": "probe-none" }));
        let motors = |is_start: bool| json!({ "type": "UAV-MOTOR", "ids": ids, "start": is_start });
        let sent_before = self.requests;
        self.operate(&env_07::RULE, PROGRESS_TIMEOUT, motors(true));
        if self.requests > sent_before {
            self.undo(motors(false));
        }
    }

    /// Sends the command that undoes an earlier one, whatever the user selected, and even if the time limit is reached.
    #[allow(clippy::needless_pass_by_value)] // callers build the body in the call
    fn undo(&mut self, body: Value) {
        let end = std::mem::replace(&mut self.end, Instant::now() + PROGRESS_TIMEOUT);
        if let Some(receipt) = receipt(self.insist(&body).as_ref()) {
            self.wait(PROGRESS_TIMEOUT, |message| is_end(message, &receipt));
        }
        self.end = end;
    }

    /// Makes a short flight. Returns true if all UAVs took off and were seen on the ground afterwards.
    fn fly(&mut self, uavs: &[String], first: &str) -> bool {
        let ids = with_unknown_id(uavs);
        let Some(ground) = self.altitudes(uavs) else {
            self.coverage.not_sent(&FLIGHT_COMMANDS, "needs the altitude of each UAV");
            return false;
        };
        if ground.iter().any(|altitude| matches!(altitude, Altitude::AboveHome(height) if *height > AIRBORNE))
        {
            self.note("no UAV was made to fly, because a UAV is in the air".to_owned());
            self.coverage.not_sent(&FLIGHT_COMMANDS, "a UAV is in the air");
            return false;
        }
        let sent_before = self.requests;
        self.operate(&env_07::RULE, PROGRESS_TIMEOUT, json!({ "type": "UAV-TAKEOFF", "ids": ids }));
        let has_taken_off = self.requests > sent_before;
        let is_in_air =
            |now: &[Altitude]| heights(now, &ground).is_some_and(|all| all.iter().all(|up| *up > AIRBORNE));
        let was_in_air = has_taken_off && self.wait_for_altitudes(TAKEOFF_TIMEOUT, uavs, is_in_air);
        self.query(json!({ "type": "UAV-HOVER", "ids": ids }));
        self.fly_up(first);
        if !has_taken_off {
            self.query(json!({ "type": "UAV-RTH", "ids": ids }));
            self.query(json!({ "type": "UAV-LAND", "ids": ids }));
            return false;
        }
        let is_landed = self.land(uavs, &ground);
        if !is_landed {
            self.cut_short(format!("these UAVs were not seen to land, check them: {}", uavs.join(", ")));
        }
        was_in_air && is_landed
    }

    /// Makes a UAV fly to a point above its position.
    fn fly_up(&mut self, uav: &str) {
        let state = self.query(json!({ "type": "UAV-INF", "ids": [uav] }));
        let position = state.map(|answer| answer["body"]["status"][uav]["position"].clone());
        let Some([latitude, longitude, ..]) = position.as_ref().and_then(Value::as_array).map(Vec::as_slice)
        else {
            return self.coverage.not_sent(&["UAV-FLY"], "needs the position of a UAV");
        };
        let target = json!([latitude, longitude, null, HEIGHT]);
        self.query(json!({ "type": "UAV-FLY", "ids": [uav], "target": target }));
        self.listen(FLIGHT);
    }

    /// Returns and lands UAVs, whatever the user selected, and even if the time limit is reached or a connection fails.
    /// Returns true if all UAVs were seen on the ground.
    fn land(&mut self, uavs: &[String], ground: &[Altitude]) -> bool {
        let ids = with_unknown_id(uavs);
        let end = std::mem::replace(&mut self.end, Instant::now() + LANDING_TIMEOUT);
        let cut_short = self.cut_short.take();
        self.insist(&json!({ "type": "UAV-RTH", "ids": ids }));
        self.listen(FLIGHT);
        self.end = Instant::now() + LANDING_TIMEOUT;
        if let Some(receipt) = receipt(self.insist(&json!({ "type": "UAV-LAND", "ids": ids })).as_ref()) {
            self.wait(PROGRESS_TIMEOUT, |message| is_end(message, &receipt));
        }
        let is_down =
            |now: &[Altitude]| heights(now, ground).is_some_and(|all| all.iter().all(|up| *up < LANDED));
        // A UAV that only passes this height is lower a moment later.
        let mut before: Option<Vec<Altitude>> = None;
        let is_still = |now: &[Altitude]| {
            let moved = before.replace(now.to_vec()).and_then(|before| heights(now, &before));
            is_down(now) && moved.is_some_and(|all| all.iter().all(|moved| moved.abs() < STILL))
        };
        let is_landed = self.wait_for_altitudes(LANDING_TIMEOUT, uavs, is_still);
        self.end = end;
        if let Some(reason) = cut_short {
            self.cut_short(reason);
        }
        is_landed
    }

    /// Sends a request until the server answers it, whatever the user selected. Connects again if necessary.
    fn insist(&mut self, body: &Value) -> Option<Value> {
        for _ in 0..MAX_ATTEMPTS {
            self.reconnects = 0;
            if let Some(answer) = self.discover(body.clone()) {
                return Some(answer);
            }
            // The UAV matters more than the reason to stop.
            self.cut_short = None;
            thread::sleep(ALTITUDE_INTERVAL);
        }
        None
    }

    /// Sends the commands that would make a flying UAV fall.
    fn restart(&mut self, uavs: &[String], is_on_ground: bool) {
        if !is_on_ground {
            let why = "the UAVs were not seen to take off and land";
            return self.coverage.not_sent(&["SHOW-CRTH-START", "UAV-HALT", "UAV-RST"], why);
        }
        let all = ids(self.discover(json!({ "type": "UAV-LIST" })).as_ref());
        if !all.is_empty() && all.iter().all(|id| uavs.contains(id)) {
            self.query(json!({ "type": "SHOW-CRTH-START" }));
        } else {
            self.coverage.not_sent(&["SHOW-CRTH-START"], "could move UAVs that --uav doesn't name");
        }
        for kind in ["UAV-HALT", "UAV-RST"] {
            self.operate(
                &env_07::RULE,
                PROGRESS_TIMEOUT,
                json!({ "type": kind, "ids": with_unknown_id(uavs) }),
            );
        }
    }

    /// Waits until the altitudes of all UAVs are as wanted. Returns false if they never are, or if an altitude is
    /// unknown.
    fn wait_for_altitudes(
        &mut self,
        time: Duration,
        uavs: &[String],
        mut is_wanted: impl FnMut(&[Altitude]) -> bool,
    ) -> bool {
        let until = (Instant::now() + time).min(self.end);
        loop {
            if self.altitudes(uavs).is_some_and(|altitudes| is_wanted(&altitudes)) {
                return true;
            }
            if Instant::now() >= until {
                return false;
            }
            if self.session.is_some() {
                self.listen(ALTITUDE_INTERVAL);
            } else {
                thread::sleep(ALTITUDE_INTERVAL);
            }
        }
    }

    /// The altitudes of UAVs. `None` if one of them is unknown.
    fn altitudes(&mut self, uavs: &[String]) -> Option<Vec<Altitude>> {
        let answer = self.discover(json!({ "type": "UAV-INF", "ids": uavs }))?;
        let altitude = |id: &String| {
            let position = &answer["body"]["status"][id]["position"];
            let above_home = position[3].as_i64().map(Altitude::AboveHome);
            above_home.or_else(|| position[2].as_i64().map(Altitude::AboveSea))
        };
        uavs.iter().map(altitude).collect()
    }

    /// Sends a command, and waits for the end of its first operation.
    fn operate(&mut self, rule: &'static FlockwaveRule, limit: Duration, body: Value) {
        if let Some(receipt) = receipt(self.query_for_trial(rule, body).as_ref()) {
            self.wait(limit, |message| is_end(message, &receipt));
        }
    }

    /// Waits for a message.
    fn wait(&mut self, time: Duration, is_wanted: impl Fn(&Value) -> bool) -> Option<Value> {
        let until = (Instant::now() + time).min(self.end);
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
