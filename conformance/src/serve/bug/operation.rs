//! Bugs in operations that go on after the response.

use serde_json::{Value, json};

use super::{Bug, Outgoing, progress};
use crate::flockwave::session::OPERATIONS;

pub(super) const BUGS: &[Bug] = &[
    Bug::message("FW-ASY-01", "LOG-DATA has a receipt and an error.", |out| {
        if let Some(body) = out.body_of("LOG-DATA")
            && body.get("receipt").is_some()
        {
            body["error"] = json!("the log is late");
        }
    }),
    Bug::message("FW-ASY-02", "The last object that was asked for is missing.", |out| {
        out.lose_last(&OPERATIONS);
    })
    .with(&["FW-ASY-09"]),
    Bug::message("FW-ASY-03", "There is an object that nobody asked for.", |out| {
        if OPERATIONS.contains(&out.kind()) {
            out.message()["body"]["error"]["ghost-1"] = json!("there is no such object");
        }
    }),
    Bug::behaviour("FW-ASY-04", "Receipts are 70 characters long.").with(&["FW-ENV-18"]),
    Bug::behaviour("FW-ASY-04I", "All operations have the same receipt.").with(&["FW-ASY-10", "FW-ASY-22"]),
    Bug::message("FW-ASY-06", "Progress comes before the response with the receipt.", |out| {
        if let Some(receipt) = receipt(out) {
            out.precede(progress(&receipt));
        }
    })
    .with(&["FW-ASY-09"]),
    Bug::message("FW-ASY-07", "ASYNC-RESP has a result and an error.", |out| {
        if let Some(body) = out.body_of("ASYNC-RESP") {
            body["result"] = json!(true);
            body["error"] = json!("and yet");
        }
    }),
    Bug::message("FW-ASY-08", "The error of ASYNC-RESP is a number.", |out| {
        if let Some(body) = out.body_of("ASYNC-RESP").and_then(Value::as_object_mut) {
            body.remove("result");
            body.insert("error".to_owned(), json!(7));
        }
    }),
    Bug::message("FW-ASY-09", "Progress of an operation comes that nobody knows.", |out| {
        if receipt(out).is_some() {
            out.follow(None, progress(&json!("nobody-has-this")));
        }
    }),
    Bug::message("FW-ASY-10", "Nothing is heard of the end of operations.", |out| {
        if out.kind() == "ASYNC-RESP" {
            out.message = None;
        }
    })
    .with(&["FW-ASY-17"]),
    Bug::message("FW-ASY-11", "Progress comes after the end.", |out| {
        if let Some(body) = out.body_of("ASYNC-RESP") {
            let receipt = body["id"].clone();
            out.follow(None, progress(&receipt));
        }
    }),
    Bug::message("FW-ASY-12", "More than all is done.", |out| {
        if let Some(body) = out.body_of("ASYNC-ST") {
            body["progress"]["percentage"] = json!(140);
        }
    }),
    Bug::message("FW-ASY-13", "Nobody is told that an operation is suspended.", |out| {
        if let Some(body) = out.body_of("ASYNC-ST").and_then(Value::as_object_mut) {
            body.remove("suspended");
        }
    }),
    Bug::behaviour("FW-ASY-14", "Suspended operations go on by themselves."),
    Bug::message("FW-ASY-16", "Receipts that were cancelled or resumed are also errors.", |out| {
        if !["ASYNC-CANCEL", "ASYNC-RESUME"].contains(&out.kind()) {
            return;
        }
        let body = &mut out.message()["body"];
        if let Some(receipt) = body["success"][0].as_str().map(str::to_owned) {
            body["error"][receipt] = json!("and yet");
        }
    }),
    Bug::behaviour("FW-ASY-17", "Operations that were cancelled go on."),
    Bug::behaviour("FW-ASY-18", "Operations that nobody knows can be cancelled."),
    Bug::behaviour("FW-ASY-19", "Operations that aren't suspended can be resumed."),
    Bug::message("FW-ASY-20", "ASYNC-TIMEOUT has its receipt as a text.", |out| {
        if let Some(body) = out.body_of("ASYNC-TIMEOUT") {
            body["ids"] = body["ids"][0].take();
        }
    }),
    Bug::message("FW-ASY-20J", "ASYNC-TIMEOUT has its receipt twice.", |out| {
        if let Some(ids) = out.body_of("ASYNC-TIMEOUT").and_then(|body| body["ids"].as_array_mut()) {
            ids.extend_from_within(..1);
        }
    }),
    Bug::message("FW-ASY-22", "Results that are booleans are texts.", |out| {
        let is_command = out.kind().starts_with("UAV-") || out.kind() == "ASYNC-RESP";
        let Some(result) = out.message()["body"].get_mut("result").filter(|_| is_command) else { return };
        let values: Vec<&mut Value> = match result {
            Value::Object(values) => values.values_mut().collect(),
            value => vec![value],
        };
        for value in values.into_iter().filter(|value| value.is_boolean()) {
            *value = json!("yes");
        }
    }),
];

/// The first receipt of a response.
fn receipt(out: &mut Outgoing<'_>) -> Option<Value> {
    match out.message()["body"].get("receipt")? {
        Value::Object(receipts) => receipts.values().next().cloned(),
        Value::String(receipt) => Some(json!(receipt)),
        _ => None,
    }
}
