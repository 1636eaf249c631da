//! Wraps text for terminals.

/// The maximum width of a line. A longer word gets its own line.
const WIDTH: usize = 80;

/// Wraps a line at spaces. Each further line is indented by this many spaces. The first line starts after `offset`
/// columns. Within a line, leading spaces and runs of several spaces are kept.
pub fn wrapped(text: &str, offset: usize, indent: usize) -> String {
    let (mut lines, mut column, mut is_first) = (String::new(), offset, true);
    for word in text.split(' ') {
        let width = word.chars().count();
        if !is_first && column + 1 + width > WIDTH && width > 0 {
            lines.truncate(lines.trim_end_matches(' ').len());
            lines.push('\n');
            lines.extend(std::iter::repeat_n(' ', indent));
            column = indent;
        } else if !is_first {
            lines.push(' ');
            column += 1;
        }
        lines.push_str(word);
        column += width;
        is_first = false;
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wraps_at_spaces_and_keeps_the_words() {
        assert_eq!(wrapped("a  short line", 0, 2), "a  short line");
        let long = "word ".repeat(40);
        let lines = wrapped(&long, 13, 13);
        assert!(lines.lines().skip(1).all(|line| line.starts_with(&" ".repeat(13))), "{lines}");
        assert!(lines.lines().all(|line| line.chars().count() <= WIDTH), "{lines}");
        assert_eq!(lines.split_whitespace().count(), 40);
        let unbroken = "x".repeat(100);
        assert_eq!(wrapped(&format!("a {unbroken} b"), 0, 2), format!("a\n  {unbroken}\n  b"));
    }
}
