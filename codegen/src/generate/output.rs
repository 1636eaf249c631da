//! Writing output: only what changed, all or nothing, and nothing but what an earlier run wrote is
//! ever replaced or removed.
//!
//! A manifest in each output folder lists the files of the last run. A file that it doesn't list and
//! that doesn't say itself that it is generated belongs to the user, and stands in the way.

use std::collections::BTreeSet;
use std::fmt;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Component, Path, PathBuf};

use super::parallel::side_by_side;
use crate::emit::{GENERATED_BY, OutputFile};
use crate::failure::Failure;

/// The list of generated files, beside them.
const MANIFEST: &str = ".uavspec-manifest";

/// How far into a file the generator's mark is looked for, in bytes.
const MARK_WITHIN: usize = 1_000;

/// An output folder and what belongs into it.
#[derive(Debug)]
pub(crate) struct Folder {
    pub(crate) path: PathBuf,
    pub(crate) files: Vec<OutputFile>,
}

/// A file that is not as it should be.
#[derive(Debug)]
pub(crate) enum Difference {
    Missing(PathBuf),
    Changed(PathBuf),
    Orphaned(PathBuf),
}

impl Difference {
    pub(crate) fn into_path(self) -> PathBuf {
        match self {
            Self::Missing(path) | Self::Changed(path) | Self::Orphaned(path) => path,
        }
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing(path) => write!(formatter, "missing: {}", path.display()),
            Self::Changed(path) => write!(formatter, "changed: {}", path.display()),
            Self::Orphaned(path) => write!(formatter, "orphaned: {}", path.display()),
        }
    }
}

/// What a run would do to a folder.
struct Changes<'f> {
    folder: &'f Path,
    /// Files to be written, the manifest last.
    write: Vec<(PathBuf, &'f str, bool)>,
    remove: Vec<PathBuf>,
    manifest: String,
    is_manifest_stale: bool,
}

impl Changes<'_> {
    fn is_any(&self) -> bool {
        !self.write.is_empty() || !self.remove.is_empty() || self.is_manifest_stale
    }
}

/// Lists what differs between the folders and what belongs into them.
pub(crate) fn compare(folders: &[Folder]) -> Result<Vec<Difference>, Failure> {
    let changes = changes_of_all(folders)?;
    Ok(differences(&changes))
}

/// Makes the folders hold what belongs into them, and lists what was different.
pub(crate) fn write(folders: &[Folder]) -> Result<Vec<Difference>, Failure> {
    let changes = changes_of_all(folders)?;
    // All is staged before anything is put in place, so that a full disk leaves all as it was.
    let stale: Vec<&Changes<'_>> = changes.iter().filter(|change| change.is_any()).collect();
    let staged =
        side_by_side(&stale, |change| stage(change).map_err(|error| unwritable(change.folder, &error)))?;
    let staged: Vec<_> = stale.into_iter().zip(staged).collect();
    side_by_side(&staged, |(change, stage)| {
        commit(change, stage.path()).map_err(|error| unwritable(change.folder, &error))
    })?;
    Ok(differences(&changes))
}

fn differences(changes: &[Changes<'_>]) -> Vec<Difference> {
    let mut differences = Vec::new();
    for change in changes {
        for (path, _, exists) in &change.write {
            let path = change.folder.join(path);
            differences.push(if *exists { Difference::Changed(path) } else { Difference::Missing(path) });
        }
        differences.extend(change.remove.iter().map(|path| Difference::Orphaned(change.folder.join(path))));
        if change.is_manifest_stale && change.write.is_empty() && change.remove.is_empty() {
            differences.push(Difference::Changed(change.folder.join(MANIFEST)));
        }
    }
    differences
}

fn changes_of_all(folders: &[Folder]) -> Result<Vec<Changes<'_>>, Failure> {
    for (index, folder) in folders.iter().enumerate() {
        if folders[..index].iter().any(|other| other.path == folder.path) {
            let message = format!("two outputs share the folder {}", folder.path.display());
            return Err(Failure::new(message).with_hint("give each output a folder of its own"));
        }
    }
    side_by_side(folders, changes_of)
}

fn changes_of(folder: &Folder) -> Result<Changes<'_>, Failure> {
    let path = &folder.path;
    if path.exists() && !path.is_dir() {
        return Err(Failure::new(format!("{} is not a folder", path.display()))
            .with_hint("name a folder for the output"));
    }
    let (owned, listed) = read_manifest(path)?;
    let mut paths: Vec<&str> = folder.files.iter().map(|file| file.path.as_str()).collect();
    paths.sort_unstable();
    let manifest = format!("# {GENERATED_BY}: the files of the last run.\n{}\n", paths.join("\n"));
    let mut write = Vec::new();
    for file in &folder.files {
        let relative = PathBuf::from(&file.path);
        let full = path.join(&relative);
        refuse_links(path, &relative)?;
        match fs::read(&full) {
            Ok(bytes) if bytes == file.text.as_bytes() => {}
            Ok(bytes) if owned.contains(&relative) || is_marked(&bytes) => {
                write.push((relative, file.text.as_str(), true));
            }
            Ok(_) => {
                let message = format!("{} exists and was not generated", full.display());
                return Err(
                    Failure::new(message).with_hint("move it away, or choose another folder for the output")
                );
            }
            Err(error) if error.kind() == ErrorKind::NotFound => {
                write.push((relative, file.text.as_str(), false));
            }
            Err(error) => return Err(unwritable(&full, &error)),
        }
    }
    let wanted: BTreeSet<PathBuf> = folder.files.iter().map(|file| PathBuf::from(&file.path)).collect();
    let mut remove = Vec::new();
    for orphan in owned.into_iter().filter(|path| !wanted.contains(path)) {
        refuse_links(path, &orphan)?;
        if path.join(&orphan).is_file() {
            remove.push(orphan);
        }
    }
    Ok(Changes {
        folder: path,
        write,
        remove,
        is_manifest_stale: listed.as_deref() != Some(&manifest),
        manifest,
    })
}

/// The files that an earlier run wrote, and the manifest as it is. Lines that lead out of the folder
/// were not written by a run, and are not followed.
fn read_manifest(folder: &Path) -> Result<(BTreeSet<PathBuf>, Option<String>), Failure> {
    let path = folder.join(MANIFEST);
    let text = match fs::read_to_string(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok((BTreeSet::new(), None)),
        Err(error) => return Err(Failure::new(format!("{}: {error}", path.display()))),
    };
    let is_inside = |path: &Path| path.components().all(|part| matches!(part, Component::Normal(_)));
    let lines = text.lines().filter(|line| !line.starts_with('#') && !line.is_empty()).map(PathBuf::from);
    Ok((lines.filter(|path| is_inside(path)).collect(), Some(text)))
}

/// Whether a file says of itself that it is generated.
fn is_marked(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(MARK_WITHIN)];
    head.windows(GENERATED_BY.len()).any(|window| window == GENERATED_BY.as_bytes())
}

/// A folder inside the output that is a link would lead out of it.
fn refuse_links(folder: &Path, relative: &Path) -> Result<(), Failure> {
    let mut at = folder.to_path_buf();
    for part in relative.parent().into_iter().flat_map(Path::components) {
        at.push(part);
        if at.is_symlink() {
            let message = format!("{} is a link that leads out of the output folder", at.display());
            return Err(Failure::new(message).with_hint("put a folder in its place"));
        }
    }
    Ok(())
}

/// Writes everything to a temporary folder inside the output folder, from where it need only be renamed.
fn stage(change: &Changes<'_>) -> io::Result<tempfile::TempDir> {
    fs::create_dir_all(change.folder)?;
    let stage = tempfile::Builder::new().prefix(".uavspec-").tempdir_in(change.folder)?;
    for (index, (_, text, _)) in change.write.iter().enumerate() {
        fs::write(stage.path().join(index.to_string()), text)?;
    }
    fs::write(stage.path().join(MANIFEST), &change.manifest)?;
    let parents: BTreeSet<&Path> = change.write.iter().filter_map(|(path, ..)| path.parent()).collect();
    for parent in parents {
        fs::create_dir_all(change.folder.join(parent))?;
    }
    Ok(stage)
}

fn commit(change: &Changes<'_>, stage: &Path) -> io::Result<()> {
    for (index, (path, ..)) in change.write.iter().enumerate() {
        fs::rename(stage.join(index.to_string()), change.folder.join(path))?;
    }
    for path in &change.remove {
        fs::remove_file(change.folder.join(path))?;
        // Folders that are empty now go too; one that isn't says so by failing.
        for parent in path.ancestors().skip(1).take_while(|parent| !parent.as_os_str().is_empty()) {
            if fs::remove_dir(change.folder.join(parent)).is_err() {
                break;
            }
        }
    }
    fs::rename(stage.join(MANIFEST), change.folder.join(MANIFEST))
}

fn unwritable(path: &Path, error: &io::Error) -> Failure {
    Failure::new(format!("{}: {error}", path.display()))
        .with_hint("nothing was put in place; check that the folder can be written")
}
