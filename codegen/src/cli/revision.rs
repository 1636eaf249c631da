//! Definitions at a revision of a Git repository.
//!
//! Calls the `git` program, which respects the user's configuration, worktrees and partial clones.

use std::ffi::OsStr;
use std::fs;
use std::io::{self, Read as _, Seek as _, Write as _};
use std::path::{Component, Path, PathBuf};
use std::process::{Command, Output, Stdio};

use uavspec_schema::failure::Failure;
use uavspec_schema::terminal;

use crate::load::{Plan, is_definition};

/// The definitions and configuration files of a revision, in a temporary folder that is deleted on drop.
pub(super) struct Checkout {
    folder: tempfile::TempDir,
    /// The top folder of the repository's working tree.
    top: PathBuf,
}

/// A file in a Git tree.
struct Blob<'t> {
    id: &'t str,
    path: PathBuf,
}

impl Checkout {
    /// Extracts the files of `revision` that `plan` may need, from the repository that contains `near`.
    pub(super) fn of(revision: &str, near: &Path, plan: &Plan) -> Result<Self, Failure> {
        let near = if near.as_os_str().is_empty() { Path::new(".") } else { near };
        let near = if near.is_dir() { near } else { near.parent().unwrap_or(Path::new(".")) };
        let near = if near.as_os_str().is_empty() { Path::new(".") } else { near };
        let Some(top) = text_of(&git(near, ["rev-parse", "--show-toplevel"])?) else {
            let message = format!(
                "the folder `{revision}` does not exist, and {} is not in a Git repository",
                terminal::path(near)
            );
            return Err(Failure::new(message).with_hint("give a folder, or a revision of a repository"));
        };
        let commit = commit(revision, near)?;
        let tree = git(near, ["ls-tree", "-r", "-z", "--full-tree", &commit])?;
        let listing = String::from_utf8_lossy(&tree.stdout);
        let is_needed = |blob: &Blob<'_>| {
            let forms = plan.packages.iter().map(|package| package.form);
            let is_configuration = blob.path.file_name() == Some(OsStr::new("uavspec.toml"));
            is_configuration || forms.into_iter().any(|form| is_definition(&blob.path, form))
        };
        let blobs: Vec<Blob<'_>> = listing.split('\0').filter_map(blob).filter(is_needed).collect();
        let folder = tempfile::tempdir()
            .map_err(|error| Failure::new(format!("cannot create a temporary folder: {error}")))?;
        extract(&blobs, near, folder.path())
            .map_err(|error| Failure::new(format!("cannot read the revision `{revision}`: {error}")))?;
        Ok(Self { folder, top: PathBuf::from(top) })
    }

    /// The folder with the files.
    pub(super) fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// The path in this checkout that corresponds to a path in the working tree.
    pub(super) fn place_of(&self, path: &Path) -> Result<PathBuf, Failure> {
        let outside = || Failure::new(format!("{} is not in the repository", terminal::path(path)));
        let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
        // A file that no longer exists in the working tree may exist at the revision.
        let whole = fs::canonicalize(path).or_else(|_| std::path::absolute(path)).map_err(|_| outside())?;
        let top = fs::canonicalize(&self.top).unwrap_or_else(|_| self.top.clone());
        Ok(self.folder().join(whole.strip_prefix(top).map_err(|_| outside())?))
    }
}

fn git<'a>(near: &Path, arguments: impl IntoIterator<Item = &'a str>) -> Result<Output, Failure> {
    let run = Command::new("git").arg("-C").arg(near).args(arguments).stdin(Stdio::null()).output();
    run.map_err(|error| {
        Failure::new(format!("cannot run git: {error}"))
            .with_hint("install git, or give a folder with the earlier definitions")
    })
}

/// The output of a command, or `None` if the command failed.
fn text_of(output: &Output) -> Option<String> {
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim_end().to_owned())
}

/// The commit id of a revision.
fn commit(revision: &str, near: &Path) -> Result<String, Failure> {
    let name = format!("{revision}^{{commit}}");
    let found = git(near, ["rev-parse", "--verify", "--quiet", "--end-of-options", &name])?;
    if let Some(commit) = text_of(&found) {
        return Ok(commit);
    }
    let is_shallow =
        text_of(&git(near, ["rev-parse", "--is-shallow-repository"])?).as_deref() == Some("true");
    let hint = if is_shallow {
        "this clone is shallow; fetch the rest with `git fetch --unshallow --tags` \
         (on GitHub, `fetch-depth: 0` for actions/checkout)"
    } else {
        "give a folder or an existing branch, tag or commit; `git fetch` updates remote branches and tags"
    };
    let message = format!("`{revision}` is not a folder or a revision of the repository");
    Err(Failure::new(message).with_hint(hint))
}

/// Parses a line of the listing: `mode type id<tab>path`. Returns `None` unless the entry is a plain file.
fn blob(line: &str) -> Option<Blob<'_>> {
    let (facts, path) = line.split_once('\t')?;
    let mut facts = facts.split(' ');
    let (mode, _, id) = (facts.next()?, facts.next()?, facts.next()?);
    let path = PathBuf::from(path);
    // Reject paths outside the folder, which a malicious tree may contain.
    let is_plain = path.components().all(|part| matches!(part, Component::Normal(_)));
    (mode.starts_with("100") && is_plain).then_some(Blob { id, path })
}

/// Writes blobs below `folder`.
fn extract(blobs: &[Blob<'_>], near: &Path, folder: &Path) -> io::Result<()> {
    // Pass the ids in a file instead of a pipe, so neither process can block the other.
    let mut ids = tempfile::tempfile()?;
    for blob in blobs {
        writeln!(ids, "{}", blob.id)?;
    }
    ids.rewind()?;
    let mut child = Command::new("git")
        .arg("-C")
        .arg(near)
        .args(["cat-file", "--batch"])
        .stdin(ids)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()?;
    let Some(output) = child.stdout.take() else { return Err(io::ErrorKind::BrokenPipe.into()) };
    let mut output = io::BufReader::new(output);
    let result = blobs.iter().try_for_each(|blob| write_next(&mut output, &folder.join(&blob.path)));
    drop(output);
    child.wait()?;
    result
}

/// Writes the next object in the output of `git cat-file --batch`. Each object consists of a line `id type size`, the
/// content and a newline.
fn write_next(output: &mut impl io::BufRead, path: &Path) -> io::Result<()> {
    let mut head = String::new();
    output.read_line(&mut head)?;
    let size = head.trim_end().rsplit(' ').next().and_then(|size| size.parse::<u64>().ok());
    let Some(size) = size else { return Err(io::Error::other(head.trim_end().to_owned())) };
    if let Some(parent) = path.parent() {
        fs::create_dir_all(parent)?;
    }
    let mut file = fs::File::create(path)?;
    io::copy(&mut output.by_ref().take(size), &mut file)?;
    output.read_exact(&mut [0])
}
