//! Paths by their texts.

use std::path::{Component, Path, PathBuf};

/// Takes `.` and `a/..` out of a path, by its text alone.
pub(crate) fn normalise(path: &Path) -> PathBuf {
    let mut normal = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir if matches!(normal.components().next_back(), Some(Component::Normal(_))) => {
                normal.pop();
            }
            component => normal.push(component),
        }
    }
    normal
}

/// The path of the folder `to` as an address in a page of the folder `from`, by their texts alone.
pub(crate) fn seen_from(from: &Path, to: &Path) -> String {
    let (from, to) = (normalise(from), normalise(to));
    let shared = from.components().zip(to.components()).take_while(|(left, right)| left == right).count();
    let up = from.components().skip(shared).map(|_| "..".to_owned());
    let down = to.components().skip(shared).map(|part| part.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_are_seen_from_each_other() {
        for (from, to, expected) in [
            ("../generated/docs", "../generated/schemas", "../schemas"),
            ("docs/messages", "./schemas", "../../schemas"),
            ("docs", "docs/schemas", "schemas"),
        ] {
            assert_eq!(seen_from(Path::new(from), Path::new(to)), expected);
        }
    }
}
