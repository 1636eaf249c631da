//! Definitions as they were at a revision of a Git repository.
//!
//! Git itself is asked: it knows the user's configuration, worktrees and partial clones, and who has a
//! repository has it.

use std::ffi::OsStr;
use std::fs;
use std::io::{self, Read as _, Seek as _, Write as _};
use std::path::{Component, Path, PathBuf};
use std::process::{Command, Output, Stdio};

use crate::failure::Failure;
use crate::load::Plan;
use crate::load::is_definition;

/// A revision's definitions and configuration files in a folder of their own, which goes with this value.
pub(super) struct Checkout {
    folder: tempfile::TempDir,
    /// The top folder of the repository's working tree.
    top: PathBuf,
}

/// A blob of a tree.
struct Blob<'t> {
    id: &'t str,
    path: PathBuf,
}

impl Checkout {
    /// Takes out what `plan` may need of `revision` from the repository that `near` lies in.
    pub(super) fn of(revision: &str, near: &Path, plan: &Plan) -> Result<Self, Failure> {
        let near = if near.as_os_str().is_empty() { Path::new(".") } else { near };
        let near = if near.is_dir() { near } else { near.parent().unwrap_or(Path::new(".")) };
        let near = if near.as_os_str().is_empty() { Path::new(".") } else { near };
        let Some(top) = text_of(&git(near, ["rev-parse", "--show-toplevel"])?) else {
            let message = format!("no folder `{revision}`, and {} is in no Git repository", near.display());
            return Err(Failure::new(message).with_hint("name a folder, or a revision of a repository"));
        };
        let commit = commit(revision, near)?;
        let tree = git(near, ["ls-tree", "-r", "-z", "--full-tree", &commit])?;
        let listing = String::from_utf8_lossy(&tree.stdout);
        let wanted = |blob: &Blob<'_>| {
            let forms = plan.packages.iter().map(|package| package.form);
            let is_configuration = blob.path.file_name() == Some(OsStr::new("uavspec.toml"));
            is_configuration || forms.into_iter().any(|form| is_definition(&blob.path, form))
        };
        let blobs: Vec<Blob<'_>> = listing.split('\0').filter_map(blob).filter(wanted).collect();
        let folder =
            tempfile::tempdir().map_err(|error| Failure::new(format!("a folder for files: {error}")))?;
        take_out(&blobs, near, folder.path())
            .map_err(|error| Failure::new(format!("reading revision `{revision}`: {error}")))?;
        Ok(Self { folder, top: PathBuf::from(top) })
    }

    /// The folder that holds the files.
    pub(super) fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Where a path of the working tree is here.
    pub(super) fn place_of(&self, path: &Path) -> Result<PathBuf, Failure> {
        let outside = || Failure::new(format!("{} is not in the repository", path.display()));
        let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
        // What is gone from the working tree may have been there at the revision.
        let whole = fs::canonicalize(path).or_else(|_| std::path::absolute(path)).map_err(|_| outside())?;
        let top = fs::canonicalize(&self.top).unwrap_or_else(|_| self.top.clone());
        Ok(self.folder().join(whole.strip_prefix(top).map_err(|_| outside())?))
    }
}

fn git<'a>(near: &Path, arguments: impl IntoIterator<Item = &'a str>) -> Result<Output, Failure> {
    let run = Command::new("git").arg("-C").arg(near).args(arguments).stdin(Stdio::null()).output();
    run.map_err(|error| {
        Failure::new(format!("git can't be run: {error}"))
            .with_hint("install it, or name a folder with the earlier definitions")
    })
}

/// What a command that succeeded printed.
fn text_of(output: &Output) -> Option<String> {
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim_end().to_owned())
}

/// The commit that a revision names.
fn commit(revision: &str, near: &Path) -> Result<String, Failure> {
    let name = format!("{revision}^{{commit}}");
    let found = git(near, ["rev-parse", "--verify", "--quiet", "--end-of-options", &name])?;
    if let Some(commit) = text_of(&found) {
        return Ok(commit);
    }
    let is_shallow =
        text_of(&git(near, ["rev-parse", "--is-shallow-repository"])?).as_deref() == Some("true");
    let hint = if is_shallow {
        "this clone is shallow: get the rest with `git fetch --unshallow --tags` \
         (on GitHub, `fetch-depth: 0` for actions/checkout)"
    } else {
        "name a branch, a tag or a commit that `git log` knows, or a folder; `git fetch` gets those of others"
    };
    let message = format!("`{revision}` is neither a folder nor a revision of the repository");
    Err(Failure::new(message).with_hint(hint))
}

/// A line `mode type id<tab>path` of a listing, where it is a plain file.
fn blob(line: &str) -> Option<Blob<'_>> {
    let (facts, path) = line.split_once('\t')?;
    let mut facts = facts.split(' ');
    let (mode, _, id) = (facts.next()?, facts.next()?, facts.next()?);
    let path = PathBuf::from(path);
    // A hostile tree may have names that lead elsewhere.
    let is_plain = path.components().all(|part| matches!(part, Component::Normal(_)));
    (mode.starts_with("100") && is_plain).then_some(Blob { id, path })
}

/// Writes blobs below `folder`.
fn take_out(blobs: &[Blob<'_>], near: &Path, folder: &Path) -> io::Result<()> {
    // From a file, so that neither side waits for the other.
    let mut wanted = tempfile::tempfile()?;
    for blob in blobs {
        writeln!(wanted, "{}", blob.id)?;
    }
    wanted.rewind()?;
    let mut child = Command::new("git")
        .arg("-C")
        .arg(near)
        .args(["cat-file", "--batch"])
        .stdin(wanted)
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

/// Writes what follows in the output of `git cat-file --batch`: `id type size`, the content, a newline.
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
