//! A session that runs in one thread, so that its allocations can be counted.

use std::fs;

use lsp_server::{Connection, Message, Notification, Request};
use serde_json::{Value, json};
use uavspec_lsp::serve;
use uavspec_schema::Form;
use uavspec_schema::msg::Dialect;

/// The requests after each file is opened, in addition to requests about a position.
const WHOLE: [&str; 7] = [
    "documentSymbol",
    "foldingRange",
    "semanticTokens/full",
    "formatting",
    "inlayHint",
    "codeAction",
    "hover",
];

/// The requests at the end, about positions in the last file.
const ABOUT_PLACES: [&str; 6] =
    ["definition", "references", "documentHighlight", "completion", "prepareRename", "rename"];

/// Opens all files of a package, and sends all requests.
pub(crate) fn edit_all(form: Form, files: &[(String, String)]) {
    let dialect = match form {
        Form::Msg(Dialect::Px4) => "px4",
        Form::Msg(Dialect::Ros2) => "ros2",
        Form::Table => "table",
        Form::Events => "events",
    };
    let folder = tempfile::tempdir().expect("a folder");
    let config = format!(
        "[lint]\npreset = \"strict\"\n[[package]]\nname = \"demo\"\ndialect = \"{dialect}\"\ninclude = [\"*.{{msg,md,json}}\"]\n"
    );
    fs::write(folder.path().join("uavspec.toml"), config).expect("a file");
    let uri = |name: &str| format!("file://{}", folder.path().join(name).display());
    let mut session = Session::default();
    let folders = json!([{ "uri": uri("").trim_end_matches('/'), "name": "test" }]);
    session.request("initialize", json!({ "capabilities": {}, "workspaceFolders": folders }));
    session.notify("initialized", json!({}));
    for (name, text) in files {
        fs::write(folder.path().join(name), text).expect("a file");
        let document = json!({ "uri": uri(name), "languageId": "msg", "version": 1, "text": text });
        session.notify("textDocument/didOpen", json!({ "textDocument": document }));
        session.ask(&WHOLE, &uri(name), text.lines().count(), 0);
    }
    if let Some((name, text)) = files.last() {
        let last = text.lines().count() - 1;
        // The positions of a type, a name, and an annotation or a column.
        for (line, character) in [(0, 9), (1, 1), (1, 9), (last, 1), (last, 9), (last, 24)] {
            session.ask(&ABOUT_PLACES, &uri(name), line, character);
        }
    }
    session.request("workspace/symbol", json!({ "query": "wind" }));
    session.request("shutdown", Value::Null);
    session.notify("exit", Value::Null);
    serve(&session.server, &|_, _| Vec::new()).expect("a session");
    let is_refused = |message: &Message| matches!(message, Message::Response(response) if response.response_result.is_err());
    let refused = session.editor.receiver.try_iter().filter(is_refused).count();
    assert!(refused < 20, "{refused} requests are refused");
}

/// The messages of an editor, sent before the server starts.
struct Session {
    editor: Connection,
    server: Connection,
    last_id: i32,
}

impl Default for Session {
    fn default() -> Self {
        let (editor, server) = Connection::memory();
        Self { editor, server, last_id: 0 }
    }
}

impl Session {
    fn notify(&self, method: &str, params: Value) {
        let notification = Notification { method: method.to_owned(), params };
        self.editor.sender.send(notification.into()).expect("a server");
    }

    fn request(&mut self, method: &str, params: Value) {
        self.last_id += 1;
        let request = Request { id: self.last_id.into(), method: method.to_owned(), params };
        self.editor.sender.send(request.into()).expect("a server");
    }

    /// Sends requests about a document, its first lines, and a position.
    fn ask(&mut self, methods: &[&str], uri: &str, line: usize, character: usize) {
        let position = json!({ "line": line, "character": character });
        let params = json!({
            "textDocument": { "uri": uri },
            "position": position,
            "range": { "start": { "line": 0, "character": 0 }, "end": position },
            "context": { "diagnostics": [], "includeDeclaration": true },
            "newName": "renamed",
            "options": { "tabSize": 4, "insertSpaces": true },
        });
        for method in methods {
            self.request(&format!("textDocument/{method}"), params.clone());
        }
    }
}
