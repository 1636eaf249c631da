//! The glob patterns of entries.

use globset::{GlobBuilder, GlobMatcher, escape};

/// A compiled glob.
#[derive(Debug)]
pub(super) struct Pattern {
    matcher: GlobMatcher,
}

impl Pattern {
    /// Compiles a pattern for names. `*` matches anything, as in `--filter`.
    pub(super) fn for_names(text: &str) -> Result<Self, String> {
        Self::new(text, false)
    }

    /// Compiles a pattern for paths. `*` stops at `/`, but `**` doesn't.
    pub(super) fn for_paths(text: &str) -> Result<Self, String> {
        Self::new(text.strip_prefix("./").unwrap_or(text), true)
    }

    fn new(text: &str, is_path: bool) -> Result<Self, String> {
        let glob = GlobBuilder::new(text).literal_separator(is_path).build();
        let glob = glob.map_err(|error| error.kind().to_string())?;
        Ok(Self { matcher: glob.compile_matcher() })
    }

    pub(super) fn is_match(&self, text: &str) -> bool {
        self.matcher.is_match(text.strip_prefix("./").unwrap_or(text))
    }
}

/// A pattern that matches exactly these names.
pub(super) fn exact(names: &[String]) -> String {
    let Some((first, others)) = names.split_first() else { return String::new() };
    if others.is_empty() {
        return escape(first);
    }
    // An alternative can't be empty. The text after the last common `/` is never empty.
    let is_common = |end: &usize| others.iter().all(|name| name.starts_with(&first[..*end]));
    let start = first.rmatch_indices('/').map(|(at, _)| at + 1).find(is_common).unwrap_or(0);
    let rests = names.iter().map(|name| escape(&name[start..]).replace(',', "[,]"));
    format!("{}{{{}}}", escape(&first[..start]), rests.collect::<Vec<_>>().join(","))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_star_stops_at_slashes_in_paths_only() {
        let name = Pattern::for_names("decode-*/px4/Event/*").expect("a pattern");
        assert!(
            name.is_match("decode-cdr/px4/Event/typical") && !name.is_match("encode-cdr/px4/Event/typical")
        );
        assert!(Pattern::for_names("glider.*").expect("a pattern").is_match("glider.marks.height"));
        let path = Pattern::for_paths("logs/2019-*.ulg").expect("a pattern");
        assert!(path.is_match("logs/2019-07.ulg") && path.is_match("./logs/2019-07.ulg"));
        assert!(!path.is_match("logs/2019-07/a.ulg") && !path.is_match("old/logs/2019-07.ulg"));
        assert!(Pattern::for_paths("./**/*.ulg").expect("a pattern").is_match("old/logs/2019-07.ulg"));
        assert!(Pattern::for_names("[").is_err());
    }

    #[test]
    fn an_exact_pattern_matches_only_its_names() {
        let pattern_of =
            |names: &[&str]| exact(&names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>());
        assert_eq!(pattern_of(&["hash-cdr/px4/Glider/hash"]), "hash-cdr/px4/Glider/hash");
        assert_eq!(pattern_of(&["a/Glider/x", "a/Glider/x-y"]), "a/Glider/{x,x-y}");
        assert_eq!(pattern_of(&["a/Glider/x", "a/Mark/x", "a/Glider/y"]), "a/{Glider/x,Mark/x,Glider/y}");
        let odd = ["a/b,c", "a/[0]*", "a/{x}", "b"];
        let pattern = Pattern::for_names(&pattern_of(&odd)).expect("a pattern");
        assert!(odd.iter().all(|name| pattern.is_match(name)));
        assert!(["a/b", "a/c", "c", "a/0", "a/x", "a/"].iter().all(|name| !pattern.is_match(name)));
    }
}
