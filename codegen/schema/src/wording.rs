//! Parts of sentences: counts, large numbers, and suggestions for misspelt names.

use std::fmt::Display;

/// The maximum length of a name, in bytes. Comparing two texts takes time proportional to the product of their lengths.
const MAX_NAME: usize = 100;

/// A count with its noun, such as `2 bytes`.
pub fn plural<N: Copy + PartialEq + From<u8> + Display>(count: N, noun: &str) -> String {
    let ending = if count == N::from(1) { "" } else { "s" };
    format!("{} {noun}{ending}", thousands(count))
}

/// A natural number with thousands separators, such as `1,234,567`.
pub fn thousands(number: impl Display) -> String {
    let digits = number.to_string();
    let mut grouped = String::with_capacity(digits.len() + digits.len() / 3);
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    grouped
}

/// The most similar of the known names, if one is similar.
pub fn similar<'k>(name: &str, known: impl IntoIterator<Item = &'k str>) -> Option<&'k str> {
    let max_distance = |known: &str| 1 + known.len() / 5;
    known
        .into_iter()
        .filter(|known| name.len() <= MAX_NAME && known.len().abs_diff(name.len()) <= max_distance(known))
        .map(|known| (strsim::damerau_levenshtein(known, name), known))
        .filter(|(distance, known)| *distance <= max_distance(known))
        .min()
        .map(|(_, known)| known)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_have_separators_and_a_plural() {
        assert_eq!([0, 1, 2, 1_234_567].map(|count| plural(count, "file")).join(", "), {
            "0 files, 1 file, 2 files, 1,234,567 files"
        });
        assert_eq!([999, 1_000, 12_345].map(thousands), ["999", "1,000", "12,345"]);
    }

    #[test]
    fn suggests_only_similar_names() {
        let suggested = |name| similar(name, ["FW-TCP-03", "FW-UDP-03", "UAV-INF"]);
        assert_eq!(suggested("FW-TPC-03"), Some("FW-TCP-03"));
        assert_eq!(suggested("UAVINF"), Some("UAV-INF"));
        assert_eq!(suggested("wind"), None);
        assert_eq!(suggested(&"x".repeat(10_000)), None);
    }
}
