//! Adjusts links in documents whose path on the site differs from their path in the repository.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use pulldown_cmark::{CowStr, Event, Options, Parser, Tag};

use crate::chapters::{Chapter, GENERATED, README, START, by_hand};

/// Maps files of the repository to pages of the site.
pub(crate) struct Links<'r> {
    repository: &'r Path,
    /// Pages by file of the repository, or by file and section, such as `README.md#install`.
    pages: BTreeMap<String, &'static str>,
}

impl<'r> Links<'r> {
    pub(crate) fn of(repository: &'r Path) -> Self {
        let address = |chapter: &Chapter| match chapter.section {
            "" => chapter.source.to_owned(),
            section => format!("{}#{}", chapter.source, section.to_lowercase().replace(' ', "-")),
        };
        let pages = by_hand().map(|chapter| (address(chapter), chapter.page));
        Self { repository, pages: pages.chain([(README.to_owned(), START.page)]).collect() }
    }

    /// Returns a document whose links are adjusted for the site. A link to a file that isn't on the site becomes plain
    /// text.
    ///
    /// Links to missing files and reference-style links are added to `errors`.
    pub(crate) fn moved(&self, text: &str, chapter: &Chapter, errors: &mut Vec<String>) -> String {
        let mut moved = String::with_capacity(text.len());
        let mut end = 0;
        for (event, range) in Parser::new_ext(text, Options::ENABLE_TABLES).into_offset_iter() {
            let Event::Start(Tag::Link { dest_url, .. }) = event else { continue };
            let whole = &text[range.clone()];
            let Some(target) = local(&dest_url) else { continue };
            let line = || text[..range.start].matches('\n').count() + 1;
            let Some(at) = whole.rfind(&*dest_url) else {
                let place = format!("{}:{}", chapter.source, line());
                errors.push(format!("{place}: write the address in the link itself: `[…]({target})`"));
                continue;
            };
            let path = joined(chapter.source, target.split('#').next().unwrap_or(target));
            if !self.repository.join(&path).exists() {
                let place = format!("{}:{}", chapter.source, line());
                errors.push(format!("{place}: link to a missing file: `{path}`"));
                continue;
            }
            moved.push_str(&text[end..range.start]);
            let place = target.find('#').map_or("", |place| &target[place..]);
            let section = self.pages.get(&format!("{path}{place}")).map(|page| ((*page).to_owned(), ""));
            match section.or_else(|| Some((self.page(&path)?, place))) {
                Some((page, place)) => {
                    let page = seen_from(chapter.page, &page);
                    moved.extend([&whole[..at], &page, place, &whole[at + dest_url.len()..]]);
                }
                None => moved.push_str(whole[..at].trim_start_matches('[').trim_end_matches("](")),
            }
            end = range.end;
        }
        moved.push_str(&text[end..]);
        moved
    }

    /// Returns the path on the site for a file or folder of the repository.
    fn page(&self, path: &str) -> Option<String> {
        if let Some(page) = self.pages.get(path) {
            return Some((*page).to_owned());
        }
        let below = path.strip_prefix("generated/")?;
        let folder = below.split('/').next()?;
        let is_folder = self.repository.join(path).is_dir();
        let has_index = self.repository.join(path).join("README.md").is_file();
        let page = match (is_folder, has_index) {
            (true, true) => format!("{}/README.md", below.trim_end_matches('/')),
            _ if folder == "schemas" => below.replace(".schema.json", ".schema.md"),
            // Keep links to other folders. For a local folder, browsers show a list of its files.
            _ => below.to_owned(),
        };
        GENERATED.contains(&folder).then_some(page)
    }
}

/// Returns the link if it leads to another file of the repository.
fn local<'l>(link: &'l CowStr<'_>) -> Option<&'l str> {
    let is_elsewhere = link.contains(':') || link.starts_with(['#', '/']);
    (!is_elsewhere).then_some(link)
}

/// Resolves `link` in the document `from`.
fn joined(from: &str, link: &str) -> String {
    let mut path = PathBuf::from(from);
    path.pop();
    for part in link.split('/') {
        match part {
            "" | "." => {}
            ".." => {
                path.pop();
            }
            part => path.push(part),
        }
    }
    path.display().to_string().replace('\\', "/")
}

/// Returns the address of the page `to` relative to the page `from`.
fn seen_from(from: &str, to: &str) -> String {
    format!("{}{to}", "../".repeat(from.matches('/').count()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moved(text: &str) -> (String, Vec<String>) {
        let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let mut errors = Vec::new();
        let readme = by_hand().find(|chapter| chapter.source == README).expect("a section of the README");
        (Links::of(&repository).moved(text, readme, &mut errors), errors)
    }

    #[test]
    fn adjusts_links_to_the_pages_of_the_site() {
        let text = "See [tables](definitions/README.md#pages), [`rules`](generated/docs/rules/), [us](#here), \
                    [them](https://example.org) and the [licence](LICENSE-MIT).";
        let expected = "See [tables](../guide/tables.md#pages), [`rules`](../docs/rules/README.md), [us](#here), \
                        [them](https://example.org) and the licence.";
        assert_eq!(moved(text), (expected.to_owned(), vec![]));
    }

    #[test]
    fn reports_a_broken_link_with_its_line() {
        let (_, errors) = moved("One line.\n\n[gone](definitions/gone.md)\n");
        assert_eq!(errors, ["README.md:3: link to a missing file: `definitions/gone.md`"]);
        let (_, errors) = moved("[tables]\n\n[tables]: definitions/README.md\n");
        assert_eq!(
            errors,
            ["README.md:1: write the address in the link itself: `[…](definitions/README.md)`"]
        );
    }
}
