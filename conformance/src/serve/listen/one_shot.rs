//! HTTP one-shots: a POST is a request, its response the answer.
//!
//! The specification doesn't know this transport; the path, and that operations are waited for, are as in the
//! protocol's reference server. There, the answer is always a body without its envelope. Here it has one where the
//! request had one, so that rules on envelopes can be tried over this transport, too.

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

/// How long operations are waited for.
const OPERATION_TIMEOUT: Duration = Duration::from_secs(20);

/// The id of requests that came without an envelope.
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
        Err(error) => return Response::refusal("400 Bad Request", format!("the body is no JSON: {error}")),
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
        return Response::refusal("403 Forbidden", "these aren't the name and password");
    }
    let incoming = Incoming::from_value(message);
    if incoming == Incoming::Ignored {
        return Response::refusal(
            "400 Bad Request",
            "the body is no request: an object with a text as its id",
        );
    }
    let is_open = shared.hub().options.login.is_none() || request.header("authorization").is_some();
    shared.hub().take(session, incoming);
    let Some(mut answer) = next(outbox, Instant::now()) else {
        return Response::refusal("500 Internal Server Error", "there is no answer");
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

/// An answer, as it was written and as it is read.
struct Answered {
    written: String,
    message: Value,
    has_changed: bool,
}

impl Answered {
    /// The answer as it was written, as far as nothing came later.
    fn text(&self) -> String {
        if self.has_changed { self.message.to_string() } else { self.written.clone() }
    }
}

fn next(outbox: &Outbox, until: Instant) -> Option<Answered> {
    let Taken::Texts(texts) = outbox.take(1, until) else { return None };
    let written = texts.into_iter().next()?;
    let message = serde_json::from_str(&written).unwrap_or(Value::Null);
    Some(Answered { written, message, has_changed: false })
}

/// Waits for operations, and puts what came of them where it would stand if it had come at once.
fn await_operations(outbox: &Outbox, answer: &mut Answered) {
    let mut open: BTreeMap<String, Option<String>> = match answer.message["body"].get("receipt") {
        Some(Value::String(receipt)) => BTreeMap::from([(receipt.clone(), None)]),
        Some(Value::Object(receipts)) => {
            let text = |receipt: &Value| receipt.as_str().unwrap_or_default().to_owned();
            receipts.iter().map(|(id, receipt)| (text(receipt), Some(id.clone()))).collect()
        }
        _ => return,
    };
    let until = Instant::now() + OPERATION_TIMEOUT;
    let body = &mut answer.message["body"];
    let mut settle = |open: &mut BTreeMap<String, Option<String>>,
                      receipt: &str,
                      name: &str,
                      value: Value| match open.remove(receipt) {
        Some(Some(id)) => body[name][id] = value,
        Some(None) => body[name] = value,
        None => {}
    };
    while !open.is_empty() {
        let Some(news) = next(outbox, until) else { break };
        let news = &news.message["body"];
        let receipt = news["id"].as_str().unwrap_or_default();
        match news["type"].as_str().unwrap_or_default() {
            "ASYNC-RESP" => {
                let name = if news.get("result").is_some() { "result" } else { "error" };
                settle(&mut open, receipt, name, news[name].clone());
            }
            "ASYNC-ST" if news["suspended"] == json!(true) => {
                settle(
                    &mut open,
                    receipt,
                    "error",
                    json!("it waits for the client, which has to be connected"),
                );
            }
            "ASYNC-TIMEOUT" => {
                for receipt in news["ids"].as_array().into_iter().flatten().filter_map(Value::as_str) {
                    settle(&mut open, receipt, "error", json!("nothing was heard of it"));
                }
            }
            _ => {}
        }
    }
    for receipt in open.clone().into_keys() {
        settle(&mut open, &receipt, "error", json!("it takes too long"));
    }
    if let Some(body) = answer.message["body"].as_object_mut() {
        body.remove("receipt");
    }
    answer.has_changed = true;
}
