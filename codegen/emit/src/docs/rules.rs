//! Pages about rules: one page for each rule, a table of all rules, and a page about parser errors.
//!
//! These pages document uavspec, not the definitions. Each command that has rules describes them as a [`Chapter`].

mod breaking;
mod chapter;
mod lint;
mod reading;

pub(super) use self::chapter::OVERVIEW;
use self::chapter::{Chapter, RulePage, rule_path};
use super::markdown::{Page, href, inline, link};
use crate::file::OutputFile;

/// Heading of the overview.
pub(super) const TITLE: &str = "Rules of lint and breaking";

/// The rules of all commands.
pub(super) struct Rules {
    chapters: Vec<Chapter>,
}

impl Rules {
    /// Creates the chapters.
    pub(super) fn new() -> Self {
        Self { chapters: vec![lint::chapter(), breaking::chapter()] }
    }

    fn rule_pages(&self) -> impl Iterator<Item = &RulePage> {
        self.chapters.iter().flat_map(|chapter| &chapter.pages)
    }

    /// Adds the entries below the overview to the table of contents. The entries of topics have no page.
    pub(super) fn contents(&self, mut item: impl FnMut(usize, &str, &str)) {
        item(0, reading::TITLE, &reading::path());
        for chapter in &self.chapters {
            for (topic, ids) in chapter.topics {
                item(0, topic, "");
                for id in ids.split(' ') {
                    item(1, id, &rule_path(id));
                }
            }
        }
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
    let errors = link("parser errors", &href(OVERVIEW, &reading::path(), ""));
    page.block(&format!(
        "uavspec reports these findings in valid definitions. In invalid definitions, it reports {errors}."
    ));
    for chapter in chapters {
        page.heading(2, &inline(chapter.title));
        page.block(&chapter.about);
        page.table(&chapter.table);
    }
    page.finish()
}
