//! HTTP one-shot requests: the body of a POST is a request, and the body of the HTTP response contains the answer.
//!
//! The specification doesn't define this transport. The path is that of the protocol's reference server, which also
//! waits for operations before it answers. The reference server always answers without an envelope. This server adds an
//! envelope if the request has one, so that rules on envelopes can be tested over HTTP as well.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use uavspec::flockwave::json as flockwave;

use super::Shared;
use crate::flockwave::transport::http::{Request, Response};
use crate::serve::hub::{ConnectionKind, SessionId, Sink};
use crate::serve::message::{envelope, value};
use crate::serve::outbox::{Outbox, Taken};
use crate::serve::request::Incoming;

/// The maximum time to wait for operations.
const OPERATION_TIMEOUT: Duration = Duration::from_secs(20);

/// The id of requests without an envelope.
const DEFAULT_ID: &str = "http";

struct BoxSink(Arc<Outbox>);

impl Sink for BoxSink {
    fn send(&self, text: &str) {
        self.0.push(text.to_owned());
    }

    fn close(&self) {
        self.0.close();
    }
}

/// Answers a request.
pub(super) fn answer(shared: &Shared, request: &Request) -> Response {
    let kind =
        request.header("content-type").and_then(|kind| kind.split(';').next()).unwrap_or_default().trim();
    if !kind.eq_ignore_ascii_case("application/json") {
        return Response::refusal("415 Unsupported Media Type", "the Content-Type must be application/json");
    }
    let message: Value = match serde_json::from_slice(&request.body) {
        Ok(message) => message,
        Err(error) => {
            return Response::refusal("400 Bad Request", format!("the body is not valid JSON: {error}"));
        }
    };
    let has_envelope = message.get("body").is_some() || message.get("$fw.version").is_some();
    let message = if has_envelope { message } else { envelope(DEFAULT_ID, None, message) };
    let outbox = Arc::new(Outbox::default());
    let session = shared.open(ConnectionKind::OneShot, Arc::new(BoxSink(Arc::clone(&outbox))));
    let response = exchange(shared, request, session, &outbox, message, has_envelope);
    shared.close(session);
    response
}

fn exchange(
    shared: &Shared,
    request: &Request,
    session: SessionId,
    outbox: &Outbox,
    message: Value,
    has_envelope: bool,
) -> Response {
    if let Some(credentials) = request.header("authorization")
        && !is_logged_in(shared, session, outbox, credentials)
    {
        return Response::refusal("403 Forbidden", "wrong name or password");
    }
    let incoming = Incoming::from_value(message);
    if incoming == Incoming::Ignored {
        return Response::refusal("400 Bad Request", "the body must be an object whose id is a string");
    }
    let is_open = shared.hub().options.login.is_none() || request.header("authorization").is_some();
    shared.hub().take(session, incoming);
    let Some(mut answer) = next(outbox, Instant::now()) else {
        return Response::refusal("500 Internal Server Error", "no answer");
    };
    await_operations(outbox, &mut answer);
    let text = if has_envelope { answer.text() } else { answer.message["body"].to_string() };
    if is_open || answer.message["body"]["type"] != "ACK-NAK" {
        return Response::new("200 OK", "application/json", text);
    }
    Response::new("401 Unauthorized", "application/json", text).with("WWW-Authenticate", "Basic")
}

fn is_logged_in(shared: &Shared, session: SessionId, outbox: &Outbox, credentials: &str) -> bool {
    let Some(data) = credentials.strip_prefix("Basic ") else { return false };
    let request = flockwave::Request::from(flockwave::auth_req::Request {
        method: flockwave::AuthenticationMethod::Basic,
        data: data.trim().to_owned(),
        session: None,
    });
    shared.hub().take(session, Incoming::from_value(envelope("login", None, value(&request))));
    next(outbox, Instant::now()).is_some_and(|answer| answer.message["body"]["result"] == json!(true))
}

/// An answer, as text and as parsed JSON.
struct ParsedAnswer {
    written: String,
    message: Value,
    has_changed: bool,
}

impl ParsedAnswer {
    /// The text. It stays unchanged unless an operation changed the answer.
    fn text(&self) -> String {
        if self.has_changed { self.message.to_string() } else { self.written.clone() }
    }
}

fn next(outbox: &Outbox, until: Instant) -> Option<ParsedAnswer> {
    let Taken::Texts(texts) = outbox.take(1, until) else { return None };
    let written = texts.into_iter().next()?;
    let message = serde_json::from_str(&written).unwrap_or(Value::Null);
    Some(ParsedAnswer { written, message, has_changed: false })
}

/// Waits for operations, and adds their results to the answer as if the results had been available immediately.
fn await_operations(outbox: &Outbox, answer: &mut ParsedAnswer) {
    let mut pending: BTreeMap<String, Option<String>> = match answer.message["body"].get("receipt") {
        Some(Value::String(receipt)) => BTreeMap::from([(receipt.clone(), None)]),
        Some(Value::Object(receipts)) => {
            let text = |receipt: &Value| receipt.as_str().unwrap_or_default().to_owned();
            receipts.iter().map(|(id, receipt)| (text(receipt), Some(id.clone()))).collect()
        }
        _ => return,
    };
    let until = Instant::now() + OPERATION_TIMEOUT;
    let body = &mut answer.message["body"];
    let mut settle = |pending: &mut BTreeMap<String, Option<String>>,
                      receipt: &str,
                      name: &str,
                      value: Value| match pending.remove(receipt) {
        Some(Some(id)) => body[name][id] = value,
        Some(None) => body[name] = value,
        None => {}
    };
    while !pending.is_empty() {
        let Some(notification) = next(outbox, until) else { break };
        let notification = &notification.message["body"];
        let receipt = notification["id"].as_str().unwrap_or_default();
        match notification["type"].as_str().unwrap_or_default() {
            "ASYNC-RESP" => {
                let name = if notification.get("result").is_some() { "result" } else { "error" };
                settle(&mut pending, receipt, name, notification[name].clone());
            }
            "ASYNC-ST" if notification["suspended"] == json!(true) => {
                settle(
                    &mut pending,
                    receipt,
                    "error",
                    json!("the operation is waiting for the client; connect over TCP to resume it"),
                );
            }
            "ASYNC-TIMEOUT" => {
                for receipt in notification["ids"].as_array().into_iter().flatten().filter_map(Value::as_str)
                {
                    settle(&mut pending, receipt, "error", json!("the UAV doesn't respond"));
                }
            }
            _ => {}
        }
    }
    for receipt in pending.clone().into_keys() {
        settle(&mut pending, &receipt, "error", json!("timeout"));
    }
    if let Some(body) = answer.message["body"].as_object_mut() {
        body.remove("receipt");
    }
    answer.has_changed = true;
}
