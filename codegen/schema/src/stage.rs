//! Temporary folders next to the files of a user. Later runs remove the folders of killed runs.
//!
//! Each folder contains a locked file. The operating system releases the lock if the run is killed, so the next run can
//! distinguish an abandoned folder from a folder in use. The file's content and the folder's owner show that the folder
//! belongs to this program and this user.
//!
//! Other users may be able to write to the output folder. The temporary folders are therefore private, and new files
//! never replace existing files or follow links.
//!
//! ```
//! use uavspec_schema::stage::Stage;
//!
//! let folder = tempfile::tempdir()?;
//! let stage = Stage::new(folder.path())?;
//! let mut file = stage.file(None)?;
//! std::io::Write::write_all(&mut file, b"text")?;
//! file.persist(folder.path().join("Wind.msg"))?;
//! drop(stage);
//! assert_eq!(std::fs::read_dir(folder.path())?.count(), 1);
//! # Ok::<(), std::io::Error>(())
//! ```

use std::fs::{self, File, Metadata, OpenOptions, Permissions};
use std::io::{self, BufWriter, ErrorKind, Read as _, Seek as _, Write};
use std::path::{Path, PathBuf};

use fs4::{FileExt, TryLockError};
use same_file::Handle;
use tempfile::NamedTempFile;

use crate::terminal;

/// The start of the names of temporary folders.
const PREFIX: &str = ".uavspec-";

/// The name of the temporary folder that only one run uses at a time.
const EXCLUSIVE: &str = ".uavspec-stage";

/// The name of the locked file in a temporary folder. No other file in the folder has this name.
const LOCK: &str = ".lock";

/// The content of the locked file.
const MARK: &str = "This temporary folder of uavspec is removed when the run ends.\n";

/// The permissions of a temporary folder.
#[cfg(unix)]
const PRIVATE: u32 = 0o700;

/// The permissions of a new file, which the user's mask restricts.
#[cfg(unix)]
const DEFAULT: u32 = 0o666;

/// The maximum number of attempts to create a temporary folder while other runs remove their folders.
const MAX_ATTEMPTS: usize = 1_000;

/// A temporary folder, removed when it is dropped.
#[derive(Debug)]
pub struct Stage {
    path: PathBuf,
    /// The open file holds the lock.
    _lock: File,
}

impl Stage {
    /// Creates a temporary folder in `folder`, and removes abandoned folders.
    pub fn new(folder: &Path) -> io::Result<Self> {
        let path = private(PREFIX).tempdir_in(folder)?.keep();
        let lock = OpenOptions::new().read(true).write(true).create_new(true).open(path.join(LOCK))?;
        wait_for(&lock)?;
        let stage = Self::mark(path, lock)?;
        stage.remove_abandoned(folder);
        Ok(stage)
    }

    /// Like [`Self::new`], but waits until no other run has an exclusive temporary folder in `folder`.
    pub fn exclusive(folder: &Path) -> io::Result<Self> {
        Self::exclusive_with(folder, wait_for)
    }

    /// Like [`Self::new`], but fails if another run has an exclusive temporary folder in `folder`.
    ///
    /// # Errors
    /// Also fails if the folder isn't writable.
    pub fn claim(folder: &Path) -> io::Result<Self> {
        Self::exclusive_with(folder, |lock| match FileExt::try_lock(lock) {
            Ok(()) => Ok(()),
            Err(TryLockError::WouldBlock) => {
                Err(io::Error::new(ErrorKind::ResourceBusy, "another run is writing to this folder"))
            }
            Err(TryLockError::Error(error)) => unless_unsupported(error),
        })
    }

    fn exclusive_with(folder: &Path, lock: fn(&File) -> io::Result<()>) -> io::Result<Self> {
        let user = owner(&tempfile::tempfile_in(folder)?.metadata()?);
        for _ in 0..MAX_ATTEMPTS {
            let path = match private(EXCLUSIVE).rand_bytes(0).tempdir_in(folder) {
                Ok(created) => created.keep(),
                Err(error) if error.kind() == ErrorKind::AlreadyExists => folder.join(EXCLUSIVE),
                Err(error) => return Err(error),
            };
            if let Some(stage) = Self::take_over(path, user, lock)? {
                remove_files(&stage.path);
                stage.remove_abandoned(folder);
                return Ok(stage);
            }
        }
        Err(io::Error::other(format!(
            "other runs keep removing temporary folders in {}",
            terminal::path(folder)
        )))
    }

    /// The temporary folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Creates a file with a random name in the temporary folder. The file has the given permissions, or the default
    /// permissions.
    ///
    /// # Errors
    /// Fails if the file can't be created.
    pub fn file(&self, permissions: Option<Permissions>) -> io::Result<NamedTempFile> {
        let mut builder = tempfile::Builder::new();
        #[cfg(unix)]
        if permissions.is_none() {
            builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(DEFAULT));
        }
        let file = builder.prefix("").tempfile_in(&self.path)?;
        if let Some(permissions) = permissions {
            file.as_file().set_permissions(permissions)?;
        }
        Ok(file)
    }

    /// Locks an existing folder. `None` if the folder was removed in the meantime. Fails if it isn't a temporary folder
    /// of this user.
    fn take_over(path: PathBuf, user: u32, lock: fn(&File) -> io::Result<()>) -> io::Result<Option<Self>> {
        // Don't follow a link, which could lead to any other folder.
        match fs::symlink_metadata(&path) {
            Ok(metadata) if !metadata.is_dir() => return Err(foreign(&path, "is not a folder")),
            Ok(metadata) if owner(&metadata) != user => {
                return Err(foreign(&path, "belongs to another user"));
            }
            _ => {}
        }
        let Some(mut file) = open_lock(&path)? else { return Ok(None) };
        lock(&file)?;
        // A stage for a removed folder must never be created: dropping the stage would remove the folder of the next
        // owner.
        if !is_current(&file, &path) {
            return Ok(None);
        }
        // A run that was killed early leaves no mark, but no other files either.
        if !is_marked(&mut file) && files(&path).next().is_some() {
            return Err(foreign(&path, "is not a temporary folder of uavspec"));
        }
        Self::mark(path, file).map(Some)
    }

    /// Marks a folder that this run has locked.
    fn mark(path: PathBuf, mut lock: File) -> io::Result<Self> {
        lock.rewind()?;
        lock.set_len(0)?;
        lock.write_all(MARK.as_bytes())?;
        Ok(Self { path, _lock: lock })
    }

    /// Removes the temporary folders that killed runs of this user left behind. If `folder` is writable but not
    /// readable, removes nothing.
    fn remove_abandoned(&self, folder: &Path) {
        let Ok(user) = fs::symlink_metadata(&self.path).map(|metadata| owner(&metadata)) else { return };
        for path in entries(folder).into_iter().flatten().filter(|path| *path != self.path) {
            let is_own = fs::symlink_metadata(&path).is_ok_and(|metadata| owner(&metadata) == user);
            if is_own
                && let Ok(mut lock) = existing_lock(&path)
                && FileExt::try_lock(&lock).is_ok()
                && is_current(&lock, &path)
                && is_marked(&mut lock)
            {
                remove(&path);
            }
        }
    }
}

/// Creates folders that only this user may read, with names that start with `prefix`.
fn private(prefix: &str) -> tempfile::Builder<'_, '_> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(prefix);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(PRIVATE));
    builder
}

/// The folder that contains a file.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
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
    match replaceable(path)? {
        Some(path) => replace(&path, |staged| fill(staged.as_file().try_clone()?)),
        None => fill(File::create(path)?),
    }
}

/// Like [`write_file`], for content that isn't written from start to end: `content` gets the path of an empty file.
///
/// # Errors
/// Also fails if the path is a pipe or a device.
pub fn write_at<T, E: From<io::Error>>(
    path: &Path,
    content: impl FnOnce(&Path) -> Result<T, E>,
) -> Result<T, E> {
    let unusual = || io::Error::new(ErrorKind::InvalidInput, "it is not an ordinary file");
    replace(&replaceable(path)?.ok_or_else(unusual)?, |staged| content(staged.path()))
}

/// The path of the file that a new file replaces: the target of a link, or the path itself. `None` if the path can't be
/// replaced, because it is a pipe or a terminal. A pipe may have no real path, and the target of a link may be absent.
fn replaceable(path: &Path) -> io::Result<Option<PathBuf>> {
    match fs::metadata(path) {
        Ok(metadata) if metadata.is_file() => fs::canonicalize(path).map(Some),
        Err(_) if !path.is_symlink() => Ok(Some(path.to_path_buf())),
        _ => Ok(None),
    }
}

/// Creates a folder in one step. `content` fills a temporary folder.
///
/// # Errors
/// Also fails if the path exists.
pub fn write_folder<T, E: From<io::Error>>(
    path: &Path,
    content: impl FnOnce(&Path) -> Result<T, E>,
) -> Result<T, E> {
    if fs::symlink_metadata(path).is_ok() {
        return Err(io::Error::new(ErrorKind::AlreadyExists, "it already exists").into());
    }
    let stage = Stage::new(folder_of(path))?;
    let staged = stage.path().join("content");
    fs::create_dir(&staged)?;
    let result = content(&staged)?;
    // Replacing an empty folder that appeared meanwhile would be harmless.
    fs::rename(&staged, path)?;
    Ok(result)
}

/// Replaces a file, or creates it. `content` fills a temporary file.
fn replace<T, E: From<io::Error>>(
    path: &Path,
    content: impl FnOnce(&NamedTempFile) -> Result<T, E>,
) -> Result<T, E> {
    let permissions = fs::metadata(path).ok().map(|metadata| metadata.permissions());
    let stage = Stage::new(folder_of(path))?;
    let staged = stage.file(permissions)?;
    let result = content(&staged)?;
    staged.persist(path).map_err(io::Error::from)?;
    Ok(result)
}

impl Drop for Stage {
    fn drop(&mut self) {
        remove(&self.path);
    }
}

/// True if `folder` contains the temporary folder of a run that was killed or hasn't ended.
pub fn is_any_in(folder: &Path) -> bool {
    entries(folder).is_ok_and(|mut entries| entries.next().is_some())
}

/// Waits for a lock.
fn wait_for(lock: &File) -> io::Result<()> {
    FileExt::lock(lock).or_else(unless_unsupported)
}

/// Ignores the error of a file system without locks. On such file systems, runs can't wait for each
/// other.
fn unless_unsupported(error: io::Error) -> io::Result<()> {
    if error.kind() == ErrorKind::Unsupported { Ok(()) } else { Err(error) }
}

/// Opens the lock file in a temporary folder. `None` if the folder was removed in the meantime.
fn open_lock(path: &Path) -> io::Result<Option<File>> {
    // Creating a new file never follows a link.
    let opened = match OpenOptions::new().read(true).write(true).create_new(true).open(path.join(LOCK)) {
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
        return OpenOptions::new().read(true).write(true).open(lock);
    }
    Err(foreign(&lock, "is not a file"))
}

/// True if the content of a lock file shows that a run created it.
fn is_marked(lock: &mut File) -> bool {
    let mut text = String::new();
    let read = lock.rewind().and_then(|()| lock.take(MARK.len() as u64 + 1).read_to_string(&mut text));
    read.is_ok() && text == MARK
}

/// The user id of the owner of a file. On systems without user ids, 1 for a link, and 0 for anything else.
fn owner(metadata: &Metadata) -> u32 {
    #[cfg(unix)]
    return std::os::unix::fs::MetadataExt::uid(metadata);
    #[cfg(not(unix))]
    return u32::from(metadata.is_symlink());
}

/// The error for a folder that this program must not change.
fn foreign(path: &Path, problem: &str) -> io::Error {
    io::Error::other(format!("{} {problem}: rename or remove it", terminal::path(path)))
}

/// True if an open lock file is still the lock file in the folder.
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

/// Removes a temporary folder. The lock file is the last file, so a folder without a lock file is empty. Files that
/// can't be removed are left to the next run.
fn remove(path: &Path) {
    remove_files(path);
    let _ = fs::remove_file(path.join(LOCK));
    let _ = fs::remove_dir(path);
}

/// Removes all files and folders in a temporary folder except the lock file. Links aren't followed.
fn remove_files(path: &Path) {
    files(path).for_each(|file| {
        if fs::remove_file(&file).is_err() {
            let _ = fs::remove_dir_all(&file);
        }
    });
}

/// The files in a temporary folder except the lock file.
fn files(path: &Path) -> impl Iterator<Item = PathBuf> + use<> {
    let entries = fs::read_dir(path).into_iter().flatten().filter_map(Result::ok);
    entries.filter(|entry| entry.file_name() != LOCK).map(|entry| entry.path())
}

#[cfg(test)]
mod tests {
    use std::thread;

    use super::*;

    #[test]
    fn a_new_folder_appears_whole_or_not_at_all() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("new");
        let fill = |error: Option<io::Error>| {
            write_folder(&path, |staged| {
                fs::write(staged.join("file"), "text")?;
                assert!(!path.exists());
                error.map_or(Ok(()), Err)
            })
        };
        assert!(fill(Some(io::Error::other("full"))).is_err());
        assert_eq!(fs::read_dir(&folder).expect("a folder").count(), 0);
        fill(None).expect("a folder");
        assert_eq!(fs::read_to_string(path.join("file")).expect("a file"), "text");
        assert_eq!(fill(None).expect_err("it exists").kind(), ErrorKind::AlreadyExists);
        assert_eq!(fs::read_dir(&folder).expect("a folder").count(), 1);
    }

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
        fs::write(folder.join(name).join(LOCK), MARK).expect("a file");
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
        for (name, lock) in [(".uavspec-mine", None), (".uavspec-other", Some("pid 1"))] {
            fs::create_dir(folder.path().join(name)).expect("a folder");
            fs::write(folder.path().join(name).join("notes"), "mine").expect("a file");
            if let Some(text) = lock {
                fs::write(folder.path().join(name).join(LOCK), text).expect("a file");
            }
        }
        fs::write(folder.path().join(".uavspec-manifest"), "a file").expect("a file");
        drop(Stage::new(folder.path()).expect("a stage"));
        let others =
            [".uavspec-empty", ".uavspec-manifest", ".uavspec-mine", ".uavspec-other"].map(str::to_owned);
        let mut kept = [&others[..], &[used_name]].concat();
        kept.sort();
        assert_eq!(names(folder.path()), kept);
        assert_eq!(fs::read(used.path().join("0")).expect("a file"), b"text");
        drop(used);
        assert_eq!(names(folder.path()), others);
        for (name, files) in [(".uavspec-mine", &["notes"][..]), (".uavspec-other", &[LOCK, "notes"])] {
            assert_eq!(names(&folder.path().join(name)), files);
        }
    }

    #[test]
    fn an_exclusive_folder_replaces_no_folder_of_others() {
        for lock in [None, Some("pid 1")] {
            let folder = tempfile::tempdir().expect("a folder");
            let path = folder.path().join(EXCLUSIVE);
            fs::create_dir(&path).expect("a folder");
            fs::write(path.join("notes"), "mine").expect("a file");
            if let Some(text) = lock {
                fs::write(path.join(LOCK), text).expect("a file");
            }
            let error = Stage::exclusive(folder.path()).expect_err("a folder of others");
            assert!(error.to_string().contains("is not a temporary folder of uavspec"), "{error}");
            assert!(path.join("notes").exists());
        }
    }

    #[test]
    fn a_folder_is_claimed_only_once() {
        let folder = tempfile::tempdir().expect("a folder");
        let stage = Stage::claim(folder.path()).expect("a stage");
        let error = Stage::claim(folder.path()).expect_err("another run");
        assert_eq!(error.to_string(), "another run is writing to this folder");
        drop(stage);
        assert!(Stage::claim(folder.path()).is_ok());
    }

    #[cfg(unix)]
    #[test]
    fn written_files_keep_their_permissions_and_temporary_folders_are_private() {
        use std::os::unix::fs::PermissionsExt as _;

        let mode = |path: &Path| fs::metadata(path).expect("metadata").permissions().mode() & 0o777;
        let folder = tempfile::tempdir().expect("a folder");
        for stage in [Stage::new(folder.path()), Stage::claim(folder.path())] {
            assert_eq!(mode(stage.expect("a stage").path()), 0o700);
        }
        let path = folder.path().join("report");
        let write = || write_file(&path, |file| file.write_all(b"text"));
        for expected in [0o600, 0o640, 0o666] {
            fs::write(&path, "old").expect("a file");
            fs::set_permissions(&path, Permissions::from_mode(expected)).expect("permissions");
            write().expect("written");
            assert_eq!(mode(&path), expected);
        }
        // A new file has the same permissions as a new file of any other program.
        fs::remove_file(&path).expect("a file");
        write().expect("written");
        let other = folder.path().join("other");
        fs::write(&other, "text").expect("a file");
        assert_eq!(mode(&path), mode(&other));
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
