//! Suggestions for misspelt names.

/// The maximum length of a name, in bytes. Longer texts are not names.
const MAX_NAME: usize = 100;

/// The most similar of the known names, if one is similar.
pub(crate) fn similar<'k>(name: &str, known: impl Iterator<Item = &'k str>) -> Option<&'k str> {
    let is_similar = |(distance, known): &(usize, &str)| *distance <= 1 + known.len() / 5;
    let short = known.filter(|_| name.len() <= MAX_NAME);
    let distances = short.map(|known| (strsim::damerau_levenshtein(known, name), known));
    distances.filter(is_similar).min().map(|(_, known)| known)
}

#[cfg(test)]
mod tests {
    use super::similar;

    #[test]
    fn suggests_only_similar_names() {
        let known = ["FW-TCP-03", "FW-UDP-03", "UAV-INF"];
        let suggested = |name| similar(name, known.into_iter());
        assert_eq!(suggested("FW-TPC-03"), Some("FW-TCP-03"));
        assert_eq!(suggested("UAVINF"), Some("UAV-INF"));
        assert_eq!(suggested("wind"), None);
        assert_eq!(suggested(&"x".repeat(10_000)), None);
    }
}
