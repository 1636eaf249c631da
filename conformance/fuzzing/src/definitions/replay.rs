//! Replays edits of documents, for the fuzz target.

use std::path::Path;

use lsp_server::{Connection, Notification};
use lsp_types::Position;
use serde_json::{Value, json};
use uavspec_lsp::{Server, uri};

/// The requests that concern a position.
const REQUESTS: [&str; 6] =
    ["hover", "definition", "documentHighlight", "completion", "prepareRename", "rename"];

/// The requests that concern a whole document.
const WHOLE: [&str; 5] = ["documentSymbol", "foldingRange", "semanticTokens/full", "formatting", "inlayHint"];

/// A change of a document. Later requests use its position.
#[derive(Debug)]
pub(crate) struct Edit<'t> {
    /// The index of the document.
    pub(crate) document: usize,
    /// The start and the end of the replaced text.
    pub(crate) range: [Position; 2],
    /// The new text.
    pub(crate) text: &'t str,
}

/// Opens documents, applies edits to them, and sends all requests after each edit. At the end, a new server that opens
/// the final texts must have the same findings.
pub(crate) fn replay(documents: &[(&str, &str)], edits: &[Edit<'_>]) {
    let (connection, _editor) = Connection::memory();
    let mut server = start(&connection);
    let folder = Path::new("/nowhere");
    let uris: Vec<String> = documents.iter().map(|(path, _)| uri::from_path(&folder.join(path)).0).collect();
    for ((_, text), uri) in documents.iter().zip(&uris) {
        open(&mut server, uri, text);
    }
    for edit in edits {
        let Some(uri) = uris.get(edit.document % uris.len()) else { return };
        let range = json!({ "start": edit.range[0], "end": edit.range[1] });
        let change = json!({ "range": range, "text": edit.text });
        let document = json!({ "uri": uri, "version": 2 });
        let params = json!({ "textDocument": document, "contentChanges": [change] });
        note(&mut server, "textDocument/didChange", params);
        ask(&mut server, uri, &range);
    }
    let texts: Vec<String> =
        uris.iter().map(|uri| server.text(uri).expect("an open document").to_owned()).collect();
    let mut fresh = start(&connection);
    for (uri, text) in uris.iter().zip(&texts) {
        open(&mut fresh, uri, text);
    }
    assert_eq!(server.current(), fresh.current(), "{texts:?}");
}

fn start(connection: &Connection) -> Server<'_> {
    let folder = json!([{ "uri": "file:///nowhere", "name": "nowhere" }]);
    let parameters =
        json!({ "processId": null, "rootUri": null, "capabilities": {}, "workspaceFolders": folder });
    Server::new(connection, &|_, _| Vec::new(), &parameters).expect("valid parameters")
}

fn open(server: &mut Server<'_>, uri: &str, text: &str) {
    let document = json!({ "uri": uri, "languageId": "msg", "version": 1, "text": text });
    note(server, "textDocument/didOpen", json!({ "textDocument": document }));
}

fn note(server: &mut Server<'_>, method: &str, params: Value) {
    server.try_note(Notification { method: method.to_owned(), params }).expect("valid parameters");
}

/// Sends all requests. Each must be answered, or refused with a reason.
fn ask(server: &mut Server<'_>, uri: &str, range: &Value) {
    let context = json!({ "diagnostics": [], "includeDeclaration": true });
    let params = json!({
        "textDocument": { "uri": uri },
        "position": range["start"],
        "range": range,
        "context": context,
        "newName": "renamed",
        "options": { "tabSize": 4, "insertSpaces": true },
    });
    for method in REQUESTS.iter().chain(&WHOLE).chain(&["references", "codeAction"]) {
        if let Err((code, reason)) = server.answer(&format!("textDocument/{method}"), params.clone()) {
            assert!(code as i32 == lsp_server::ErrorCode::RequestFailed as i32, "{method}: {reason}");
        }
    }
    server.answer("uavspec/layout", params).expect("pictures");
}
