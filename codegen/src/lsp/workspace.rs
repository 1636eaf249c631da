//! The folders and documents that are open in the editor.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use lsp_types::TextDocumentContentChangeEvent as Change;

use super::lines::{Encoding, Lines};
use super::project::{Project, Root};
use super::snapshot::Document;
use crate::load::Config;

/// All projects, and the texts of open documents.
pub(super) struct Workspace {
    pub(super) encoding: Encoding,
    pub(super) projects: Vec<Project>,
    open: BTreeMap<PathBuf, String>,
    /// True if definitions were read since the diagnostics were published, or if a project was removed.
    is_changed: bool,
}

impl Workspace {
    pub(super) fn new(folders: &[PathBuf], encoding: Encoding) -> Self {
        let mut workspace = Self { encoding, projects: Vec::new(), open: BTreeMap::new(), is_changed: true };
        for folder in folders {
            workspace.add_folder(folder);
        }
        workspace
    }

    /// Adds the project of a folder.
    pub(super) fn add_folder(&mut self, folder: &Path) {
        self.add(Root::of_folder(folder));
    }

    /// Removes the projects in a folder.
    pub(super) fn remove_folder(&mut self, folder: &Path) {
        self.projects.retain(|project| !project.root.folder().starts_with(folder));
        self.is_changed = true;
    }

    fn add(&mut self, root: Root) {
        if self.projects.iter().all(|project| project.root != root) {
            self.projects.push(Project::new(root));
        }
    }

    /// Opens a document. A document outside all projects opens the project of its configuration file or its folder.
    pub(super) fn open(&mut self, path: &Path, text: String) {
        self.projects.iter_mut().for_each(|project| project.edit(path, &text));
        self.open.insert(path.to_path_buf(), text);
        self.refresh();
        if self.project_of(path).is_none() {
            // The file may be new.
            self.reload();
            self.refresh();
        }
        if self.project_of(path).is_none() {
            let folder = path.parent().unwrap_or(path);
            let config = path.ancestors().skip(1).find_map(Config::in_folder);
            let roots = config.map(Root::Config).into_iter().chain([Root::Folder(folder.to_path_buf())]);
            for root in roots {
                let known = self.projects.len();
                self.add(root);
                self.refresh();
                if self.project_of(path).is_some() {
                    return;
                }
                self.projects.truncate(known);
            }
        }
    }

    /// Closes a document. From now on, its file is read.
    pub(super) fn close(&mut self, path: &Path) {
        self.open.remove(path);
        self.projects.iter_mut().filter(|project| project.contains(path)).for_each(Project::reload);
    }

    /// Applies changes to an open document.
    pub(super) fn edit(&mut self, path: &Path, changes: Vec<Change>) {
        let Some(text) = self.open.get_mut(path) else { return };
        for change in changes {
            match change {
                Change::TextDocumentContentChangeWholeDocument(change) => *text = change.text,
                Change::TextDocumentContentChangePartial(change) => {
                    let range = Lines::new(text, self.encoding).offsets(change.range);
                    text.replace_range(range, &change.text);
                }
            }
        }
        for project in &mut self.projects {
            project.edit(path, text);
        }
    }

    /// Notes that files changed.
    pub(super) fn reload(&mut self) {
        self.projects.iter_mut().for_each(Project::reload);
    }

    /// Reads the definitions that changed.
    pub(super) fn refresh(&mut self) {
        for project in &mut self.projects {
            self.is_changed |= project.refresh(&self.open, self.encoding);
        }
    }

    /// True if definitions were read since the last call.
    pub(super) fn take_changed(&mut self) -> bool {
        std::mem::take(&mut self.is_changed)
    }

    /// The text of an open document.
    #[cfg(any(fuzzing, test))]
    pub(super) fn text(&self, path: &Path) -> Option<&str> {
        self.open.get(path).map(String::as_str)
    }

    /// The document at a path.
    pub(super) fn document(&self, path: &Path) -> Option<Document<'_>> {
        self.project_of(path)?.snapshot()?.document(path)
    }

    /// The project that reads a file. A configuration file takes precedence over a folder without one.
    fn project_of(&self, path: &Path) -> Option<&Project> {
        let projects = self.projects.iter().filter(|project| project.contains(path));
        projects.min_by_key(|project| matches!(project.root, Root::Folder(_)))
    }
}
