//! The patterns of entries.

use globset::{GlobBuilder, GlobMatcher, escape};

/// The names that an entry matches. Most names need no compiled glob, which takes more time and memory.
#[derive(Debug)]
pub(super) enum Pattern {
    Exact(String),
    Glob(GlobMatcher),
}

impl Pattern {
    /// Compiles a pattern for names. `*` matches anything.
    pub(super) fn for_names(text: &str) -> Result<Self, String> {
        Self::new(text, false)
    }

    /// Compiles a pattern for [`plain`] paths. `*` stops at `/`, but `**` doesn't.
    pub(super) fn for_paths(text: &str) -> Result<Self, String> {
        Self::new(plain(text), true)
    }

    fn new(text: &str, is_path: bool) -> Result<Self, String> {
        if !text.contains(['*', '?', '[', ']', '{', '}', '\\']) {
            return Ok(Self::Exact(text.to_owned()));
        }
        let glob = GlobBuilder::new(text).literal_separator(is_path).build();
        Ok(Self::Glob(glob.map_err(|error| error.kind().to_string())?.compile_matcher()))
    }

    pub(super) fn is_match(&self, text: &str) -> bool {
        match self {
            Self::Exact(name) => name == text,
            Self::Glob(glob) => glob.is_match(text),
        }
    }
}

/// A path without a leading `./`.
pub(super) fn plain(path: &str) -> &str {
    path.strip_prefix("./").unwrap_or(path)
}

/// A pattern that matches exactly these names.
pub(super) fn exact(names: &[String]) -> String {
    let Some((first, others)) = names.split_first() else { return String::new() };
    if others.is_empty() {
        return escape(first);
    }
    // Split the names after the last common `/`, because an alternative can't be empty. The text after this `/` is
    // never empty.
    let is_common = |end: &usize| others.iter().all(|name| name.starts_with(&first[..*end]));
    let start = first.rmatch_indices('/').map(|(at, _)| at + 1).find(is_common).unwrap_or(0);
    let rests = names.iter().map(|name| escape(&name[start..]).replace(',', "[,]"));
    format!("{}{{{}}}", escape(&first[..start]), rests.collect::<Vec<_>>().join(","))
}
