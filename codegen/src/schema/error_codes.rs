//! Error codes of a package: the model, and its resolution from all pages at once.

mod alternatives;
mod prose;

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use uavspec_runtime::{ErrorClass, Severity};

use crate::diagnostic::{Diagnostic, Problem};
use crate::source::Span;
use crate::table::error_code::{self, ErrorCodeRow, ErrorCodeTable, range_text};
use crate::table::{Page, Text};
use alternatives::Alternatives;

/// A table of error codes.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorTable {
    /// Its heading without the range.
    pub title: String,
    /// The class of all its codes.
    pub class: ErrorClass,
    /// The codes that the heading sets apart for it.
    pub range: RangeInclusive<u32>,
    /// The codes that it defines, sorted.
    pub codes: Vec<ErrorCode>,
    /// The heading.
    pub span: Span,
}

/// An error code.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorCode {
    /// The code.
    pub code: u32,
    /// What user interfaces show where space is short.
    pub abbreviation: Option<String>,
    /// The class of its table.
    pub class: ErrorClass,
    /// Codes that its description refers to, sorted.
    pub see_also: Vec<u32>,
    /// Codes of which only one stands for the same event: `use … only if …; otherwise use code N`.
    /// Sorted; each of them has this code among its own.
    pub alternatives: Vec<u32>,
    /// What it means.
    pub description: String,
    /// The version of the specification that introduced it.
    pub since: Option<String>,
    /// The cell that gives the code.
    pub span: Span,
}

impl ErrorCode {
    /// How grave it is, by the two bits of the code that say so.
    pub fn severity(&self) -> Severity {
        Severity::of(self.code)
    }
}

/// Resolves the error codes of all `pages` of a package, sorted by their ranges.
pub fn resolve(pages: &[Page]) -> (Vec<ErrorTable>, Vec<Diagnostic>) {
    let mut resolver = Resolver::default();
    let tables: Vec<ErrorCodeTable<'_>> = pages.iter().flat_map(|page| resolver.read(page)).collect();
    resolver.check_overlaps(&tables);
    let rows: Vec<(usize, &ErrorCodeRow<'_>)> = resolver.unique_rows(&tables);
    resolver.check_abbreviations(&tables, &rows);
    let codes = resolver.codes(&rows);
    let mut model: Vec<Option<ErrorTable>> = tables.iter().map(error_table).collect();
    for ((table, row), (see_also, alternatives)) in rows.into_iter().zip(codes) {
        if let Some(table) = &mut model[table] {
            table.codes.push(error_code(row, table.class, see_also, alternatives));
        }
    }
    (sorted(model.into_iter().flatten().collect()), resolver.diagnostics)
}

fn sorted(mut tables: Vec<ErrorTable>) -> Vec<ErrorTable> {
    for table in &mut tables {
        table.codes.sort_by_key(|code| code.code);
    }
    tables.sort_by(|left, right| {
        let key = |table: &ErrorTable| (*table.range.start(), *table.range.end());
        key(left).cmp(&key(right)).then_with(|| left.title.cmp(&right.title))
    });
    tables
}

fn error_table(table: &ErrorCodeTable<'_>) -> Option<ErrorTable> {
    let block = table.block.as_ref()?;
    Some(ErrorTable {
        title: block.title.clone(),
        class: block.class,
        range: block.codes.clone(),
        codes: Vec::new(),
        span: table.span,
    })
}

fn error_code(row: &ErrorCodeRow<'_>, class: ErrorClass, see_also: Vec<u32>, alternatives: Vec<u32>) -> ErrorCode {
    let description = row.description.as_str();
    let column = row.since.map(Text::as_str).filter(|since| !is_none(since));
    ErrorCode {
        code: row.code,
        abbreviation: Some(row.abbreviation.as_str()).filter(|text| !is_none(text)).map(str::to_owned),
        class,
        see_also,
        alternatives,
        description: description.to_owned(),
        since: column.or_else(|| prose::since(description)).map(str::to_owned),
        span: row.span,
    }
}

/// Whether a cell says that there is nothing to say.
fn is_none(text: &str) -> bool {
    matches!(text, "" | "-" | "–" | "—")
}

/// What is known of all pages while they are resolved.
#[derive(Default)]
struct Resolver {
    diagnostics: Vec<Diagnostic>,
    /// Where each code is first defined; nowhere, if its row can't be read.
    known: BTreeMap<u32, Option<Span>>,
}

impl Resolver {
    fn report(&mut self, problem: Problem, span: Span) {
        self.diagnostics.push(Diagnostic::new(problem, span));
    }

    fn report_with(&mut self, problem: Problem, span: Span, related: Span, label: &str) {
        self.diagnostics.push(Diagnostic::new(problem, span).with_related(related, label));
    }

    fn read<'p>(&mut self, page: &'p Page) -> Vec<ErrorCodeTable<'p>> {
        let (tables, diagnostics) = error_code::read(page);
        if tables.is_empty() && diagnostics.is_empty() {
            self.report(Problem::NoTable, page.headings.first().map_or(page.span.part(0..0), |first| first.text.span()));
        }
        self.diagnostics.extend(diagnostics);
        self.known.extend(tables.iter().flat_map(|table| &table.unread).map(|code| (*code, None)));
        tables
    }

    /// All rows with the index of their table, but of each code only the first.
    fn unique_rows<'t, 'p>(&mut self, tables: &'t [ErrorCodeTable<'p>]) -> Vec<(usize, &'t ErrorCodeRow<'p>)> {
        let mut rows = Vec::new();
        for (index, table) in tables.iter().enumerate() {
            for row in &table.rows {
                self.check_range(row, table);
                let known = self.known.entry(row.code).or_default();
                if let Some(first) = *known {
                    let problem = Problem::DuplicateCode { code: row.code };
                    self.report_with(problem, row.span, first, "first defined here");
                } else {
                    *known = Some(row.span);
                    rows.push((index, row));
                }
            }
        }
        rows
    }

    fn check_range(&mut self, row: &ErrorCodeRow<'_>, table: &ErrorCodeTable<'_>) {
        let Some(block) = table.block.as_ref().filter(|block| !block.codes.contains(&row.code)) else { return };
        let problem = Problem::CodeOutsideClass { code: row.code, range: range_text(&block.codes) };
        self.report_with(problem, row.span, table.span, "under this heading");
    }

    fn check_abbreviations(&mut self, tables: &[ErrorCodeTable<'_>], rows: &[(usize, &ErrorCodeRow<'_>)]) {
        let mut first: BTreeMap<(ErrorClass, &str), &ErrorCodeRow<'_>> = BTreeMap::new();
        for (table, row) in rows {
            let text = row.abbreviation.as_str();
            if text.is_empty() {
                self.report(Problem::MissingAbbreviation { code: row.code }, row.abbreviation.span());
            }
            let Some(block) = tables[*table].block.as_ref().filter(|_| !is_none(text)) else { continue };
            match first.get(&(block.class, text)) {
                Some(other) => {
                    let problem = Problem::DuplicateAbbreviation { abbreviation: text.to_owned(), code: other.code };
                    self.report_with(problem, row.abbreviation.span(), other.abbreviation.span(), "first used here");
                }
                None => {
                    first.insert((block.class, text), row);
                }
            }
        }
    }

    /// Vendors share the codes from 256: what one has set apart, no other may use.
    fn check_overlaps(&mut self, tables: &[ErrorCodeTable<'_>]) {
        let shared = |table: &&ErrorCodeTable<'_>| table.block.as_ref().is_some_and(|block| *block.codes.end() > 255);
        let mut blocks: Vec<(&RangeInclusive<u32>, Span)> = tables
            .iter()
            .filter(shared)
            .filter_map(|table| Some((&table.block.as_ref()?.codes, table.span)))
            .collect();
        blocks.sort_by_key(|(codes, span)| (*codes.start(), *span));
        let mut furthest: Option<(u32, Span)> = None;
        for (codes, span) in blocks {
            if let Some((end, other)) = furthest.filter(|(end, _)| end >= codes.start()) {
                let block = range_text(&(*codes.start()..=end.min(*codes.end())));
                let (first, second) = (other.min(span), other.max(span));
                self.report_with(Problem::OverlappingBlock { block }, second, first, "and by this");
            }
            if furthest.is_none_or(|(end, _)| end < *codes.end()) {
                furthest = Some((*codes.end(), span));
            }
        }
    }

    /// For each row the codes that it refers to, and those that it is an alternative of.
    fn codes(&mut self, rows: &[(usize, &ErrorCodeRow<'_>)]) -> Vec<(Vec<u32>, Vec<u32>)> {
        let mut alternatives = Alternatives::default();
        let see_also: Vec<Vec<u32>> =
            rows.iter().map(|(_, row)| self.references(row, &mut alternatives)).collect();
        self.diagnostics.extend(alternatives.check(&self.known));
        let sets = alternatives.closed();
        let of = |row: &ErrorCodeRow<'_>| sets.get(&row.code).map(|set| set.iter().copied().collect());
        rows.iter().zip(see_also).map(|((_, row), see_also)| (see_also, of(row).unwrap_or_default())).collect()
    }

    fn references(&mut self, row: &ErrorCodeRow<'_>, alternatives: &mut Alternatives) -> Vec<u32> {
        let description = row.description;
        let mut codes = Vec::new();
        for reference in prose::references(description.as_str()) {
            let text = &description.as_str()[reference.range.clone()];
            let span = description.part(reference.range);
            let code = text.parse().ok().filter(|code| self.known.contains_key(code));
            let Some(code) = code else {
                self.report(Problem::DanglingCode { code: text.to_owned() }, span);
                continue;
            };
            if code != row.code {
                codes.push(code);
                if reference.is_alternative {
                    alternatives.add(row.code, code, span);
                }
            }
        }
        codes.sort_unstable();
        codes.dedup();
        codes
    }
}
