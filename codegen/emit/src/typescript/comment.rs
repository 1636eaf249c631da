//! Comments. All definition text is escaped.

use uavspec_schema::prose;

use crate::file::notice;

/// Formats a documentation comment, or an empty string for an empty text.
pub(super) fn block(text: &str, indent: &str) -> String {
    if text.is_empty() {
        return String::new();
    }
    // Escapes the end of a comment and the start of a tag.
    let text = prose::block(text).replace("*/", "*&#47;").replace('@', "\\@");
    if !text.contains('\n') {
        return format!("{indent}/** {text} */\n");
    }
    let lines = text.lines().map(|line| match line {
        "" => format!("{indent} *\n"),
        line => format!("{indent} * {line}\n"),
    });
    format!("{indent}/**\n{}{indent} */\n", lines.collect::<String>())
}

/// Escapes text for a one-line comment.
pub(super) fn line(text: &str) -> String {
    text.chars().map(prose::visible).collect()
}

/// The first line of a generated file.
pub(super) fn header(from: &str) -> String {
    format!("// {}\n\n", notice(from))
}
