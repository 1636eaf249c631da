//! Error codes: a page for each table, and one that lists all codes of a package.

use std::collections::{BTreeMap, BTreeSet};

use uavspec_runtime::Severity;

use super::language::{self, Heading, marked, path_in};
use super::markdown::{Table, anchor, code, gist, href, inline, link, number_column, text_column, unbroken};
use super::message::heading;
use super::scope::with_links;
use super::site::Site;
use super::words::{self, Words};
use crate::emit::OutputFile;
use crate::schema::{ErrorCode, ErrorTable, Package};
use crate::translation::{error_code_key, error_codes_unit, error_table_key};

/// Heading of everything about error codes.
pub(super) const TITLE: &str = words::ERROR_CODES.english();

/// Longest description in the list of all codes, in characters.
const MAX_GIST: usize = 120;

/// The sign of a severity: emoji are coloured on GitHub and in mdBook alike, and the word beside
/// each says the same.
const fn sign(severity: Severity) -> &'static str {
    match severity {
        Severity::Informational => "🔵",
        Severity::Warning => "🟡",
        Severity::Error => "🟠",
        Severity::Fatal => "🔴",
    }
}

/// The page that lists all codes.
pub(super) fn overview_path(package: &Package) -> String {
    format!("{}/error-codes.md", package.name)
}

/// The page of each table, in their order; no two are the same, even where case doesn't count.
pub(super) fn table_paths(package: &Package) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let path = |table: &ErrorTable| {
        let mut stem = slug(&table.title);
        if stem.is_empty() || taken.contains(&stem) {
            let mark = if stem.is_empty() { "codes" } else { stem.as_str() };
            stem = format!("{mark}-{}", table.range.start());
        }
        while !taken.insert(stem.clone()) {
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

/// What the table of contents lists, with the depth of each: the page of all codes, those of the tables below it,
/// and the same in other languages.
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

/// All tables of a package, as seen from the page `from`.
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

/// The title of a table, as Markdown.
fn title(site: &Site<'_>, package: &Package, table: &ErrorTable) -> String {
    let said = site.said(|| error_table_key(package, table), &table.title);
    marked(&inline(said.text), said.tag)
}

fn range(words: Words, table: &ErrorTable) -> String {
    let (first, last) = (table.range.start().to_string(), table.range.end().to_string());
    match *table.range.end() {
        _ if first == last => first,
        u32::MAX => words.fill(words::AND_ABOVE, &[("first", &first)]),
        _ => words.fill(words::RANGE, &[("low", &first), ("high", &last)]),
    }
}

/// The severities of the codes of a table, from harmless to grave.
fn severities(words: Words, table: &ErrorTable) -> String {
    let found: BTreeSet<Severity> = table.codes.iter().map(ErrorCode::severity).collect();
    found.into_iter().map(|found| severity(words, found)).collect::<Vec<_>>().join(", ")
}

fn severity(words: Words, severity: Severity) -> String {
    unbroken(&format!("{} {}", sign(severity), words.severity(severity)))
}

/// All pages about the error codes of a package.
pub(super) fn pages(site: &Site<'_>, package: &Package) -> Vec<OutputFile> {
    if package.error_tables.is_empty() {
        return Vec::new();
    }
    let book = Codes::of(site, package);
    let mut pages = vec![book.overview()];
    pages.extend((0..package.error_tables.len()).map(|index| book.page(index)));
    pages
}

/// The codes of a package, and where each is described.
struct Codes<'p, 's> {
    site: &'p Site<'s>,
    package: &'p Package,
    /// What all its pages belong to.
    unit: String,
    /// The English page of each table.
    english_paths: Vec<String>,
    /// The page of each table.
    paths: Vec<String>,
    /// By code: the index of its table.
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
        page.block(words.get(words::SEVERITY_MEANS));
        page.table(&list(self.site, &path, self.package));
        heading(&mut page, words, 2, words::ALL_CODES);
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
                self.description(&path, found, |text| gist(text, MAX_GIST)),
                self.references(&path, &found.alternatives),
            ]);
        }
        page.table(&table);
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
        let columns = [
            number_column(words.get(words::CODE)),
            text_column(words.get(words::ABBREVIATION)),
            text_column(words.get(words::SEVERITY)),
            text_column(words.get(words::DESCRIPTION)),
            text_column(words.get(words::ALTERNATIVES)),
            text_column(words.get(words::SEE_ALSO)),
            text_column(words.get(words::SINCE)),
        ];
        let mut rows = Table::new(&columns);
        for found in &table.codes {
            let others: Vec<u32> =
                found.see_also.iter().copied().filter(|other| !found.alternatives.contains(other)).collect();
            rows.row([
                format!("{}{}", anchor(&code_anchor(found.code)), found.code),
                abbreviation(found),
                severity(words, found.severity()),
                self.description(path, found, str::to_owned),
                self.references(path, &found.alternatives),
                self.references(path, &others),
                found.since.as_deref().map(inline).unwrap_or_default(),
            ]);
        }
        page.table(&rows);
        if table.codes.iter().any(|found| !found.alternatives.is_empty()) {
            page.block(words.get(words::ONE_OF_ALTERNATIVES));
        }
        page.finish()
    }

    /// A description, or as much of it as `part` takes, in which the codes that it refers to are links.
    fn description(&self, from: &str, found: &ErrorCode, part: impl Fn(&str) -> String) -> String {
        let said = self.site.said(|| error_code_key(self.package, found.code), &found.description);
        let text = with_links(&part(said.text), |previous, word| {
            // Elsewhere a number may count something else. The words of other languages aren't known.
            let is_reference = said.is_translated
                || matches!(previous.to_ascii_lowercase().as_str(), "code" | "codes" | "or" | "and")
                || !previous.is_empty() && previous.bytes().all(|byte| byte.is_ascii_digit());
            let code = word.parse().ok().filter(|code| is_reference && found.see_also.contains(code))?;
            Some(self.link(from, code))
        });
        marked(&text, said.tag)
    }

    fn references(&self, from: &str, codes: &[u32]) -> String {
        let link =
            |code: &u32| unbroken(&format!("{} {}", sign(Severity::of(*code)), self.link(from, *code)));
        codes.iter().map(link).collect::<Vec<_>>().join(", ")
    }

    /// A code as a link to where it is described, or as a mere number.
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
