//! The definitions of a PX4 type in all releases.

use std::collections::{BTreeSet, HashMap};

use uavspec_codegen::msg::Dialect;
use uavspec_codegen::schema::Message;
use uavspec_codegen::schema::fingerprint::{hashed_text, ros_name};
use uavspec_codegen::{SourceMap, read, release};
use uavspec_runtime::Definition;

use super::index::{Family, Index, ReleaseId, Row};

/// A definition that releases contain.
#[derive(Debug)]
pub(crate) struct ReleasedType {
    /// The releases from the oldest to the newest, such as `px4@1.16`.
    releases: Vec<String>,
    /// The text that PX4's hash covers.
    pub(crate) fields: String,
}

impl ReleasedType {
    /// The releases in text.
    pub(crate) fn releases(&self) -> String {
        match &self.releases[..] {
            [first, .., last] => format!("{first} to {last}"),
            releases => releases.concat(),
        }
    }
}

/// The definition with a full ROS name and PX4's hash.
pub(crate) fn released_type(name: &str, hash: u32) -> Option<ReleasedType> {
    let index = Index::built_in();
    let rows: Vec<&Row> = index.of_name(name).filter(|row| row.hash == hash).collect();
    let releases: BTreeSet<_> = rows.iter().flat_map(|row| row.releases.iter()).collect();
    let text = release::select(&index.release(*releases.last()?).text(), &BTreeSet::from([name]));
    let mut sources = SourceMap::default();
    let packages = release::packages(&text, Dialect::Px4, "", &mut sources);
    let (schema, _) = read(&sources, &packages);
    let is_named = |message: &&Message| ros_name(&schema, message) == name;
    let fields = hashed_text(&schema, schema.messages.iter().find(is_named)?);
    Some(ReleasedType { releases: releases.into_iter().map(|id| index.label(id)).collect(), fields })
}

/// PX4's hash of each topic in a firmware that has these types. The other types are those of the release that has most of
/// these types.
pub(crate) fn topic_hashes(types: &[Definition]) -> HashMap<String, u32> {
    let index = Index::built_in();
    let is_shared = |row: &&Row| types.iter().any(|ty| ty.type_hash == row.type_hash);
    let shared: Vec<&Row> = index.rows().iter().filter(is_shared).collect();
    let count = |release: &ReleaseId| shared.iter().filter(|row| row.releases.contains(*release)).count();
    let releases = index.releases_of(Family::Px4).filter(|release| !index.is_moving(*release));
    let Some(release) = releases.max_by_key(count) else { return HashMap::new() };
    let rows = index.rows().iter().filter(|row| row.releases.contains(release));
    let others = rows.flat_map(|row| row.topics.iter().map(|topic| (topic.clone(), row.hash)));
    let own = types.iter().flat_map(|ty| ty.topics.iter().map(|topic| ((*topic).to_owned(), ty.hash)));
    others.chain(own).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_releases_of_each_hash() {
        let index = Index::built_in();
        let name = "px4_msgs/msg/VehicleStatus";
        let mut texts = BTreeSet::new();
        for row in index.of_name(name) {
            let found = released_type(name, row.hash).expect("a definition");
            assert!(found.releases.len() >= row.releases.iter().count());
            texts.insert(found.fields);
        }
        assert!(texts.len() > 3 && texts.iter().all(|text| text.starts_with("uint64 timestamp\n")));
        assert!(released_type(name, 0).is_none());
    }
}
