//! Chapters of rules, and the pages of rules.

use crate::docs::markdown::{Page, Table, code, href, link, with_code};
use crate::file::OutputFile;

/// Path of the page with all rules.
pub(in crate::docs) const OVERVIEW: &str = "rules/README.md";

/// The number of unchanged lines shown before and after each change.
const CONTEXT: usize = 2;

/// The rules of a command.
pub(super) struct Chapter {
    /// Heading of the table, as plain text.
    pub(super) title: &'static str,
    /// A description of the rules, in Markdown.
    pub(super) about: String,
    /// The topics in the table of contents, with the ids of their rules, separated by spaces.
    pub(super) topics: &'static [(&'static str, &'static str)],
    /// One row for each rule.
    pub(super) table: Table,
    /// One page for each rule.
    pub(super) pages: Vec<RulePage>,
}

/// The contents of a rule's page. The fields `statement`, `why` and `fix` are plain text with code in backticks.
pub(super) struct RulePage {
    pub(super) id: &'static str,
    pub(super) statement: &'static str,
    /// Facts in Markdown, such as the level.
    pub(super) facts: Vec<String>,
    pub(super) why: &'static str,
    /// An example of a violation, and the output of the tool.
    pub(super) example: Vec<Listing>,
    pub(super) fix: &'static str,
    /// The corrected example.
    pub(super) corrected: Vec<Listing>,
    /// A line about configuration, in Markdown.
    pub(super) configuration: String,
}

/// Lines of a file, or output of a tool.
pub(super) struct Listing {
    /// The path of the file. Empty for output.
    pub(super) path: String,
    pub(super) text: String,
}

impl Listing {
    pub(super) fn output(text: String) -> Self {
        Self { path: String::new(), text }
    }

    /// The difference between two files, if any.
    pub(super) fn difference(old: (&str, &str), new: (&str, &str)) -> Option<Self> {
        let text = changed_lines(old.1, new.1);
        if old.0 == new.0 {
            return (!text.is_empty()).then(|| Self { path: new.0.to_owned(), text });
        }
        Some(Self { path: String::new(), text: format!("--- {}\n+++ {}\n{text}", old.0, new.0) })
    }
}

/// The path of a rule page, to which [`report::rule_page`](uavspec_lint::report::rule_page) points.
pub(super) fn rule_path(id: &str) -> String {
    format!("rules/{id}.md")
}

/// A link to the page of a rule.
pub(super) fn rule_link(from: &str, id: &str) -> String {
    link(&code(id), &href(from, &rule_path(id), ""))
}

impl RulePage {
    pub(super) fn write(&self) -> OutputFile {
        let mut page = Page::new(&rule_path(self.id), &code(self.id));
        page.block(&with_code(self.statement));
        page.block(&self.facts.join(" · "));
        page.heading(2, "Why it matters");
        page.block(&with_code(self.why));
        page.heading(2, "Example");
        self.example.iter().for_each(|listing| write_listing(&mut page, listing));
        page.heading(2, "How to fix");
        page.block(&with_code(self.fix));
        self.corrected.iter().for_each(|listing| write_listing(&mut page, listing));
        page.heading(2, "Configuration");
        page.block(&self.configuration);
        page.finish()
    }
}

fn write_listing(page: &mut Page, listing: &Listing) {
    if !listing.path.is_empty() {
        page.block(&code(&listing.path));
    }
    page.listing(&listing.text);
}

/// The lines that differ between two texts, marked with `-` and `+`, with [`CONTEXT`] lines around them.
fn changed_lines(old: &str, new: &str) -> String {
    let (old, new): (Vec<&str>, Vec<&str>) = (old.lines().collect(), new.lines().collect());
    let start = old.iter().zip(&new).take_while(|(left, right)| left == right).count();
    let rest = old[start..].iter().rev().zip(new[start..].iter().rev());
    let same = rest.take_while(|(left, right)| left == right).count();
    let (old_end, new_end) = (old.len() - same, new.len() - same);
    if start == old_end && start == new_end {
        return String::new();
    }
    let marked = |mark: &str, lines: &[&str]| -> String {
        let line =
            |line: &&str| if line.is_empty() { mark.trim_end().to_owned() } else { format!("{mark}{line}") };
        lines.iter().map(|text| line(text) + "\n").collect()
    };
    let is_text = |line: &&str| !line.is_empty();
    let before = &old[start.saturating_sub(CONTEXT)..start];
    let before = &before[before.iter().position(is_text).unwrap_or(before.len())..];
    let after = &old[old_end..(old_end + CONTEXT).min(old.len())];
    let after = &after[..after.iter().rposition(is_text).map_or(0, |last| last + 1)];
    [
        marked("  ", before),
        marked("- ", &old[start..old_end]),
        marked("+ ", &new[start..new_end]),
        marked("  ", after),
    ]
    .concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_have_context() {
        assert_eq!(
            changed_lines("a\nb\nc\nd\ne\nf\n", "a\nb\nc\nx\ny\ne\nf\n"),
            "  b\n  c\n- d\n+ x\n+ y\n  e\n  f\n"
        );
        assert_eq!(changed_lines("a\n", "a\nb\n"), "  a\n+ b\n");
        assert_eq!(changed_lines("b\nb\n", "b\n"), "  b\n- b\n");
        assert_eq!(changed_lines("a\n\nb\nc\n\nd\n", "a\n\nb\nx\n\nd\n"), "  b\n- c\n+ x\n\n  d\n");
        assert_eq!(changed_lines("a\n\nb\n\n", "a\n\nc\n\n"), "  a\n\n- b\n+ c\n");
        assert_eq!(changed_lines("a\n", "a\n"), "");
    }

    #[test]
    fn a_renamed_file_has_both_names() {
        let listing = Listing::difference(("wind.msg", "a\n"), ("Wind.msg", "a\n")).expect("a difference");
        assert_eq!(listing.text, "--- wind.msg\n+++ Wind.msg\n");
        assert!(Listing::difference(("wind.msg", "a\n"), ("wind.msg", "a\n")).is_none());
    }
}
