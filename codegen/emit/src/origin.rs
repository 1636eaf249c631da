//! Paths of definitions relative to the folder of their package. Outputs therefore don't depend on where the
//! definitions are stored.

use std::collections::{BTreeSet, HashMap};

use uavspec_schema::source::{SourceId, SourceMap, Span};
use uavspec_schema::{Package, Schema};

/// Relative paths of all definitions of a schema.
#[derive(Debug)]
pub(super) struct Origins<'s> {
    sources: &'s SourceMap,
    /// For each source, the byte length of the package folder at the start of its path.
    folders: HashMap<SourceId, usize>,
}

impl<'s> Origins<'s> {
    pub(super) fn new(schema: &Schema, sources: &'s SourceMap) -> Self {
        let mut folders = HashMap::new();
        for package in &schema.packages {
            let ids: BTreeSet<SourceId> =
                spans(schema, package).map(|span| sources.source_of(span)).collect();
            let folder = shared_folder(ids.iter().map(|id| sources.path(*id)));
            folders.extend(ids.into_iter().map(|id| (id, folder)));
        }
        Self { sources, folders }
    }

    /// Path of the definition that contains `span`, relative to the package folder.
    pub(super) fn path(&self, span: Span) -> &'s str {
        let id = self.sources.source_of(span);
        let folder = self.folders.get(&id).copied().unwrap_or_default();
        self.sources.path(id).get(folder..).unwrap_or_default()
    }
}

/// The spans of all definitions of a package.
fn spans(schema: &Schema, package: &Package) -> impl Iterator<Item = Span> {
    let messages = package.messages.iter().map(|id| schema.message(*id).span);
    let interfaces = package.interfaces.iter().map(|interface| interface.span);
    let tables = package.error_tables.iter().map(|table| table.span);
    let types = package.json_types.iter().map(|id| schema.json_type(*id).span);
    let json_messages = package.json_messages.iter().map(|id| schema.json_message(*id).span);
    messages.chain(interfaces).chain(tables).chain(types).chain(json_messages)
}

/// Byte length of the longest common folder prefix of `paths`, including the last separator.
fn shared_folder<'p>(mut paths: impl Iterator<Item = &'p str>) -> usize {
    let folder = |path: &str| path.rfind(['/', '\\']).map_or(0, |separator| separator + 1);
    let Some(first) = paths.next() else { return 0 };
    paths.fold(folder(first), |shared, path| {
        let equal = first[..shared].bytes().zip(path.bytes()).take_while(|(left, right)| left == right);
        let equal = equal.count();
        let is_separator = |byte: &u8| matches!(byte, b'/' | b'\\');
        first.as_bytes()[..equal].iter().rposition(is_separator).map_or(0, |separator| separator + 1)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shared_folder_ends_at_a_separator() {
        for (paths, expected) in [
            (&["A.msg"][..], ""),
            (&["/home/px4/msg/A.msg"], "/home/px4/msg/"),
            (&["px4/msg/A.msg", "px4/msg/versioned/B.msg"], "px4/msg/"),
            (&["px4/msg/A.msg", "px4/srv/A.srv", "px4/srv/B.srv"], "px4/"),
            (&["px4/A.msg", "px4_msgs/B.msg"], ""),
            (&["é/A.msg", "è/B.msg"], ""),
            (&["C:\\px4\\A.msg", "C:\\px4\\B.msg"], "C:\\px4\\"),
        ] {
            let shared = shared_folder(paths.iter().copied());
            assert_eq!(&paths[0][..shared], expected, "{paths:?}");
        }
    }
}
