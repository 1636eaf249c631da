//! Temporary folders next to the files of a user. They never outlive their run for long.
//!
//! Each folder contains a locked file. The operating system releases the lock if the run is killed, so the next run can
//! tell an abandoned folder from one in use.
//!
//! ```
//! use uavspec_codegen::stage::Stage;
//!
//! let folder = tempfile::tempdir()?;
//! let stage = Stage::new(folder.path())?;
//! std::fs::write(stage.path().join("new"), "text")?;
//! std::fs::rename(stage.path().join("new"), folder.path().join("Wind.msg"))?;
//! drop(stage);
//! assert_eq!(std::fs::read_dir(folder.path())?.count(), 1);
//! # Ok::<(), std::io::Error>(())
//! ```

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

use fs4::{FileExt, TryLockError};
use same_file::Handle;

use crate::terminal;

/// The start of the names of temporary folders.
const PREFIX: &str = ".uavspec-";

/// The name of the temporary folder that only one run uses at a time.
const EXCLUSIVE: &str = ".uavspec-stage";

/// The name of the locked file in a temporary folder. No other file in the folder has this name.
const LOCK: &str = ".lock";

/// The maximum number of attempts to create a temporary folder while other runs remove theirs.
const MAX_ATTEMPTS: usize = 1_000;

/// A temporary folder, removed when it is dropped.
#[derive(Debug)]
pub struct Stage {
    path: PathBuf,
    /// The open file holds the lock.
    _lock: File,
}

impl Stage {
    /// Creates a temporary folder in `folder`, and removes abandoned ones.
    pub fn new(folder: &Path) -> io::Result<Self> {
        remove_abandoned(folder);
        for _ in 0..MAX_ATTEMPTS {
            let path = tempfile::Builder::new().prefix(PREFIX).tempdir_in(folder)?.keep();
            if let Some(stage) = Self::claim(path)? {
                return Ok(stage);
            }
        }
        Err(contended(folder))
    }

    /// Like [`Self::new`], but waits until no other run has an exclusive temporary folder in `folder`.
    pub(crate) fn exclusive(folder: &Path) -> io::Result<Self> {
        for _ in 0..MAX_ATTEMPTS {
            let path = folder.join(EXCLUSIVE);
            match fs::create_dir(&path) {
                Err(error) if error.kind() != ErrorKind::AlreadyExists => return Err(error),
                _ => {}
            }
            if let Some(stage) = Self::claim(path)? {
                remove_files(&stage.path);
                remove_abandoned(folder);
                return Ok(stage);
            }
        }
        Err(contended(folder))
    }

    /// The temporary folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Locks an existing folder, after waiting for its current owner. `None` if the folder was removed meanwhile.
    fn claim(path: PathBuf) -> io::Result<Option<Self>> {
        // A link could lead to any other folder.
        if !fs::symlink_metadata(&path).map_or(true, |metadata| metadata.is_dir()) {
            return Err(io::Error::other(format!("{} is not a folder", terminal::path(path))));
        }
        let Some(lock) = open_lock(&path)? else { return Ok(None) };
        match FileExt::lock(&lock) {
            // Without locks, runs can't wait for each other.
            Err(error) if error.kind() != ErrorKind::Unsupported => return Err(error),
            _ => {}
        }
        // A stage of a removed folder is never created: dropping it would remove the folder of the next owner.
        Ok(is_current(&lock, &path).then(|| Self { path, _lock: lock }))
    }
}

/// The folder that contains a file.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Replaces a file in one step. `fill` writes the new file to the path that it receives.
pub fn replace<T, E: From<io::Error>>(path: &Path, fill: impl FnOnce(&Path) -> Result<T, E>) -> Result<T, E> {
    let stage = Stage::new(folder_of(path))?;
    let staged = stage.path().join("file");
    let result = fill(&staged)?;
    fs::rename(staged, path)?;
    Ok(result)
}

/// Writes a file in one step. If this fails, an existing file stays unchanged.
pub fn write_file<T, E: From<io::Error>>(
    path: &Path,
    content: impl FnOnce(&mut Box<dyn Write>) -> Result<T, E>,
) -> Result<T, E> {
    let fill = |file: File| {
        let mut file: Box<dyn Write> = Box::new(BufWriter::new(file));
        let result = content(&mut file)?;
        file.flush()?;
        Ok(result)
    };
    // A pipe or a terminal can't be replaced. If the path is a link, the link's target is replaced. A pipe may have no
    // real path, and the target of a link may be absent.
    let path = match fs::metadata(path) {
        Ok(metadata) if metadata.is_file() => fs::canonicalize(path)?,
        Err(_) if !path.is_symlink() => path.to_path_buf(),
        _ => return fill(File::create(path)?),
    };
    // A new file in a temporary folder has default permissions. A temporary file would be private.
    replace(&path, |staged| fill(File::create(staged)?))
}

impl Drop for Stage {
    fn drop(&mut self) {
        remove(&self.path);
    }
}

/// True if `folder` contains the temporary folder of a run that was killed or hasn't ended.
pub(crate) fn is_any_in(folder: &Path) -> bool {
    entries(folder).is_ok_and(|mut entries| entries.next().is_some())
}

/// Opens the lock file in a temporary folder. `None` if the folder was removed meanwhile.
fn open_lock(path: &Path) -> io::Result<Option<File>> {
    let lock = path.join(LOCK);
    // Creating a new file never follows a link.
    let opened = match OpenOptions::new().write(true).create_new(true).open(&lock) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => existing_lock(path),
        opened => opened,
    };
    match opened {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        opened => opened.map(Some),
    }
}

fn existing_lock(path: &Path) -> io::Result<File> {
    let lock = path.join(LOCK);
    if fs::symlink_metadata(&lock)?.is_file() {
        return OpenOptions::new().write(true).open(lock);
    }
    Err(io::Error::other(format!("{} is not a file", terminal::path(lock))))
}

/// True if an open lock file is still the one in the folder.
fn is_current(lock: &File, path: &Path) -> bool {
    let open = lock.try_clone().and_then(Handle::from_file);
    let named = Handle::from_path(path.join(LOCK));
    open.is_ok_and(|open| named.is_ok_and(|named| open == named))
}

/// The temporary folders in a folder.
fn entries(folder: &Path) -> io::Result<impl Iterator<Item = PathBuf>> {
    let is_stage = |entry: &fs::DirEntry| {
        let name = entry.file_name();
        name.to_string_lossy().starts_with(PREFIX) && entry.file_type().is_ok_and(|kind| kind.is_dir())
    };
    Ok(fs::read_dir(folder)?.filter_map(Result::ok).filter(is_stage).map(|entry| entry.path()))
}

/// Removes the temporary folders of runs that were killed. A folder may be writable but not readable; then nothing is
/// removed.
fn remove_abandoned(folder: &Path) {
    for path in entries(folder).into_iter().flatten() {
        match existing_lock(&path) {
            Ok(lock) => match FileExt::try_lock(&lock) {
                Ok(()) if is_current(&lock, &path) => remove(&path),
                Ok(()) | Err(TryLockError::WouldBlock | TryLockError::Error(_)) => {}
            },
            // Only an empty folder is removed. Its owner notices, and creates another one.
            Err(_) => drop(fs::remove_dir(&path)),
        }
    }
}

/// Removes a temporary folder. The lock file is the last file, so a folder without one is empty. Files that can't be
/// removed are left to the next run.
fn remove(path: &Path) {
    remove_files(path);
    let _ = fs::remove_file(path.join(LOCK));
    let _ = fs::remove_dir(path);
}

/// Removes all files in a temporary folder except the lock file.
fn remove_files(path: &Path) {
    for entry in fs::read_dir(path).into_iter().flatten().filter_map(Result::ok) {
        if entry.file_name() != LOCK {
            let _ = fs::remove_file(entry.path());
        }
    }
}

fn contended(folder: &Path) -> io::Error {
    io::Error::other(format!("other runs keep removing temporary folders in {}", terminal::path(folder)))
}

#[cfg(test)]
mod tests {
    use std::thread;

    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let names = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").file_name());
        let mut names: Vec<String> = names.map(|name| name.to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// Runs a function 50 times in each of four threads.
    fn in_many_runs(run: impl Fn() + Sync) {
        thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| (0..50).for_each(|_| run()));
            }
        });
    }

    /// Creates the temporary folder of a killed run.
    fn abandon(folder: &Path, name: &str) {
        fs::create_dir(folder.join(name)).expect("a folder");
        fs::write(folder.join(name).join(LOCK), "").expect("a file");
        fs::write(folder.join(name).join("0"), "text").expect("a file");
    }

    #[test]
    fn removes_the_folders_of_killed_runs_and_no_others() {
        let folder = tempfile::tempdir().expect("a folder");
        let used = Stage::new(folder.path()).expect("a stage");
        let used_name = used.path().file_name().expect("a name").to_string_lossy().into_owned();
        fs::write(used.path().join("0"), "text").expect("a file");
        abandon(folder.path(), ".uavspec-dead");
        abandon(folder.path(), EXCLUSIVE);
        fs::create_dir(folder.path().join(".uavspec-empty")).expect("a folder");
        fs::create_dir(folder.path().join(".uavspec-mine")).expect("a folder");
        fs::write(folder.path().join(".uavspec-mine/notes"), "mine").expect("a file");
        fs::write(folder.path().join(".uavspec-manifest"), "a file").expect("a file");
        drop(Stage::new(folder.path()).expect("a stage"));
        let mut kept = [".uavspec-manifest".to_owned(), ".uavspec-mine".to_owned(), used_name];
        kept.sort();
        assert_eq!(names(folder.path()), kept);
        assert_eq!(fs::read(used.path().join("0")).expect("a file"), b"text");
        drop(used);
        assert_eq!(names(folder.path()), [".uavspec-manifest", ".uavspec-mine"]);
    }

    #[test]
    fn an_exclusive_folder_takes_over_from_a_killed_run() {
        let folder = tempfile::tempdir().expect("a folder");
        abandon(folder.path(), EXCLUSIVE);
        abandon(folder.path(), ".uavspec-dead");
        let stage = Stage::exclusive(folder.path()).expect("a stage");
        assert_eq!(names(folder.path()), [EXCLUSIVE]);
        assert_eq!(names(stage.path()), [LOCK]);
        drop(stage);
        assert_eq!(names(folder.path()), Vec::<String>::new());
    }

    #[test]
    fn only_one_run_has_the_exclusive_folder() {
        let folder = tempfile::tempdir().expect("a folder");
        in_many_runs(|| {
            let stage = Stage::exclusive(folder.path()).expect("a stage");
            let file = stage.path().join("0");
            let new = OpenOptions::new().write(true).create_new(true).open(&file);
            assert!(new.is_ok(), "another thread has the folder");
            thread::yield_now();
            fs::remove_file(&file).expect("no other thread removed the file");
        });
        assert_eq!(names(folder.path()), Vec::<String>::new());
    }

    #[test]
    fn runs_do_not_remove_the_folders_of_others_while_they_create_them() {
        let folder = tempfile::tempdir().expect("a folder");
        in_many_runs(|| {
            let stage = Stage::new(folder.path()).expect("a stage");
            fs::write(stage.path().join("0"), "text").expect("the folder exists");
        });
        assert_eq!(names(folder.path()), Vec::<String>::new());
    }

    #[cfg(unix)]
    #[test]
    fn follows_no_links() {
        use std::os::unix::fs::symlink;

        let (folder, other) =
            (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
        abandon(other.path(), "stage");
        symlink(other.path().join("stage"), folder.path().join(EXCLUSIVE)).expect("a link");
        symlink(other.path().join("stage"), folder.path().join(".uavspec-dead")).expect("a link");
        let error = Stage::exclusive(folder.path()).expect_err("a link");
        assert!(error.to_string().contains("is not a folder"), "{error}");
        drop(Stage::new(folder.path()).expect("a stage"));
        fs::remove_file(folder.path().join(EXCLUSIVE)).expect("a link");
        fs::create_dir(folder.path().join(EXCLUSIVE)).expect("a folder");
        symlink(other.path().join("absent"), folder.path().join(EXCLUSIVE).join(LOCK)).expect("a link");
        assert!(Stage::exclusive(folder.path()).is_err());
        assert_eq!(names(&other.path().join("stage")), [LOCK, "0"]);
        assert_eq!(names(other.path()), ["stage"]);
    }
}
