//! Error codes: a page for each table, and one that lists all codes of a package.

use std::collections::{BTreeMap, BTreeSet};

use uavspec_runtime::Severity;

use super::markdown::{
    Page, Table, anchor, code, gist, href, inline, link, number_column, plural, text_column, unbroken,
};
use super::scope::with_links;
use super::site::Site;
use crate::emit::OutputFile;
use crate::schema::{ErrorCode, ErrorTable, Package};

/// Heading of everything about error codes.
pub(super) const TITLE: &str = "Error codes";

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

/// All tables of a package, as seen from the page `from`.
pub(super) fn list(from: &str, package: &Package) -> Table {
    let columns =
        [text_column("Table"), text_column("Range"), text_column("Severity"), number_column("Codes")];
    let mut list = Table::new(&columns);
    for (table, path) in package.error_tables.iter().zip(table_paths(package)) {
        list.row([
            link(&inline(&table.title), &href(from, &path, "")),
            range(table),
            severities(table),
            table.codes.len().to_string(),
        ]);
    }
    list
}

fn range(table: &ErrorTable) -> String {
    let (first, last) = (table.range.start(), table.range.end());
    match (first, last) {
        _ if first == last => first.to_string(),
        (_, &u32::MAX) => format!("{first} and above"),
        _ => format!("{first} to {last}"),
    }
}

/// The severities of the codes of a table, from harmless to grave.
fn severities(table: &ErrorTable) -> String {
    let found: BTreeSet<Severity> = table.codes.iter().map(ErrorCode::severity).collect();
    found.into_iter().map(severity).collect::<Vec<_>>().join(", ")
}

fn severity(severity: Severity) -> String {
    unbroken(&format!("{} {severity}", sign(severity)))
}

/// All pages about the error codes of a package.
pub(super) fn pages(site: &Site<'_>, package: &Package) -> Vec<OutputFile> {
    if package.error_tables.is_empty() {
        return Vec::new();
    }
    let book = Codes::of(package);
    let mut pages = vec![book.overview()];
    pages.extend(
        package.error_tables.iter().zip(&book.paths).map(|(table, path)| book.page(site, table, path)),
    );
    pages
}

/// The codes of a package, and where each is described.
struct Codes<'s> {
    package: &'s Package,
    paths: Vec<String>,
    /// By code: the index of its table.
    tables: BTreeMap<u32, usize>,
}

impl<'s> Codes<'s> {
    fn of(package: &'s Package) -> Self {
        let tables = package.error_tables.iter().enumerate();
        let tables = tables
            .flat_map(|(index, table)| table.codes.iter().map(move |code| (code.code, index)))
            .collect();
        Self { package, paths: table_paths(package), tables }
    }

    fn overview(&self) -> OutputFile {
        let path = overview_path(self.package);
        let mut page = Page::new(&path, TITLE);
        page.block(
            "The severity of a code is in two bits of the code itself, `(code & 0xFF) >> 6`: 0 is informational, \
             1 a warning, 2 an error, 3 a fatal error. That holds for all codes below 256 and should hold for all others.",
        );
        page.table(&list(&path, self.package));
        page.heading(2, "All codes");
        // Filled by a script; the table next to it says all without one.
        page.block("<div class=\"error-code-filter\"></div>");
        let columns = [
            number_column("Code"),
            text_column("Abbreviation"),
            text_column("Severity"),
            text_column("Meaning"),
            text_column("Alternatives"),
        ];
        let mut table = Table::new(&columns);
        for found in self.package.error_tables.iter().flat_map(|table| &table.codes) {
            table.row([
                self.link(&path, found.code),
                abbreviation(found),
                severity(found.severity()),
                self.description(&path, found, &gist(&found.description, MAX_GIST)),
                self.references(&path, &found.alternatives),
            ]);
        }
        page.table(&table);
        page.finish()
    }

    fn page(&self, site: &Site<'_>, table: &ErrorTable, path: &str) -> OutputFile {
        let mut page = Page::new(path, &inline(&table.title));
        let position = site.sources.position(table.span);
        let source = code(&format!("{}:{}", site.source(table.span), position.line));
        let all = link("all error codes", &href(path, &overview_path(self.package), ""));
        page.block(&format!(
            "Codes {} ({}); {}, defined in {source}. See also {all}.",
            range(table),
            table.class,
            plural(table.codes.len() as u64, "code")
        ));
        let columns = [
            number_column("Code"),
            text_column("Abbreviation"),
            text_column("Severity"),
            text_column("Description"),
            text_column("Alternatives"),
            text_column("See also"),
            text_column("Since"),
        ];
        let mut rows = Table::new(&columns);
        for found in &table.codes {
            let others: Vec<u32> =
                found.see_also.iter().copied().filter(|other| !found.alternatives.contains(other)).collect();
            rows.row([
                format!("{}{}", anchor(&code_anchor(found.code)), found.code),
                abbreviation(found),
                severity(found.severity()),
                self.description(path, found, &found.description),
                self.references(path, &found.alternatives),
                self.references(path, &others),
                found.since.as_deref().map(inline).unwrap_or_default(),
            ]);
        }
        page.table(&rows);
        if table.codes.iter().any(|found| !found.alternatives.is_empty()) {
            page.block("Of a code and its alternatives only one is to be sent: they are one condition at different severities.");
        }
        page.finish()
    }

    /// A description in which the codes that it refers to are links.
    fn description(&self, from: &str, found: &ErrorCode, text: &str) -> String {
        with_links(text, |previous, word| {
            // Elsewhere a number may count something else.
            let is_reference =
                matches!(previous.to_ascii_lowercase().as_str(), "code" | "codes" | "or" | "and")
                    || !previous.is_empty() && previous.bytes().all(|byte| byte.is_ascii_digit());
            let code = word.parse().ok().filter(|code| is_reference && found.see_also.contains(code))?;
            Some(self.link(from, code))
        })
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
