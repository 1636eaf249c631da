//! The commands that a probe has sent and not yet undone.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Value, json};
use uavspec_rules::flockwave::trial::UNKNOWN_ID;
use uavspec_types::flockwave::ErrorCode;

/// An effect of a command on a UAV, which the probe must undo. Effects are undone in this order: a sleeping UAV obeys
/// no command, and a flying UAV would fall if its motors were stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Effect {
    /// The UAV may be asleep.
    Asleep,
    /// The UAV may be in the air.
    Airborne,
    /// The motors may be running on the ground.
    MotorsOn,
}

impl Effect {
    /// All effects, in the order in which they are undone.
    pub(super) const ALL: [Self; 3] = [Self::Asleep, Self::Airborne, Self::MotorsOn];

    /// The effect that a request may have on its UAVs.
    fn of(body: &Value) -> Option<Self> {
        match body["type"].as_str()? {
            "UAV-SLEEP" => Some(Self::Asleep),
            "UAV-TAKEOFF" | "UAV-FLY" | "UAV-HOVER" | "UAV-RTH" | "SHOW-CRTH-START" => Some(Self::Airborne),
            // A motor may start unless the request says otherwise.
            "UAV-MOTOR" if body["start"] != false => Some(Self::MotorsOn),
            _ => None,
        }
    }

    /// A warning about a UAV that may be in this state.
    fn warning(self, uav: &str) -> String {
        let uav = uavspec_model::text::shown(uav);
        match self {
            Self::Asleep => format!("UAV {uav} may still be asleep"),
            Self::Airborne => format!("UAV {uav} may still be flying"),
            Self::MotorsOn => format!("the motors of UAV {uav} may still be running"),
        }
    }

    /// True if the status of a UAV is known, and doesn't report this effect.
    pub(super) fn is_absent(self, status: &Value) -> bool {
        let codes = match self {
            Self::Asleep => &[ErrorCode::SLEEP][..],
            Self::Airborne => &[ErrorCode::TAKEOFF, ErrorCode::LANDING, ErrorCode::RTH],
            Self::MotorsOn => &[ErrorCode::MOTORS],
        };
        status.is_object() && !codes.iter().any(|code| has_code(status, *code))
    }

    /// The type of the request that undoes the effect.
    pub(super) fn undo_type(self) -> &'static str {
        match self {
            Self::Asleep => "UAV-WAKEUP",
            Self::Airborne => "UAV-LAND",
            Self::MotorsOn => "UAV-MOTOR",
        }
    }

    /// The request that undoes the effect. It contains only ids of existing UAVs, because a server might refuse the
    /// whole request for an unknown id.
    pub(super) fn undo(self, uavs: &[String]) -> Value {
        let mut body = json!({ "type": self.undo_type(), "ids": uavs });
        if self == Self::MotorsOn {
            body["start"] = false.into();
        }
        body
    }
}

/// The commands that have not been undone yet.
#[derive(Clone, Debug, Default)]
pub(super) struct Commanded {
    /// The effects, by effect and UAV. The flag is true if the server refused the command.
    effects: BTreeMap<(Effect, String), bool>,
    /// The receipts of calibrations and tests that haven't ended.
    operations: BTreeSet<String>,
    /// The receipts of commands that undo effects. The value is true if the operation succeeded, false if it failed,
    /// and `None` until it ends.
    undoing: BTreeMap<String, Option<bool>>,
}

impl Commanded {
    /// Records a request that is about to be sent, because it may have an effect even if it is never answered. `all`
    /// are the UAVs that a request without ids addresses.
    pub(super) fn sent<'u>(&mut self, body: &Value, all: impl Iterator<Item = &'u String>) {
        let Some(effect) = Effect::of(body) else { return };
        let uavs = uavs(body).unwrap_or_else(|| all.cloned().collect());
        self.effects.extend(uavs.into_iter().map(|uav| ((effect, uav), false)));
    }

    /// Records the answer to a request.
    pub(super) fn answered(&mut self, body: &Value, answer: &Value) {
        if matches!(body["type"].as_str(), Some("UAV-CALIB" | "UAV-TEST")) {
            self.operations.extend(receipts(answer));
        }
        let Some(effect) = Effect::of(body) else { return };
        for uav in uavs(body).unwrap_or_default() {
            let is_refused = matches!(Reply::new(answer, &uav), Reply::Refusal(_));
            if let Some(was_refused) = self.effects.get_mut(&(effect, uav)) {
                *was_refused = is_refused;
            }
        }
    }

    /// Records a notification, which may report the end of operations.
    pub(super) fn received(&mut self, body: &Value) {
        let is_timeout = body["type"] == "ASYNC-TIMEOUT";
        let ended = match body["type"].as_str() {
            Some("ASYNC-RESP") => std::slice::from_ref(&body["id"]),
            Some("ASYNC-TIMEOUT") => body["ids"].as_array().map_or(&[][..], Vec::as_slice),
            _ => return,
        };
        let has_succeeded = !is_timeout && body["error"].is_null() && body["result"] != false;
        for receipt in ended.iter().filter_map(Value::as_str) {
            self.operations.remove(receipt);
            if let Some(outcome) = self.undoing.get_mut(receipt) {
                *outcome = Some(has_succeeded);
            }
        }
    }

    /// Records the receipt of a command that undoes an effect.
    pub(super) fn follow(&mut self, receipt: &str) {
        self.undoing.entry(receipt.to_owned()).or_default();
    }

    /// True if the operation with this receipt succeeded, and false if it failed. `None` until it ends.
    pub(super) fn outcome(&self, receipt: &str) -> Option<bool> {
        self.undoing.get(receipt).copied().flatten()
    }

    /// Records that the effect on a UAV has been undone.
    pub(super) fn undone(&mut self, effect: Effect, uav: &str) {
        self.effects.remove(&(effect, uav.to_owned()));
    }

    /// True if the server refused the command with this effect, so the UAV may never have been in this state.
    pub(super) fn is_refused(&self, effect: Effect, uav: &str) -> bool {
        self.effects.get(&(effect, uav.to_owned())) == Some(&true)
    }

    /// The UAVs that may be in this state.
    pub(super) fn uavs(&self, effect: Effect) -> Vec<String> {
        self.effects.keys().filter(|(other, _)| *other == effect).map(|(_, uav)| uav.clone()).collect()
    }

    /// True if all UAVs are safe.
    pub(super) fn is_safe(&self) -> bool {
        self.effects.is_empty()
    }

    /// Removes and returns the receipts of the operations that haven't ended.
    pub(super) fn take_operations(&mut self) -> BTreeSet<String> {
        std::mem::take(&mut self.operations)
    }

    /// Clauses that name the UAVs that may be unsafe. `None` if all UAVs are safe.
    pub(super) fn at_risk(&self) -> Option<String> {
        let warnings: Vec<String> = self.effects.keys().map(|(effect, uav)| effect.warning(uav)).collect();
        (!warnings.is_empty()).then(|| warnings.join("; "))
    }
}

/// The UAVs that a command names. `None` if it has no ids.
fn uavs(body: &Value) -> Option<Vec<String>> {
    let ids = body["ids"].as_array()?.iter().filter_map(Value::as_str);
    Some(ids.filter(|id| *id != UNKNOWN_ID).map(str::to_owned).collect())
}

/// The receipts in an answer.
fn receipts(answer: &Value) -> Vec<String> {
    match &answer["body"]["receipt"] {
        Value::String(receipt) => vec![receipt.clone()],
        Value::Object(all) => all.values().filter_map(Value::as_str).map(str::to_owned).collect(),
        _ => Vec::new(),
    }
}

/// An answer to a command, for one UAV. The probe doesn't rely on it: the status of the UAV shows whether an effect is
/// undone.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Reply {
    /// The UAV has executed the command. The result is null if the command has no result.
    Success,
    /// The UAV is executing the command. Contains the receipt of the operation.
    Receipt(String),
    /// The command was refused. Contains the reason.
    Refusal(String),
    /// The answer doesn't mention the UAV.
    Missing,
}

impl Reply {
    pub(super) fn new(answer: &Value, uav: &str) -> Self {
        let body = &answer["body"];
        if body["type"] == "ACK-NAK" {
            return Self::Refusal(text(&body["reason"]));
        }
        let receipt = body["receipt"].as_str().or_else(|| body["receipt"][uav].as_str());
        match (receipt, &body["error"][uav], body["result"].get(uav)) {
            (_, error, _) if !error.is_null() => Self::Refusal(text(error)),
            (Some(receipt), ..) => Self::Receipt(receipt.to_owned()),
            (None, _, Some(Value::Bool(false))) => Self::Refusal("the command failed".to_owned()),
            (None, _, None) => Self::Missing,
            (None, _, Some(_)) => Self::Success,
        }
    }
}

/// True if the status of a UAV contains this error code.
pub(super) fn has_code(status: &Value, code: ErrorCode) -> bool {
    status["errors"].as_array().is_some_and(|codes| codes.iter().any(|other| *other == u64::from(code.0)))
}

/// True if, according to its status, the UAV is on the ground and awake, and its motors aren't running.
pub(super) fn is_at_rest(status: &Value) -> bool {
    let has = |code: ErrorCode| has_code(status, code);
    let is_on_ground = has(ErrorCode::GROUND) || has(ErrorCode::LANDED);
    is_on_ground && !has(ErrorCode::MOTORS) && !has(ErrorCode::SLEEP)
}

fn text(reason: &Value) -> String {
    reason.as_str().map_or_else(|| reason.to_string(), str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn remembers_each_command_that_changes_a_uav() {
        let ids = ["07", UNKNOWN_ID];
        for (kind, risk) in [
            ("UAV-TAKEOFF", Some("UAV 07 may still be flying")),
            ("UAV-FLY", Some("UAV 07 may still be flying")),
            ("UAV-HOVER", Some("UAV 07 may still be flying")),
            ("UAV-RTH", Some("UAV 07 may still be flying")),
            ("UAV-SLEEP", Some("UAV 07 may still be asleep")),
            ("UAV-MOTOR", Some("the motors of UAV 07 may still be running")),
            ("UAV-LAND", None),
            ("UAV-WAKEUP", None),
            ("UAV-INF", None),
        ] {
            let mut commanded = Commanded::default();
            commanded.sent(&json!({ "type": kind, "ids": ids }), [].iter());
            assert_eq!(commanded.at_risk().as_deref(), risk, "{kind}");
            assert_eq!(commanded.is_safe(), risk.is_none());
        }
        let mut commanded = Commanded::default();
        commanded.sent(&json!({ "type": "UAV-MOTOR", "ids": ["07"], "start": false }), [].iter());
        assert!(commanded.is_safe());
        commanded.sent(&json!({ "type": "SHOW-CRTH-START" }), ["07".to_owned(), "08".to_owned()].iter());
        assert_eq!(commanded.uavs(Effect::Airborne), ["07", "08"]);
    }

    #[test]
    fn wakes_uavs_before_it_lands_them_and_stops_motors_last() {
        let mut commanded = Commanded::default();
        for kind in ["UAV-MOTOR", "UAV-TAKEOFF", "UAV-SLEEP"] {
            commanded.sent(&json!({ "type": kind, "ids": ["07"] }), [].iter());
        }
        let order: Vec<Effect> = commanded.effects.keys().map(|(effect, _)| *effect).collect();
        assert_eq!(order, Effect::ALL);
    }

    #[test]
    fn a_refused_command_may_have_had_an_effect() {
        let mut commanded = Commanded::default();
        let body = json!({ "type": "UAV-MOTOR", "ids": ["07", "08"], "start": true });
        commanded.sent(&body, [].iter());
        let answer =
            json!({ "body": { "type": "UAV-MOTOR", "result": { "07": true }, "error": { "08": "no" } } });
        commanded.answered(&body, &answer);
        assert!(!commanded.is_refused(Effect::MotorsOn, "07"));
        assert!(commanded.is_refused(Effect::MotorsOn, "08"));
        assert_eq!(commanded.uavs(Effect::MotorsOn), ["07", "08"]);
        commanded.undone(Effect::MotorsOn, "07");
        assert_eq!(commanded.uavs(Effect::MotorsOn), ["08"]);
    }

    #[test]
    fn a_state_that_is_reported_or_unknown_is_not_absent() {
        let is_absent = |effect: Effect, status: Value| effect.is_absent(&status);
        assert!(is_absent(Effect::MotorsOn, json!({ "errors": [1] })));
        assert!(is_absent(Effect::MotorsOn, json!({})));
        assert!(!is_absent(Effect::MotorsOn, json!({ "errors": [8] })));
        assert!(!is_absent(Effect::Asleep, json!({ "errors": [66, 9] })));
        assert!(!is_absent(Effect::Asleep, Value::Null));
    }

    #[test]
    fn only_a_uav_that_is_awake_on_the_ground_is_at_rest() {
        let is_at_rest = |codes: Value| is_at_rest(&json!({ "errors": codes }));
        assert!(is_at_rest(json!([1])) && is_at_rest(json!([66, 1])) && is_at_rest(json!([7])));
        for codes in [json!([]), json!(null), json!([8]), json!([1, 8]), json!([9, 1]), json!(["1"])] {
            assert!(!is_at_rest(codes.clone()), "{codes}");
        }
    }

    #[test]
    fn an_unclear_answer_is_no_refusal() {
        let mut commanded = Commanded::default();
        let body = json!({ "type": "UAV-MOTOR", "ids": ["07"], "start": true });
        commanded.sent(&body, [].iter());
        commanded.answered(&body, &json!({ "body": { "type": "ACK-ACK" } }));
        assert!(!commanded.is_refused(Effect::MotorsOn, "07"));
    }

    #[test]
    fn forgets_operations_that_ended() {
        let mut commanded = Commanded::default();
        let body = json!({ "type": "UAV-TEST", "ids": ["1", "2", "3"] });
        let receipts = json!({ "1": "a", "2": "b", "3": "c" });
        commanded.answered(&body, &json!({ "body": { "type": "UAV-TEST", "receipt": receipts } }));
        commanded.received(&json!({ "type": "ASYNC-RESP", "id": "a", "result": true }));
        commanded.received(&json!({ "type": "ASYNC-TIMEOUT", "ids": ["c", 7] }));
        assert_eq!(commanded.take_operations(), BTreeSet::from(["b".to_owned()]));
        assert_eq!(commanded.take_operations(), BTreeSet::new());
    }

    #[test]
    fn remembers_how_the_operations_ended_that_undo_effects() {
        let mut commanded = Commanded::default();
        for receipt in ["a", "b", "c", "d"] {
            commanded.follow(receipt);
        }
        commanded.received(&json!({ "type": "ASYNC-RESP", "id": "a", "result": null }));
        commanded.received(&json!({ "type": "ASYNC-RESP", "id": "b", "error": "no" }));
        commanded.received(&json!({ "type": "ASYNC-TIMEOUT", "ids": ["c", "other"] }));
        commanded.follow("a");
        let outcomes = ["a", "b", "c", "d", "other"].map(|receipt| commanded.outcome(receipt));
        assert_eq!(outcomes, [Some(true), Some(false), Some(false), None, None]);
        assert_eq!(commanded.take_operations(), BTreeSet::new(), "a landing must not be cancelled");
    }

    #[test]
    fn understands_all_answers_to_commands() {
        let reply = |body: Value| Reply::new(&json!({ "body": body }), "07");
        let refusal = |reason: &str| Reply::Refusal(reason.to_owned());
        assert_eq!(reply(json!({ "type": "ACK-NAK", "reason": "busy" })), refusal("busy"));
        assert_eq!(reply(json!({ "type": "UAV-LAND", "error": { "07": "lost" } })), refusal("lost"));
        assert_eq!(
            reply(json!({ "type": "UAV-LAND", "result": { "07": false } })),
            refusal("the command failed")
        );
        for result in [json!(true), Value::Null, json!("done")] {
            assert_eq!(reply(json!({ "type": "UAV-LAND", "result": { "07": result } })), Reply::Success);
        }
        assert_eq!(
            reply(json!({ "type": "UAV-LAND", "receipt": { "07": "r" } })),
            Reply::Receipt("r".to_owned())
        );
        let other = reply(json!({ "type": "UAV-LAND", "result": { "08": true } }));
        assert_eq!(other, Reply::Missing);
        assert_eq!(reply(json!({ "type": "ACK-ACK" })), Reply::Missing);
    }
}
