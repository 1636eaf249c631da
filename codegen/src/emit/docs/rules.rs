//! Rules: a page for each, a table of all, and a page on what the readers report beside them.
//!
//! These pages are about uavspec, not about anybody's definitions. Each command that has rules describes them
//! as a [`Chapter`]; what they have in common is written here.

mod breaking;
mod chapter;
mod lint;
mod reading;

pub(super) use self::chapter::OVERVIEW;
use self::chapter::{Chapter, RulePage, rule_path};
use super::markdown::{Page, href, inline, link};
use crate::emit::file::OutputFile;

/// Heading of everything about rules.
pub(super) const TITLE: &str = "Rules";

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
