//! Quotes command lines.

use std::fmt::Write as _;

use uavspec_schema::terminal;

/// Quotes words for a shell. Reports would escape some characters for display, so words with such characters are quoted
/// as `$'…'`, which consists of printable characters.
pub fn command_line<'w>(words: impl IntoIterator<Item = &'w str>) -> String {
    let quoted = words.into_iter().map(|word| match shlex::try_quote(word) {
        Ok(quoted) if terminal::path(word) == word => quoted.into_owned(),
        _ => escaped(word),
    });
    quoted.collect::<Vec<_>>().join(" ")
}

/// Quotes a word with octal escapes, which bash, zsh and POSIX 2024 shells read.
fn escaped(word: &str) -> String {
    let mut escaped = String::from("$'");
    for byte in word.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' | b'.' | b'/' | b' ' => {
                escaped.push(char::from(byte));
            }
            // Writing to a `String` can't fail.
            _ => _ = write!(escaped, "\\{byte:03o}"),
        }
    }
    escaped + "'"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotes_command_lines_for_a_shell() {
        assert_eq!(command_line(["uavspec", "check", "a b.ulg", "-"]), "uavspec check 'a b.ulg' -");
        // A shell splits the line into the same words.
        for word in ["it's", "a\"b", "$HOME", "`id`", "a;b", "*", "", "~", "a\\b", "#1", "'", "é", "a:b"] {
            let words = ["uavspec", word];
            assert_eq!(shlex::split(&command_line(words)).as_deref(), Some(&words.map(str::to_owned)[..]));
        }
    }

    #[test]
    fn command_lines_are_printable() {
        assert_eq!(
            command_line(["a\n::error::\u{1b}'\u{202e}"]),
            r"$'a\012\072\072error\072\072\033\047\342\200\256'"
        );
        assert_eq!(command_line(["##[error]"]), r"$'\043\043\133error\135'");
        assert_eq!(command_line(["a\0b"]), r"$'a\000b'");
    }
}
