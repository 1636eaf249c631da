//! The event loop: reads the messages of the editor, answers requests, and publishes diagnostics.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use lsp_server::{Connection, ErrorCode, Message, Notification, Request, Response};
use lsp_types::{
    CodeActionKind, CodeActionParams, Diagnostic, DidChangeTextDocumentParams,
    DidChangeWorkspaceFoldersParams, DidCloseTextDocumentParams, DidOpenTextDocumentParams, InlayHintParams,
    LspNotificationMethod, LspRequestMethod, Position, PublishDiagnosticsParams, ReferenceParams,
    RenameParams, ResourceOperationKind, SemanticTokens, TextDocumentIdentifier, TextDocumentSyncKind,
    WorkspaceSymbolParams,
};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use super::hover::History;
use super::lines::Encoding;
use super::parameters::Parameters;
use super::project::Project;
use super::snapshot::{Document, Snapshot};
use super::workspace::Workspace;
use super::{
    completion, diagnostics, fixes, format, hover, layout, navigation, outline, rename, tokens, uri,
};

/// The request for pictures of memory layouts, which isn't part of the protocol.
const LAYOUT: &str = "uavspec/layout";

/// The files whose changes the editor reports.
const WATCHED: &str = "**/{*.msg,*.srv,*.action,*.md,*.adoc,*.json,*.json.xz,*.po,uavspec.toml}";

/// A failed request: the code of the protocol, and a message for the user.
pub(super) type Failed = (ErrorCode, String);

/// The server of one editor.
pub struct Server<'c> {
    connection: &'c Connection,
    history: &'c History<'c>,
    workspace: Workspace,
    /// True if the editor can rename files as part of an edit.
    can_rename_files: bool,
    /// True if the editor supports snippets, whose placeholders the user fills in.
    has_snippets: bool,
    /// True if the editor can report changes of files.
    can_watch_files: bool,
    published: BTreeMap<PathBuf, Vec<Diagnostic>>,
}

/// The document and the position of a request.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Place {
    text_document: TextDocumentIdentifier,
    #[serde(default)]
    position: Position,
}

impl<'c> Server<'c> {
    /// Creates the server for the parameters of the editor's `initialize` request.
    pub fn new(
        connection: &'c Connection,
        history: &'c History<'c>,
        parameters: &Value,
    ) -> Result<Self, serde_json::Error> {
        let parameters = Parameters::read(parameters)?;
        let folders: Vec<PathBuf> = parameters.folders.iter().filter_map(uri::to_path).collect();
        Ok(Self {
            connection,
            history,
            workspace: Workspace::new(&folders, Encoding::choose(&parameters.encodings)),
            can_rename_files: parameters.operations.contains(&ResourceOperationKind::Rename),
            has_snippets: parameters.has_snippets,
            can_watch_files: parameters.can_watch_files,
            published: BTreeMap::new(),
        })
    }

    /// The answer to the `initialize` request.
    pub(super) fn initialize_result(&self) -> Value {
        let server = json!({ "name": "uavspec", "version": env!("CARGO_PKG_VERSION") });
        json!({ "capabilities": capabilities(self.workspace.encoding), "serverInfo": server })
    }

    /// Serves the editor until it ends the session.
    pub(super) fn run(mut self) {
        if self.can_watch_files {
            self.watch_files();
        }
        self.publish();
        while let Ok(message) = self.connection.receiver.recv() {
            let waiting = self.connection.receiver.try_iter();
            for message in std::iter::once(message).chain(waiting) {
                match message {
                    Message::Request(request) => {
                        if request.method == LspRequestMethod::Shutdown.as_str() {
                            self.shut_down(request);
                            return;
                        }
                        let response = match self.answer(&request.method, request.params) {
                            Ok(result) => Response::new_ok(request.id, result),
                            Err((code, message)) => Response::new_err(request.id, code as i32, message),
                        };
                        self.send(response.into());
                    }
                    Message::Notification(notification) => self.note(notification),
                    Message::Response(_) => {}
                }
            }
            self.publish();
        }
    }

    /// Answers the `shutdown` request, and waits for the notification that ends the session.
    fn shut_down(&self, request: Request) {
        self.send(Response::new_ok(request.id, Value::Null).into());
        let is_exit = |message: &Message| {
            let exit = LspNotificationMethod::Exit.as_str();
            matches!(message, Message::Notification(notification) if notification.method == exit)
        };
        let _ = self.connection.receiver.iter().find(is_exit);
    }

    /// Sends a message. If the editor has disconnected, the loop ends with the next message.
    fn send(&self, message: Message) {
        let _ = self.connection.sender.send(message);
    }

    /// Asks the editor to report changes of files.
    fn watch_files(&self) {
        let method = LspNotificationMethod::WorkspaceDidChangeWatchedFiles.as_str();
        let options = json!({ "watchers": [{ "globPattern": WATCHED }] });
        let registration = json!({ "id": "files", "method": method, "registerOptions": options });
        let request = Request {
            id: 0.into(),
            method: LspRequestMethod::ClientRegisterCapability.as_str().to_owned(),
            params: json!({ "registrations": [registration] }),
        };
        self.send(request.into());
    }

    fn note(&mut self, notification: Notification) {
        if let Err(error) = self.try_note(notification) {
            let message = format!("uavspec: an invalid notification: {error}");
            let params = json!({ "type": 1, "message": message });
            let method = LspNotificationMethod::WindowLogMessage.as_str().to_owned();
            self.send(Notification { method, params }.into());
        }
    }

    /// Receives a notification.
    pub fn try_note(&mut self, notification: Notification) -> Result<(), serde_json::Error> {
        use LspNotificationMethod as Method;
        let Notification { method, params } = notification;
        match Method::from(method.as_str()) {
            Method::TextDocumentDidOpen => {
                let opened: DidOpenTextDocumentParams = serde_json::from_value(params)?;
                if let Some(path) = uri::to_path(&opened.text_document.uri) {
                    self.workspace.open(&path, opened.text_document.text);
                }
            }
            Method::TextDocumentDidChange => {
                let changed: DidChangeTextDocumentParams = serde_json::from_value(params)?;
                if let Some(path) = uri::to_path(&changed.text_document.text_document_identifier.uri) {
                    self.workspace.edit(&path, changed.content_changes);
                }
            }
            Method::TextDocumentDidClose => {
                let closed: DidCloseTextDocumentParams = serde_json::from_value(params)?;
                if let Some(path) = uri::to_path(&closed.text_document.uri) {
                    self.workspace.close(&path);
                }
            }
            Method::TextDocumentDidSave | Method::WorkspaceDidChangeWatchedFiles => self.workspace.reload(),
            Method::WorkspaceDidChangeWorkspaceFolders => {
                let changed: DidChangeWorkspaceFoldersParams = serde_json::from_value(params)?;
                let removed = changed.event.removed.iter().filter_map(|folder| uri::to_path(&folder.uri));
                removed.for_each(|folder| self.workspace.remove_folder(&folder));
                let added = changed.event.added.iter().filter_map(|folder| uri::to_path(&folder.uri));
                added.for_each(|folder| self.workspace.add_folder(&folder));
            }
            _ => {}
        }
        Ok(())
    }

    /// The answer to a request. The answer about a file that isn't a definition is null.
    pub fn answer(&mut self, method: &str, params: Value) -> Result<Value, Failed> {
        use LspRequestMethod as Method;
        self.workspace.refresh();
        let known = Method::from(method);
        if known == Method::WorkspaceSymbol {
            let params: WorkspaceSymbolParams = read(params)?;
            let snapshots = self.workspace.projects.iter().filter_map(Project::snapshot);
            let found = snapshots.flat_map(|snapshot: &Snapshot| outline::search(snapshot, &params.query));
            return Ok(json!(found.collect::<Vec<_>>()));
        }
        let is_known = method == LAYOUT || !matches!(known, Method::Custom(_));
        let place: Place = match read(params.clone()) {
            Ok(place) => place,
            Err(error) if is_known => return Err(error),
            Err(_) => return Err(unknown(method)),
        };
        let document = uri::to_path(&place.text_document.uri).and_then(|path| {
            if known == Method::TextDocumentCodeAction {
                self.workspace.checked_document(&path)
            } else {
                self.workspace.document(&path)
            }
        });
        let Some(document) = document else {
            return if is_known { Ok(Value::Null) } else { Err(unknown(method)) };
        };
        self.answer_about(&document, known, place.position, params)
    }

    /// The answer to a request about a document.
    fn answer_about(
        &self,
        document: &Document<'_>,
        method: LspRequestMethod<'_>,
        position: Position,
        params: Value,
    ) -> Result<Value, Failed> {
        use LspRequestMethod as Method;
        let offset = document.lines.offset(position);
        let refused = |reason: String| (ErrorCode::RequestFailed, reason);
        Ok(match method {
            Method::TextDocumentHover => json!(hover::hover(document, self.history, offset)),
            Method::TextDocumentDefinition => json!(navigation::definition(document, offset)),
            Method::TextDocumentReferences => {
                let params: ReferenceParams = read(params)?;
                json!(navigation::references(document, offset, params.context.include_declaration))
            }
            Method::TextDocumentDocumentHighlight => json!(navigation::highlights(document, offset)),
            Method::TextDocumentCompletion => {
                json!(completion::complete(document, offset, self.has_snippets))
            }
            Method::TextDocumentDocumentSymbol => json!(outline::symbols(document)),
            Method::TextDocumentFoldingRange => json!(outline::folds(document)),
            Method::TextDocumentSemanticTokensFull => {
                json!(SemanticTokens { result_id: None, data: tokens::tokens(document) })
            }
            Method::TextDocumentInlayHint => {
                let params: InlayHintParams = read(params)?;
                json!(layout::hints(document, params.range))
            }
            Method::TextDocumentCodeAction => {
                let params: CodeActionParams = read(params)?;
                json!(fixes::actions(document, params.range, params.context.only.as_deref()))
            }
            Method::TextDocumentFormatting => json!(format::edits(document)),
            Method::TextDocumentPrepareRename => json!(rename::prepare(document, offset).map_err(refused)?),
            Method::TextDocumentRename => {
                let params: RenameParams = read(params)?;
                let edit = rename::rename(document, offset, &params.new_name, self.can_rename_files);
                json!(edit.map_err(refused)?)
            }
            Method::Custom(LAYOUT) => json!(layout::pictures(document)),
            other => return Err(unknown(other.as_str())),
        })
    }

    /// Publishes the diagnostics that changed.
    fn publish(&mut self) {
        self.workspace.refresh();
        if !self.workspace.take_changed() {
            return;
        }
        let current = self.diagnostics();
        for (path, found) in &current {
            if self.published.get(path) != Some(found) {
                self.publish_file(path, found.clone());
            }
        }
        for path in self.published.keys().filter(|path| !current.contains_key(*path)) {
            self.publish_file(path, Vec::new());
        }
        self.published = current;
    }

    /// The diagnostics by file. Contains only files that have diagnostics.
    fn diagnostics(&self) -> BTreeMap<PathBuf, Vec<Diagnostic>> {
        let mut current = BTreeMap::new();
        for project in &self.workspace.projects {
            let mut found = diagnostics::of_project(project);
            // Keep only the findings of the project that owns the file, even if it has none.
            let is_owner = |owner: &Project| owner.root == project.root;
            found.retain(|path, _| self.workspace.owner_of(path).is_some_and(is_owner));
            current.append(&mut found);
        }
        current
    }

    fn publish_file(&self, path: &Path, diagnostics: Vec<Diagnostic>) {
        let params = PublishDiagnosticsParams { uri: uri::from_path(path), version: None, diagnostics };
        let method = LspNotificationMethod::TextDocumentPublishDiagnostics.as_str().to_owned();
        self.send(Notification { method, params: json!(params) }.into());
    }
}

impl Server<'_> {
    /// The text of an open document.
    pub fn text(&self, uri: &str) -> Option<&str> {
        self.workspace.text(&uri::to_path(&lsp_types::Uri(uri.to_owned()))?)
    }

    /// The current diagnostics of all files.
    pub fn current(&mut self) -> BTreeMap<PathBuf, Vec<Diagnostic>> {
        self.workspace.refresh();
        self.diagnostics()
    }
}

fn read<T: DeserializeOwned>(params: Value) -> Result<T, Failed> {
    serde_json::from_value(params).map_err(|error| (ErrorCode::InvalidParams, error.to_string()))
}

fn unknown(method: &str) -> Failed {
    (ErrorCode::MethodNotFound, format!("unknown request `{method}`"))
}

/// The features of the server, in the form of `lsp_types::ServerCapabilities`. That type covers the features of all
/// servers, and would increase the compile time.
fn capabilities(encoding: Encoding) -> Value {
    json!({
        "positionEncoding": encoding.kind(),
        "textDocumentSync": { "openClose": true, "change": TextDocumentSyncKind::Incremental, "save": true },
        "completionProvider": { "triggerCharacters": completion::TRIGGERS },
        "hoverProvider": true,
        "definitionProvider": true,
        "referencesProvider": true,
        "documentHighlightProvider": true,
        "documentSymbolProvider": true,
        "codeActionProvider": { "codeActionKinds": [CodeActionKind::QuickFix, fixes::fix_all()] },
        "workspaceSymbolProvider": true,
        "documentFormattingProvider": true,
        "renameProvider": { "prepareProvider": true },
        "foldingRangeProvider": true,
        "semanticTokensProvider": { "legend": tokens::legend(), "full": true },
        "inlayHintProvider": true,
        "workspace": { "workspaceFolders": { "supported": true, "changeNotifications": true } },
    })
}

#[cfg(test)]
mod tests {
    use lsp_types::ServerCapabilities;

    use super::*;

    #[test]
    fn the_features_are_those_of_the_protocol_in_its_order() {
        for encoding in [Encoding::Utf8, Encoding::Utf16] {
            let features = capabilities(encoding);
            let known: ServerCapabilities = serde_json::from_value(features.clone()).expect("capabilities");
            // An unknown name would be missing in the typed value.
            assert_eq!(json!(known).to_string(), features.to_string());
        }
    }
}
