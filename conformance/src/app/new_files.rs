//! Writes new files: either all of them or none.

use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use uavspec_model::text::terminal;
use uavspec_schema::Failure;
use uavspec_schema::stage::Stage;

/// Files that don't exist yet, with their content, in the order of output. The paths are relative to a folder.
#[derive(Debug, Default)]
pub(super) struct NewFiles {
    pub(super) files: Vec<(PathBuf, Vec<u8>)>,
    /// A folder that must not exist yet. `None` if there is no such folder.
    pub(super) new_folder: Option<&'static str>,
}

impl NewFiles {
    /// The paths, relative to the folder.
    pub(super) fn paths(&self) -> impl Iterator<Item = &Path> {
        self.files.iter().map(|(path, _)| path.as_path())
    }

    /// Adds a file.
    pub(super) fn add(&mut self, path: impl Into<PathBuf>, content: impl Into<Vec<u8>>) {
        self.files.push((path.into(), content.into()));
    }

    /// Writes the files to a folder, which is created if necessary. Existing files are never replaced. If this fails,
    /// everything that was created is removed.
    pub(super) fn write(&self, folder: &Path) -> Result<(), Failure> {
        self.check_absent(folder)?;
        write(folder, self).map_err(|error| {
            Failure::new(format!("{}: {error}; nothing was written", terminal::path(folder)))
                .with_hint("check that the folder is writable")
        })
    }

    /// Fails if any of these already exists: one of the files, a file with the name of a required folder, or the new
    /// folder. The error lists all of them.
    fn check_absent(&self, folder: &Path) -> Result<(), Failure> {
        let obstacle = |file: &Path| {
            let mut parents = file.ancestors().skip(1).filter(|parent| !parent.as_os_str().is_empty());
            let parent = parents.find(|parent| {
                let path = folder.join(parent);
                path.exists() && (self.new_folder.map(Path::new) == Some(*parent) || !path.is_dir())
            });
            let exists = fs::symlink_metadata(folder.join(file)).is_ok();
            parent.or(exists.then_some(file)).map(|path| shown(folder, path))
        };
        let mut existing: Vec<String> = self.paths().filter_map(obstacle).collect();
        existing.dedup();
        if existing.is_empty() {
            return Ok(());
        }
        let message = format!("nothing was written, because these files exist:\n  {}", existing.join("\n  "));
        Err(Failure::new(message).with_hint("choose another folder, or move the files"))
    }
}

/// The path of a file in a folder, in the form that is displayed.
pub(super) fn shown(folder: &Path, path: &Path) -> String {
    terminal::path(folder.strip_prefix(".").unwrap_or(folder).join(path))
}

/// The files and folders that have been created. They are removed if another file can't be written.
#[derive(Debug, Default)]
struct Created {
    /// The created folders, from the outermost to the innermost.
    folders: Vec<PathBuf>,
    files: Vec<PathBuf>,
}

fn write(folder: &Path, files: &NewFiles) -> io::Result<()> {
    let mut created = Created::default();
    let written = created.write(folder, files);
    if written.is_err() {
        created.remove();
    }
    written
}

impl Created {
    fn write(&mut self, folder: &Path, files: &NewFiles) -> io::Result<()> {
        self.create_folder(folder)?;
        let stage = Stage::new(folder)?;
        let mut staged = Vec::new();
        // The complete content is on the disk before the first file appears.
        for (path, content) in &files.files {
            let mut file = stage.file(None)?;
            file.write_all(content)?;
            staged.push((file.into_temp_path(), folder.join(path)));
        }
        for (file, path) in staged {
            self.create_folder(path.parent().unwrap_or(folder))?;
            file.persist_noclobber(&path)?;
            self.files.push(path);
        }
        Ok(())
    }

    /// Creates a folder and its parents.
    fn create_folder(&mut self, folder: &Path) -> io::Result<()> {
        let missing: Vec<&Path> = folder
            .ancestors()
            .take_while(|ancestor| !ancestor.as_os_str().is_empty() && !ancestor.is_dir())
            .collect();
        for folder in missing.into_iter().rev() {
            fs::create_dir(folder)?;
            self.folders.push(folder.to_path_buf());
        }
        Ok(())
    }

    /// Removes everything that was created. Folders that contain other files are kept.
    fn remove(&self) {
        for file in &self.files {
            let _ = fs::remove_file(file);
        }
        for folder in self.folders.iter().rev() {
            let _ = fs::remove_dir(folder);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files() -> NewFiles {
        let mut files = NewFiles::default();
        files.add("Cargo.toml", "a");
        files.add("messages/Cargo.toml", "b");
        files.add("runtime/src/lib.rs", [0xff]);
        files
    }

    #[test]
    fn creates_folders_and_leaves_no_temporary_files() {
        let parent = tempfile::tempdir().expect("a folder");
        let folder = parent.path().join("a/b");
        write(&folder, &files()).expect("written");
        let mut names: Vec<_> = fs::read_dir(&folder)
            .expect("a folder")
            .map(|entry| entry.expect("an entry").file_name())
            .collect();
        names.sort();
        assert_eq!(names, ["Cargo.toml", "messages", "runtime"]);
        for (path, content) in files().files {
            assert_eq!(fs::read(folder.join(path)).expect("a file"), content);
        }
    }

    #[test]
    fn an_obstacle_leaves_the_folder_unchanged() {
        let folder = tempfile::tempdir().expect("a folder");
        // The last files can't be written.
        fs::create_dir(folder.path().join("runtime")).expect("a folder");
        fs::write(folder.path().join("runtime/src"), "mine").expect("a file");
        assert!(write(folder.path(), &files()).is_err());
        let left: Vec<PathBuf> = walkdir::WalkDir::new(folder.path())
            .min_depth(1)
            .into_iter()
            .map(|entry| entry.expect("an entry").into_path())
            .collect();
        assert_eq!(left, ["runtime", "runtime/src"].map(|path| folder.path().join(path)));
        // If a folder can't be created, nothing is created.
        assert!(write(&folder.path().join("runtime/src/below"), &files()).is_err());
    }

    #[test]
    fn a_file_that_appears_meanwhile_is_not_replaced() {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join("Cargo.toml"), "mine").expect("a file");
        assert!(write(folder.path(), &files()).is_err());
        assert_eq!(fs::read_to_string(folder.path().join("Cargo.toml")).expect("a file"), "mine");
        assert!(!folder.path().join("messages").exists());
    }
}
