//! The parameters of the editor's `initialize` request, as far as the server uses them.
//!
//! `lsp_types::InitializeParams` also has all other capabilities of editors. Code that reads these takes long to
//! compile.

use lsp_types::{PositionEncodingKind, ResourceOperationKind, Uri, WorkspaceFolder};
use serde::Deserialize;

/// The parameters.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Parameters {
    pub(super) workspace_folders: Option<Vec<WorkspaceFolder>>,
    /// The folder, if the editor doesn't send workspace folders.
    pub(super) root_uri: Option<Uri>,
    pub(super) capabilities: Capabilities,
}

/// The features of the editor.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Capabilities {
    pub(super) general: Option<General>,
    pub(super) workspace: Option<Workspace>,
    pub(super) text_document: Option<TextDocument>,
}

/// Features of the protocol.
#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct General {
    pub(super) position_encodings: Option<Vec<PositionEncodingKind>>,
}

/// Features for folders.
#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Workspace {
    pub(super) workspace_edit: Option<WorkspaceEdit>,
    pub(super) did_change_watched_files: Option<WatchedFiles>,
}

/// Features of edits.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct WorkspaceEdit {
    pub(super) resource_operations: Option<Vec<ResourceOperationKind>>,
}

/// Features of watched files.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct WatchedFiles {
    pub(super) dynamic_registration: Option<bool>,
}

/// Features for documents.
#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextDocument {
    pub(super) completion: Option<Completion>,
}

/// Features of completion.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Completion {
    pub(super) completion_item: Option<CompletionItem>,
}

/// Features of completed items.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct CompletionItem {
    pub(super) snippet_support: Option<bool>,
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    fn read(parameters: Value) -> Result<Parameters, serde_json::Error> {
        serde_json::from_value(parameters)
    }

    fn read_capabilities(capabilities: &Value) -> Result<Parameters, serde_json::Error> {
        read(json!({ "processId": null, "capabilities": capabilities }))
    }

    #[test]
    fn all_members_but_the_capabilities_are_optional() {
        let missing = read(json!({ "capabilities": {} })).expect("parameters");
        assert!(missing.workspace_folders.is_none() && missing.root_uri.is_none());
        let null = read(json!({ "capabilities": {}, "rootUri": null, "workspaceFolders": null }));
        assert!(null.is_ok_and(|null| null.workspace_folders.is_none() && null.root_uri.is_none()));
        for capabilities in [
            json!({ "general": null, "workspace": null, "textDocument": null }),
            json!({ "workspace": { "workspaceEdit": null, "didChangeWatchedFiles": {} } }),
            json!({ "textDocument": { "completion": { "completionItem": null } } }),
            // The server doesn't read these members.
            json!({ "window": 1, "general": { "markdown": { "parser": "marked" } } }),
        ] {
            assert!(read_capabilities(&capabilities).is_ok(), "{capabilities}");
        }
    }

    #[test]
    fn wrong_types_are_errors() {
        for parameters in [
            json!({}),
            json!({ "capabilities": {}, "rootUri": 1 }),
            json!({ "capabilities": {}, "workspaceFolders": {} }),
            json!({ "capabilities": {}, "workspaceFolders": [{ "uri": "file:///a" }] }),
        ] {
            assert!(read(parameters.clone()).is_err(), "{parameters}");
        }
        for capabilities in [
            json!(null),
            json!({ "general": { "positionEncodings": "utf-8" } }),
            json!({ "workspace": { "workspaceEdit": { "resourceOperations": [1] } } }),
            json!({ "workspace": { "didChangeWatchedFiles": { "dynamicRegistration": 1 } } }),
            json!({ "textDocument": { "completion": { "completionItem": { "snippetSupport": "" } } } }),
        ] {
            assert!(read_capabilities(&capabilities).is_err(), "{capabilities}");
        }
    }
}
