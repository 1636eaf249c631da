//! Translated pages: their paths, and the links between languages.

use uavspec_schema::prose;
use uavspec_schema::translation::{SOURCE_LANGUAGE, is_right_to_left};

use super::markdown::{Page, href, inline, link};
use super::site::{Site, path_in};
use super::words::{Word, Words};

/// A main heading in Markdown, both in the page language and in English.
pub(super) struct Heading<'h> {
    pub(super) text: &'h str,
    pub(super) english: &'h str,
}

/// Starts a page about `unit` in the site language. Adds the main heading and links to other languages. `english` is
/// the path of the English page.
pub(super) fn page(site: &Site<'_>, unit: &str, english: &str, heading: &Heading<'_>) -> Page {
    let path = site.path_of(english, unit);
    let mut page = Page::without_heading(&path);
    if let Some(language) = site.language.filter(|_| !site.words.are_english()) {
        page.begin_language(&attributes(&language.tag));
    }
    if heading.text == heading.english {
        page.heading(1, heading.text);
    } else {
        page.heading_for(1, heading.text, heading.english);
    }
    page.block(&switch(site, unit, english, &path));
    page
}

/// Links to the page in all languages, or an empty string if it is not translated.
fn switch(site: &Site<'_>, unit: &str, english: &str, from: &str) -> String {
    let mut others = site.languages_of(unit).peekable();
    if others.peek().is_none() {
        return String::new();
    }
    let current = site.language.map_or(SOURCE_LANGUAGE, |language| language.tag.as_str());
    let others = others
        .map(|language| (language.tag.as_str(), language.name.as_str(), path_in(english, &language.tag)));
    let all = std::iter::once((SOURCE_LANGUAGE, "English", english.to_owned())).chain(others);
    let entry = |(tag, name, path): (&str, &str, String)| {
        let is_current = tag == current;
        let name = if is_current { inline(name) } else { marked(&inline(name), Some(tag)) };
        if is_current { name } else { link(&name, &href(from, &path, "")) }
    };
    all.map(entry).collect::<Vec<_>>().join(" · ")
}

/// Adds a fixed heading, whose anchor is the same in all languages.
pub(super) fn heading(page: &mut Page, words: Words, level: usize, word: Word) {
    if words.are_english() {
        page.heading(level, word.english());
    } else {
        page.heading_for(level, words.get(word), word.english());
    }
}

/// Marks the language of inline Markdown for screen readers. `tag` is `None` for the page language.
pub(super) fn marked(markdown: &str, tag: Option<&str>) -> String {
    match tag {
        Some(tag) if !markdown.is_empty() => format!("<span {}>{markdown}</span>", attributes(tag)),
        _ => markdown.to_owned(),
    }
}

/// Like [`marked`], for paragraphs.
pub(super) fn marked_block(markdown: &str, tag: Option<&str>) -> String {
    match tag {
        Some(tag) if !markdown.is_empty() => format!("<div {}>\n\n{markdown}\n\n</div>", attributes(tag)),
        _ => markdown.to_owned(),
    }
}

/// The HTML attributes for a language.
fn attributes(tag: &str) -> String {
    let direction = if is_right_to_left(tag) { " dir=\"rtl\"" } else { "" };
    format!("lang=\"{}\"{direction}", prose::xml(tag))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_text_in_other_languages() {
        assert_eq!(marked("a", Some("uk")), "<span lang=\"uk\">a</span>");
        assert_eq!(marked("a", None), "a");
        assert_eq!(marked_block("a", Some("ar")), "<div lang=\"ar\" dir=\"rtl\">\n\na\n\n</div>");
        assert_eq!(marked_block("", Some("ar")), "");
    }
}
