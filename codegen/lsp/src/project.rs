//! A set of packages that are read together, and their current snapshot.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use uavspec_codegen::load::{Config, Loaded, Plan, lint_settings, load_with_catalogues};
use uavspec_schema::failure::Failure;
use uavspec_schema::source::SourceId;

use super::discovery;
use super::lines::Encoding;
use super::snapshot::Snapshot;

/// The packages of a configuration file, or of a folder without one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Root {
    Config(PathBuf),
    Folder(PathBuf),
}

impl Root {
    /// The root of a folder: its configuration file, if it has one.
    pub(super) fn of_folder(folder: &Path) -> Self {
        Config::in_folder(folder).map_or_else(|| Self::Folder(folder.to_path_buf()), Self::Config)
    }

    /// The folder that contains the definitions.
    pub(super) fn folder(&self) -> &Path {
        match self {
            Self::Config(file) => file.parent().unwrap_or(Path::new("")),
            Self::Folder(folder) => folder,
        }
    }

    fn plan(&self, open: &BTreeMap<PathBuf, String>) -> Result<Plan, Failure> {
        let mut plan = match self {
            Self::Config(file) => match open.get(file) {
                Some(text) => Config::parse(file, text.clone())?.plan()?,
                None => Config::read(file)?.plan()?,
            },
            Self::Folder(folder) => discovery::plan(folder, open),
        };
        plan.open.clone_from(open);
        Ok(plan)
    }
}

/// The changes since the last snapshot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Change {
    None,
    /// The text of open documents.
    Texts,
    /// The set of files, or the content of files that aren't open.
    Files,
}

/// A project.
pub(super) struct Project {
    pub(super) root: Root,
    change: Change,
    plan: Plan,
    /// The packages that were searched since files last changed, because edits refer to them. Some don't exist.
    searched: BTreeSet<String>,
    snapshot: Option<Snapshot>,
    /// The reason why the definitions can't be read.
    failure: Option<Failure>,
}

impl Project {
    pub(super) fn new(root: Root) -> Self {
        let plan = Plan::of_packages(Vec::new());
        Self { root, change: Change::Files, plan, searched: BTreeSet::new(), snapshot: None, failure: None }
    }

    /// The snapshot, unless the definitions can't be read.
    pub(super) fn snapshot(&self) -> Option<&Snapshot> {
        self.snapshot.as_ref()
    }

    /// The reason why the definitions can't be read.
    pub(super) fn failure(&self) -> Option<&Failure> {
        self.failure.as_ref()
    }

    /// True if the project reads this file.
    pub(super) fn contains(&self, path: &Path) -> bool {
        matches!(&self.root, Root::Config(file) if file == path)
            || self.snapshot.as_ref().is_some_and(|snapshot| snapshot.contains(path))
    }

    /// True if the project reads this file only because its packages refer to the package of the file.
    pub(super) fn is_dependency(&self, path: &Path) -> bool {
        self.snapshot.as_ref().is_some_and(|snapshot| snapshot.is_dependency(path))
    }

    /// Records the new text of an open document.
    pub(super) fn edit(&mut self, path: &Path, text: &str) {
        let read = self.snapshot.as_ref().and_then(|snapshot| snapshot.text(path));
        // Ignore an opened file whose text the project has already read.
        if read == Some(text) && self.change == Change::None {
            return;
        }
        let is_read = read.is_some();
        let change = match &self.root {
            Root::Config(file) if file == path => Change::Files,
            // The set of files changes, because a page without definitions is not part of the project.
            Root::Folder(folder) if is_read != discovery::is_read(folder, path, text) => Change::Files,
            _ if is_read => Change::Texts,
            _ => Change::None,
        };
        self.change = self.change.max(change);
    }

    /// Records that files changed.
    pub(super) fn reload(&mut self) {
        self.change = Change::Files;
    }

    /// Reads the definitions again if they changed. Returns true if they were read.
    pub(super) fn refresh(&mut self, open: &BTreeMap<PathBuf, String>, encoding: Encoding) -> bool {
        let known = match std::mem::replace(&mut self.change, Change::None) {
            Change::None => return false,
            Change::Texts => self.snapshot.take().and_then(|snapshot| self.edited(snapshot.loaded, open)),
            Change::Files => {
                self.searched.clear();
                None
            }
        };
        let loaded = match known {
            Some(loaded) => Ok(loaded),
            None => self.load(open),
        };
        let is_whole = matches!(self.root, Root::Config(_));
        match loaded {
            Ok(loaded) => {
                let settings = lint_settings(&self.plan, &loaded);
                self.snapshot = Some(Snapshot::new(loaded, &settings, is_whole, encoding));
                self.failure = None;
            }
            Err(failure) => (self.snapshot, self.failure) = (None, Some(failure)),
        }
        true
    }

    /// The definitions with the new texts of open documents. `None` if files must be read again, because an edit refers to
    /// another package or makes a file readable or unreadable.
    fn edited(&mut self, mut loaded: Loaded, open: &BTreeMap<PathBuf, String>) -> Option<Loaded> {
        let texts = changed(&loaded, open);
        let before = unreadable(&loaded);
        loaded.set_texts(&texts);
        let known = self.searched.len();
        self.searched.append(&mut loaded.missing_packages(|id| texts.contains_key(&id)));
        (unreadable(&loaded) == before && self.searched.len() == known).then_some(loaded)
    }

    fn load(&mut self, open: &BTreeMap<PathBuf, String>) -> Result<Loaded, Failure> {
        self.plan = self.root.plan(open)?;
        load_with_catalogues(&self.plan)
    }
}

/// The sources that can't be read.
fn unreadable(loaded: &Loaded) -> BTreeSet<SourceId> {
    loaded.diagnostics.iter().map(|diagnostic| loaded.sources.source_of(diagnostic.span)).collect()
}

/// The texts of open documents that differ from the loaded texts.
fn changed(loaded: &Loaded, open: &BTreeMap<PathBuf, String>) -> BTreeMap<SourceId, String> {
    let texts = loaded.paths.iter().filter_map(|(id, path)| Some((*id, open.get(path)?)));
    texts
        .filter(|(id, text)| loaded.sources.text(*id) != *text)
        .map(|(id, text)| (id, text.clone()))
        .collect()
}
