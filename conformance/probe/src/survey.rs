//! The survey: requests that change nothing, for each family of messages.

use std::collections::BTreeSet;
use std::time::Duration;

use serde_json::{Value, json};
use uavspec_flockwave::transport::endpoint::Endpoint;
use uavspec_rules::flockwave::trial::{self, Request, UNKNOWN_ID};
use uavspec_rules::flockwave::{ack_06, env_24, sys_ping_01};

use super::Probe;
use crate::limits::MAX_OBJECTS;

/// The approximate number of steps.
pub(super) const STEPS: usize = 80;

/// A message type that doesn't exist.
const UNKNOWN_TYPE: &str = "PROBE-NONE";

/// The time limit for the first UAV to appear. Some servers have UAVs only while a client is connected.
const UAV_TIMEOUT: Duration = Duration::from_secs(5);

/// The default time limit for the appearance of the UAVs that may receive commands.
pub(super) const NAMED_UAV_TIMEOUT: Duration = Duration::from_secs(30);

/// The interval between requests while waiting for UAVs.
const POLL_INTERVAL: Duration = Duration::from_millis(400);

impl Probe<'_, '_> {
    /// Sends all requests of the survey.
    pub(super) fn survey(&mut self) {
        if !self.server() {
            return;
        }
        let uavs = self.fleet();
        self.lists(&uavs);
        self.extras();
        self.requests_for_trials(&uavs);
        self.query(json!({ "type": "SYS-TIME" }));
        self.observe();
        self.command(&uavs);
        self.query(json!({ "type": "UAV-LIST" }));
        self.query(json!({ "type": "OBJ-LIST" }));
    }

    /// Requests information about the server. Returns false if the probe can't continue.
    fn server(&mut self) -> bool {
        let login = self.discover(json!({ "type": "AUTH-INF" }));
        // A server may refuse even this request before the login.
        let is_refused = login.as_ref().is_some_and(|answer| answer["body"]["type"] != "AUTH-INF");
        let login = login.unwrap_or_default();
        let is_required = login["body"]["required"] == true;
        let methods = login["body"]["methods"].as_array();
        let has_basic = methods.is_some_and(|methods| methods.iter().any(|method| method == "basic"));
        // With HTTP Basic authentication, the client is logged in from the start.
        let may_be_logged_in = self.options.login.is_some()
            && matches!(self.endpoint, Endpoint::Http { .. } | Endpoint::SocketIo { .. });
        if is_required && !may_be_logged_in {
            self.query_for_trial(&ack_06::RULE, json!({ "type": "UAV-LIST" }));
        }
        if self.options.login.is_none() {
            if is_required {
                self.failure = Some("the server requires a login; use --login".to_owned());
                return false;
            }
        } else if !has_basic && !is_required && !is_refused {
            // The login is meant for the HTTP server.
            self.has_login = false;
            self.coverage.not_sent(&["AUTH-REQ"], "the server has no login with the method basic");
        } else if !self.log_in() {
            self.has_login = false;
            let reason =
                self.cut_short.take().unwrap_or_else(|| "the server didn't answer AUTH-REQ".to_owned());
            // A server without a login refuses both requests. AUTH-RESP is an answer to the login, not a refusal.
            let has_no_login = is_refused && self.coverage.refused("AUTH-REQ") > 0;
            if !(has_no_login || may_be_logged_in && self.is_logged_in(is_required)) {
                self.failure = Some(format!("{reason}; check the name and password of --login"));
                return false;
            }
        }
        self.query(json!({ "type": "AUTH-WHOAMI" }));
        self.query_for_trial(&sys_ping_01::RULE, json!({ "type": "SYS-PING" }));
        self.query_for_trial(&env_24::RULE, json!({ "type": "SYS-VER" }));
        self.query(json!({ "type": "SYS-VER" }));
        for _ in 0..2 {
            self.query(json!({ "type": "SYS-TIME" }));
        }
        self.query(json!({ "type": "SYS-PORTS" }));
        let refusal = self.query(json!({ "type": UNKNOWN_TYPE }));
        self.unknown_type = refusal.as_ref().and_then(|answer| reason(answer, UNKNOWN_TYPE));
        self.cut_short.is_none() && self.failure.is_none() && !self.stop.is_due()
    }

    /// True if the client is logged in without AUTH-REQ, because each HTTP request contains the login.
    fn is_logged_in(&mut self, is_required: bool) -> bool {
        let user = self.discover(json!({ "type": "AUTH-WHOAMI" }));
        if user.is_some_and(|answer| answer["body"]["user"].as_str().is_some_and(|user| !user.is_empty())) {
            return true;
        }
        let served = self.discover(json!({ "type": "UAV-LIST" }));
        is_required && served.is_some_and(|answer| answer["body"]["type"] == "UAV-LIST")
    }

    /// Requests the UAVs, their states, and other objects.
    fn fleet(&mut self) -> Vec<String> {
        self.await_uavs();
        self.query(json!({ "type": "UAV-LIST" }));
        self.query_for_trial(&env_24::RULE, json!({ "type": "OBJ-LIST", "filter": ["uav"] }));
        let uavs = ids(self.discover(json!({ "type": "UAV-LIST" })).as_ref());
        self.query(json!({ "type": "OBJ-LIST" }));
        for kind in ["uav", "beacon", "weatherStation", "dock"] {
            self.query(json!({ "type": "OBJ-LIST", "filter": [kind] }));
        }
        self.query(json!({ "type": "OBJ-LIST" }));
        let uavs = selected(uavs, &self.options.uavs);
        for kind in ["UAV-INF", "UAV-VER", "UAV-PREFLT"] {
            self.query(json!({ "type": kind, "ids": with_unknown_id(&uavs) }));
        }
        self.query(json!({ "type": "UAV-LIST" }));
        uavs
    }

    /// Waits for the first UAV, and for all UAVs that may receive commands.
    fn await_uavs(&mut self) {
        let (began, end) = (self.clock.now(), self.end);
        let limit = if self.options.uavs.is_empty() { UAV_TIMEOUT } else { self.options.uav_timeout };
        // This wait extends the time limit of the probe, because the limit is for the other requests.
        self.end += limit;
        let mut first_after = None;
        loop {
            let uavs = ids(self.discover(json!({ "type": "UAV-LIST" })).as_ref());
            let waited = self.clock.now().saturating_duration_since(began);
            if !uavs.is_empty() {
                first_after.get_or_insert(waited);
            }
            let is_complete = !uavs.is_empty() && self.options.uavs.iter().all(|uav| uavs.contains(uav));
            if is_complete || waited >= limit || self.must_stop().is_some() || !self.ensure_connected() {
                break;
            }
            self.listen(POLL_INTERVAL);
            self.sleep(self.clock.left(began + waited + POLL_INTERVAL));
        }
        match first_after {
            None => self.note(format!("no UAV appeared within {} s", limit.as_secs())),
            Some(time) if time > POLL_INTERVAL => {
                self.note(format!("the first UAV appeared after {:.1} s", time.as_secs_f64()));
                // More UAVs may appear soon.
                self.listen(POLL_INTERVAL * 4);
            }
            Some(_) => {}
        }
        self.end = end + self.clock.now().saturating_duration_since(began);
    }

    /// Requests the objects of the mandatory and common message families.
    fn lists(&mut self, uavs: &[String]) {
        let connections = ids(self.query_for_trial(&env_24::RULE, json!({ "type": "CONN-LIST" })).as_ref());
        self.query(json!({ "type": "CONN-INF", "ids": with_unknown_id(&connections) }));
        let clocks = ids(self.query(json!({ "type": "CLK-LIST" })).as_ref());
        self.query(json!({ "type": "CLK-INF", "ids": with_unknown_id(&clocks) }));
        let beacons = ids(self.query(json!({ "type": "OBJ-LIST", "filter": ["beacon"] })).as_ref());
        for kind in ["BCN-INF", "BCN-PROPS"] {
            self.query(json!({ "type": kind, "ids": with_unknown_id(&beacons) }));
        }
        let stations = ids(self.query(json!({ "type": "WTH-LIST" })).as_ref());
        self.query(json!({ "type": "WTH-INF", "ids": with_unknown_id(&stations) }));
        self.query(json!({ "type": "WTH-AT", "position": [474_863_000, 189_151_000] }));
        let presets = ids(self.query_for_trial(&env_24::RULE, json!({ "type": "RTK-LIST" })).as_ref());
        self.query(json!({ "type": "RTK-INF", "ids": with_unknown_id(&presets) }));
        for kind in ["RTK-SOURCE", "RTK-STAT", "RTK-SURVEY"] {
            self.query(json!({ "type": kind }));
        }
        let extensions = self.query_for_trial(&env_24::RULE, json!({ "type": "EXT-LIST" }));
        let extensions = strings(extensions.as_ref().map(|answer| &answer["body"]["loaded"]));
        self.query_for_trial(
            &env_24::RULE,
            json!({ "type": "EXT-INF", "ids": with_unknown_id(&extensions) }),
        );
        let first = &extensions[..extensions.len().min(1)];
        self.query(json!({ "type": "EXT-CFG", "ids": with_unknown_id(first) }));
        self.devices(uavs);
    }

    /// Requests the objects of the optional message families. A server may refuse all of these requests.
    fn extras(&mut self) {
        for kind in ["LCN-INF", "TIMESYNC-STATUS", "SHOW-CFG", "SHOW-LIGHTS"] {
            self.query(json!({ "type": kind }));
        }
        let docks = ids(self.query(json!({ "type": "OBJ-LIST", "filter": ["dock"] })).as_ref());
        self.query(json!({ "type": "DOCK-INF", "ids": with_unknown_id(&docks) }));
        let targets = ids(self.query(json!({ "type": "FW-TARGET-LIST" })).as_ref());
        self.query(json!({ "type": "FW-TARGET-INF", "ids": with_unknown_id(&targets) }));
        self.query(json!({ "type": "FW-OBJECT-LIST" }));
    }

    /// Requests the device trees of UAVs, and the values of one channel in these trees.
    fn devices(&mut self, uavs: &[String]) {
        let ids = with_unknown_id(&uavs[..uavs.len().min(2)]);
        let trees = self.query_for_trial(&env_24::RULE, json!({ "type": "DEV-LIST", "ids": ids }));
        let channel = trees.as_ref().and_then(|answer| {
            let trees = answer["body"]["devices"].as_object()?;
            trees.iter().find_map(|(id, tree)| channel(&format!("/{id}"), tree, 0))
        });
        let paths: Vec<String> = channel.into_iter().chain([format!("/{UNKNOWN_ID}")]).collect();
        for kind in ["DEV-INF", "DEV-SUB", "DEV-UNSUB"] {
            self.query(json!({ "type": kind, "paths": paths }));
        }
        self.query_for_trial(&env_24::RULE, json!({ "type": "DEV-LISTSUB", "pathFilter": ["/"] }));
    }

    /// Sends the requests that test rules on the survey's connection.
    fn requests_for_trials(&mut self, uavs: &[String]) {
        for (rule, request) in trial::requests(uavs) {
            if self.options.selection.has_trial(rule, request.how, request.body["type"].as_str()) {
                self.request(rule, request);
            }
        }
        // A server may refuse unknown operations, so the second request contains no operation.
        for ids in [&[UNKNOWN_ID][..], &[]] {
            let resume = json!({ "type": "ASYNC-RESUME", "ids": ids, "values": {} });
            self.query_for_trial(&env_24::RULE, resume);
        }
    }

    /// Listens for notifications.
    fn observe(&mut self) {
        let until = (self.clock.now() + self.options.observe).min(self.end);
        while self.clock.now() < until && !self.stop.is_due() && self.ensure_connected() {
            self.listen(self.clock.left(until).min(POLL_INTERVAL));
        }
        self.step();
    }

    /// True if the server refuses a request with the same reason as a request of an unknown type.
    pub(super) fn is_unsupported(&self, answer: &Value, type_name: &str) -> bool {
        self.unknown_type.is_some() && reason(answer, type_name) == self.unknown_type
    }

    /// Sends a request whose answer is needed for later requests. It is sent even if the user didn't select its type.
    #[allow(clippy::needless_pass_by_value)] // callers build the body in the call
    pub(super) fn discover(&mut self, body: Value) -> Option<Value> {
        self.request(&env_24::RULE.rule, Request::new("", body))
    }

    /// Reads messages for some time.
    pub(super) fn listen(&mut self, time: Duration) {
        let until = self.clock.now() + time;
        let Some(session) = &mut self.session else { return };
        while session.receive(&mut self.tape, until).is_some() && self.clock.now() < until {}
    }
}

/// The reason for a refusal. The type of the request is removed from the text.
fn reason(answer: &Value, type_name: &str) -> Option<String> {
    let is_refusal = answer["body"]["type"] == "ACK-NAK";
    is_refusal.then(|| answer["body"]["reason"].as_str().unwrap_or_default().replace(type_name, "…"))
}

/// The distinct ids in an answer.
pub(super) fn ids(answer: Option<&Value>) -> Vec<String> {
    strings(answer.map(|answer| &answer["body"]["ids"]))
}

fn strings(list: Option<&Value>) -> Vec<String> {
    let list = list.and_then(Value::as_array).into_iter().flatten();
    let found: BTreeSet<&str> = list.filter_map(Value::as_str).collect();
    found.into_iter().map(str::to_owned).collect()
}

/// The UAVs to request in detail: first the UAVs that the user named, then others.
fn selected(mut uavs: Vec<String>, named: &[String]) -> Vec<String> {
    uavs.sort_by_key(|id| !named.contains(id));
    uavs.truncate(MAX_OBJECTS);
    uavs
}

/// The first id, followed by a nonexistent id.
pub(super) fn with_unknown_id(ids: &[String]) -> Vec<&str> {
    ids.iter().take(MAX_OBJECTS).map(String::as_str).chain([UNKNOWN_ID]).collect()
}

/// The path of the first channel in a device tree.
fn channel(path: &str, node: &Value, depth: usize) -> Option<String> {
    if node["type"] == "channel" {
        return Some(path.to_owned());
    }
    let children = node["children"].as_object().filter(|_| depth < 8)?;
    children.iter().find_map(|(name, child)| channel(&format!("{path}/{name}"), child, depth + 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Only the selected UAVs receive commands.
    #[test]
    fn named_uavs_are_selected_from_a_large_fleet() {
        let fleet: Vec<String> = (0..500).map(|number| format!("uav {number:03}")).collect();
        let named = ["uav 400".to_owned(), "uav 499".to_owned(), "uav 999".to_owned()];
        let found = selected(fleet, &named);
        assert_eq!(found.len(), MAX_OBJECTS);
        assert_eq!(found[..3], ["uav 400", "uav 499", "uav 000"]);
    }
}
