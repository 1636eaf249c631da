//! The documents of the site, in the order of its table of contents.

use std::collections::BTreeSet;

/// A handwritten document, or a section of one.
pub(crate) struct Chapter {
    /// The title in the table of contents.
    pub(crate) title: &'static str,
    /// The path of the file in the repository.
    pub(crate) source: &'static str,
    /// The second-level heading of the section, or an empty string for the whole document.
    pub(crate) section: &'static str,
    /// The path of the page on the site.
    pub(crate) page: &'static str,
}

const fn chapter(title: &'static str, source: &'static str, page: &'static str) -> Chapter {
    Chapter { title, source, section: "", page }
}

/// A section of the README. The README is too long for one page.
const fn section(title: &'static str, section: &'static str, page: &'static str) -> Chapter {
    Chapter { title, source: README, section, page }
}

/// The document that the site shows in sections. The start page replaces its first lines.
pub(crate) const README: &str = "README.md";

/// The start page.
pub(crate) const START: Chapter = chapter("Home", "xtask/site/guide/index.md", "index.md");

/// The sections of the README that are not on the site, because chapters contain more details.
#[cfg(test)]
const OMITTED: [&str; 6] =
    ["Install", "Try it", "For whom", "What it is, and what it isn't", "How mature it is", "Read on"];

/// The part of the guide that precedes the reference: installation and tutorials.
const FIRST_STEPS: (&str, &[Chapter]) = (
    "Get started",
    &[
        chapter("Install", "xtask/site/guide/install.md", "guide/install.md"),
        chapter("Your first check", "xtask/site/guide/first-check.md", "guide/first-check.md"),
        chapter("Generate types from definitions", "xtask/site/guide/first-types.md", "guide/first-types.md"),
        chapter("Test a server", "xtask/site/guide/first-server.md", "guide/first-server.md"),
        chapter("Test a vehicle", "xtask/site/guide/first-vehicle.md", "guide/first-vehicle.md"),
        chapter("Watch a fleet", "xtask/site/guide/first-fleet.md", "guide/first-fleet.md"),
    ],
);

/// The parts of the guide that follow the reference. Titles contain the command in parentheses.
const PARTS: [(&str, &[Chapter]); 6] = [
    (
        "Write definitions",
        &[
            chapter("The .msg language", "xtask/site/guide/msg-language.md", "guide/msg-language.md"),
            chapter("Pages with tables", "definitions/README.md", "guide/tables.md"),
            chapter("Events", "xtask/site/guide/events.md", "guide/events.md"),
            chapter("Editors", "xtask/site/guide/editors.md", "guide/editors.md"),
            chapter("Wire formats", "xtask/site/guide/wire-formats.md", "guide/wire-formats.md"),
            chapter("Find mistakes (lint)", "xtask/site/guide/lint.md", "guide/lint.md"),
            chapter(
                "Translate descriptions (translate)",
                "xtask/site/guide/translate.md",
                "guide/translate.md",
            ),
            chapter("Find breaking changes (breaking)", "xtask/site/guide/breaking.md", "guide/breaking.md"),
        ],
    ),
    (
        "Generate code",
        &[
            chapter("Generate and format (codegen, fmt)", "xtask/site/guide/codegen.md", "guide/codegen.md"),
            chapter("Use it in your build", "xtask/site/guide/your-build.md", "guide/your-build.md"),
            chapter("Keys of uavspec.toml", "xtask/site/guide/configuration.md", "guide/configuration.md"),
            chapter("Generate conversions", "xtask/site/guide/conversions.md", "guide/conversions.md"),
            chapter("Rust", "generated/README.md", "guide/rust.md"),
            chapter(
                "TypeScript and Python",
                "xtask/site/guide/typescript-and-python.md",
                "guide/typescript-and-python.md",
            ),
            chapter("JSON Schemas", "xtask/site/guide/json-schemas.md", "guide/json-schemas.md"),
            chapter("Test vectors", "xtask/site/guide/test-vectors.md", "guide/test-vectors.md"),
        ],
    ),
    (
        "Use captures",
        &[
            chapter("Explain a flight (explain)", "xtask/site/guide/explain.md", "guide/explain.md"),
            chapter(
                "Explain codes, fields and values (explain)",
                "xtask/site/guide/word.md",
                "guide/word.md",
            ),
            chapter("Check captures (check)", "xtask/site/guide/check.md", "guide/check.md"),
            chapter("Convert captures (convert)", "xtask/site/guide/convert.md", "guide/convert.md"),
            chapter("Reports", "xtask/site/guide/reports.md", "guide/reports.md"),
            chapter("Baselines", "xtask/site/guide/baselines.md", "guide/baselines.md"),
            chapter("Run uavspec in CI", "xtask/site/guide/ci.md", "guide/ci.md"),
            chapter("Query many captures", "xtask/site/guide/query.md", "guide/query.md"),
            chapter("Use uavspec in Python", "xtask/site/guide/python.md", "guide/python.md"),
            chapter("Check captures on a cluster", "xtask/site/guide/cluster.md", "guide/cluster.md"),
        ],
    ),
    (
        "Test applications, codecs and servers",
        &[
            chapter(
                "Compare an application with releases (compat)",
                "xtask/site/guide/compat.md",
                "guide/compat.md",
            ),
            chapter("Test a codec (test)", "xtask/site/guide/test.md", "guide/test.md"),
            chapter("Testees", "conformance/testees/README.md", "guide/testees.md"),
            chapter("Test a live server (probe)", "xtask/site/guide/probe.md", "guide/probe.md"),
            chapter("Test a live vehicle (probe)", "xtask/site/guide/vehicle.md", "guide/vehicle.md"),
            chapter("Run a reference server (serve)", "xtask/site/guide/serve.md", "guide/serve.md"),
            chapter("Watch a server or a vehicle (watch)", "xtask/site/guide/watch.md", "guide/watch.md"),
        ],
    ),
    (
        "Understand rules",
        &[
            chapter("How checking works", "xtask/site/guide/conformance.md", "guide/conformance.md"),
            chapter("List and explain rules (rules)", "xtask/site/guide/rules.md", "guide/rules.md"),
            chapter("Self-test", "xtask/site/guide/self-test.md", "guide/self-test.md"),
            chapter("Glossary", "xtask/site/guide/glossary.md", "guide/glossary.md"),
        ],
    ),
    (
        "About the project",
        &[
            chapter("Documentation site", "xtask/site/guide/site.md", "guide/site.md"),
            chapter("Changes", "CHANGELOG.md", "project/changes.md"),
            chapter("Architecture", "ARCHITECTURE.md", "project/architecture.md"),
            chapter("Contributing", "CONTRIBUTING.md", "project/contributing.md"),
            chapter("Security", "SECURITY.md", "project/security.md"),
            section("Licence", "Licence", "project/licence.md"),
        ],
    ),
];

/// The title of the part that contains the reference.
const REFERENCE: &str = "Look up";

/// Titles in the reference that replace the names of packages.
const TITLES: [(&str, &str); 5] = [
    ("flockwave", "Flockwave protocol"),
    ("flockwave messages", "Flockwave messages"),
    ("flockwave types", "Flockwave types"),
    ("px4", "PX4 messages"),
    ("px4_events", "PX4 events"),
];

/// All handwritten documents.
pub(crate) fn by_hand() -> impl Iterator<Item = &'static Chapter> {
    let parts = [&FIRST_STEPS].into_iter().chain(&PARTS);
    [&START].into_iter().chain(parts.flat_map(|(_, chapters)| chapters.iter()))
}

/// The folders of `generated/` that are copied to the site unchanged.
pub(crate) const GENERATED: [&str; 3] = ["docs", "schemas", "vectors"];

/// Returns the table of contents. `reference` is the table of contents of the generated documentation, and `schemas`
/// contains the entries of the JSON Schemas.
pub(crate) fn summary(reference: &str, schemas: &str) -> String {
    let start = format!("# Summary\n\n[{}]({})\n\n", START.title, START.page);
    let reference = format!("# {REFERENCE}\n\n{}{schemas}\n", below_docs(reference));
    [start, part(&FIRST_STEPS), reference].into_iter().chain(PARTS.iter().map(part)).collect()
}

/// Returns the titles that occur more than once in a table of contents. Readers can't distinguish such chapters.
pub(crate) fn repeated_titles(summary: &str) -> Vec<&str> {
    let titles = summary.lines().filter_map(|line| Some(line.split_once('[')?.1.split_once("](")?.0));
    let mut known = BTreeSet::new();
    titles.filter(|title| !known.insert(*title)).collect()
}

fn part((title, chapters): &(&str, &[Chapter])) -> String {
    let items: String =
        chapters.iter().map(|Chapter { title, page, .. }| format!("- [{title}]({page})\n")).collect();
    format!("# {title}\n\n{items}\n")
}

/// Converts the list items of a table of contents to items that link to pages in the folder `docs`. The overview of all
/// packages is not an item: each package has a page.
fn below_docs(contents: &str) -> String {
    let items = contents.lines().filter_map(|line| {
        let (indent, item) = line.split_once("- [")?;
        let (title, path) = item.split_once("](")?;
        let title = TITLES.iter().find(|(name, _)| *name == title).map_or(title, |(_, title)| title);
        let folder = if path == ")" { "" } else { "docs/" };
        Some(format!("{indent}- [{title}]({folder}{path}\n"))
    });
    items.collect()
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::*;

    #[test]
    fn the_contents_list_each_page_of_the_guide() {
        let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        for entry in fs::read_dir(repository.join("xtask/site/guide")).expect("the guide") {
            let name = entry.expect("a file").file_name().into_string().expect("UTF-8");
            let path = format!("xtask/site/guide/{name}");
            assert!(by_hand().any(|chapter| chapter.source == path), "{path} is not a chapter");
        }
    }

    #[test]
    fn the_site_contains_each_section_of_the_readme() {
        let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let readme = fs::read_to_string(repository.join(README)).expect("the README");
        for heading in readme.lines().filter_map(|line| line.strip_prefix("## ")) {
            let is_chapter = by_hand().any(|chapter| chapter.source == README && chapter.section == heading);
            assert!(is_chapter != OMITTED.contains(&heading), "{heading}");
        }
    }

    #[test]
    fn moves_the_contents_of_the_reference_into_its_folder() {
        let contents = "<!-- made by -->\n\n# Summary\n\n[Overview](README.md)\n\n- [px4](px4/README.md)\n  - [Event](px4/Event.md)\n- [Units]()\n";
        assert_eq!(
            below_docs(contents),
            "- [PX4 messages](docs/px4/README.md)\n  - [Event](docs/px4/Event.md)\n- [Units]()\n"
        );
    }

    #[test]
    fn finds_repeated_titles() {
        let summary = "# Summary\n\n[Home](index.md)\n\n- [Units]()\n  - [Home](docs/home.md)\n";
        assert_eq!(repeated_titles(summary), ["Home"]);
    }
}
