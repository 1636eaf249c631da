//! The inputs of a run: files, folders, patterns and the URLs of object stores.

use std::path::{Path, PathBuf};

use uavspec_capture::input::{self, Files, Input, Listed};
use uavspec_capture::names::NOT_A_CAPTURE;
use uavspec_model::text::{is_object_url, shown_url, terminal};
use uavspec_report::{Origin, Unreadable};

use super::tables::Done;
use super::{Status, stores};

/// The help for a URL that can't be listed.
const CREDENTIALS: &str = "credentials come from the environment, such as AWS_ACCESS_KEY_ID";

/// The captures that a user names.
#[derive(Default)]
pub(super) struct Found {
    pub(super) captures: Vec<Input>,
    /// The inputs that can't be read, and the inputs without captures.
    pub(super) unreadable: Vec<Unreadable>,
    /// The other files in folders, which aren't checked.
    pub(super) skipped: Vec<Unreadable>,
    /// The folders and patterns that contain no captures.
    empty: Vec<Unreadable>,
}

impl Found {
    /// Finds the captures, in the order of the inputs. Prints errors.
    pub(super) fn new(inputs: &[PathBuf]) -> Result<Self, Status> {
        let mut found = Self::default();
        for input in inputs {
            match input.to_str().filter(|text| is_object_url(text)) {
                Some(url) => found.add_url(url)?,
                None => found.add_path(input)?,
            }
        }
        // If there are no captures at all, empty folders aren't failures. The outcome then says that nothing was
        // checked.
        if !found.captures.is_empty() {
            found.unreadable.append(&mut found.empty);
        }
        Ok(found)
    }

    /// Skips the captures that are done, and prints the numbers of captures. Returns true if no captures remain.
    pub(super) fn skip(&mut self, done: &Done) -> bool {
        let before = self.captures.len();
        self.captures.retain(|input| !done.contains(&input.name(), &Origin::of(input)));
        let (left, skipped) = (self.captures.len(), before - self.captures.len());
        terminal::eprintln!("{skipped} of {before} captures are in the tables already; {left} to check");
        left == 0 && skipped > 0
    }

    fn add_path(&mut self, path: &Path) -> Result<(), Status> {
        let files = input::files(&[path.to_owned()]).map_err(|(path, error)| {
            Status::Usage.because(format_args!("{}: {error}", terminal::path(&path)))
        })?;
        let Files { captures, skipped, unreadable, empty } = files;
        for (path, reason) in unreadable.iter().chain(&empty) {
            terminal::error(format_args!("{}: {reason}", terminal::path(path)), None);
        }
        let file = |path: PathBuf, reason: &str| Unreadable {
            path: path.to_string_lossy().into_owned(),
            message: reason.to_owned(),
        };
        self.captures.extend(captures.into_iter().map(Input::Path));
        self.skipped.extend(skipped.into_iter().map(|(path, reason)| file(path, reason)));
        self.unreadable.extend(unreadable.into_iter().map(|(path, reason)| file(path, &reason)));
        self.empty.extend(empty.into_iter().map(|(path, reason)| file(path, &reason)));
        Ok(())
    }

    /// Adds the objects that a URL denotes.
    fn add_url(&mut self, url: &str) -> Result<(), Status> {
        let shown = shown_url(url);
        let Listed { captures, skipped } = stores::list(url).map_err(|problem| {
            let (help, status) = if cfg!(feature = "stores") {
                (Some(CREDENTIALS), Status::Unreadable)
            } else {
                (None, Status::Usage)
            };
            terminal::error(format_args!("{}: {problem}", terminal::shown(&shown)), help);
            status
        })?;
        if captures.is_empty() {
            let file = Unreadable { path: shown, message: Listed::NOTHING.to_owned() };
            terminal::error(format_args!("{}: {}", terminal::shown(&file.path), file.message), None);
            self.empty.push(file);
        }
        self.captures.extend(captures);
        self.skipped
            .extend(skipped.into_iter().map(|path| Unreadable { path, message: NOT_A_CAPTURE.to_owned() }));
        Ok(())
    }
}
