//! Bugs in answers that say yes or no, in what the server says of itself, in lists, and in the smaller families.

use serde_json::{Value, json};

use super::{Bug, Outgoing};

/// Families whose responses say for each thing that was asked for how it is, or why that isn't known.
const INFORMATION: [&str; 7] =
    ["BCN-INF", "CLK-INF", "WTH-INF", "RTK-INF", "EXT-INF", "UAV-PREFLT", "DEV-INF"];

pub(super) const BUGS: &[Bug] = &[
    Bug::message("FW-ACK-01", "An acknowledgment that answers nothing follows each SYS-VER.", |out| {
        if out.kind() == "SYS-VER" {
            out.follow(None, json!({ "type": "ACK-ACK" }));
        }
    })
    .with(&["FW-ENV-17"]),
    Bug::message("FW-ACK-03", "ACK-ACK has a reason.", |out| {
        if let Some(body) = out.body_of("ACK-ACK") {
            body["reason"] = json!("why not");
        }
    }),
    Bug::message("FW-ACK-04", "The reason of ACK-NAK is an object.", |out| {
        if let Some(body) = out.body_of("ACK-NAK") {
            body["reason"] = json!({ "en": "no" });
        }
    }),
    Bug::behaviour("FW-ACK-06", "Requests are served without the login that they need (with --login)."),
    Bug::message("FW-SYS-PING-01", "SYS-PING is answered with ACK-NAK.", |out| {
        if out.asked() == Some("SYS-PING") {
            out.message()["body"] = json!({ "type": "ACK-NAK" });
        }
    }),
    Bug::message("FW-SYS-PING-02", "SYS-PING is answered with SYS-PING.", |out| {
        if out.asked() == Some("SYS-PING") {
            out.message()["body"] = json!({ "type": "SYS-PING" });
        }
    })
    .with(&["FW-SYS-PING-01", "FW-ENV-16"]),
    Bug::message("FW-SYS-VER-01", "The name of the software is a number.", |out| {
        set(out, "SYS-VER", "software", json!(7));
    }),
    Bug::message("FW-SYS-VER-02", "The version of the software is a word.", |out| {
        set(out, "SYS-VER", "version", json!("newest"));
    }),
    Bug::message("FW-SYS-VER-03", "The name of the server is a list.", |out| {
        set(out, "SYS-VER", "name", json!(["glider"]));
    }),
    Bug::message("FW-SYS-VER-04", "The revision of the software is another each time.", |out| {
        let revision = format!("revision {}", out.number);
        set(out, "SYS-VER", "revision", json!(revision));
    }),
    Bug::message("FW-SYS-TIME-01", "The time of the server is in seconds, with a fraction.", |out| {
        if let Some(body) = out.body_of("SYS-TIME") {
            #[expect(clippy::cast_precision_loss, reason = "it is a bug")]
            let seconds = body["timestamp"].as_u64().unwrap_or_default() as f64 / 1000.0 + 0.000_5;
            body["timestamp"] = json!(seconds);
        }
    }),
    Bug::message("FW-SYS-TIME-02", "The clock of the server stands still.", |out| {
        set(out, "SYS-TIME", "timestamp", json!(1_700_000_000_000_u64));
    })
    .with(&["FW-UAV-INF-09"]),
    Bug::behaviour("FW-SYS-TIME-03", "An adjustment of 0 puts the clock forward by an hour."),
    Bug::message("FW-SYS-PORTS-01", "Ports are texts.", |out| {
        for port in ports(out) {
            *port = json!(port.to_string());
        }
    }),
    Bug::message("FW-SYS-PORTS-02", "All ports are off by one.", |out| {
        for port in ports(out) {
            let number = port.as_u64().unwrap_or(1);
            *port = json!(if number == 1 { 2 } else { number - 1 });
        }
    }),
    Bug::message("FW-SYS-CLOSE-01", "The reason of SYS-CLOSE is a number.", |out| {
        set(out, "SYS-CLOSE", "reason", json!(7));
    }),
    Bug::message(
        "FW-SYS-CLOSE-02",
        "SYS-CLOSE comes after each SYS-VER, and the connection goes on.",
        |out| {
            if out.kind() == "SYS-VER" {
                out.follow(None, json!({ "type": "SYS-CLOSE" }));
            }
        },
    ),
    Bug::message("FW-SYS-MSG-01", "Items of SYS-MSG have no message.", |out| {
        if let Some(item) = item(out) {
            item.remove("message");
        }
    }),
    Bug::message("FW-SYS-MSG-02", "Items of SYS-MSG are of severity loud.", |out| {
        if let Some(item) = item(out) {
            item.insert("severity".to_owned(), json!("loud"));
        }
    }),
    Bug::message("FW-OBJ-LIST-01", "The last id in OBJ-LIST is a number.", |out| number(out, "OBJ-LIST")),
    Bug::message("FW-OBJ-LIST-01J", "OBJ-LIST has its first id twice.", |out| repeat(out, "OBJ-LIST")),
    Bug::behaviour("FW-OBJ-LIST-02", "OBJ-LIST doesn't heed its filter.")
        .with(&["FW-OBJ-LIST-03", "FW-UAV-LIST-02"]),
    Bug::behaviour("FW-OBJ-LIST-03", "OBJ-LIST refuses types that the server doesn't know."),
    Bug::behaviour("FW-OBJ-LIST-04", "OBJ-LIST without a filter has UAVs only."),
    Bug::message("FW-OBJ-DEL-01", "OBJ-DEL has its ids as a text.", |out| {
        if let Some(body) = out.body_of("OBJ-DEL") {
            body["ids"] = body["ids"][0].take();
        }
    }),
    Bug::behaviour("FW-OBJ-DEL-02", "Objects that are gone stay in the lists."),
    Bug::message("FW-UAV-LIST-01", "The last id in UAV-LIST is a number.", |out| number(out, "UAV-LIST")),
    Bug::message("FW-UAV-LIST-01J", "UAV-LIST has its first id twice.", |out| repeat(out, "UAV-LIST")),
    Bug::message("FW-UAV-LIST-02", "UAV-LIST lacks its last UAV.", |out| {
        if let Some(ids) = out.body_of("UAV-LIST").and_then(|body| body["ids"].as_array_mut()) {
            ids.pop();
        }
    }),
    Bug::message("FW-UAV-LIST-03", "Lists have a UAV that UAV-INF doesn't know.", |out| {
        let has_uavs = match out.kind() {
            "UAV-LIST" => true,
            "OBJ-LIST" => {
                let filter = out.request.and_then(|body| body.get("filter")).and_then(Value::as_array);
                filter.is_none_or(|kinds| kinds.contains(&json!("uav")))
            }
            _ => false,
        };
        if has_uavs && let Some(ids) = out.message()["body"]["ids"].as_array_mut() {
            ids.push(json!("wraith-1"));
        }
    }),
    Bug::message("FW-AUTH-01", "A failed login has a user.", |out| {
        if let Some(body) = out.body_of("AUTH-RESP") {
            body["result"] = json!(false);
            body["user"] = json!("nobody");
        }
    }),
    Bug::message("FW-CONN-INF-01", "The last connection that was asked for is missing.", |out| {
        out.lose_last(&["CONN-INF"]);
    }),
    Bug::message("FW-CONN-INF-02", "Connections have other ids than their keys.", |out| {
        each_status(out, "CONN-INF", |status| status["id"] = json!("radio-7"));
    }),
    Bug::message("FW-CONN-INF-03", "The purpose of connections is a number.", |out| {
        each_status(out, "CONN-INF", |status| status["purpose"] = json!(1));
    }),
    Bug::message(
        "FW-INF-01",
        "The last thing that was asked for is missing, in BCN-INF and the like.",
        |out| {
            out.lose_last(&INFORMATION[..6]);
        },
    ),
    Bug::message("FW-DEV-01", "The last object or path that was asked for is missing.", |out| {
        out.lose_last(&["DEV-LIST", "DEV-INF"]);
    })
    .with(&["FW-INF-01"]),
    Bug::message("FW-PRM-01", "PRM-SET-MANY succeeds, and has failed.", |out| {
        let Some(body) = out.body_of("PRM-SET-MANY") else { return };
        for outcome in body["result"].as_object_mut().into_iter().flat_map(|map| map.values_mut()) {
            *outcome = json!({ "success": true, "failed": ["CRUISE_SPEED"] });
        }
    }),
    Bug::message("FW-WTH-01", "The time of the weather is a text.", |out| {
        each_status(out, "WTH-INF", |status| status["timestamp"] = json!("noon"));
        if let Some(body) = out.body_of("WTH-AT") {
            body["weather"]["timestamp"] = json!("noon");
        }
    }),
];

fn set(out: &mut Outgoing<'_>, kind: &str, field: &str, value: Value) {
    if let Some(body) = out.body_of(kind) {
        body[field] = value;
    }
}

fn ports<'o>(out: &'o mut Outgoing<'_>) -> impl Iterator<Item = &'o mut Value> {
    let ports = out.body_of("SYS-PORTS").and_then(|body| body["ports"].as_object_mut());
    ports.into_iter().flat_map(|ports| ports.values_mut())
}

fn item<'o>(out: &'o mut Outgoing<'_>) -> Option<&'o mut serde_json::Map<String, Value>> {
    out.body_of("SYS-MSG")?["items"][0].as_object_mut()
}

fn number(out: &mut Outgoing<'_>, kind: &str) {
    let ids = out.body_of(kind).and_then(|body| body["ids"].as_array_mut());
    if let Some(last) = ids.and_then(|ids| ids.last_mut()) {
        *last = json!(7);
    }
}

fn repeat(out: &mut Outgoing<'_>, kind: &str) {
    if let Some(ids) = out.body_of(kind).and_then(|body| body["ids"].as_array_mut()) {
        ids.extend_from_within(..1.min(ids.len()));
    }
}

fn each_status(out: &mut Outgoing<'_>, kind: &str, change: fn(&mut Value)) {
    let status = out.body_of(kind).and_then(|body| body["status"].as_object_mut());
    status.into_iter().flat_map(|status| status.values_mut()).for_each(change);
}
