//! Small definitions that show what a rule means, in its documentation and in its tests.

use std::path::Path;

use crate::msg::{Dialect, Kind};
use crate::read::PackageInput;
use crate::schema::Form;
use crate::source::{SourceId, SourceMap};

/// A definition that shows what a rule means.
#[derive(Clone, Copy, Debug)]
pub struct Example {
    /// Its file name: the extension says what it is. A `.msg` file is of PX4, in a folder of ROS 2; a `.po` file
    /// translates `TRANSLATED`.
    pub path: &'static str,
    /// What it says.
    pub text: &'static str,
}

/// The definition that catalogues in examples translate.
pub(crate) const TRANSLATED: Example = Example {
    path: "Glider.msg",
    text: "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n\
           float32 sink      # [m/s] Sink rate\n",
};

/// Name of the package that examples without a folder belong to.
const PACKAGE: &str = "demo";

/// The packages that `files` make up, paths and texts, which are shown as if they were in `folder`.
pub fn packages<'f>(
    files: impl IntoIterator<Item = (&'f str, &'f str)>,
    folder: &str,
    sources: &mut SourceMap,
) -> Vec<PackageInput> {
    let mut packages: Vec<PackageInput> = Vec::new();
    for (path, text) in files.into_iter().filter(|(path, _)| !is_catalogue(path)) {
        let (name, form) = match path.split_once('/') {
            _ if Kind::of(path).is_none() => ("pages", Form::Table),
            Some((package, _)) => (package, Form::Msg(Dialect::Ros2)),
            None => (PACKAGE, Form::Msg(Dialect::Px4)),
        };
        let Some(id) = add(path, text, folder, sources) else { continue };
        match packages.iter_mut().find(|package| package.name == name) {
            Some(package) => package.sources.push(id),
            None => packages.push(PackageInput::new(name, form, vec![id])),
        }
    }
    packages
}

/// The catalogues among `files`, in the same way.
pub fn catalogues<'f>(
    files: impl IntoIterator<Item = (&'f str, &'f str)>,
    folder: &str,
    sources: &mut SourceMap,
) -> Vec<SourceId> {
    let files = files.into_iter().filter(|(path, _)| is_catalogue(path));
    files.filter_map(|(path, text)| add(path, text, folder, sources)).collect()
}

fn add(path: &str, text: &str, folder: &str, sources: &mut SourceMap) -> Option<SourceId> {
    let shown = if folder.is_empty() { path.to_owned() } else { format!("{folder}/{path}") };
    // Examples are short, and text.
    sources.add(shown, text.as_bytes().to_vec()).ok()
}

/// Whether a file holds translations.
pub fn is_catalogue(path: &str) -> bool {
    Path::new(path).extension().is_some_and(|extension| extension == "po")
}

impl Example {
    /// Path and text.
    pub fn file(&self) -> (&'static str, &'static str) {
        (self.path, self.text)
    }

    /// Path and text, of what it translates too.
    pub fn files(&self) -> Vec<(&'static str, &'static str)> {
        if is_catalogue(self.path) { vec![TRANSLATED.file(), self.file()] } else { vec![self.file()] }
    }
}
