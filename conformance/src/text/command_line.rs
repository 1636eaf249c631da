//! Quotes command lines.

use std::borrow::Cow;

use uavspec_codegen::terminal::shown;

/// Quotes words for a shell.
pub(crate) fn command_line<'w>(words: impl IntoIterator<Item = &'w str>) -> String {
    let quoted = words.into_iter().map(|word| {
        // Only NUL can't be quoted, and arguments can't contain NUL.
        shlex::try_quote(word).map_or_else(|_| shown(word), Cow::into_owned)
    });
    quoted.collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

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
