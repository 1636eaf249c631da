//! The parameters of the editor's `initialize` request that the server uses.
//!
//! `lsp_types::InitializeParams` also contains all other capabilities of editors, and would increase the compile time.

use lsp_types::{PositionEncodingKind, ResourceOperationKind, Uri, WorkspaceFolder};
use serde::Deserialize;
use serde_json::{Error, Map, Value};

/// The parameters. A missing feature is empty or false.
pub(super) struct Parameters {
    pub(super) folders: Vec<Uri>,
    pub(super) encodings: Vec<PositionEncodingKind>,
    /// The operations on files that an edit may contain.
    pub(super) operations: Vec<ResourceOperationKind>,
    pub(super) has_snippets: bool,
    /// True if the server can ask the editor to report changes of files.
    pub(super) can_watch_files: bool,
}

impl Parameters {
    pub(super) fn read(parameters: &Value) -> Result<Self, Error> {
        let capabilities = parameters.get("capabilities").unwrap_or(&Value::Null);
        Map::<String, Value>::deserialize(capabilities)?;
        let folders: Option<Vec<WorkspaceFolder>> = member(parameters, "/workspaceFolders")?;
        // An editor without workspace folders may send a single root folder.
        let root: Option<Uri> = member(parameters, "/rootUri")?;
        let folders = folders.map(|folders| folders.into_iter().map(|folder| folder.uri).collect());
        Ok(Self {
            folders: folders.unwrap_or_else(|| Vec::from_iter(root)),
            encodings: member(capabilities, "/general/positionEncodings")?,
            operations: member(capabilities, "/workspace/workspaceEdit/resourceOperations")?,
            has_snippets: member(capabilities, "/textDocument/completion/completionItem/snippetSupport")?,
            can_watch_files: member(capabilities, "/workspace/didChangeWatchedFiles/dynamicRegistration")?,
        })
    }
}

/// The value at a JSON pointer, or the default if the value is missing or null.
fn member<'p, T: Default + Deserialize<'p>>(parameters: &'p Value, pointer: &str) -> Result<T, Error> {
    let found: Option<T> = parameters.pointer(pointer).map_or(Ok(None), Option::deserialize)?;
    Ok(found.unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn read_capabilities(capabilities: &Value) -> Result<Parameters, Error> {
        Parameters::read(&json!({ "processId": null, "capabilities": capabilities }))
    }

    #[test]
    fn all_members_but_the_capabilities_are_optional() {
        for parameters in [
            json!({ "capabilities": {} }),
            json!({ "capabilities": {}, "rootUri": null, "workspaceFolders": null }),
        ] {
            let found = Parameters::read(&parameters).expect("parameters");
            assert!(found.folders.is_empty(), "{parameters}");
        }
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
            assert!(Parameters::read(&parameters).is_err(), "{parameters}");
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
