//! The application that `uavspec probe --application` compares with a vehicle.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use memchr::memmem;
use uavspec_model::ApplicationType;
use uavspec_model::text::{plural, terminal};
use uavspec_schema::msg::Dialect;
use walkdir::WalkDir;

use crate::app::{Status, library};

/// The extensions of files that are searched for topic names.
const EXTENSIONS: [&str; 11] = ["c", "cc", "cpp", "h", "hpp", "json", "launch", "py", "rs", "xml", "yaml"];

/// The maximum number of bytes that are read from a file.
const MAX_SIZE: u64 = 1 << 20;

/// The maximum number of files.
const MAX_FILES: usize = 20_000;

/// The folders in the names of PX4 topics.
const FOLDERS: [&str; 2] = ["fmu/in/", "fmu/out/"];

/// An application.
pub(super) struct Application {
    /// The types of the topics that the application uses.
    pub types: Vec<ApplicationType>,
    /// A note for the report, if the application doesn't use all types of its definitions.
    pub note: Option<String>,
}

impl Application {
    /// Reads the definitions of a path or a release. If files in the folder name PX4 topics, the application uses only
    /// these.
    pub(super) fn load(path: &Path) -> Result<Self, Status> {
        let definitions = library(Some(path), Some(Dialect::Px4), &[])?;
        let mut types = ApplicationType::all(&definitions.base().schema);
        let named = named_topics(path);
        if named.is_empty() {
            return Ok(Self { types, note: None });
        }
        for ty in &mut types {
            ty.topics.retain(|topic| named.contains(topic));
        }
        types.retain(|ty| !ty.topics.is_empty());
        let count: usize = types.iter().map(|ty| ty.topics.len()).sum();
        let note = format!(
            "only {} of the application can be compared, because files in {} name no others",
            plural(count, "topic"),
            terminal::path(path)
        );
        Ok(Self { types, note: Some(note) })
    }
}

/// The names of topics after `fmu/in/` and `fmu/out/`, in the files of a folder. A name with a version is also included
/// without the version.
fn named_topics(folder: &Path) -> BTreeSet<String> {
    let files = WalkDir::new(folder).into_iter().filter_map(Result::ok).filter(|entry| {
        let extension = entry.path().extension().and_then(|extension| extension.to_str());
        entry.file_type().is_file() && extension.is_some_and(|extension| EXTENSIONS.contains(&extension))
    });
    files.take(MAX_FILES).flat_map(|entry| topics_in(&start_of(entry.path()))).collect()
}

/// The first bytes of a file. Empty if the file can't be read.
fn start_of(path: &Path) -> Vec<u8> {
    let mut bytes = Vec::new();
    let read = File::open(path).and_then(|file| file.take(MAX_SIZE).read_to_end(&mut bytes));
    read.map_or_else(|_| Vec::new(), |_| bytes)
}

fn topics_in(text: &[u8]) -> Vec<String> {
    let starts = FOLDERS.iter().flat_map(|folder| {
        memmem::find_iter(text, folder).map(move |at| at + folder.len()).collect::<Vec<_>>()
    });
    let names = starts.map(|at| {
        let is_part = |byte: &&u8| byte.is_ascii_alphanumeric() || **byte == b'_';
        text[at..].iter().take_while(is_part).map(|byte| char::from(*byte)).collect::<String>()
    });
    names.filter(|name| !name.is_empty()).flat_map(with_unversioned).collect()
}

/// A name, and the name without its version if it has one.
fn with_unversioned(name: String) -> Vec<String> {
    let unversioned = uavspec_rules::definitions::unversioned(&name).map(str::to_owned);
    std::iter::once(name).chain(unversioned).collect()
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::PathBuf;

    use super::*;

    #[test]
    fn uses_the_topics_that_files_name() {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &str| {
            let path: PathBuf = folder.path().join(name);
            fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            fs::write(path, text).expect("a file");
        };
        write("msgs/msg/Wind.msg", "uint64 timestamp\nfloat32 speed\n");
        write("msgs/msg/Gust.msg", "uint64 timestamp\nfloat32 speed\n");
        let all = Application::load(folder.path()).expect("an application");
        assert_eq!((all.types.len(), all.note), (2, None));
        write("app/node.cpp", "subscribe(\"/fmu/out/wind_v2\"); publish(\"fmu/in/\" + name);");
        write("app/notes.txt", "/fmu/out/gust");
        let some = Application::load(folder.path()).expect("an application");
        assert_eq!(some.types.len(), 1);
        assert_eq!(some.types[0].topics, ["wind"]);
        assert!(some.note.expect("a note").starts_with("only 1 topic of the application"));
    }
}
