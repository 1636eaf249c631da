//! The documents of the site, in the order of its table of contents.

/// A handwritten document.
pub(crate) struct Chapter {
    /// The title in the table of contents.
    pub(crate) title: &'static str,
    /// The path of the file in the repository.
    pub(crate) source: &'static str,
    /// The path of the page on the site.
    pub(crate) page: &'static str,
}

const fn chapter(title: &'static str, source: &'static str, page: &'static str) -> Chapter {
    Chapter { title, source, page }
}

/// The start page.
pub(crate) const START: Chapter = chapter("Start here", "xtask/site/guide/index.md", "index.md");

/// The parts of the guide and their chapters. The reference precedes them.
pub(crate) const CHAPTERS: [(&str, &[Chapter]); 6] = [
    (
        "Guide: definitions",
        &[
            chapter("Introduction", "README.md", "guide/introduction.md"),
            chapter("The .msg language", "xtask/site/guide/msg-language.md", "guide/msg-language.md"),
            chapter("Pages with tables", "definitions/README.md", "guide/tables.md"),
            chapter("Editors", "xtask/site/guide/editors.md", "guide/editors.md"),
            chapter("Wire formats", "xtask/site/guide/wire-formats.md", "guide/wire-formats.md"),
        ],
    ),
    (
        "Guide: generate",
        &[
            chapter("codegen, fmt, inspect", "xtask/site/guide/codegen.md", "guide/codegen.md"),
            chapter("Use it in your build", "xtask/site/guide/your-build.md", "guide/your-build.md"),
            chapter("Convert between releases", "xtask/site/guide/conversions.md", "guide/conversions.md"),
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
        "Guide: maintain definitions",
        &[
            chapter("lint", "xtask/site/guide/lint.md", "guide/lint.md"),
            chapter("translate", "xtask/site/guide/translate.md", "guide/translate.md"),
            chapter("breaking", "xtask/site/guide/breaking.md", "guide/breaking.md"),
        ],
    ),
    (
        "Guide: check",
        &[
            chapter("How checking works", "xtask/site/guide/conformance.md", "guide/conformance.md"),
            chapter("uavspec check", "xtask/site/guide/check.md", "guide/check.md"),
            chapter("uavspec explain", "xtask/site/guide/explain.md", "guide/explain.md"),
            chapter("uavspec rules", "xtask/site/guide/rules.md", "guide/rules.md"),
            chapter("uavspec test", "xtask/site/guide/test.md", "guide/test.md"),
            chapter("Testees", "conformance/testees/README.md", "guide/testees.md"),
            chapter("uavspec probe", "xtask/site/guide/probe.md", "guide/probe.md"),
            chapter("uavspec serve", "xtask/site/guide/serve.md", "guide/serve.md"),
            chapter("uavspec watch", "xtask/site/guide/watch.md", "guide/watch.md"),
            chapter("Reports", "xtask/site/guide/reports.md", "guide/reports.md"),
            chapter("Known failures", "xtask/site/guide/known-failures.md", "guide/known-failures.md"),
            chapter("Self-test", "xtask/site/guide/self-test.md", "guide/self-test.md"),
        ],
    ),
    ("Terms", &[chapter("Glossary", "xtask/site/guide/glossary.md", "guide/glossary.md")]),
    (
        "Project",
        &[
            chapter("Documentation site", "xtask/site/guide/site.md", "guide/site.md"),
            chapter("Changes", "CHANGELOG.md", "project/changes.md"),
            chapter("Architecture", "ARCHITECTURE.md", "project/architecture.md"),
            chapter("Contributing", "CONTRIBUTING.md", "project/contributing.md"),
            chapter("Security", "SECURITY.md", "project/security.md"),
        ],
    ),
];

/// All handwritten documents.
pub(crate) fn by_hand() -> impl Iterator<Item = &'static Chapter> {
    [&START].into_iter().chain(CHAPTERS.iter().flat_map(|(_, chapters)| chapters.iter()))
}

/// The folders of `generated/` that are copied to the site unchanged.
pub(crate) const GENERATED: [&str; 3] = ["docs", "schemas", "vectors"];

/// Returns the table of contents. `reference` is the table of contents of the generated documentation.
pub(crate) fn summary(reference: &str) -> String {
    let mut text = format!("# Summary\n\n[{}]({})\n\n# Look up\n\n", START.title, START.page);
    text.push_str(&below_docs(reference));
    text.extend(CHAPTERS.iter().map(|(part, chapters)| format!("\n# {part}\n\n{}", items(chapters))));
    text
}

fn items(chapters: &[Chapter]) -> String {
    chapters.iter().map(|Chapter { title, page, .. }| format!("- [{title}]({page})\n")).collect()
}

/// Converts the lines of a table of contents to list items that link to pages in the folder `docs`.
fn below_docs(contents: &str) -> String {
    let lines = contents.lines().filter(|line| line.contains("]("));
    let item = |line: &str| {
        let line = line.replacen("](", "](docs/", 1);
        if line.starts_with('[') { format!("- {line}\n") } else { format!("{line}\n") }
    };
    lines.map(item).collect()
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::*;

    #[test]
    fn the_contents_and_the_readme_list_each_page_of_the_guide() {
        let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let readme = fs::read_to_string(repository.join("README.md")).expect("the README");
        for entry in fs::read_dir(repository.join("xtask/site/guide")).expect("the guide") {
            let name = entry.expect("a file").file_name().into_string().expect("UTF-8");
            let path = format!("xtask/site/guide/{name}");
            assert!(by_hand().any(|chapter| chapter.source == path), "{path} is not a chapter");
            let is_listed = readme.contains(&format!("]({path})"));
            assert!(is_listed || path == START.source, "README.md lacks {path}");
        }
    }

    #[test]
    fn moves_the_contents_of_the_reference_into_its_folder() {
        let contents = "<!-- made by -->\n\n# Summary\n\n[Overview](README.md)\n\n- [px4](px4/README.md)\n  - [Event](px4/Event.md)\n";
        assert_eq!(
            below_docs(contents),
            "- [Overview](docs/README.md)\n- [px4](docs/px4/README.md)\n  - [Event](docs/px4/Event.md)\n"
        );
    }
}
