//! Writes new files: all or none.

use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use uavspec_schema::stage::Stage;

use super::files::Files;

/// The files and folders that were created, which are removed if another file can't be written.
#[derive(Debug, Default)]
struct Created {
    /// From the outermost to the innermost.
    folders: Vec<PathBuf>,
    files: Vec<PathBuf>,
}

/// Writes the files. Existing files are never replaced. If this fails, everything that was created is removed.
pub(super) fn write(folder: &Path, files: &Files) -> io::Result<()> {
    let mut created = Created::default();
    let written = created.write(folder, files);
    if written.is_err() {
        created.remove();
    }
    written
}

impl Created {
    fn write(&mut self, folder: &Path, files: &Files) -> io::Result<()> {
        self.create_folder(folder)?;
        let stage = Stage::new(folder)?;
        let mut staged = Vec::new();
        // The whole content is on the disk before the first file appears.
        for (path, text) in files.iter() {
            let mut file = stage.file(None)?;
            file.write_all(text.as_bytes())?;
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

    /// Removes everything. Folders to which others added files are kept.
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

    fn files() -> Files {
        let mut files = Files::default();
        files.add_example();
        files.add_crate();
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
        assert_eq!(names, ["Cargo.toml", "messages", "msg", "uavspec-runtime"]);
        for (path, text) in files().iter() {
            assert_eq!(fs::read_to_string(folder.join(path)).expect("a file"), text);
        }
    }

    #[test]
    fn an_obstacle_leaves_the_folder_unchanged() {
        let folder = tempfile::tempdir().expect("a folder");
        // The last files can't be written.
        fs::create_dir(folder.path().join("uavspec-runtime")).expect("a folder");
        fs::write(folder.path().join("uavspec-runtime/src"), "mine").expect("a file");
        assert!(write(folder.path(), &files()).is_err());
        let left: Vec<PathBuf> = walkdir::WalkDir::new(folder.path())
            .min_depth(1)
            .into_iter()
            .map(|entry| entry.expect("an entry").into_path())
            .collect();
        assert_eq!(left, ["uavspec-runtime", "uavspec-runtime/src"].map(|path| folder.path().join(path)));
        // Nothing is created for a folder that can't be created.
        assert!(write(&folder.path().join("uavspec-runtime/src/below"), &files()).is_err());
    }

    #[test]
    fn a_file_that_appears_meanwhile_is_not_replaced() {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join("Cargo.toml"), "mine").expect("a file");
        assert!(write(folder.path(), &files()).is_err());
        assert_eq!(fs::read_to_string(folder.path().join("Cargo.toml")).expect("a file"), "mine");
        assert!(!folder.path().join("msg").exists());
    }
}
