//! Error codes: a page for each table, and a page that lists all codes of a package.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::json;
use uavspec_runtime::Severity;
use uavspec_schema::prose::xml;
use uavspec_schema::translation::{error_code_key, error_codes_unit, error_table_key};
use uavspec_schema::{ErrorCode, ErrorTable, Package};

use super::language::{self, Heading, heading, marked};
use super::markdown::{Page, Table, code, href, inline, link, number_column, text_column, unbroken};
use super::scope::with_links;
use super::site::{Site, path_in};
use super::words::{self, Words};
use crate::file::OutputFile;
use crate::json_schema::Target;

/// Heading of sections about error codes.
pub(super) const TITLE: &str = words::ERROR_CODES.english();

/// The symbol of a severity. A fuller circle means a more severe error. Style sheets colour the symbol. The adjacent
/// text states the severity as well.
fn sign(severity: Severity) -> String {
    let sign = match severity {
        Severity::Informational => '○',
        Severity::Warning => '◔',
        Severity::Error => '◑',
        Severity::Fatal => '●',
    };
    format!("<span class=\"severity-{severity}\" aria-hidden=\"true\">{sign}</span>")
}

/// Path of the page that lists all codes.
pub(super) fn overview_path(package: &Package) -> String {
    format!("{}/error-codes.md", package.name)
}

/// Paths of the pages of all tables, in order. The paths are unique even on case-insensitive file systems.
pub(super) fn table_paths(package: &Package) -> Vec<String> {
    let mut used = BTreeSet::new();
    let path = |table: &ErrorTable| {
        let mut stem = slug(&table.title);
        if stem.is_empty() || used.contains(&stem) {
            let mark = if stem.is_empty() { "codes" } else { stem.as_str() };
            stem = format!("{mark}-{}", table.range.start());
        }
        while !used.insert(stem.clone()) {
            stem.push('x');
        }
        format!("{}/error-codes/{stem}.md", package.name)
    };
    package.error_tables.iter().map(path).collect()
}

fn slug(title: &str) -> String {
    let words = title.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join("-").to_ascii_lowercase()
}

/// Entries for the table of contents, with their depth: the page that lists all codes, the table pages, and their
/// translations.
pub(super) fn contents(site: &Site<'_>, package: &Package) -> Vec<(usize, String, String)> {
    let tables: Vec<(&ErrorTable, String)> = package.error_tables.iter().zip(table_paths(package)).collect();
    let overview = overview_path(package);
    let mut contents = vec![(0, TITLE.to_owned(), overview.clone())];
    contents.extend(tables.iter().map(|(table, path)| (1, table.title.clone(), path.clone())));
    for language in site.languages_of(&error_codes_unit(package)) {
        let words = Words::of(&language.tag);
        let name = words.get(words::ERROR_CODES);
        let name = if words.are_english() { format!("{name} ({})", language.name) } else { name.to_owned() };
        contents.push((1, name, path_in(&overview, &language.tag)));
        contents.extend(tables.iter().map(|(table, path)| {
            let title = language.get(&error_table_key(package, table)).unwrap_or(&table.title);
            (2, title.to_owned(), path_in(path, &language.tag))
        }));
    }
    contents
}

/// All tables of a package, with links relative to the page `from`.
pub(super) fn list(site: &Site<'_>, from: &str, package: &Package) -> Table {
    let words = site.words;
    let columns = [
        text_column(words.get(words::TABLE)),
        text_column(words.get(words::CODE_RANGE)),
        text_column(words.get(words::SEVERITY)),
        number_column(words.get(words::CODES)),
    ];
    let mut list = Table::new(&columns);
    let unit = error_codes_unit(package);
    for (table, path) in package.error_tables.iter().zip(table_paths(package)) {
        list.row([
            link(&title(site, package, table), &href(from, &site.path_of(&path, &unit), "")),
            range(words, table),
            severities(words, table),
            table.codes.len().to_string(),
        ]);
    }
    list
}

/// The title of a table as Markdown.
fn title(site: &Site<'_>, package: &Package, table: &ErrorTable) -> String {
    let title = site.localized(|| error_table_key(package, table), &table.title);
    marked(&inline(title.text), title.tag)
}

fn range(words: Words, table: &ErrorTable) -> String {
    let (first, last) = (table.range.start().to_string(), table.range.end().to_string());
    match *table.range.end() {
        _ if first == last => first,
        u32::MAX => words.fill(words::AND_ABOVE, &[("first", &first)]),
        _ => words.fill(words::RANGE, &[("low", &first), ("high", &last)]),
    }
}

/// The severities that occur in a table, in ascending order.
fn severities(words: Words, table: &ErrorTable) -> String {
    let found: BTreeSet<Severity> = table.codes.iter().map(ErrorCode::severity).collect();
    found.into_iter().map(|found| severity(words, found)).collect::<Vec<_>>().join(", ")
}

fn severity(words: Words, severity: Severity) -> String {
    format!("{}&nbsp;{}", sign(severity), unbroken(words.severity(severity)))
}

/// All pages about the error codes of a package.
pub(super) fn pages(site: &Site<'_>, package: &Package) -> Vec<OutputFile> {
    if package.error_tables.is_empty() {
        return Vec::new();
    }
    let codes = Codes::of(site, package);
    let mut pages = vec![codes.overview()];
    pages.extend((0..package.error_tables.len()).map(|index| codes.page(index)));
    pages
}

/// The codes of a package with the pages that describe them.
struct Codes<'p, 's> {
    site: &'p Site<'s>,
    package: &'p Package,
    /// Translation unit of the pages.
    unit: String,
    /// Paths of the English pages, by table.
    english_paths: Vec<String>,
    /// Paths of the pages in the site language, by table.
    paths: Vec<String>,
    /// The index of the table that contains each code.
    tables: BTreeMap<u32, usize>,
}

impl<'p, 's> Codes<'p, 's> {
    fn of(site: &'p Site<'s>, package: &'p Package) -> Self {
        let tables = package.error_tables.iter().enumerate();
        let tables = tables
            .flat_map(|(index, table)| table.codes.iter().map(move |code| (code.code, index)))
            .collect();
        let unit = error_codes_unit(package);
        let english_paths = table_paths(package);
        let paths = english_paths.iter().map(|path| site.path_of(path, &unit)).collect();
        Self { site, package, unit, english_paths, paths, tables }
    }

    fn overview(&self) -> OutputFile {
        let words = self.site.words;
        let english = overview_path(self.package);
        let path = self.site.path_of(&english, &self.unit);
        let heading_of_page = Heading { text: words.get(words::ERROR_CODES), english: TITLE };
        let mut page = language::page(self.site, &self.unit, &english, &heading_of_page);
        // A script fills this element. Without the script, the table that follows shows the same data.
        let words_of_script = json!({
            "title": words.get(words::ERROR_CODES),
            "find": words.get(words::FIND_A_CODE),
            "example": words.get(words::FIND_EXAMPLE),
            "severity": words.get(words::SEVERITY),
            "alternatives": words.get(words::ALTERNATIVES),
            "shownOfAll": words.get(words::SHOWN_OF_ALL),
        });
        page.block(&format!(
            "<div class=\"error-code-filter\" data-words=\"{}\"></div>",
            xml(&words_of_script.to_string())
        ));
        let columns = [
            number_column(words.get(words::CODE)),
            text_column(words.get(words::ABBREVIATION)),
            text_column(words.get(words::SEVERITY)),
            text_column(words.get(words::MEANING)),
            text_column(words.get(words::ALTERNATIVES)),
        ];
        let mut table = Table::new(&columns);
        for found in self.package.error_tables.iter().flat_map(|table| &table.codes) {
            table.row([
                self.link(&path, found.code),
                abbreviation(found),
                severity(words, found.severity()),
                self.description(&path, found),
                self.references(&path, &found.alternatives),
            ]);
        }
        page.table(&table);
        heading(&mut page, words, 2, words::SEVERITY);
        page.block(words.get(words::SEVERITY_MEANS));
        page.table(&list(self.site, &path, self.package));
        let packages = &self.site.schema.packages;
        if let Some(index) = packages.iter().position(|package| package.name == self.package.name) {
            page.block(&self.site.line_of_files(&path, Target::ErrorCode(index)));
        }
        page.finish()
    }

    fn page(&self, index: usize) -> OutputFile {
        let Self { site, package, unit, .. } = self;
        let (table, path) = (&package.error_tables[index], self.paths[index].as_str());
        let words = site.words;
        let heading = Heading { text: &title(site, package, table), english: &inline(&table.title) };
        let mut page = language::page(site, unit, &self.english_paths[index], &heading);
        let position = site.sources.position(table.span);
        let source = code(&format!("{}:{}", site.source(table.span), position.line));
        let overview = site.path_of(&overview_path(package), unit);
        page.block(&words.fill(
            words::TABLE_FACTS,
            &[
                ("range", &range(words, table)),
                ("class", words.class(table.class)),
                ("count", &words.codes(table.codes.len() as u64)),
                ("source", &source),
                ("all", &link(words.get(words::ALL_ERROR_CODES), &href(path, &overview, ""))),
            ],
        ));
        if table.codes.iter().any(|found| !found.alternatives.is_empty()) {
            page.block(words.get(words::ONE_OF_ALTERNATIVES));
        }
        for found in &table.codes {
            self.write_code(&mut page, path, found);
        }
        page.finish()
    }

    /// Writes the section about a code. The section heading makes the code searchable.
    fn write_code(&self, page: &mut Page, path: &str, found: &ErrorCode) {
        let words = self.site.words;
        page.anchor(&code_anchor(found.code));
        let abbreviation = found.abbreviation.as_deref().map(inline).unwrap_or_default();
        page.heading(2, format!("{} {abbreviation}", found.code).trim_end());
        page.block(&self.description(path, found));
        let others: Vec<u32> =
            found.see_also.iter().copied().filter(|other| !found.alternatives.contains(other)).collect();
        let facts = [
            (words::SEVERITY, severity(words, found.severity())),
            (words::ALTERNATIVES, self.references(path, &found.alternatives)),
            (words::SEE_ALSO, self.references(path, &others)),
            (words::SINCE, found.since.as_deref().map(inline).unwrap_or_default()),
        ];
        let facts = facts.iter().filter(|(_, value)| !value.is_empty());
        let facts: Vec<String> =
            facts.map(|(word, value)| format!("{}: {value}", words.get(*word))).collect();
        page.block(&facts.join(" · "));
    }

    /// A description, with links to the codes that it refers to.
    fn description(&self, from: &str, found: &ErrorCode) -> String {
        let description =
            self.site.localized(|| error_code_key(self.package, found.code), &found.description);
        let text = with_links(description.text, |previous, word| {
            // In English text, a number is a reference only after words such as "code". In translations, these words
            // are unknown.
            let is_reference = description.is_translated
                || matches!(previous.to_ascii_lowercase().as_str(), "code" | "codes" | "or" | "and")
                || !previous.is_empty() && previous.bytes().all(|byte| byte.is_ascii_digit());
            let code = word.parse().ok().filter(|code| is_reference && found.see_also.contains(code))?;
            Some(self.link(from, code))
        });
        marked(&text, description.tag)
    }

    fn references(&self, from: &str, codes: &[u32]) -> String {
        let link = |code: &u32| format!("{}&nbsp;{}", sign(Severity::of(*code)), self.link(from, *code));
        codes.iter().map(link).collect::<Vec<_>>().join(", ")
    }

    /// A code, linked to its description if there is one.
    fn link(&self, from: &str, code: u32) -> String {
        let path = self.tables.get(&code).and_then(|table| self.paths.get(*table));
        path.map_or_else(
            || code.to_string(),
            |path| link(&code.to_string(), &href(from, path, &code_anchor(code))),
        )
    }
}

fn code_anchor(code: u32) -> String {
    format!("code-{code}")
}

fn abbreviation(found: &ErrorCode) -> String {
    found.abbreviation.as_deref().map(code).unwrap_or_default()
}
