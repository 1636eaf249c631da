//! HTTP one-shot requests: the body of a POST is a request, and the body of the HTTP response contains the answer.
//!
//! The specification doesn't define this transport. The path is the same as in the protocol's reference server, which
//! also waits for operations before it answers. The reference server always answers without an envelope. This server
//! adds an envelope if the request has one, so that rules on envelopes can be tested over HTTP as well.

use std::collections::BTreeMap;
use std::rc::Rc;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use uavspec_flockwave::transport::http::{Request, Response};
use uavspec_types::flockwave::json as flockwave;

use super::Shared;
use super::limits::Share;
use super::outbox::Outbox;
use super::web::Pending;
use crate::hub::{ConnectionKind, SessionId};
use crate::message::{envelope, value};
use crate::request::Incoming;

/// The maximum time to wait for operations.
const OPERATION_TIMEOUT: Duration = Duration::from_secs(20);

/// The memory that an answer takes as parsed JSON, as a multiple of the length of its text.
const PARSED_SIZE: usize = 8;

/// The id of requests without an envelope.
const DEFAULT_ID: &str = "http";

/// A request whose operations may continue.
pub(super) struct Exchange {
    session: SessionId,
    queue: Rc<Outbox>,
    message: Value,
    /// The text of the message. `None` if an operation changed the message.
    written: Option<String>,
    /// The receipts of operations that continue, each with the id of its UAV if the answer has several receipts.
    pending: BTreeMap<String, Option<String>>,
    /// The memory of the answer.
    _share: Share,
    until: Instant,
    has_envelope: bool,
    is_open: bool,
}

/// Starts the exchange for a request.
pub(super) fn exchange(shared: &mut Shared, request: &Request) -> Result<Exchange, Response> {
    let kind =
        request.header("content-type").and_then(|kind| kind.split(';').next()).unwrap_or_default().trim();
    if !kind.eq_ignore_ascii_case("application/json") {
        let reason = "the Content-Type must be application/json";
        return Err(Response::refusal("415 Unsupported Media Type", reason));
    }
    let message: Value = serde_json::from_slice(&request.body)
        .map_err(|error| bad(format!("the body is not valid JSON: {error}")))?;
    let queue = Rc::new(shared.outbox(None));
    let session = shared.hub.open(ConnectionKind::OneShot, Rc::<Outbox>::clone(&queue));
    let exchange = start(shared, request, session, queue, message);
    if exchange.is_err() {
        shared.hub.close(session);
    }
    exchange
}

fn bad(reason: impl Into<String>) -> Response {
    Response::refusal("400 Bad Request", reason)
}

fn start(
    shared: &mut Shared,
    request: &Request,
    session: SessionId,
    queue: Rc<Outbox>,
    message: Value,
) -> Result<Exchange, Response> {
    let credentials = request.header("authorization");
    if credentials.is_some_and(|credentials| !is_logged_in(shared, session, &queue, credentials)) {
        return Err(Response::refusal("403 Forbidden", "wrong name or password"));
    }
    let has_envelope = message.get("body").is_some() || message.get("$fw.version").is_some();
    let message = if has_envelope { message } else { envelope(DEFAULT_ID, None, message) };
    let incoming = Incoming::from_value(message);
    if incoming == Incoming::Ignored {
        return Err(bad("the body must be an object whose id is a string"));
    }
    shared.hub.take(session, incoming);
    let (written, message) =
        next(&queue).ok_or_else(|| Response::refusal("500 Internal Server Error", "no answer"))?;
    let (pending, share) = (receipts(&message), Share::new(&shared.queued));
    if !pending.is_empty() {
        share.set(written.len() * PARSED_SIZE);
    }
    if share.is_exceeded() {
        let reason = "too many requests are waiting for operations";
        return Err(Response::refusal("503 Service Unavailable", reason));
    }
    Ok(Exchange {
        session,
        queue,
        message,
        written: Some(written),
        pending,
        _share: share,
        until: shared.now() + OPERATION_TIMEOUT,
        has_envelope,
        is_open: shared.hub.options.login.is_none() || credentials.is_some(),
    })
}

fn is_logged_in(shared: &mut Shared, session: SessionId, queue: &Outbox, credentials: &str) -> bool {
    let Some(data) = credentials.strip_prefix("Basic ") else { return false };
    let request = flockwave::Request::from(flockwave::auth_req::Request {
        method: flockwave::AuthenticationMethod::Basic,
        data: data.trim().to_owned(),
        session: None,
    });
    shared.hub.take(session, Incoming::from_value(envelope("login", None, value(&request))));
    next(queue).is_some_and(|(_, answer)| answer["body"]["result"] == json!(true))
}

/// The next message from the hub, as text and as parsed JSON.
fn next(queue: &Outbox) -> Option<(String, Value)> {
    let written = String::from_utf8(queue.take()?).ok()?;
    let message = serde_json::from_str(&written).unwrap_or(Value::Null);
    Some((written, message))
}

/// The receipts in an answer, each with the id of its UAV if the answer has several receipts.
fn receipts(answer: &Value) -> BTreeMap<String, Option<String>> {
    match answer["body"].get("receipt") {
        Some(Value::String(receipt)) => BTreeMap::from([(receipt.clone(), None)]),
        Some(Value::Object(receipts)) => {
            let text = |receipt: &Value| receipt.as_str().unwrap_or_default().to_owned();
            receipts.iter().map(|(id, receipt)| (text(receipt), Some(id.clone()))).collect()
        }
        _ => BTreeMap::new(),
    }
}

impl Pending for Exchange {
    /// Returns the response if all operations have ended. Their results become part of the answer, as if they had been
    /// available immediately.
    fn response(&mut self, shared: &mut Shared) -> Option<Response> {
        while !self.pending.is_empty() {
            match next(&self.queue) {
                Some((_, notification)) => self.take(&notification["body"]),
                None if self.queue.is_closed() || shared.now() >= self.until => {
                    for receipt in self.pending.clone().into_keys() {
                        self.settle(&receipt, "error", json!("timeout"));
                    }
                }
                None => return None,
            }
        }
        let body = &self.message["body"];
        let written = if self.has_envelope { self.written.take() } else { Some(body.to_string()) };
        let text = written.unwrap_or_else(|| self.message.to_string());
        if self.is_open || body["type"] != "ACK-NAK" {
            return Some(Response::new("200 OK", "application/json", text));
        }
        let response = Response::new("401 Unauthorized", "application/json", text);
        Some(response.with("WWW-Authenticate", "Basic"))
    }

    fn end(&mut self, shared: &mut Shared) {
        shared.hub.close(self.session);
    }
}

impl Exchange {
    /// Processes a notification.
    fn take(&mut self, notification: &Value) {
        let receipt = notification["id"].as_str().unwrap_or_default();
        match notification["type"].as_str().unwrap_or_default() {
            "ASYNC-RESP" => {
                let name = if notification.get("result").is_some() { "result" } else { "error" };
                self.settle(receipt, name, notification[name].clone());
            }
            "ASYNC-ST" if notification["suspended"] == json!(true) => {
                let reason = "the operation is waiting for the client; connect over TCP to resume it";
                self.settle(receipt, "error", json!(reason));
            }
            "ASYNC-TIMEOUT" => {
                for receipt in notification["ids"].as_array().into_iter().flatten().filter_map(Value::as_str)
                {
                    self.settle(receipt, "error", json!("the UAV doesn't respond"));
                }
            }
            _ => {}
        }
    }

    /// Adds the result of an operation to the answer.
    fn settle(&mut self, receipt: &str, name: &str, value: Value) {
        let body = &mut self.message["body"];
        match self.pending.remove(receipt) {
            Some(Some(id)) => body[name][id] = value,
            Some(None) => body[name] = value,
            None => return,
        }
        self.written = None;
        if self.pending.is_empty()
            && let Some(body) = body.as_object_mut()
        {
            body.remove("receipt");
        }
    }
}
