//! The language server: an editor's view of definitions, by the Language Server Protocol.
//!
//! ```text
//!  documents, files ──▶ Workspace ──▶ Project ──▶ Snapshot ──▶ answers, diagnostics
//! ```
//!
//! A `Snapshot` contains the definitions of a project, read with the texts of open documents, and
//! all findings. After a change, the next request or the end of the queue of messages replaces the snapshot. Reading and
//! checking all messages of PX4 takes about as long as an editor needs to draw a frame, so nothing is updated piecewise.
//! Each feature is a function of a snapshot.

mod completion;
mod diagnostics;
mod discovery;
mod fixes;
mod format;
mod hover;
mod layout;
mod lines;
mod navigation;
mod outline;
mod parameters;
mod project;
mod rename;
#[cfg(any(fuzzing, test))]
mod replay;
mod server;
mod snapshot;
mod symbol;
mod tokens;
mod transport;
mod uri;
mod workspace;

use lsp_server::Connection;

pub use self::hover::History;
#[cfg(any(fuzzing, test))]
pub(crate) use self::replay::{Edit, replay};
use self::server::Server;
use crate::failure::Failure;

/// Serves an editor on standard input and output until the editor ends the session.
pub fn run(history: &History<'_>) -> Result<(), Failure> {
    let (connection, threads) = transport::stdio();
    serve(&connection, history)?;
    // The threads end when the connection is closed.
    drop(connection);
    threads.join().map_err(|error| Failure::new(format!("the connection to the editor failed: {error}")))
}

/// Serves an editor on a connection until the editor ends the session.
pub fn serve(connection: &Connection, history: &History<'_>) -> Result<(), Failure> {
    let failed =
        |error: lsp_server::ProtocolError| Failure::new(format!("the editor violated the protocol: {error}"));
    let (id, parameters) = connection.initialize_start().map_err(failed)?;
    let server = match Server::new(connection, history, parameters) {
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
