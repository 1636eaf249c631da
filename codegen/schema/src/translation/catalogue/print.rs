//! Printer for catalogues. The printer breaks a string only after a line break in its text. Any other wrapping differs
//! between tools and would cause spurious diffs.

use super::entry::{Catalogue, Entry};

/// Prints a catalogue as text that parses to the same catalogue.
pub fn print(catalogue: &Catalogue) -> String {
    let mut text = String::new();
    for (index, entry) in catalogue.entries.iter().enumerate() {
        if index > 0 {
            text.push('\n');
        }
        print_entry(entry, &mut text);
    }
    if !catalogue.end.is_empty() && !text.is_empty() {
        text.push('\n');
    }
    lines(&mut text, "", &catalogue.end);
    text
}

fn print_entry(entry: &Entry, text: &mut String) {
    lines(text, "", &entry.comments);
    lines(text, "#. ", &entry.notes);
    lines(text, "#: ", &entry.references);
    if !entry.flags.is_empty() {
        line(text, "#, ", &entry.flags.join(", "));
    }
    let (mark, previous) = if entry.is_obsolete { ("#~ ", "#~| ") } else { ("", "#| ") };
    let parts = [
        (previous, "msgctxt", entry.previous_context.as_deref()),
        (previous, "msgid", entry.previous_id.as_deref()),
        (mark, "msgctxt", entry.context.as_deref()),
        (mark, "msgid", Some(entry.id.as_str())),
        (mark, "msgstr", Some(entry.translation.as_str())),
    ];
    for (mark, keyword, string) in parts {
        if let Some(string) = string {
            strings(text, mark, keyword, string);
        }
    }
}

/// Prints a string on a single line, or on one line for each line of its text.
fn strings(text: &mut String, mark: &str, keyword: &str, string: &str) {
    let parts: Vec<&str> = string.split_inclusive('\n').collect();
    if parts.len() <= 1 && !string.ends_with('\n') {
        line(text, mark, &format!("{keyword} {}", quote(string)));
        return;
    }
    line(text, mark, &format!("{keyword} \"\""));
    for part in parts {
        line(text, mark, &quote(part));
    }
}

fn lines(text: &mut String, mark: &str, lines: &[String]) {
    for content in lines {
        line(text, mark, content);
    }
}

fn line(text: &mut String, mark: &str, content: &str) {
    text.push_str(mark);
    text.push_str(content);
    let end = text.trim_end_matches(' ').len();
    text.truncate(end);
    text.push('\n');
}

fn quote(string: &str) -> String {
    let mut quoted = String::with_capacity(string.len() + 2);
    quoted.push('"');
    for character in string.chars() {
        match character {
            '\n' => quoted.push_str("\\n"),
            '\t' => quoted.push_str("\\t"),
            '\r' => quoted.push_str("\\r"),
            '"' | '\\' => quoted.extend(['\\', character]),
            _ => quoted.push(character),
        }
    }
    quoted.push('"');
    quoted
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::source::SourceMap;
    use crate::translation::catalogue::parse;

    fn read(text: &str) -> Catalogue {
        let mut sources = SourceMap::default();
        let id = sources.add("uk.po", text.as_bytes().to_vec()).expect("a text");
        let (catalogue, places, diagnostics) = parse(&sources, id);
        assert!(diagnostics.is_empty(), "{diagnostics:?}\n{text}");
        assert_eq!(catalogue.entries.len(), places.len());
        catalogue
    }

    fn text() -> impl Strategy<Value = String> {
        let pieces = vec!["a", "ї", "\n", "\"", "\\", " ", "\t", "\r", "#", "msgid", "%", "\u{2028}"];
        prop::collection::vec(prop::sample::select(pieces), 0..8).prop_map(|pieces| pieces.concat())
    }

    fn words(start: &'static str) -> impl Strategy<Value = Vec<String>> {
        let word = "[a-z]{1,6}( [a-z]{1,6})?".prop_map(move |word| format!("{start}{word}"));
        prop::collection::btree_set(word, 0..3).prop_map(|words| words.into_iter().collect())
    }

    prop_compose! {
        fn entry()(
            comments in words("# "),
            notes in words(""),
            references in words(""),
            flags in words(""),
            previous_context in prop::option::of(text()),
            previous_id in prop::option::of(text()),
            context in prop::option::of(text()),
            id in text(),
            translation in text(),
            is_obsolete in any::<bool>(),
        ) -> Entry {
            Entry { comments, notes, references, flags, previous_context, previous_id, context, id, translation, is_obsolete }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn parses_printed_catalogues(entries in prop::collection::vec(entry(), 0..5), end in words("# ")) {
            let catalogue = Catalogue { entries, end };
            let text = print(&catalogue);
            prop_assert_eq!(&read(&text), &catalogue, "{}", text);
            prop_assert_eq!(print(&read(&text)), text);
        }

        #[test]
        fn does_not_panic_on_any_text(text in r#"(#[~|,.:]?|msgid|msgstr|msgctxt| |"|\\|n|\n|ї|[|]){0,40}"#) {
            let mut sources = SourceMap::default();
            let id = sources.add("uk.po", text.into_bytes()).expect("a text");
            parse(&sources, id);
        }
    }

    #[test]
    fn joins_strings_on_consecutive_lines() {
        let catalogue = read("msgid \"\"\n\"a\\n\"\n  \"b\"\nmsgstr\t\"c\"\r\n\"d\"\n");
        assert_eq!(
            (catalogue.entries[0].id.as_str(), catalogue.entries[0].translation.as_str()),
            ("a\nb", "cd")
        );
    }
}
