//! Small definitions that show what a rule means, in its documentation and in its tests.

use crate::PackageInput;
use crate::msg::{Dialect, Kind};
use crate::schema::Form;
use crate::source::SourceMap;

/// A definition that shows what a rule means.
#[derive(Clone, Copy, Debug)]
pub struct Example {
    /// Its file name: the extension says what it is. A `.msg` file is of PX4, in a folder of ROS 2.
    pub path: &'static str,
    /// What it says.
    pub text: &'static str,
}

/// Name of the package that examples without a folder belong to.
const PACKAGE: &str = "demo";

/// The packages that `files` make up, paths and texts, which are shown as if they were in `folder`.
pub fn packages<'f>(
    files: impl IntoIterator<Item = (&'f str, &'f str)>,
    folder: &str,
    sources: &mut SourceMap,
) -> Vec<PackageInput> {
    let mut packages: Vec<PackageInput> = Vec::new();
    for (path, text) in files {
        let (name, form) = match path.split_once('/') {
            _ if Kind::of(path).is_none() => ("pages", Form::Table),
            Some((package, _)) => (package, Form::Msg(Dialect::Ros2)),
            None => (PACKAGE, Form::Msg(Dialect::Px4)),
        };
        let shown = if folder.is_empty() { path.to_owned() } else { format!("{folder}/{path}") };
        // Examples are short, and text.
        let Ok(id) = sources.add(shown, text.as_bytes().to_vec()) else { continue };
        match packages.iter_mut().find(|package| package.name == name) {
            Some(package) => package.sources.push(id),
            None => packages.push(PackageInput::new(name, form, vec![id])),
        }
    }
    packages
}

impl Example {
    /// Path and text.
    pub fn file(&self) -> (&'static str, &'static str) {
        (self.path, self.text)
    }
}
