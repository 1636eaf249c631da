//! An editor for tests: it keeps the texts of documents, sends requests and collects diagnostics.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::thread::{self, JoinHandle};
use std::time::Duration;

use lsp_server::{Connection, Message, Notification, Request, RequestId};
use serde_json::{Value, json};
use tempfile::TempDir;
use uavspec_lsp::serve;

/// Invents a history for any message or item.
fn invented(message: &str, item: Option<&str>) -> Vec<String> {
    vec![format!("since 1.0: {message} {}", item.unwrap_or("whole"))]
}

/// The time limit for a message, which ends tests that would hang. Even slow computers don't reach it.
const LIMIT: Duration = Duration::from_secs(600);

/// An editor with a folder of files.
pub(super) struct Editor {
    connection: Connection,
    server: Option<JoinHandle<()>>,
    folder: TempDir,
    texts: BTreeMap<PathBuf, String>,
    diagnostics: BTreeMap<String, Vec<Value>>,
    last_id: i32,
    /// The answer to `initialize`.
    pub(super) initialized: Value,
}

impl Editor {
    /// Starts a server in a folder with these files.
    pub(super) fn new(files: &[(&str, &str)]) -> Self {
        let edit = json!({ "resourceOperations": ["rename"] });
        let completion = json!({ "completionItem": { "snippetSupport": true } });
        let capabilities =
            json!({ "workspace": { "workspaceEdit": edit }, "textDocument": { "completion": completion } });
        Self::with_capabilities(files, &capabilities)
    }

    pub(super) fn with_capabilities(files: &[(&str, &str)], capabilities: &Value) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        for (path, text) in files {
            let path = folder.path().join(path);
            fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            fs::write(path, text).expect("a file");
        }
        let (connection, server) = Connection::memory();
        let server = thread::spawn(move || serve(&server, &invented).expect("a session"));
        let mut editor = Self {
            connection,
            server: Some(server),
            folder,
            texts: BTreeMap::new(),
            diagnostics: BTreeMap::new(),
            last_id: 0,
            initialized: Value::Null,
        };
        let root = editor.uri("");
        let folders = json!([{ "uri": root.trim_end_matches('/'), "name": "test" }]);
        let parameters = json!({ "processId": null, "rootUri": null, "capabilities": capabilities, "workspaceFolders": folders });
        editor.initialized = editor.request("initialize", parameters).expect("initialized");
        editor.notify("initialized", json!({}));
        editor
    }

    pub(super) fn path(&self, path: &str) -> PathBuf {
        self.folder.path().join(path)
    }

    pub(super) fn uri(&self, path: &str) -> String {
        format!("file://{}", self.path(path).display())
    }

    /// Opens a file with its text on disk.
    pub(super) fn open(&mut self, path: &str) {
        let text = fs::read_to_string(self.path(path)).expect("a file");
        self.open_with(path, &text);
    }

    /// Opens a file with another text.
    pub(super) fn open_with(&mut self, path: &str, text: &str) {
        self.texts.insert(self.path(path), text.to_owned());
        let document = json!({ "uri": self.uri(path), "languageId": "msg", "version": 1, "text": text });
        self.notify("textDocument/didOpen", json!({ "textDocument": document }));
    }

    /// Replaces the first occurrence of a text in an open document.
    pub(super) fn edit(&mut self, path: &str, old: &str, new: &str) {
        let text = self.text(path).to_owned();
        let at = text.find(old).unwrap_or_else(|| panic!("{old:?} in {text:?}"));
        let range = json!({ "start": position(&text, at), "end": position(&text, at + old.len()) });
        self.texts.insert(self.path(path), text.replacen(old, new, 1));
        self.notify_change(path, &json!({ "range": range, "text": new }));
    }

    fn notify_change(&mut self, path: &str, change: &Value) {
        let document = json!({ "uri": self.uri(path), "version": 2 });
        self.notify(
            "textDocument/didChange",
            json!({ "textDocument": document, "contentChanges": [change] }),
        );
    }

    pub(super) fn close(&mut self, path: &str) {
        self.texts.remove(&self.path(path));
        self.notify("textDocument/didClose", json!({ "textDocument": { "uri": self.uri(path) } }));
    }

    /// The text of an open document.
    pub(super) fn text(&self, path: &str) -> &str {
        &self.texts[&self.path(path)]
    }

    pub(super) fn notify(&self, method: &str, params: Value) {
        let notification = Notification { method: method.to_owned(), params };
        self.connection.sender.send(notification.into()).expect("a server");
    }

    /// Sends a request, and returns its result or the message of its error.
    pub(super) fn request(&mut self, method: &str, params: Value) -> Result<Value, String> {
        self.last_id += 1;
        let id = RequestId::from(self.last_id);
        let request = Request { id: id.clone(), method: method.to_owned(), params };
        self.connection.sender.send(request.into()).expect("a server");
        loop {
            match self.receive() {
                Message::Response(response) if response.id == id => {
                    return response.response_result.map_err(|error| error.message);
                }
                _ => {}
            }
        }
    }

    /// Sends a request about an open document.
    pub(super) fn about(&mut self, method: &str, path: &str, mut params: Value) -> Result<Value, String> {
        params["textDocument"] = json!({ "uri": self.uri(path) });
        self.request(&format!("textDocument/{method}"), params)
    }

    /// Sends a request about a position, given as a text of the document with `^` at the cursor.
    pub(super) fn at(
        &mut self,
        method: &str,
        path: &str,
        place: &str,
        mut params: Value,
    ) -> Result<Value, String> {
        let (before, after) = place.split_once('^').expect("a cursor");
        let whole = format!("{before}{after}");
        let text = self.text(path);
        let at = text.find(&whole).unwrap_or_else(|| panic!("{whole:?} in {text:?}")) + before.len();
        params["position"] = position(text, at);
        self.about(method, path, params)
    }

    /// The text of a hover.
    pub(super) fn hover(&mut self, path: &str, place: &str) -> String {
        let hover = self.at("hover", path, place, json!({})).expect("an answer");
        hover["contents"]["value"].as_str().unwrap_or_default().to_owned()
    }

    /// Waits until the diagnostics of a file have these codes.
    pub(super) fn expect_codes(&mut self, path: &str, codes: &[&str]) {
        let uri = self.uri(path);
        loop {
            let found = self.codes(&uri);
            if found == codes {
                return;
            }
            let message = self.connection.receiver.recv_timeout(LIMIT);
            let message = message.unwrap_or_else(|_| panic!("{path}: {found:?} instead of {codes:?}"));
            self.keep(&message);
        }
    }

    fn codes(&self, uri: &str) -> Vec<String> {
        let found = self.diagnostics.get(uri).into_iter().flatten();
        found.map(|found| found["code"].as_str().unwrap_or_default().to_owned()).collect()
    }

    /// The diagnostics of a file, as last received.
    pub(super) fn diagnostics(&self, path: &str) -> &[Value] {
        self.diagnostics.get(&self.uri(path)).map_or(&[], Vec::as_slice)
    }

    fn receive(&mut self) -> Message {
        let message = self.connection.receiver.recv_timeout(LIMIT).expect("a message");
        self.keep(&message);
        message
    }

    /// Stores the diagnostics in a message.
    fn keep(&mut self, message: &Message) {
        if let Message::Notification(Notification { method, params }) = message
            && method == "textDocument/publishDiagnostics"
        {
            let uri = params["uri"].as_str().expect("a URI").to_owned();
            let found = params["diagnostics"].as_array().expect("a list").clone();
            self.diagnostics.insert(uri, found);
        }
    }

    /// Applies the edits of one document to its text.
    pub(super) fn apply(&self, path: &str, edits: &Value) -> String {
        let mut text = self.text(path).to_owned();
        let offset = |text: &str, position: &Value| offset(text, position);
        let mut edits: Vec<&Value> = edits.as_array().expect("edits").iter().collect();
        edits.sort_by_key(|edit| std::cmp::Reverse(offset(&text, &edit["range"]["start"])));
        for edit in edits {
            let (start, end) = (offset(&text, &edit["range"]["start"]), offset(&text, &edit["range"]["end"]));
            text.replace_range(start..end, edit["newText"].as_str().expect("a text"));
        }
        text
    }
}

impl Drop for Editor {
    fn drop(&mut self) {
        if thread::panicking() {
            return;
        }
        self.request("shutdown", Value::Null).expect("an answer");
        self.notify("exit", Value::Null);
        self.server.take().into_iter().for_each(|server| server.join().expect("no panic"));
    }
}

/// A position in UTF-16 code units.
fn position(text: &str, at: usize) -> Value {
    let line = text[..at].matches('\n').count();
    let start = text[..at].rfind('\n').map_or(0, |newline| newline + 1);
    json!({ "line": line, "character": text[start..at].encode_utf16().count() })
}

fn offset(text: &str, position: &Value) -> usize {
    let number = |name: &str| usize::try_from(position[name].as_u64().expect("a number")).expect("small");
    let mut lines = text.split_inclusive('\n');
    let start: usize = lines.by_ref().take(number("line")).map(str::len).sum();
    let mut units = 0;
    for (at, character) in text[start..].char_indices() {
        if units == number("character") {
            return start + at;
        }
        units += character.len_utf16();
    }
    text.len()
}
