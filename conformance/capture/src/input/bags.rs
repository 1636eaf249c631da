//! Groups the files of bags that a folder contains.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::Files;
use crate::rosbag::metadata::{FILE_NAME, Metadata};

/// Replaces the files that a bag's `metadata.yaml` lists with the bag's folder. `from` is the index of the first
/// capture to consider. Other files in the folder of a bag stay separate captures.
pub(super) fn group(files: &mut Files, from: usize) {
    let mut bags: BTreeMap<PathBuf, BTreeSet<String>> = BTreeMap::new();
    files.skipped.retain(|(path, _)| {
        let Some(folder) = path.parent().filter(|_| path.file_name().is_some_and(|name| name == FILE_NAME))
        else {
            return true;
        };
        let Ok(Some(metadata)) = Metadata::read(folder) else { return true };
        bags.insert(folder.to_owned(), metadata.files.into_iter().collect());
        false
    });
    if bags.is_empty() {
        return;
    }
    let bag_of = |path: &Path| {
        let (folder, names) = bags.get_key_value(path.parent()?)?;
        names.contains(path.file_name()?.to_str()?).then(|| folder.clone())
    };
    let mut grouped = BTreeSet::new();
    for path in files.captures.split_off(from) {
        match bag_of(&path) {
            None => files.captures.push(path),
            Some(folder) if grouped.insert(folder.clone()) => files.captures.push(folder),
            Some(_) => {}
        }
    }
    // Bags without files. Their check reports this.
    files.captures.extend(bags.into_keys().filter(|folder| !grouped.contains(folder)));
}
