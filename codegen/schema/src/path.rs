//! Lexical operations on paths.

use std::path::{Component, Path, PathBuf};

/// Removes `.` and `a/..` from a path, without access to the file system.
pub fn normalise(path: &Path) -> PathBuf {
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

/// The relative URL from a page in the folder `from` to the folder `to`.
pub fn seen_from(from: &Path, to: &Path) -> String {
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
    fn finds_the_relative_path_between_folders() {
        for (from, to, expected) in [
            ("../generated/docs", "../generated/schemas", "../schemas"),
            ("docs/messages", "./schemas", "../../schemas"),
            ("docs", "docs/schemas", "schemas"),
        ] {
            assert_eq!(seen_from(Path::new(from), Path::new(to)), expected);
        }
    }
}
