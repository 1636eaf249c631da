//! The differences between two texts, line by line.

use std::fmt::Write as _;
use std::ops::Range;

use similar::algorithms::{Capture, Compact, Replace, myers};
use similar::{DiffOp, DiffTag, group_diff_ops};

/// The number of lines around each change in a patch.
const CONTEXT: usize = 3;

/// The lines of a text, with their line breaks.
pub fn lines(text: &str) -> Vec<&str> {
    text.split_inclusive('\n').collect()
}

/// The operations that turn the `old` lines into the `new` lines. The operations cover all lines, in order.
pub fn operations(old: &[&str], new: &[&str]) -> Vec<DiffOp> {
    let mut found = Compact::new(Replace::new(Capture::new()), old, new);
    let Ok(()) = myers::diff(&mut found, old, 0..old.len(), new, 0..new.len());
    found.into_inner().into_inner().into_ops()
}

/// The patch that turns the `old` text of a file into the `new` text. Empty if the texts are equal.
pub fn patch(file: &str, old: &str, new: &str) -> String {
    let (old, new) = (lines(old), lines(new));
    let mut patch = String::new();
    for hunk in group_diff_ops(operations(&old, &new), CONTEXT) {
        let (Some(first), Some(last)) = (hunk.first(), hunk.last()) else { continue };
        if patch.is_empty() {
            let _ = writeln!(patch, "--- {file}\n+++ {file}");
        }
        let old_range = place(first.old_range().start..last.old_range().end);
        let new_range = place(first.new_range().start..last.new_range().end);
        let _ = writeln!(patch, "@@ -{old_range} +{new_range} @@");
        for operation in &hunk {
            let (old, new) = (&old[operation.old_range()], &new[operation.new_range()]);
            if operation.tag() == DiffTag::Equal {
                push(' ', old, &mut patch);
            } else {
                push('-', old, &mut patch);
                push('+', new, &mut patch);
            }
        }
    }
    patch
}

/// The location of lines in the header of a hunk. For an empty range, the location is the preceding line.
fn place(lines: Range<usize>) -> String {
    match lines.len() {
        0 => format!("{},0", lines.start),
        1 => (lines.start + 1).to_string(),
        count => format!("{},{count}", lines.start + 1),
    }
}

fn push(mark: char, lines: &[&str], patch: &mut String) {
    for line in lines {
        patch.push(mark);
        patch.push_str(line);
        if !line.ends_with('\n') {
            patch.push_str("\n\\ No newline at end of file\n");
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The patch without its first two lines, which name the file.
    fn hunks(old: &str, new: &str) -> String {
        let patch = patch("a.msg", old, new);
        patch.strip_prefix("--- a.msg\n+++ a.msg\n").expect("the name of the file").to_owned()
    }

    #[test]
    fn equal_texts_have_no_patch() {
        for text in ["", "a", "a\n", "a\nb\nc\nd\ne\nf\ng\nh\n"] {
            assert_eq!(patch("a.msg", text, text), "");
        }
    }

    #[test]
    fn shows_the_place_and_the_neighbours_of_each_change() {
        let old: String = (1..=20).map(|number| format!("{number}\n")).collect();
        let new = old.replacen("1\n", "one\n", 1).replace("\n11\n", "\n") + "21\n";
        assert_eq!(
            hunks(&old, &new),
            "@@ -1,4 +1,4 @@\n-1\n+one\n 2\n 3\n 4\n\
             @@ -8,7 +8,6 @@\n 8\n 9\n 10\n-11\n 12\n 13\n 14\n\
             @@ -18,3 +17,4 @@\n 18\n 19\n 20\n+21\n"
        );
    }

    #[test]
    fn joins_changes_with_up_to_six_lines_between_them() {
        let old = "a\n1\n2\n3\n4\n5\n6\nb\n";
        let new = "A\n1\n2\n3\n4\n5\n6\nB\n";
        assert_eq!(hunks(old, new), "@@ -1,8 +1,8 @@\n-a\n+A\n 1\n 2\n 3\n 4\n 5\n 6\n-b\n+B\n");
    }

    #[test]
    fn the_place_of_no_lines_is_the_line_before() {
        assert_eq!(hunks("", "a\nb\n"), "@@ -0,0 +1,2 @@\n+a\n+b\n");
        assert_eq!(hunks("a\nb\n", ""), "@@ -1,2 +0,0 @@\n-a\n-b\n");
        assert_eq!(hunks("a\n", ""), "@@ -1 +0,0 @@\n-a\n");
    }

    #[test]
    fn marks_a_missing_line_break_at_the_end() {
        let mark = "\\ No newline at end of file\n";
        assert_eq!(hunks("a\nb", "a\nb\n"), format!("@@ -1,2 +1,2 @@\n a\n-b\n{mark}+b\n"));
        assert_eq!(hunks("a\nb\n", "a\nb"), format!("@@ -1,2 +1,2 @@\n a\n-b\n+b\n{mark}"));
        assert_eq!(hunks("a\nb", "A\nb"), format!("@@ -1,2 +1,2 @@\n-a\n+A\n b\n{mark}"));
        assert_eq!(hunks("", "a"), format!("@@ -0,0 +1 @@\n+a\n{mark}"));
    }

    #[test]
    fn keeps_carriage_returns() {
        assert_eq!(hunks("a\r\nb\r\n", "a\nb\n"), "@@ -1,2 +1,2 @@\n-a\r\n-b\r\n+a\n+b\n");
        assert_eq!(hunks("a\r\nb\r\n", "a\r\nc\r\n"), "@@ -1,2 +1,2 @@\n a\r\n-b\r\n+c\r\n");
    }

    proptest! {
        #[test]
        fn operations_cover_all_lines(old in "[ab\n]{0,40}", new in "[ab\n]{0,40}") {
            let (old, new) = (lines(&old), lines(&new));
            let (mut old_at, mut new_at) = (0, 0);
            for operation in operations(&old, &new) {
                prop_assert_eq!(operation.old_range().start, old_at);
                prop_assert_eq!(operation.new_range().start, new_at);
                if operation.tag() == DiffTag::Equal {
                    prop_assert_eq!(&old[operation.old_range()], &new[operation.new_range()]);
                }
                (old_at, new_at) = (operation.old_range().end, operation.new_range().end);
            }
            prop_assert_eq!((old_at, new_at), (old.len(), new.len()));
        }
    }
}
