//! HTTP: dispatches requests by path, and adds CORS headers for browsers.

use std::rc::Rc;

use uavspec_flockwave::transport::http::{Incoming, Request, Requests, Response};
use uavspec_flockwave::transport::{ONE_SHOT_PATH, SOCKET_IO_PATH};

use super::connection::{Protocol, Step};
use super::limits::{REQUEST_LIMIT, Reason};
use super::outbox::Outbox;
use super::{Shared, engine, one_shot};

/// The reply to a request.
pub(super) enum Reply {
    /// The response.
    Now(Response),
    /// The response follows later.
    Later(Box<dyn Pending>),
}

/// A request that waits for its response.
pub(super) trait Pending {
    /// The response, if it is available.
    fn response(&mut self, shared: &mut Shared) -> Option<Response>;

    /// Ends the request after its response, or because its client has disconnected.
    fn end(&mut self, shared: &mut Shared);
}

/// An HTTP client. One-shot requests and Socket.IO share a port, as clients expect.
pub(super) struct WebClient {
    requests: Requests,
    /// The request that hasn't been answered yet.
    pending: Option<(Request, Box<dyn Pending>)>,
}

impl WebClient {
    pub(super) fn new() -> Self {
        Self { requests: Requests::new(REQUEST_LIMIT), pending: None }
    }

    /// Sends the response to a request, if it is available.
    fn answer(&mut self, shared: &mut Shared, outbox: &Rc<Outbox>, request: Request, reply: Reply) -> Step {
        let response = match reply {
            Reply::Now(response) => response,
            Reply::Later(mut pending) => {
                let Some(response) = pending.response(shared) else {
                    self.pending = Some((request, pending));
                    return Step::Waiting;
                };
                pending.end(shared);
                response
            }
        };
        let is_request = response.is_success();
        outbox.push(with_cors_headers(&request, response).to_bytes(Some(&request)));
        if request.is_last { Step::End } else { Step::Handled { is_request } }
    }

    /// Handles a request.
    fn reply(shared: &mut Shared, request: &Request) -> Reply {
        match request.method.as_str() {
            // A CORS preflight request.
            "OPTIONS" => Reply::Now(Response::new("200 OK", "text/plain", "")),
            _ if is_at(request, SOCKET_IO_PATH) => {
                engine::by_polling(shared, request).unwrap_or_else(Reply::Now)
            }
            "POST" if is_at(request, ONE_SHOT_PATH) => match one_shot::exchange(shared, request) {
                Ok(exchange) => Reply::Later(Box::new(exchange)),
                Err(refusal) => Reply::Now(refusal),
            },
            _ if is_at(request, ONE_SHOT_PATH) => {
                let refusal = Response::refusal("405 Method Not Allowed", "send messages with POST");
                Reply::Now(refusal.with("Allow", "POST"))
            }
            _ => {
                let location =
                    format!("send messages to {ONE_SHOT_PATH}, or use Socket.IO at {SOCKET_IO_PATH}");
                Reply::Now(Response::refusal("404 Not Found", location))
            }
        }
    }

    fn upgrade(&mut self, shared: &mut Shared, outbox: &Rc<Outbox>, request: &Request) -> Step {
        let requests = std::mem::replace(&mut self.requests, Requests::new(0));
        match engine::over_web_socket(shared, outbox, request, &requests.into_rest()) {
            Ok(client) => Step::Upgrade(Box::new(client)),
            Err(response) => {
                outbox.push(response.to_bytes(None));
                Step::End
            }
        }
    }
}

impl Protocol for WebClient {
    fn feed(&mut self, bytes: &[u8]) {
        self.requests.feed(bytes);
    }

    fn step(&mut self, shared: &mut Shared, outbox: &Rc<Outbox>) -> Step {
        if let Some((request, pending)) = self.pending.take() {
            return self.answer(shared, outbox, request, Reply::Later(pending));
        }
        match self.requests.take() {
            None => Step::Starved,
            Some(Incoming::Expectation) => {
                outbox.push("HTTP/1.1 100 Continue\r\n\r\n");
                Step::Handled { is_request: false }
            }
            Some(Incoming::Refused(response)) => {
                outbox.push(response.to_bytes(None));
                Step::End
            }
            Some(Incoming::Request(mut request)) => {
                if is_at(&request, SOCKET_IO_PATH) && request.has_word("upgrade", "websocket") {
                    return self.upgrade(shared, outbox, &request);
                }
                let reply = Self::reply(shared, &request);
                request.body = Vec::new();
                self.answer(shared, outbox, request, reply)
            }
        }
    }

    fn unfinished(&self) -> usize {
        self.requests.capacity()
    }

    fn end(&mut self, shared: &mut Shared, _: Reason) {
        if let Some((_, mut pending)) = self.pending.take() {
            pending.end(shared);
        }
    }
}

/// True if a request is for this path, with or without a trailing slash.
fn is_at(request: &Request, path: &str) -> bool {
    request.path.trim_end_matches('/') == path.trim_end_matches('/')
}

/// Adds CORS headers, since clients in browsers usually have another origin.
fn with_cors_headers(request: &Request, response: Response) -> Response {
    let Some(origin) = request.header("origin") else { return response };
    response
        .with("Access-Control-Allow-Origin", origin)
        .with("Access-Control-Allow-Credentials", "true")
        .with("Access-Control-Allow-Headers", "Authorization, Content-Type")
        .with("Access-Control-Allow-Methods", "GET, POST, OPTIONS")
        .with("Vary", "Origin")
}
