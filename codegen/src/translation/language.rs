//! Tags of languages, and what languages call themselves.

/// The language that definitions are written in.
pub const SOURCE_LANGUAGE: &str = "en";

/// What languages call themselves, by tag: those that people who work with drones write most. The header of a
/// catalogue may say it otherwise.
const NAMES: &[(&str, &str)] = &[
    ("ar", "العربية"),
    ("bg", "Български"),
    ("ca", "Català"),
    ("cs", "Čeština"),
    ("da", "Dansk"),
    ("de", "Deutsch"),
    ("el", "Ελληνικά"),
    ("en", "English"),
    ("es", "Español"),
    ("et", "Eesti"),
    ("fa", "فارسی"),
    ("fi", "Suomi"),
    ("fr", "Français"),
    ("he", "עברית"),
    ("hi", "हिन्दी"),
    ("hr", "Hrvatski"),
    ("hu", "Magyar"),
    ("id", "Bahasa Indonesia"),
    ("it", "Italiano"),
    ("ja", "日本語"),
    ("ka", "ქართული"),
    ("ko", "한국어"),
    ("lt", "Lietuvių"),
    ("lv", "Latviešu"),
    ("nb", "Norsk bokmål"),
    ("nl", "Nederlands"),
    ("pl", "Polski"),
    ("pt", "Português"),
    ("pt-BR", "Português (Brasil)"),
    ("ro", "Română"),
    ("ru", "Русский"),
    ("sk", "Slovenčina"),
    ("sl", "Slovenščina"),
    ("sr", "Српски"),
    ("sv", "Svenska"),
    ("th", "ไทย"),
    ("tr", "Türkçe"),
    ("uk", "Українська"),
    ("ur", "اردو"),
    ("vi", "Tiếng Việt"),
    ("zh", "中文"),
    ("zh-CN", "简体中文"),
    ("zh-Hans", "简体中文"),
    ("zh-Hant", "繁體中文"),
    ("zh-TW", "繁體中文"),
];

/// Languages and scripts that are written from right to left.
const RIGHT_TO_LEFT: &[&str] = &["ar", "arab", "ckb", "dv", "fa", "he", "hebr", "ps", "sd", "ug", "ur", "yi"];

/// What a language calls itself: that of its tag, or of the tag without its last parts. Of one that the table
/// doesn't know it is the tag.
pub(crate) fn name(tag: &str) -> &str {
    shorter(tag)
        .find_map(|tag| NAMES.iter().find(|(known, _)| known.eq_ignore_ascii_case(tag)))
        .map_or(tag, |(_, name)| name)
}

/// A tag, then the same without its last part, and so on.
pub(crate) fn shorter(tag: &str) -> impl Iterator<Item = &str> {
    std::iter::successors(Some(tag), |tag| tag.rsplit_once('-').map(|(start, _)| start))
}

/// Whether a text has the form of a tag of BCP 47: a language of two or three letters, and parts of up to eight
/// letters and digits.
pub fn is_tag(text: &str) -> bool {
    let mut parts = text.split('-');
    let is_language = parts.next().is_some_and(|part| {
        matches!(part.len(), 2..=3) && part.bytes().all(|byte| byte.is_ascii_lowercase())
    });
    let is_part =
        |part: &str| (1..=8).contains(&part.len()) && part.bytes().all(|byte| byte.is_ascii_alphanumeric());
    is_language && text.len() <= 35 && parts.all(is_part)
}

/// Whether a language is written from right to left.
pub fn is_right_to_left(tag: &str) -> bool {
    let mut parts = tag.split('-');
    let language = parts.next().unwrap_or_default();
    // A script of four letters says it, whatever the language.
    let script = parts.find(|part| part.len() == 4 && part.bytes().all(|byte| byte.is_ascii_alphabetic()));
    RIGHT_TO_LEFT.contains(&script.unwrap_or(language).to_ascii_lowercase().as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_language_calls_itself_by_the_nearest_tag() {
        assert_eq!(name("uk"), "Українська");
        assert_eq!(name("uk-UA"), "Українська");
        assert_eq!(name("pt-BR"), "Português (Brasil)");
        assert_eq!(name("tlh"), "tlh");
    }

    #[test]
    fn tags_have_their_form() {
        for tag in ["uk", "pt-BR", "zh-Hant-TW", "sr-Latn", "gsw"] {
            assert!(is_tag(tag), "{tag}");
        }
        for text in ["", "UK", "uk_UA", "ukrainian", "u", "uk-", "uk-toolongapart", "uk/../x", "укр"] {
            assert!(!is_tag(text), "{text}");
        }
    }

    #[test]
    fn the_script_says_the_direction() {
        assert!(is_right_to_left("ar") && is_right_to_left("fa-IR") && is_right_to_left("az-Arab"));
        assert!(!is_right_to_left("uk") && !is_right_to_left("ur-Latn"));
    }
}
