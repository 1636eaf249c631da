//! Markdown of tables and untrusted text.

use std::fmt::Write as _;

/// Escapes text. Code in backticks remains code.
pub(super) fn text(text: &str) -> String {
    let mut rest = text;
    let mut shown = String::new();
    while let Some((before, (inside, after))) =
        rest.split_once('`').and_then(|(before, after)| Some((before, after.split_once('`')?)))
    {
        shown.extend([escaped(before), code(inside)]);
        rest = after;
    }
    shown + &escaped(rest)
}

/// Formats text as code.
pub(super) fn code(text: &str) -> String {
    if text.contains('`') || text.trim().is_empty() {
        return format!("<code>{}</code>", escaped(text));
    }
    format!("`{}`", text.replace('|', "\\|"))
}

fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '`' => escaped.push_str("&#96;"),
            '\n' => escaped.push(' '),
            '\\' | '*' | '_' | '[' | ']' | '|' | '#' | '~' | '$' | '>' => {
                escaped.extend(['\\', character]);
            }
            _ => escaped.push(character),
        }
    }
    escaped
}

/// Formats a table. Columns without content are omitted.
pub(super) fn table<const N: usize>(columns: &[&str; N], rows: &[[String; N]]) -> String {
    let shown: Vec<usize> = (0..N).filter(|at| rows.iter().any(|row| !row[*at].is_empty())).collect();
    let mut table = String::new();
    let mut line = |cell: &dyn Fn(usize) -> String| {
        let cells: Vec<String> = shown.iter().map(|at| cell(*at)).collect();
        // Writing to a string can't fail.
        let _ = writeln!(table, "| {} |", cells.join(" | "));
    };
    line(&|at| columns[at].to_owned());
    line(&|_| "---".to_owned());
    for row in rows {
        line(&|at| row[at].clone());
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escapes_text_but_not_code() {
        assert_eq!(text("a|b <i> *c* `d|e` f_g"), r"a\|b &lt;i\> \*c\* `d\|e` f\_g");
        assert_eq!(text("5` wide"), "5&#96; wide");
    }

    #[test]
    fn omits_empty_columns() {
        let rows = [["a".to_owned(), String::new()], ["b".to_owned(), String::new()]];
        assert_eq!(table(&["Field", "Unit"], &rows), "| Field |\n| --- |\n| a |\n| b |\n");
    }
}
