//! The stored inputs of a target.

use std::path::{Path, PathBuf};
use std::time::SystemTime;
use std::{fs, io};

use super::program::Program;

/// The maximum number of committed inputs of a target.
const MAX_FILES: usize = 50;

/// The maximum size of the committed inputs of a target, in bytes.
const MAX_BYTES: usize = 100_000;

/// The folders of a target.
pub(super) struct Corpus {
    /// The committed selection.
    pub(super) committed: PathBuf,
    /// All inputs that earlier runs found.
    pub(super) found: PathBuf,
    /// The prefix of inputs that violate a property.
    pub(super) artifacts: PathBuf,
}

impl Corpus {
    /// The folders of a target, which are created if necessary.
    pub(super) fn of(root: &Path, target: &str) -> Result<Self, String> {
        let corpus = Self {
            committed: root.join("xtask/fuzz/corpus").join(target),
            found: root.join("target/fuzz/corpus").join(target),
            artifacts: root.join("target/fuzz/artifacts").join(target),
        };
        for folder in [&corpus.committed, &corpus.found, &corpus.artifacts] {
            fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        }
        Ok(corpus)
    }

    /// Replaces the committed inputs with the smallest selection with the same coverage.
    pub(super) fn minimise(&self, program: &Program, target: &str) -> Result<(), String> {
        let merged = self.artifacts.with_extension("merge");
        let failed = |error: io::Error| format!("{}: {error}", merged.display());
        if merged.exists() {
            fs::remove_dir_all(&merged).map_err(failed)?;
        }
        fs::create_dir_all(&merged).map_err(failed)?;
        let folders = [&merged, &self.committed, &self.found].map(|folder| folder.as_os_str());
        let options = ["-set_cover_merge=1", "-timeout=10"].map(std::ffi::OsStr::new);
        let output = program.run(target, options.into_iter().chain(folders))?;
        if !output.status.success() {
            return Err(format!("{target}: the inputs cannot be merged"));
        }
        let selected = selection(inputs(&merged).map_err(failed)?);
        replace(&self.committed, &selected)
            .map_err(|error| format!("{}: {error}", self.committed.display()))?;
        fs::remove_dir_all(&merged).map_err(failed)
    }
}

/// A stored input, with the time at which it was written.
struct Input {
    name: String,
    written: SystemTime,
    bytes: Vec<u8>,
}

fn inputs(folder: &Path) -> io::Result<Vec<Input>> {
    let read = |entry: io::Result<fs::DirEntry>| {
        let entry = entry?;
        let written = entry.metadata()?.modified()?;
        Ok(Input {
            name: entry.file_name().to_string_lossy().into_owned(),
            written,
            bytes: fs::read(entry.path())?,
        })
    };
    fs::read_dir(folder)?.map(read).collect()
}

/// The inputs to commit. libFuzzer writes the inputs with the most coverage first.
fn selection(mut inputs: Vec<Input>) -> Vec<Input> {
    inputs.sort_by(|left, right| (left.written, &left.name).cmp(&(right.written, &right.name)));
    let mut size = 0;
    inputs.retain(|input| {
        let fits = size + input.bytes.len() <= MAX_BYTES;
        size += if fits { input.bytes.len() } else { 0 };
        fits
    });
    inputs.truncate(MAX_FILES);
    inputs
}

/// Replaces the files in a folder.
fn replace(folder: &Path, inputs: &[Input]) -> io::Result<()> {
    fs::remove_dir_all(folder)?;
    fs::create_dir_all(folder)?;
    inputs.iter().try_for_each(|input| fs::write(folder.join(&input.name), &input.bytes))
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn input(name: &str, seconds: u64, length: usize) -> Input {
        let written = SystemTime::UNIX_EPOCH + Duration::from_secs(seconds);
        Input { name: name.to_owned(), written, bytes: vec![0; length] }
    }

    fn names(inputs: Vec<Input>) -> Vec<String> {
        selection(inputs).into_iter().map(|input| input.name).collect()
    }

    #[test]
    fn selects_the_first_inputs_that_fit() {
        let inputs = vec![input("c", 3, 1), input("long", 2, MAX_BYTES), input("b", 1, 5), input("a", 1, 5)];
        assert_eq!(names(inputs), ["a", "b", "c"]);
        let many = (0..60).map(|number| input(&format!("{number:02}"), number, 1)).collect();
        assert_eq!(names(many).last().map(String::as_str), Some("49"));
    }
}
