//! Texts of the input as they are shown: whatever they hold, they can neither hide nor feign anything.

/// The longest text of the input that people are shown, in characters.
pub(crate) const MAX_SHOWN: usize = 1_000;

/// A text on one line. What can't be seen, would end the line, turn the direction of writing, or speak to a
/// terminal is written as an escape, such as `\u{202e}`; long texts are cut.
pub(crate) fn shown(text: &str) -> String {
    let mut shown = String::with_capacity(text.len().min(MAX_SHOWN));
    let end = text.char_indices().nth(MAX_SHOWN).map_or(text.len(), |(end, _)| end);
    // Quotation marks and backslashes are escaped by the library too, for literals: here they stay.
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

/// Words as a shell takes them.
pub(crate) fn command_line<'w>(words: impl IntoIterator<Item = &'w str>) -> String {
    let quoted = words.into_iter().map(|word| {
        // No argument can hold the one character that no shell can quote.
        shlex::try_quote(word).map_or_else(|_| shown(word), std::borrow::Cow::into_owned)
    });
    quoted.collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_could_hide_or_feign_is_escaped() {
        assert_eq!(
            shown("a\u{1b}[31m\n\"b\" \\ 'c' \u{202e}d é 🛩"),
            "a\\u{1b}[31m\\n\"b\" \\ 'c' \\u{202e}d é 🛩"
        );
        let long = "é".repeat(10_000);
        assert_eq!(shown(&long).chars().count(), MAX_SHOWN + 1);
        assert_eq!(shown(""), "");
    }

    #[test]
    fn commands_can_be_given_to_a_shell() {
        assert_eq!(command_line(["uavspec", "check", "a b.ulg", "-"]), "uavspec check 'a b.ulg' -");
        // What a shell makes of it is what was meant.
        for word in ["it's", "a\"b", "$HOME", "`id`", "a;b", "*", "", "~", "a\\b", "#1", "'", "a\nb", "é"] {
            let words = ["uavspec", word];
            assert_eq!(shlex::split(&command_line(words)).as_deref(), Some(&words.map(str::to_owned)[..]));
        }
        let nul = command_line(["a\0b"]);
        assert!(!nul.contains('\0'), "{nul:?}");
    }
}
