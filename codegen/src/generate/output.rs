//! Writes output. Only changed files are written: either all of them or none. Only files from an earlier run are
//! replaced or removed.
//!
//! A manifest in each output folder lists the files of the last run. Any other file without the generator's mark
//! belongs to the user. It is an error if an output has the same path as a user's file or as an input.
//!
//! All paths are checked before anything is written, so no file is written outside its output folder. The output folder
//! may be a symbolic link, but links inside it are not followed. While a run writes to a folder, other runs wait.

use std::collections::BTreeSet;
use std::fmt;
use std::fs::{self, File};
use std::io::{self, ErrorKind, Write as _};
use std::path::{Component, Path, PathBuf};

use uavspec_emit::{GENERATED_BY, OutputFile};
use uavspec_schema::failure::Failure;
use uavspec_schema::parallel::in_parallel;
use uavspec_schema::stage::{self, Stage};
use uavspec_schema::terminal;

use super::guard::check_paths;

/// The name of the manifest in each output folder.
const MANIFEST: &str = ".uavspec-manifest";

/// The number of bytes at the start of a file that are searched for the generator's mark.
const MARK_WITHIN: usize = 1_000;

/// An output folder and its generated files.
#[derive(Debug)]
pub(crate) struct Folder {
    pub(crate) path: PathBuf,
    pub(crate) files: Vec<OutputFile>,
}

/// An outdated file.
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
            Self::Missing(path) => write!(formatter, "missing: {}", terminal::path(path)),
            Self::Changed(path) => write!(formatter, "changed: {}", terminal::path(path)),
            Self::Orphaned(path) => write!(formatter, "orphaned: {}", terminal::path(path)),
        }
    }
}

/// The changes of a run to a folder.
struct Changes<'f> {
    folder: &'f Path,
    /// The files to write, each with its text and a flag that is true if the file exists.
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

/// Lists the differences between the folders on disk and the generated files.
pub(crate) fn compare(folders: &[Folder], inputs: &[PathBuf]) -> Result<Vec<Difference>, Failure> {
    let changes = changes_of_all(folders, inputs)?;
    Ok(differences(&changes))
}

/// Writes the generated files, and lists the differences. Fails if a file would replace one of the inputs.
pub(crate) fn write(folders: &[Folder], inputs: &[PathBuf]) -> Result<Vec<Difference>, Failure> {
    let is_stale = changes_of_all(folders, inputs)?
        .iter()
        .any(|change| change.is_any() || stage::is_any_in(change.folder));
    if !is_stale {
        return Ok(Vec::new());
    }
    let stages = stages(folders)?;
    // Another run may have changed the files while this run waited for the folders.
    let changes = changes_of_all(folders, inputs)?;
    let pending: Vec<_> = changes
        .iter()
        .filter(|change| change.is_any())
        .filter_map(|change| {
            Some((change, stages.iter().find(|(folder, _)| *folder == change.folder)?.1.path()))
        })
        .collect();
    // All files are staged first, so nothing changes if the disk is full.
    in_parallel(&pending, |(change, path)| {
        stage_files(change, path).map_err(|error| unwritable(change.folder, &error))
    })?;
    in_parallel(&pending, |(change, path)| {
        commit(change, path).map_err(|error| unwritable(change.folder, &error))
    })?;
    Ok(differences(&changes))
}

/// Creates a temporary folder in each output folder. Waits until no other run writes to these folders.
fn stages(folders: &[Folder]) -> Result<Vec<(&Path, Stage)>, Failure> {
    let mut real = Vec::new();
    for Folder { path, .. } in folders {
        let resolved = fs::create_dir_all(path).and_then(|()| fs::canonicalize(path));
        real.push((resolved.map_err(|error| unwritable(path, &error))?, path.as_path()));
    }
    // All runs wait for folders in the same order, so no deadlock is possible.
    real.sort();
    if let Some(pair) = real.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        return Err(shared(pair[0].1));
    }
    let stage = |(_, path): (PathBuf, _)| {
        Stage::exclusive(path).map(|stage| (path, stage)).map_err(|error| unwritable(path, &error))
    };
    real.into_iter().map(stage).collect()
}

fn shared(folder: &Path) -> Failure {
    Failure::new(format!("two outputs share the folder {}", terminal::path(folder)))
        .with_hint("give each output a separate folder")
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

fn changes_of_all<'f>(folders: &'f [Folder], inputs: &[PathBuf]) -> Result<Vec<Changes<'f>>, Failure> {
    for (index, folder) in folders.iter().enumerate() {
        if folders[..index].iter().any(|other| other.path == folder.path) {
            return Err(shared(&folder.path));
        }
    }
    // Skip missing inputs, which are reported elsewhere.
    let inputs: BTreeSet<PathBuf> = inputs.iter().filter_map(|path| fs::canonicalize(path).ok()).collect();
    in_parallel(folders, |folder| changes_of(folder, &inputs))
}

fn changes_of<'f>(folder: &'f Folder, inputs: &BTreeSet<PathBuf>) -> Result<Changes<'f>, Failure> {
    check_paths(&folder.path, &folder.files)?;
    let path = &folder.path;
    if path.exists() && !path.is_dir() {
        return Err(Failure::new(format!("{} is not a folder", terminal::path(path)))
            .with_hint("choose a folder for the output"));
    }
    let (owned, listed) = read_manifest(path)?;
    let mut paths: Vec<&str> = folder.files.iter().map(|file| file.path.as_str()).collect();
    paths.sort_unstable();
    let manifest = format!("# {GENERATED_BY}: the files of the last run.\n{}\n", paths.join("\n"));
    let mut write = Vec::new();
    for file in &folder.files {
        let relative = PathBuf::from(&file.path);
        let full = path.join(&relative);
        reject_links(path, &relative)?;
        match read_file(&full) {
            Ok(bytes) if bytes == file.text.as_bytes() => {}
            Ok(bytes) if owned.contains(&relative) || is_marked(&bytes) => {
                write.push((relative, file.text.as_str(), true));
            }
            Ok(_) => {
                let message = format!("{} exists and was not generated", terminal::path(full));
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
    let generated: BTreeSet<PathBuf> = folder.files.iter().map(|file| PathBuf::from(&file.path)).collect();
    let mut remove = Vec::new();
    for orphan in owned.into_iter().filter(|path| !generated.contains(path)) {
        reject_links(path, &orphan)?;
        if path.join(&orphan).is_file() {
            remove.push(orphan);
        }
    }
    let changed = write.iter().map(|(path, ..)| path).chain(&remove);
    reject_inputs(path, changed, inputs)?;
    Ok(Changes {
        folder: path,
        write,
        remove,
        is_manifest_stale: listed.as_deref() != Some(&manifest),
        manifest,
    })
}

/// Reads a file. Fails for anything other than a regular file, because reading a pipe would wait for a writer.
fn read_file(path: &Path) -> io::Result<Vec<u8>> {
    let is_file = fs::metadata(path)?.is_file();
    if is_file { fs::read(path) } else { Err(io::Error::other("expected a file")) }
}

/// The files that an earlier run wrote, and the text of the manifest. Ignores paths outside the folder, which no run
/// can have written.
fn read_manifest(folder: &Path) -> Result<(BTreeSet<PathBuf>, Option<String>), Failure> {
    let path = folder.join(MANIFEST);
    let text = match read_file(&path) {
        Ok(bytes) => String::from_utf8_lossy(&bytes).into_owned(),
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok((BTreeSet::new(), None)),
        Err(error) => return Err(Failure::new(format!("{}: {error}", terminal::path(path)))),
    };
    let is_inside = |path: &Path| path.components().all(|part| matches!(part, Component::Normal(_)));
    let lines = text.lines().filter(|line| !line.starts_with('#') && !line.is_empty()).map(PathBuf::from);
    Ok((lines.filter(|path| is_inside(path)).collect(), Some(text)))
}

/// True if a file contains the generator's mark.
fn is_marked(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(MARK_WITHIN)];
    head.windows(GENERATED_BY.len()).any(|window| window == GENERATED_BY.as_bytes())
}

/// Fails if one of the files is an input.
fn reject_inputs<'p>(
    folder: &Path,
    mut files: impl Iterator<Item = &'p PathBuf>,
    inputs: &BTreeSet<PathBuf>,
) -> Result<(), Failure> {
    // An absent folder contains no inputs.
    let Ok(real) = fs::canonicalize(folder) else { return Ok(()) };
    let Some(input) = files.find(|path| inputs.contains(&real.join(path))) else { return Ok(()) };
    let message = format!("the output {} would replace an input", terminal::path(folder.join(input)));
    Err(Failure::new(message).with_hint("choose another folder for the output"))
}

/// Fails if a folder of the output is a symbolic link, because its target may be outside the output folder.
fn reject_links(folder: &Path, relative: &Path) -> Result<(), Failure> {
    let mut at = folder.to_path_buf();
    for part in relative.parent().into_iter().flat_map(Path::components) {
        at.push(part);
        if at.is_symlink() {
            let message = format!(
                "{} is a symbolic link, which may lead outside the output folder",
                terminal::path(at)
            );
            return Err(Failure::new(message).with_hint("replace it with a folder"));
        }
    }
    Ok(())
}

/// Writes all files to a temporary folder inside the output folder. Afterwards, the files only have to be renamed.
fn stage_files(change: &Changes<'_>, stage: &Path) -> io::Result<()> {
    for (index, (_, text, _)) in change.write.iter().enumerate() {
        write_new(&stage.join(index.to_string()), text)?;
    }
    write_new(&stage.join(MANIFEST), &change.manifest)?;
    let parents: BTreeSet<&Path> = change.write.iter().filter_map(|(path, ..)| path.parent()).collect();
    for parent in parents {
        fs::create_dir_all(change.folder.join(parent))?;
    }
    Ok(())
}

/// Writes a new file, without following links.
fn write_new(path: &Path, text: &str) -> io::Result<()> {
    File::create_new(path)?.write_all(text.as_bytes())
}

fn commit(change: &Changes<'_>, stage: &Path) -> io::Result<()> {
    for (index, (path, ..)) in change.write.iter().enumerate() {
        fs::rename(stage.join(index.to_string()), change.folder.join(path))?;
    }
    for path in &change.remove {
        fs::remove_file(change.folder.join(path))?;
        // Remove folders that are now empty. Removal fails for all other folders.
        for parent in path.ancestors().skip(1).take_while(|parent| !parent.as_os_str().is_empty()) {
            if fs::remove_dir(change.folder.join(parent)).is_err() {
                break;
            }
        }
    }
    fs::rename(stage.join(MANIFEST), change.folder.join(MANIFEST))
}

fn unwritable(path: &Path, error: &io::Error) -> Failure {
    Failure::new(format!("{}: {error}", terminal::path(path)))
        .with_hint("no output was changed; check that the folder is writable")
}
