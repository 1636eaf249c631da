//! The application that `uavspec probe --application` compares with a vehicle.

use std::collections::BTreeSet;
use std::path::Path;

use uavspec_compat::{Hints, definitions_in};
use uavspec_model::ApplicationType;
use uavspec_model::text::{plural, terminal};
use uavspec_schema::msg::Dialect;

use crate::app::{Status, library};

/// An application.
pub(super) struct Application {
    /// The types of the topics that the application uses.
    pub types: Vec<ApplicationType>,
    /// A note for the report, if the application doesn't use all types of its definitions.
    pub note: Option<String>,
}

impl Application {
    /// Reads the definitions of a path or a release. If the sources in the folder name PX4 topics, the application uses
    /// only these.
    pub(super) fn load(path: &Path) -> Result<Self, Status> {
        let package = definitions_in(path);
        let definitions = library(Some(package.as_deref().unwrap_or(path)), Some(Dialect::Px4), &[])?;
        let schema = &definitions.base().schema;
        let mut types = ApplicationType::all(schema);
        if !path.is_dir() {
            return Ok(Self { types, note: None });
        }
        let sources = uavspec_compat::Application::read(path, &[schema], &Hints::default())
            .map_err(|failure| Status::Unreadable.failed(&failure))?;
        let named: BTreeSet<&String> = sources.uses.iter().map(|used| &used.topic.name).collect();
        if named.is_empty() {
            return Ok(Self { types, note: None });
        }
        for ty in &mut types {
            ty.topics.retain(|topic| named.contains(topic));
        }
        types.retain(|ty| !ty.topics.is_empty());
        let count: usize = types.iter().map(|ty| ty.topics.len()).sum();
        let note = format!(
            "only {} of the application can be compared, because uavspec finds no other names in {}",
            plural(count, "topic"),
            terminal::path(path)
        );
        Ok(Self { types, note: Some(note) })
    }
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
