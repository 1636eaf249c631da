//! Bugs in the state of UAVs.

use serde_json::{Value, json};

use super::{Bug, Outgoing};

pub(super) const BUGS: &[Bug] = &[
    Bug::message("FW-UAV-INF-01", "The last UAV that was asked for is missing.", |out| {
        out.lose_last(&["UAV-INF"]);
    }),
    Bug::message("FW-UAV-INF-02", "There is a UAV that nobody asked for.", |out| {
        if !out.is_notification()
            && let Some(mut state) = out.state().cloned()
        {
            state["id"] = json!("ghost-1");
            out.message()["body"]["status"]["ghost-1"] = state;
        }
    }),
    Bug::message("FW-UAV-INF-03", "A UAV has another id than its key.", |out| {
        change(out, "id", json!("ghost-1"));
    }),
    Bug::message("FW-UAV-INF-04", "Errors are objects.", |out| {
        let Some(body) = out.body_of("UAV-INF") else { return };
        for error in body["error"].as_object_mut().into_iter().flat_map(|errors| errors.values_mut()) {
            *error = json!({ "reason": error.take() });
        }
        // Reading a field that isn't there makes it one that is null.
        if body["error"].is_null()
            && let Some(body) = body.as_object_mut()
        {
            body.remove("error");
        }
    }),
    Bug::message("FW-UAV-INF-05", "Notifications have errors, too.", |out| {
        if let Some(body) = out.notification_of("UAV-INF") {
            body["error"] = json!({ "ghost-1": "there is no such UAV" });
        }
    }),
    Bug::behaviour("FW-UAV-INF-06", "An unknown UAV makes the whole request fail."),
    Bug::behaviour("FW-UAV-INF-07", "Requests with no ids, or with an id twice, fail."),
    Bug::message("FW-UAV-INF-08", "Every other time stamp lies ten seconds back.", |out| {
        let is_odd = out.number % 2 == 1;
        shift(out, |time| if is_odd { time - 10_000 } else { time });
    }),
    Bug::message("FW-UAV-INF-09", "Time stamps lie an hour ahead.", |out| {
        shift(out, |time| time + 3_600_000);
    }),
    Bug::message("FW-UST-ID", "The id of a UAV is a number.", |out| change(out, "id", json!(7))),
    Bug::message("FW-UST-TIMESTAMP", "A time stamp is a text.", |out| {
        change(out, "timestamp", json!("noon"));
    }),
    Bug::message("FW-UST-MODE", "A mode is a number.", |out| change(out, "mode", json!(4))),
    Bug::message("FW-UST-POSITION", "A latitude lies beyond the pole.", |out| {
        change(out, "position", json!([900_000_001, 0]));
    }),
    Bug::message("FW-UST-POSITIONXYZ", "A position in the flat frame has two coordinates.", |out| {
        change(out, "positionXYZ", json!([1, 2]));
    }),
    Bug::message("FW-UST-GPS", "A GPS fix is of a kind that there isn't.", |out| {
        change(out, "gps", json!([8, 12]));
    }),
    Bug::message("FW-UST-HEADING", "A heading is a full turn.", |out| change(out, "heading", json!(3600))),
    Bug::message("FW-UST-ATTITUDE", "A roll is half a turn to the right.", |out| {
        change(out, "attitude", json!([1800, 0, 0]));
    }),
    Bug::message("FW-UST-VELOCITY", "A velocity has fractions.", |out| {
        change(out, "velocity", json!([0.5, 0.5, 0.5]));
    }),
    Bug::message("FW-UST-VELOCITYXYZ", "A velocity in the flat frame is null.", |out| {
        change(out, "velocityXYZ", Value::Null);
    }),
    Bug::message("FW-UST-BATTERY", "A battery is charged to more than all.", |out| {
        change(out, "battery", json!([126, 101]));
    }),
    Bug::message("FW-UST-LIGHT", "A light has a colour of 24 bits.", |out| {
        change(out, "light", json!(0x00FF_8800));
    }),
    Bug::message("FW-UST-RSSI", "A signal is weaker than none.", |out| change(out, "rssi", json!([-60]))),
    Bug::message("FW-UST-ERRORS", "Error codes are a text.", |out| change(out, "errors", json!("none"))),
    Bug::message("FW-UST-DEBUG", "What is for debugging isn't in Base64.", |out| {
        change(out, "debug", json!("all is well!"));
    }),
    Bug::message("FW-ERR-01", "An error code is negative.", |out| change(out, "errors", json!([-1]))),
    Bug::message("FW-ERR-02", "The absence of errors is listed.", |out| change(out, "errors", json!([0]))),
    Bug::message("FW-ERR-03", "An error code is reserved.", |out| change(out, "errors", json!([300]))),
    Bug::message("FW-ERR-04", "An error code isn't registered.", |out| change(out, "errors", json!([50]))),
    Bug::message("FW-ERR-06", "An error code is listed twice.", |out| change(out, "errors", json!([64, 64]))),
    Bug::message("FW-ERR-07", "A battery is low in two ways.", |out| change(out, "errors", json!([66, 134]))),
    Bug::message("FW-ERR-08", "On the ground a UAV has left the fence in the air.", |out| {
        change(out, "errors", json!([1, 201]));
    }),
    Bug::message("FW-ERR-09", "A UAV stands on the ground and takes off.", |out| {
        change(out, "errors", json!([1, 5]));
    }),
    Bug::message("FW-ERR-10", "An error is simulated.", |out| change(out, "errors", json!([188]))),
];

/// Changes a field of the first UAV.
fn change(out: &mut Outgoing<'_>, field: &str, value: Value) {
    if let Some(state) = out.state() {
        state[field] = value;
    }
}

/// Changes the time stamp of the first UAV.
fn shift(out: &mut Outgoing<'_>, change: impl Fn(u64) -> u64) {
    let states = out.body_of("UAV-INF").and_then(|body| body.get_mut("status")?.as_object_mut());
    for state in states.into_iter().flat_map(|states| states.values_mut()) {
        state["timestamp"] = json!(change(state["timestamp"].as_u64().unwrap_or_default()));
    }
}
