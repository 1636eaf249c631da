//! Docstrings and comments. All definition text is escaped.

use uavspec_schema::prose;

use crate::file::notice;

/// Formats a docstring, or an empty string for an empty text.
pub(super) fn docstring(text: &str, indent: &str) -> String {
    if text.is_empty() {
        return String::new();
    }
    let escaped = escaped(text.trim_end());
    let mut lines = escaped.lines().map(|line| visible(line.trim_end()));
    let first = lines.next().unwrap_or_default();
    let mut rest = String::new();
    for line in lines {
        rest.push('\n');
        if !line.is_empty() {
            rest.push_str(indent);
            rest.push_str(&line);
        }
    }
    if rest.is_empty() {
        return format!("{indent}\"\"\"{first}\"\"\"\n");
    }
    format!("{indent}\"\"\"{first}{rest}\n{indent}\"\"\"\n")
}

/// Escapes backslashes and the quotes that would end a docstring.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    let mut rest = text.chars().peekable();
    while let Some(character) = rest.next() {
        let is_end = character == '"' && matches!(rest.peek(), None | Some('"'));
        if is_end || character == '\\' {
            escaped.push('\\');
        }
        escaped.push(character);
    }
    escaped
}

/// Escapes text for a one-line comment.
pub(super) fn line(text: &str) -> String {
    visible(text)
}

fn visible(line: &str) -> String {
    line.chars().map(prose::visible).collect()
}

/// The first line of a generated file.
pub(super) fn header(from: &str) -> String {
    format!("# {}\n", notice(from))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escapes_quotes_that_would_end_a_docstring() {
        for (text, expected) in [
            ("a \"b\" c", r#""""a "b" c""""#),
            ("say \"hi\"", r#""""say "hi\"""""#),
            (r#"ends \""#, r#""""ends \\\"""""#),
            (r#"a """ b"#, r#""""a \"\"" b""""#),
            ("a\u{202e}b", "\"\"\"a\u{fffd}b\"\"\""),
        ] {
            assert_eq!(docstring(text, "").trim_end(), expected);
        }
        assert_eq!(docstring("a\n\nb", "  "), "  \"\"\"a\n\n  b\n  \"\"\"\n");
    }
}
