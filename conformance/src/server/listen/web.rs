//! HTTP: which request goes where, and what browsers want to hear before they let a page read the answer.

use std::io;
use std::net::TcpStream;
use std::sync::Arc;

use super::{Shared, engine, one_shot};
use crate::live::http::{Came, Connection, Request, Response};
use crate::live::{ONE_SHOT_PATH, SOCKET_IO_PATH};

/// Serves a connection that messages come over one by one.
pub(super) fn one_shots(shared: &Arc<Shared>, stream: TcpStream) -> io::Result<()> {
    let mut connection = Connection::new(stream)?;
    let is_wanted = || !shared.is_ending();
    loop {
        let request = match connection.next(&is_wanted)? {
            Came::Request(request) => request,
            Came::Refused(response) => {
                connection.respond(None, &response)?;
                return Ok(());
            }
            Came::Nothing => return Ok(()),
        };
        let is_place = request.path.trim_end_matches('/') == ONE_SHOT_PATH;
        let response = match request.method.as_str() {
            "OPTIONS" => Response::new("204 No Content", "text/plain", ""),
            _ if !is_place => Response::refusal("404 Not Found", format!("messages go to {ONE_SHOT_PATH}")),
            "POST" => one_shot::answer(shared, &request),
            _ => Response::refusal("405 Method Not Allowed", "messages are sent with POST")
                .with("Allow", "POST"),
        };
        if !connection.respond(Some(&request), &for_browsers(&request, response))? {
            return Ok(());
        }
    }
}

/// Serves a connection that Socket.IO comes over.
pub(super) fn socket_io(shared: &Arc<Shared>, stream: TcpStream) -> io::Result<()> {
    let mut connection = Connection::new(stream)?;
    let is_wanted = || !shared.has_ended();
    loop {
        let request = match connection.next(&is_wanted)? {
            Came::Request(request) => request,
            Came::Refused(response) => {
                connection.respond(None, &response)?;
                return Ok(());
            }
            Came::Nothing => return Ok(()),
        };
        let is_place = format!("{}/", request.path.trim_end_matches('/')) == SOCKET_IO_PATH;
        if is_place && request.has_word("upgrade", "websocket") {
            return engine::over_web_socket(shared, connection, &request);
        }
        let response = match request.method.as_str() {
            "OPTIONS" => Response::new("204 No Content", "text/plain", ""),
            _ if is_place => engine::by_polling(shared, &request),
            _ => Response::refusal("404 Not Found", format!("Socket.IO is served at {SOCKET_IO_PATH}")),
        };
        if !connection.respond(Some(&request), &for_browsers(&request, response))? {
            return Ok(());
        }
    }
}

/// Lets pages of any origin read the response, as clients in browsers are mostly served from elsewhere.
fn for_browsers(request: &Request, response: Response) -> Response {
    let Some(origin) = request.header("origin") else { return response };
    response
        .with("Access-Control-Allow-Origin", origin)
        .with("Access-Control-Allow-Credentials", "true")
        .with("Access-Control-Allow-Headers", "Authorization, Content-Type")
        .with("Access-Control-Allow-Methods", "GET, POST, OPTIONS")
        .with("Vary", "Origin")
}
