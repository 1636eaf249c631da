//! HTTP: dispatches requests by path, and adds CORS headers for browsers.

use std::io;
use std::net::TcpStream;
use std::sync::Arc;

use super::{Shared, engine, one_shot};
use crate::flockwave::transport::http::{Connection, Incoming, Request, Response};
use crate::flockwave::transport::{ONE_SHOT_PATH, SOCKET_IO_PATH};

/// Serves a connection. One-shot requests and Socket.IO share a port, as clients expect.
pub(super) fn serve_connection(shared: &Arc<Shared>, stream: TcpStream) -> io::Result<()> {
    let mut connection = Connection::new(stream)?;
    let is_wanted = || !shared.is_drained();
    loop {
        let request = match connection.next(&is_wanted)? {
            Incoming::Request(request) => request,
            Incoming::Refused(response) => {
                connection.respond(None, &response)?;
                return Ok(());
            }
            Incoming::Nothing => return Ok(()),
        };
        let is_socket_io = is_at(&request, SOCKET_IO_PATH);
        if is_socket_io && request.has_word("upgrade", "websocket") {
            return engine::over_web_socket(shared, connection, &request);
        }
        let response = match request.method.as_str() {
            // A CORS preflight request.
            "OPTIONS" => Response::new("200 OK", "text/plain", ""),
            _ if is_socket_io => engine::by_polling(shared, &request),
            "POST" if is_at(&request, ONE_SHOT_PATH) => one_shot::answer(shared, &request),
            _ if is_at(&request, ONE_SHOT_PATH) => {
                Response::refusal("405 Method Not Allowed", "send messages with POST").with("Allow", "POST")
            }
            _ => {
                let location =
                    format!("send messages to {ONE_SHOT_PATH}, or use Socket.IO at {SOCKET_IO_PATH}");
                Response::refusal("404 Not Found", location)
            }
        };
        if !connection.respond(Some(&request), &with_cors_headers(&request, response))? {
            return Ok(());
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
