//! The language server, which gives editors access to definitions through the Language Server Protocol.
//!
//! ```text
//!  documents, files ──▶ Workspace ──▶ Project ──▶ Snapshot ──▶ answers, diagnostics
//! ```
//!
//! A `Snapshot` contains the definitions of a project, read with the texts of open documents, and all findings. After a
//! change, the snapshot is replaced at the next request, or when the message queue is empty. Reading and checking all
//! messages of PX4 takes about as long as an editor needs to draw a frame, so nothing is updated piecewise. Each
//! feature is a function of a snapshot.
//!
//! ```
//! use lsp_server::{Connection, Message, Notification, Request};
//! use serde_json::{Value, json};
//!
//! let (editor, server) = Connection::memory();
//! let capabilities = json!({ "processId": null, "rootUri": null, "capabilities": {} });
//! let messages: [Message; 4] = [
//!     Request::new(1.into(), "initialize".to_owned(), capabilities).into(),
//!     Notification::new("initialized".to_owned(), json!({})).into(),
//!     Request::new(2.into(), "shutdown".to_owned(), Value::Null).into(),
//!     Notification::new("exit".to_owned(), Value::Null).into(),
//! ];
//! messages.into_iter().for_each(|message| editor.sender.send(message).unwrap());
//! uavspec_lsp::serve(&server, &|_, _| Vec::new()).unwrap();
//! let Message::Response(answer) = editor.receiver.recv().unwrap() else { panic!("an answer") };
//! assert!(answer.response_result.is_ok());
//! ```

#![cfg_attr(not(test), warn(clippy::disallowed_macros, clippy::disallowed_methods))]

mod completion;
mod diagnostics;
mod discovery;
mod events;
mod fixes;
mod format;
mod hover;
mod layout;
mod limits;
mod lines;
mod navigation;
mod outline;
mod parameters;
mod project;
mod rename;
mod server;
mod snapshot;
mod symbol;
mod tokens;
mod transport;
pub mod uri;
mod workspace;

use lsp_server::Connection;
use uavspec_schema::failure::Failure;

pub use self::hover::History;
pub use self::server::Server;

/// Serves an editor on standard input and output until the editor ends the session.
pub fn run(history: &History<'_>) -> Result<(), Failure> {
    let (connection, threads) = transport::stdio();
    serve(&connection, history)?;
    // Close the connection, so that the threads end.
    drop(connection);
    threads.join().map_err(|error| Failure::new(format!("the connection to the editor failed: {error}")))
}

/// Serves an editor on a connection until the editor ends the session.
pub fn serve(connection: &Connection, history: &History<'_>) -> Result<(), Failure> {
    let failed =
        |error: lsp_server::ProtocolError| Failure::new(format!("the editor violated the protocol: {error}"));
    let (id, parameters) = connection.initialize_start().map_err(failed)?;
    let server = match Server::new(connection, history, &parameters) {
        Ok(server) => server,
        Err(error) => {
            let code = lsp_server::ErrorCode::InvalidParams as i32;
            let response = lsp_server::Response::new_err(id, code, error.to_string());
            let _ = connection.sender.send(response.into());
            return Err(Failure::new(format!("the editor's `initialize` request is invalid: {error}")));
        }
    };
    connection.initialize_finish(id, server.initialize_result()).map_err(failed)?;
    server.run();
    Ok(())
}
