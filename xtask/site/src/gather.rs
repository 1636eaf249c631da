//! Collects the sources of the site in one folder for mdBook.

use std::fs;
use std::io;
use std::path::Path;

use walkdir::WalkDir;

use crate::chapters::{GENERATED, by_hand, repeated_titles, summary};
use crate::links::Links;
use crate::{schemas, sections};

/// The files that the site adds to a book. A test of the crate `uavspec` writes the report, which the start page shows.
const ADDITIONS: [(&str, &str); 3] = [
    ("site.css", include_str!("../site.css")),
    ("site.js", include_str!("../site.js")),
    ("report.html", include_str!("../report.html")),
];

/// The collected pages.
pub(crate) struct Gathered {
    /// The number of pages.
    pub(crate) count: usize,
    /// Pages in languages other than English, which are excluded from the search index.
    pub(crate) translated: Vec<String>,
}

/// Fills the empty folder `to` from the repository. An error lists all broken links.
pub(crate) fn gather(repository: &Path, to: &Path) -> Result<Gathered, Vec<String>> {
    let failed = |error: io::Error| vec![format!("{}: {error}", to.display())];
    let generated = repository.join("generated");
    for folder in GENERATED {
        copy(&generated.join(folder), &to.join(folder))?;
    }
    let schemas = schemas::pages(&generated).map_err(|error| vec![error])?;
    for (path, text) in &schemas.pages {
        write(&to.join(path), text).map_err(failed)?;
    }
    let mut errors = Vec::new();
    let links = Links::of(repository);
    for chapter in by_hand() {
        match read(&repository.join(chapter.source)).and_then(|text| sections::of(&text, chapter)) {
            Ok(text) => {
                let text = links.moved(&text, chapter, &mut errors);
                write(&to.join(chapter.page), &text).map_err(failed)?;
            }
            Err(error) => errors.push(error),
        }
    }
    for (name, text) in ADDITIONS {
        write(&to.join(name), text).map_err(failed)?;
    }
    let reference = read(&repository.join("generated/docs/SUMMARY.md")).map_err(|error| vec![error])?;
    let summary = summary(&reference, &schemas.contents);
    errors.extend(
        repeated_titles(&summary).iter().map(|title| format!("two chapters have the title `{title}`")),
    );
    write(&to.join("SUMMARY.md"), &summary).map_err(failed)?;
    if !errors.is_empty() {
        return Err(errors);
    }
    let pages: Vec<&str> = summary.lines().filter_map(page).filter(|page| !page.is_empty()).collect();
    let is_translated = |page: &&&str| read(&to.join(page)).is_ok_and(|text| text.contains(TRANSLATED));
    let translated = pages.iter().filter(is_translated).map(|page| (*page).to_owned()).collect();
    Ok(Gathered { count: pages.len(), translated })
}

/// Returns the page that a line of the table of contents links to.
fn page(line: &str) -> Option<&str> {
    line.split_once("](")?.1.strip_suffix(')')
}

/// The start of a page in another language, after the comment that names the generator.
const TRANSLATED: &str = "-->\n\n<div lang=\"";

/// Copies a folder recursively, except for hidden files, such as the generator's manifests.
fn copy(from: &Path, to: &Path) -> Result<(), Vec<String>> {
    for entry in WalkDir::new(from).sort_by_file_name() {
        let entry = entry.map_err(|error| vec![format!("{error}; run `cargo xtask codegen` first")])?;
        let relative = entry.path().strip_prefix(from).unwrap_or(entry.path());
        let is_hidden = entry.file_name().to_string_lossy().starts_with('.');
        if entry.file_type().is_file() && !is_hidden {
            let target = to.join(relative);
            let copied = parent(&target).and_then(|()| copy_file(entry.path(), &target));
            copied.map_err(|error| vec![format!("{}: {error}", target.display())])?;
        }
    }
    Ok(())
}

/// Copies a file. In a page, replaces links to schema files with links to the pages that show these schemas.
fn copy_file(from: &Path, to: &Path) -> io::Result<()> {
    if from.extension().is_some_and(|ending| ending == "md") {
        return fs::write(to, fs::read_to_string(from)?.replace(".schema.json)", ".schema.md)"));
    }
    fs::copy(from, to).map(drop)
}

fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}

fn write(path: &Path, text: &str) -> io::Result<()> {
    parent(path)?;
    fs::write(path, text)
}

fn parent(path: &Path) -> io::Result<()> {
    path.parent().map_or(Ok(()), fs::create_dir_all)
}
