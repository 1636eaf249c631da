//! Tests of translated books.

use pulldown_cmark::{Event, Tag};
use uavspec_schema::SourceMap;
use uavspec_schema::translation::catalogue::{Catalogue, print};
use uavspec_schema::translation::{Text, new_catalogue, resolve, texts, update};

use super::{BOATS, anchors, check_links, definitions, events, is, targets, text_of};
use crate::docs::{Options, emit};
use crate::file::OutputFile;

/// The book about boats, with translations into the language `tag`. `translate` returns an empty text if there is no
/// translation.
fn boats_in(tag: &str, translate: impl Fn(&Text<'_>) -> String) -> Vec<OutputFile> {
    let (mut sources, schema) = definitions(BOATS);
    let texts = texts(&schema);
    let select = texts.iter().map(|text| text.unit.clone()).collect();
    let mut catalogue: Catalogue = update(&new_catalogue(tag), &sources, &texts, &select);
    // The first entry is the header.
    for (entry, text) in catalogue.entries.iter_mut().skip(1).zip(&texts) {
        entry.translation = translate(text);
    }
    let mut with_catalogue: SourceMap = std::mem::take(&mut sources);
    let id = with_catalogue.add(format!("{tag}.po"), print(&catalogue).into_bytes()).expect("a text");
    let (translations, _) = resolve(&with_catalogue, &schema, &[id]);
    emit(&schema, &translations, &with_catalogue, &Options::default())
}

fn in_quotes(text: &Text<'_>) -> String {
    format!("«{}»", text.text)
}

/// Pairs of an English page and its translation.
fn pairs<'f>(files: &'f [OutputFile], tag: &str) -> Vec<(&'f OutputFile, &'f OutputFile)> {
    let ending = format!(".{tag}.md");
    let translated = files.iter().filter(|file| file.path.ends_with(&ending));
    let english = |path: &str| path.replace(&ending, ".md");
    translated
        .map(|file| {
            let english = files.iter().find(|other| other.path == english(&file.path));
            (english.expect("the English page"), file)
        })
        .collect()
}

#[test]
fn keeps_the_anchors_of_the_english_page() {
    let files = boats_in("uk", in_quotes);
    check_links(&files);
    let targets = targets(&files);
    let pairs = pairs(&files, "uk");
    assert_eq!(pairs.len(), 9, "all pages with translatable texts");
    for (english, translated) in pairs {
        let (expected_targets, found) = (&targets[english.path.as_str()], &targets[translated.path.as_str()]);
        assert!(
            expected_targets.is_subset(found),
            "{}: {:?}",
            translated.path,
            expected_targets.difference(found)
        );
        let (expected_targets, found) = (anchors(&english.text), anchors(&translated.text));
        assert!(expected_targets.iter().all(|place| found.contains(place)), "{}", translated.path);
    }
}

#[test]
fn writes_a_page_in_one_language() {
    let files = boats_in("uk", in_quotes);
    for (english, translated) in pairs(&files, "uk") {
        let path = &translated.path;
        assert!(translated.text.contains("\n<div lang=\"uk\">\n\n"), "{path}");
        assert!(translated.text.ends_with("\n\n</div>\n"), "{path}");
        assert_eq!(translated.text.matches("lang=\"en\"").count(), 1, "the link to English in {path}");
        let headings = |text| {
            let is_counted =
                |event: &Event<'_>| matches!(event, Event::Start(Tag::Heading { .. } | Tag::Table(_)));
            events(text).iter().filter(|event| is_counted(event)).count()
        };
        assert_eq!(headings(&english.text), headings(&translated.text), "{path}");
    }
    let boat = text_of(&files, "boats/Boat.uk.md");
    for expected in
        ["\n## Поля\n", "\n[<span lang=\"en\">English</span>](Boat.md) · Українська\n", "](Boat.svg)"]
    {
        assert!(boat.contains(expected), "{expected}\nis not in\n{boat}");
    }
    assert!(
        text_of(&files, "boats/Boat.md")
            .contains("\nEnglish · [<span lang=\"uk\">Українська</span>](Boat.uk.md)\n")
    );
    let rig = text_of(&files, "boats/RigStatus.uk.md");
    assert!(rig.contains("](Sail.uk.md)") && !rig.contains("](Sail.md)"), "{rig}");
    let summary = text_of(&files, "SUMMARY.md");
    let listed = pairs(&files, "uk").iter().all(|(_, page)| summary.contains(&format!("({})", page.path)));
    assert!(listed, "{summary}");
}

#[test]
fn marks_untranslated_text_as_english() {
    let files =
        boats_in("uk", |text| if text.key == "boats/Boat.hull" { in_quotes(text) } else { String::new() });
    let boat = text_of(&files, "boats/Boat.uk.md");
    assert!(boat.contains(" «Colour» |") && boat.contains(" <span lang=\"en\">Red</span> |"), "{boat}");
    assert_eq!(pairs(&files, "uk").len(), 1);
    check_links(&files);
}

#[test]
fn marks_translations_in_languages_without_fixed_texts() {
    let files = boats_in("ar", in_quotes);
    let boat = text_of(&files, "boats/Boat.ar.md");
    assert!(
        boat.contains("\n## Fields\n") && !boat.contains("<div lang=\"ar\" dir=\"rtl\">\n\n# "),
        "{boat}"
    );
    assert!(boat.contains("<span lang=\"ar\" dir=\"rtl\">«"), "{boat}");
    check_links(&files);
}

#[test]
fn escapes_translations() {
    let files = boats_in("uk", |_| "<script>[x](y) | {{#include z}} `".to_owned());
    for file in files.iter().filter(|file| is(file, "md")) {
        assert!(!file.text.contains("{{#"), "{}", file.path);
        for event in events(&file.text) {
            let is_markup = match &event {
                Event::Html(html) | Event::InlineHtml(html) => html.contains("<script"),
                Event::Start(Tag::Link { dest_url, .. }) => **dest_url == *"y",
                _ => false,
            };
            assert!(!is_markup, "{}: {event:?}", file.path);
        }
    }
}
