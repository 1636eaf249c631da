//! Rules: a page for each, a table of all, and a page on what the readers report beside them.
//!
//! These pages are about uavspec, not about anybody's definitions. Each command that has rules describes them
//! as a [`Chapter`]; what they have in common is written here.

mod breaking;
mod lint;
mod reading;

use super::markdown::{Page, Table, code, href, inline, link, with_code};
use crate::emit::file::OutputFile;

/// The page of all rules.
pub(super) const OVERVIEW: &str = "rules/README.md";

/// Heading of everything about rules.
pub(super) const TITLE: &str = "Rules";

/// The rules of a command.
struct Chapter {
    /// Heading of its table; plain text.
    title: &'static str,
    /// What the rules are about, in Markdown.
    about: String,
    /// All of them, a row each.
    table: Table,
    /// The page of each.
    pages: Vec<RulePage>,
}

/// What is to be said of a rule. All texts but `facts` and `after` are plain, with code between backticks.
struct RulePage {
    id: &'static str,
    purpose: &'static str,
    /// A row each: what, and Markdown.
    facts: Vec<(&'static str, String)>,
    examples: Vec<Shown>,
    /// Paragraphs after the examples, in Markdown.
    after: Vec<String>,
}

/// An example with what is said of it.
struct Shown {
    heading: &'static str,
    /// Paths and texts.
    files: Vec<(String, String)>,
    /// What the command prints; nothing where it is empty.
    output: String,
}

/// The rules of all commands.
pub(super) struct Rules {
    chapters: Vec<Chapter>,
}

impl Rules {
    /// All that there are.
    pub(super) fn new() -> Self {
        Self { chapters: vec![lint::chapter(), breaking::chapter()] }
    }

    fn rule_pages(&self) -> impl Iterator<Item = &RulePage> {
        self.chapters.iter().flat_map(|chapter| &chapter.pages)
    }

    /// The names and paths of all pages below the overview, in their order.
    pub(super) fn contents(&self) -> Vec<(&'static str, String)> {
        let rules = self.rule_pages().map(|page| (page.id, rule_path(page.id)));
        std::iter::once((reading::TITLE, reading::path())).chain(rules).collect()
    }

    /// All pages.
    pub(super) fn pages(&self) -> Vec<OutputFile> {
        let mut files = vec![overview(&self.chapters), reading::page()];
        files.extend(self.rule_pages().map(RulePage::write));
        files
    }
}

/// The page of a rule: [`report::rule_url`](crate::report::rule_url) leads to it, too.
fn rule_path(id: &str) -> String {
    format!("rules/{id}.md")
}

/// A link to the page of a rule.
fn rule_link(from: &str, id: &str) -> String {
    link(&code(id), &href(from, &rule_path(id), ""))
}

fn overview(chapters: &[Chapter]) -> OutputFile {
    let mut page = Page::new(OVERVIEW, TITLE);
    let reading = link("errors of the readers", &href(OVERVIEW, &reading::path(), ""));
    page.block(&format!(
        "What uavspec finds in definitions that can be read. What can't be read gives {reading}."
    ));
    for chapter in chapters {
        page.heading(2, &inline(chapter.title));
        page.block(&chapter.about);
        page.table(&chapter.table);
    }
    page.finish()
}

impl RulePage {
    fn write(&self) -> OutputFile {
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
