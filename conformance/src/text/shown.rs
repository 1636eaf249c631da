//! Escapes text from the input for display, so it can't hide or imitate output.

/// The maximum length of a displayed text, in characters.
pub(crate) const MAX_SHOWN: usize = 1_000;

/// Escapes text for display on one line, and truncates it. Invisible characters, line breaks, direction changes and
/// terminal sequences become escapes such as `\u{202e}`.
pub(crate) fn shown(text: &str) -> String {
    let mut shown = String::with_capacity(text.len().min(MAX_SHOWN));
    let end = text.char_indices().nth(MAX_SHOWN).map_or(text.len(), |(end, _)| end);
    // `escape_debug` also escapes quotation marks and backslashes, which must stay unchanged here.
    for part in text[..end].split_inclusive(['"', '\'', '\\']) {
        let (body, mark) = match part.strip_suffix(['"', '\'', '\\']) {
            Some(body) => (body, &part[body.len()..]),
            None => (part, ""),
        };
        shown.extend(body.escape_debug());
        shown.push_str(mark);
    }
    if end < text.len() {
        shown.push('…');
    }
    shown
}

/// Quotes words for a shell.
pub(crate) fn command_line<'w>(words: impl IntoIterator<Item = &'w str>) -> String {
    let quoted = words.into_iter().map(|word| {
        // Only NUL can't be quoted, and arguments can't contain NUL.
        shlex::try_quote(word).map_or_else(|_| shown(word), std::borrow::Cow::into_owned)
    });
    quoted.collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escapes_control_characters_and_truncates() {
        assert_eq!(
            shown("a\u{1b}[31m\n\"b\" \\ 'c' \u{202e}d é 🛩"),
            "a\\u{1b}[31m\\n\"b\" \\ 'c' \\u{202e}d é 🛩"
        );
        let long = "é".repeat(10_000);
        assert_eq!(shown(&long).chars().count(), MAX_SHOWN + 1);
        assert_eq!(shown(""), "");
    }

    #[test]
    fn quotes_command_lines_for_a_shell() {
        assert_eq!(command_line(["uavspec", "check", "a b.ulg", "-"]), "uavspec check 'a b.ulg' -");
        // A shell splits the line into the same words.
        for word in ["it's", "a\"b", "$HOME", "`id`", "a;b", "*", "", "~", "a\\b", "#1", "'", "a\nb", "é"] {
            let words = ["uavspec", word];
            assert_eq!(shlex::split(&command_line(words)).as_deref(), Some(&words.map(str::to_owned)[..]));
        }
        let nul = command_line(["a\0b"]);
        assert!(!nul.contains('\0'), "{nul:?}");
    }
}
