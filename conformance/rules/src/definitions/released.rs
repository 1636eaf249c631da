//! The definitions of a PX4 type in all releases.

use uavspec_schema::fingerprint::hashed_text;
use uavspec_schema::msg::Dialect;

use super::index::{Index, ReleaseSet, read_definition};

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
    let rows = index.of_name(name).filter(|row| row.hash == hash);
    let releases = rows.fold(ReleaseSet::default(), |all, row| all.union(row.releases));
    let text = index.release(releases.iter().next_back()?).text();
    let (schema, id) = read_definition(text, name, Dialect::Px4)?;
    let fields = hashed_text(&schema, schema.message(id));
    Some(ReleasedType { releases: releases.iter().map(|id| index.label(id)).collect(), fields })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

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
