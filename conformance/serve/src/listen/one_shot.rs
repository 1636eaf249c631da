//! HTTP one-shot requests: the body of a POST is a request, and the body of the HTTP response contains the answer.
//!
//! The specification doesn't define this transport. The path is that of the protocol's reference server, which also
//! waits for operations before it answers. The reference server always answers without an envelope. This server adds an
//! envelope if the request has one, so that rules on envelopes can be tested over HTTP as well.

use std::collections::BTreeMap;
use std::rc::Rc;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use uavspec_flockwave::transport::http::{Request, Response};
use uavspec_model::clock::Clock;
use uavspec_types::flockwave::json as flockwave;

use super::Shared;
use super::limits::Share;
use super::outbox::{Taken, TextQueue};
use super::reply::{Pending, Reply};
use crate::hub::{ConnectionKind, SessionId, Sink};
use crate::message::{envelope, value};
use crate::request::Incoming;

/// The maximum time to wait for operations.
const OPERATION_TIMEOUT: Duration = Duration::from_secs(20);

/// The memory of an answer as text and as parsed JSON, in multiples of its length.
const PARSED_SIZE: usize = 8;

/// The id of requests without an envelope.
const DEFAULT_ID: &str = "http";

struct QueueSink(Rc<TextQueue>);

impl Sink for QueueSink {
    fn send(&self, text: &str) {
        self.0.push(text.to_owned());
    }

    fn close(&self) {
        self.0.close();
    }
}

/// Handles a request.
pub(super) fn answer(shared: &mut Shared, request: &Request) -> Reply {
    let kind =
        request.header("content-type").and_then(|kind| kind.split(';').next()).unwrap_or_default().trim();
    if !kind.eq_ignore_ascii_case("application/json") {
        return refused("415 Unsupported Media Type", "the Content-Type must be application/json");
    }
    let message: Value = match serde_json::from_slice(&request.body) {
        Ok(message) => message,
        Err(error) => return refused("400 Bad Request", format!("the body is not valid JSON: {error}")),
    };
    let has_envelope = message.get("body").is_some() || message.get("$fw.version").is_some();
    let message = if has_envelope { message } else { envelope(DEFAULT_ID, None, message) };
    let queue = Rc::new(TextQueue::new(&shared.queued));
    let session = shared.hub.open(ConnectionKind::OneShot, Rc::new(QueueSink(Rc::clone(&queue))));
    match exchange(shared, request, session, &queue, message, has_envelope) {
        Ok(exchange) => Reply::Later(Box::new(exchange)),
        Err(refusal) => {
            shared.hub.close(session);
            refusal
        }
    }
}

fn refused(status: &'static str, reason: impl Into<String>) -> Reply {
    Reply::Now(Response::refusal(status, reason))
}

fn exchange(
    shared: &mut Shared,
    request: &Request,
    session: SessionId,
    queue: &Rc<TextQueue>,
    message: Value,
    has_envelope: bool,
) -> Result<Exchange, Reply> {
    if let Some(credentials) = request.header("authorization")
        && !is_logged_in(shared, session, queue, credentials)
    {
        return Err(refused("403 Forbidden", "wrong name or password"));
    }
    let incoming = Incoming::from_value(message);
    if incoming == Incoming::Ignored {
        return Err(refused("400 Bad Request", "the body must be an object whose id is a string"));
    }
    let is_open = shared.hub.options.login.is_none() || request.header("authorization").is_some();
    shared.hub.take(session, incoming);
    let answer = next(queue).ok_or_else(|| refused("500 Internal Server Error", "no answer"))?;
    let (pending, share) = (receipts(&answer), Share::new(&shared.queued));
    if !pending.is_empty() && share.set(answer.written.len() * PARSED_SIZE).is_err() {
        return Err(refused("503 Service Unavailable", "too many requests are waiting for operations"));
    }
    Ok(Exchange {
        session,
        queue: Rc::clone(queue),
        pending,
        answer,
        _share: share,
        until: shared.now() + OPERATION_TIMEOUT,
        clock: shared.clock.clone(),
        has_envelope,
        is_open,
    })
}

fn is_logged_in(shared: &mut Shared, session: SessionId, queue: &TextQueue, credentials: &str) -> bool {
    let Some(data) = credentials.strip_prefix("Basic ") else { return false };
    let request = flockwave::Request::from(flockwave::auth_req::Request {
        method: flockwave::AuthenticationMethod::Basic,
        data: data.trim().to_owned(),
        session: None,
    });
    shared.hub.take(session, Incoming::from_value(envelope("login", None, value(&request))));
    next(queue).is_some_and(|answer| answer.message["body"]["result"] == json!(true))
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

fn next(queue: &TextQueue) -> Option<ParsedAnswer> {
    let Taken::Texts(texts) = queue.take(1) else { return None };
    let written = texts.into_iter().next()?;
    let message = serde_json::from_str(&written).unwrap_or(Value::Null);
    Some(ParsedAnswer { written, message, has_changed: false })
}

/// The receipts in an answer, each with the id of its UAV if the answer has several receipts.
fn receipts(answer: &ParsedAnswer) -> BTreeMap<String, Option<String>> {
    match answer.message["body"].get("receipt") {
        Some(Value::String(receipt)) => BTreeMap::from([(receipt.clone(), None)]),
        Some(Value::Object(receipts)) => {
            let text = |receipt: &Value| receipt.as_str().unwrap_or_default().to_owned();
            receipts.iter().map(|(id, receipt)| (text(receipt), Some(id.clone()))).collect()
        }
        _ => BTreeMap::new(),
    }
}

/// A request whose operations may continue.
struct Exchange {
    session: SessionId,
    queue: Rc<TextQueue>,
    answer: ParsedAnswer,
    /// The receipts of operations that continue.
    pending: BTreeMap<String, Option<String>>,
    /// The memory of the answer.
    _share: Share,
    clock: Clock,
    until: Instant,
    has_envelope: bool,
    is_open: bool,
}

impl Pending for Exchange {
    /// Returns the response if all operations have ended. Their results become part of the answer, as if they had been
    /// available immediately.
    fn response(&mut self, shared: &mut Shared) -> Option<Response> {
        while !self.pending.is_empty() {
            match next(&self.queue) {
                Some(notification) => self.take(&notification.message["body"]),
                None if self.queue.is_closed() || self.is_over() => {
                    for receipt in self.pending.clone().into_keys() {
                        self.settle(&receipt, "error", json!("timeout"));
                    }
                }
                None => return None,
            }
        }
        shared.hub.close(self.session);
        let text =
            if self.has_envelope { self.answer.text() } else { self.answer.message["body"].to_string() };
        if self.is_open || self.answer.message["body"]["type"] != "ACK-NAK" {
            return Some(Response::new("200 OK", "application/json", text));
        }
        let response = Response::new("401 Unauthorized", "application/json", text);
        Some(response.with("WWW-Authenticate", "Basic"))
    }

    fn is_due(&self) -> bool {
        self.queue.is_ready() || self.is_over()
    }

    fn end(&mut self, shared: &mut Shared) {
        shared.hub.close(self.session);
    }
}

impl Exchange {
    fn is_over(&self) -> bool {
        self.clock.now() >= self.until
    }

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
        let body = &mut self.answer.message["body"];
        match self.pending.remove(receipt) {
            Some(Some(id)) => body[name][id] = value,
            Some(None) => body[name] = value,
            None => return,
        }
        self.answer.has_changed = true;
        if self.pending.is_empty()
            && let Some(body) = body.as_object_mut()
        {
            body.remove("receipt");
        }
    }
}
