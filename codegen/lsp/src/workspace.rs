//! The folders and documents that are open in the editor.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use lsp_types::TextDocumentContentChangeEvent as Change;
use uavspec_codegen::load::Config;

use super::lines::{Encoding, Lines};
use super::project::{Project, Root};
use super::snapshot::Document;

/// All projects, and the texts of open documents.
pub(super) struct Workspace {
    pub(super) encoding: Encoding,
    pub(super) projects: Vec<Project>,
    /// The folders of the editor's workspace, each with the root of its project.
    folders: Vec<(PathBuf, Root)>,
    open: BTreeMap<PathBuf, String>,
    /// Documents that were opened since the last refresh.
    opened: BTreeSet<PathBuf>,
    /// Open documents that may have no project.
    uncertain: BTreeSet<PathBuf>,
    /// True if definitions were read since the diagnostics were last published, or if a project was removed.
    is_changed: bool,
}

impl Workspace {
    pub(super) fn new(folders: &[PathBuf], encoding: Encoding) -> Self {
        let mut workspace = Self {
            encoding,
            projects: Vec::new(),
            folders: Vec::new(),
            open: BTreeMap::new(),
            opened: BTreeSet::new(),
            uncertain: BTreeSet::new(),
            is_changed: true,
        };
        for folder in folders {
            workspace.add_folder(folder);
        }
        workspace
    }

    /// Adds the project of a folder.
    pub(super) fn add_folder(&mut self, folder: &Path) {
        let root = Root::of_folder(folder);
        self.folders.push((folder.to_path_buf(), root.clone()));
        self.add(root);
    }

    /// Removes the projects in a folder.
    pub(super) fn remove_folder(&mut self, folder: &Path) {
        self.projects.retain(|project| !project.root.folder().starts_with(folder));
        self.folders.retain(|(known, _)| !known.starts_with(folder));
        self.is_changed = true;
    }

    fn add(&mut self, root: Root) {
        if self.projects.iter().all(|project| project.root != root) {
            self.projects.push(Project::new(root));
        }
    }

    /// Opens a document.
    pub(super) fn open(&mut self, path: &Path, text: String) {
        self.projects.iter_mut().for_each(|project| project.edit(path, &text));
        self.open.insert(path.to_path_buf(), text);
        self.opened.insert(path.to_path_buf());
    }

    /// Adds the project of a document outside all projects: the project of its configuration file, or of its folder.
    fn add_project_of(&mut self, path: &Path) {
        let folder = path.parent().unwrap_or(path);
        let config = path.ancestors().skip(1).find_map(Config::in_folder);
        let roots = config.map(Root::Config).into_iter().chain([Root::Folder(folder.to_path_buf())]);
        for root in roots {
            let known = self.projects.len();
            self.add(root);
            self.read_changes();
            if self.project_of(path).is_some() {
                return;
            }
            self.projects.truncate(known);
        }
    }

    /// Closes a document. From then on, its file is read instead of its text.
    pub(super) fn close(&mut self, path: &Path) {
        self.open.remove(path);
        self.uncertain.remove(path);
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

    /// Records that files changed. The configuration file of a workspace folder may have been added or removed.
    pub(super) fn reload(&mut self) {
        let with_project: Vec<PathBuf> =
            self.open.keys().filter(|path| self.project_of(path).is_some()).cloned().collect();
        self.uncertain.extend(with_project);
        let mut removed = Vec::new();
        for (folder, root) in &mut self.folders {
            removed.push(std::mem::replace(root, Root::of_folder(folder)));
        }
        let current: Vec<Root> = self.folders.iter().map(|(_, root)| root.clone()).collect();
        removed.retain(|root| !current.contains(root));
        self.projects.retain(|project| !removed.contains(&project.root));
        self.is_changed |= !removed.is_empty();
        for root in current {
            self.add(root);
        }
        self.projects.iter_mut().for_each(Project::reload);
    }

    /// Reads the definitions that changed. Adds a project for each open document without one. Editors open many documents
    /// together, so each project is read once for all of its documents.
    pub(super) fn refresh(&mut self) {
        self.read_changes();
        let opened = std::mem::take(&mut self.opened);
        let is_alone = |path: &PathBuf| self.open.contains_key(path) && self.project_of(path).is_none();
        let alone: Vec<PathBuf> = opened.into_iter().filter(is_alone).collect();
        if !alone.is_empty() {
            // Read the files again, because the opened files may be new.
            self.reload();
            self.read_changes();
            self.uncertain.extend(alone);
        }
        for path in std::mem::take(&mut self.uncertain) {
            if self.project_of(&path).is_some() {
                continue;
            }
            if self.may_be_configured(&path) {
                self.uncertain.insert(path);
            } else {
                self.add_project_of(&path);
            }
        }
    }

    /// True if the document is in the folder of an unreadable project. The configuration of the project may include the
    /// document.
    fn may_be_configured(&self, path: &Path) -> bool {
        let has_failed = |project: &Project| project.failure().is_some();
        self.projects.iter().any(|project| has_failed(project) && path.starts_with(project.root.folder()))
    }

    fn read_changes(&mut self) {
        for project in &mut self.projects {
            self.is_changed |= project.refresh(&self.open, self.encoding);
        }
    }

    /// True if definitions were read since the last call.
    pub(super) fn take_changed(&mut self) -> bool {
        std::mem::take(&mut self.is_changed)
    }

    /// The text of an open document.
    pub(super) fn text(&self, path: &Path) -> Option<&str> {
        self.open.get(path).map(String::as_str)
    }

    /// The document at a path.
    pub(super) fn document(&self, path: &Path) -> Option<Document<'_>> {
        self.project_of(path)?.snapshot()?.document(path)
    }

    /// The document at a path, in the project that determines its findings.
    pub(super) fn checked_document(&self, path: &Path) -> Option<Document<'_>> {
        self.owner_of(path)?.snapshot()?.document(path)
    }

    /// The project that determines the findings of a file. A project that only refers to the package of the file comes
    /// last.
    pub(super) fn owner_of(&self, path: &Path) -> Option<&Project> {
        self.projects_with(path).min_by_key(|project| (project.is_dependency(path), is_folder(project)))
    }

    /// The project that reads a file. A configuration file takes precedence over a folder without one.
    fn project_of(&self, path: &Path) -> Option<&Project> {
        self.projects_with(path).min_by_key(|project| is_folder(project))
    }

    fn projects_with(&self, path: &Path) -> impl Iterator<Item = &Project> {
        self.projects.iter().filter(move |project| project.contains(path))
    }
}

/// True for a project without a configuration file.
fn is_folder(project: &Project) -> bool {
    matches!(project.root, Root::Folder(_))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    /// Creates a workspace with `count` definitions, and reads them. Also returns the paths and texts of the
    /// definitions.
    fn workspace(folder: &Path, count: usize) -> (Workspace, Vec<(PathBuf, String)>) {
        let files: Vec<(PathBuf, String)> = (0..count)
            .map(|number| (folder.join(format!("Wind{number}.msg")), format!("uint8 wind_{number}\n")))
            .collect();
        for (path, text) in &files {
            fs::write(path, text).expect("a file");
        }
        let mut workspace = Workspace::new(&[folder.to_path_buf()], Encoding::Utf8);
        workspace.refresh();
        assert!(workspace.take_changed());
        (workspace, files)
    }

    #[test]
    fn opening_files_that_were_read_reads_nothing_again() {
        let folder = tempfile::tempdir().expect("a folder");
        let (mut workspace, files) = workspace(folder.path(), 20);
        for (path, text) in files {
            workspace.open(&path, text);
            workspace.refresh();
            assert!(!workspace.take_changed() && workspace.document(&path).is_some());
        }
    }

    /// A mistake in the configuration may be the reason why the configuration doesn't include the file.
    #[test]
    fn a_file_that_was_opened_before_a_mistake_in_the_configuration_has_no_project() {
        for is_read_between in [true, false] {
            let folder = tempfile::tempdir().expect("a folder");
            let (mut workspace, files) = workspace(folder.path(), 1);
            let (path, text) = &files[0];
            workspace.open(path, text.clone());
            if is_read_between {
                workspace.refresh();
            }
            fs::write(folder.path().join("uavspec.toml"), "[").expect("a file");
            workspace.reload();
            workspace.refresh();
            assert!(workspace.document(path).is_none());
            fs::remove_file(folder.path().join("uavspec.toml")).expect("removed");
            workspace.reload();
            workspace.refresh();
            assert!(workspace.document(path).is_some());
        }
    }

    /// Finding the lines again for each reference would take time proportional to the number of references times the
    /// size of the file.
    #[test]
    fn the_lines_of_a_file_are_found_once() {
        let folder = tempfile::tempdir().expect("a folder");
        let (workspace, files) = workspace(folder.path(), 1);
        let allocated = || allocation_counter::measure(|| assert!(workspace.document(&files[0].0).is_some()));
        assert!(allocated().count_total > 0);
        assert_eq!(allocated().count_total, 0);
    }

    #[test]
    fn opening_many_files_reads_their_project_once() {
        for count in [20, 40] {
            let folder = tempfile::tempdir().expect("a folder");
            let (mut workspace, files) = workspace(folder.path(), count);
            for (path, _) in &files {
                workspace.open(path, "uint8 other\n".to_owned());
                workspace.open(&path.with_extension("srv"), "---\n".to_owned());
            }
            assert!(!workspace.take_changed(), "nothing is read before the files are needed");
            workspace.refresh();
            assert!(workspace.take_changed());
            assert_eq!(workspace.projects.len(), 1);
            assert!(files.iter().all(|(path, _)| workspace.document(&path.with_extension("srv")).is_some()));
        }
    }
}
