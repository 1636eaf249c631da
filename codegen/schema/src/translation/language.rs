//! Language tags and native names of languages.

/// The language of definitions.
pub const SOURCE_LANGUAGE: &str = "en";

/// Native names of common languages, by tag. The header of a catalogue can override the name.
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

/// The native name of a language. If the tag is unknown, its shorter forms are tried. If these are unknown too, the tag
/// itself is returned.
pub fn name(tag: &str) -> &str {
    shorter(tag)
        .find_map(|tag| NAMES.iter().find(|(known, _)| known.eq_ignore_ascii_case(tag)))
        .map_or(tag, |(_, name)| name)
}

/// Yields a tag, then the tag without its last part, and so on.
pub fn shorter(tag: &str) -> impl Iterator<Item = &str> {
    std::iter::successors(Some(tag), |tag| tag.rsplit_once('-').map(|(start, _)| start))
}

/// True if a text has the form of a BCP 47 tag: a language of two or three letters, followed by parts of up to eight
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

/// True if a language is written from right to left.
pub fn is_right_to_left(tag: &str) -> bool {
    let mut parts = tag.split('-');
    let language = parts.next().unwrap_or_default();
    // A script tag (four letters) takes precedence over the language.
    let script = parts.find(|part| part.len() == 4 && part.bytes().all(|byte| byte.is_ascii_alphabetic()));
    RIGHT_TO_LEFT.contains(&script.unwrap_or(language).to_ascii_lowercase().as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_native_name_of_the_nearest_tag() {
        assert_eq!(name("uk"), "Українська");
        assert_eq!(name("uk-UA"), "Українська");
        assert_eq!(name("pt-BR"), "Português (Brasil)");
        assert_eq!(name("tlh"), "tlh");
    }

    #[test]
    fn accepts_only_valid_tags() {
        for tag in ["uk", "pt-BR", "zh-Hant-TW", "sr-Latn", "gsw"] {
            assert!(is_tag(tag), "{tag}");
        }
        for text in ["", "UK", "uk_UA", "ukrainian", "u", "uk-", "uk-toolongapart", "uk/../x", "укр"] {
            assert!(!is_tag(text), "{text}");
        }
    }

    #[test]
    fn takes_the_direction_from_the_script() {
        assert!(is_right_to_left("ar") && is_right_to_left("fa-IR") && is_right_to_left("az-Arab"));
        assert!(!is_right_to_left("uk") && !is_right_to_left("ur-Latn"));
    }
}
