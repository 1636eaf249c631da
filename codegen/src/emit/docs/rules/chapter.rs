//! Chapters of rules, and the pages of rules.

use crate::emit::docs::markdown::{Page, Table, code, href, inline, link, with_code};
use crate::emit::file::OutputFile;

/// The page of all rules.
pub(in crate::emit::docs) const OVERVIEW: &str = "rules/README.md";

/// The rules of a command.
pub(super) struct Chapter {
    /// Heading of its table; plain text.
    pub(super) title: &'static str,
    /// What the rules are about, in Markdown.
    pub(super) about: String,
    /// All of them, a row each.
    pub(super) table: Table,
    /// The page of each.
    pub(super) pages: Vec<RulePage>,
}

/// What is to be said of a rule. All texts but `facts` and `after` are plain, with code between backticks.
pub(super) struct RulePage {
    pub(super) id: &'static str,
    pub(super) purpose: &'static str,
    /// A row each: what, and Markdown.
    pub(super) facts: Vec<(&'static str, String)>,
    pub(super) examples: Vec<Shown>,
    /// Paragraphs after the examples, in Markdown.
    pub(super) after: Vec<String>,
}

/// An example with what is said of it.
pub(super) struct Shown {
    pub(super) heading: &'static str,
    /// Paths and texts.
    pub(super) files: Vec<(String, String)>,
    /// What the command prints; nothing where it is empty.
    pub(super) output: String,
}

/// The page of a rule: [`report::rule_url`](crate::report::rule_url) leads to it, too.
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
        page.block(&with_code(self.purpose));
        if !self.facts.is_empty() {
            page.gap();
        }
        for (what, fact) in &self.facts {
            page.item(0, &format!("{}: {fact}", inline(what)));
        }
        for example in &self.examples {
            page.heading(2, example.heading);
            for (path, text) in &example.files {
                page.block(&code(path));
                page.listing(text);
            }
            if !example.output.is_empty() {
                page.block("What is said of it:");
                page.listing(&example.output);
            }
        }
        self.after.iter().for_each(|paragraph| page.block(paragraph));
        page.finish()
    }
}
