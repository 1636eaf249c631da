//! Resolves the error-code tables of all pages.

mod alternatives;
mod prose;

use std::collections::BTreeMap;
use std::ops::{Range, RangeInclusive};

use uavspec_runtime::ErrorClass;

use self::alternatives::Alternatives;
use crate::diagnostic::{Diagnostic, Problem};
use crate::source::Span;
use crate::table::error_code::{self, ErrorCodeRow, ErrorCodeTable, range_text};
use crate::table::{Page, Text};
use crate::{ErrorCode, ErrorTable};

/// The codes to which a description refers, with their locations. The codes may be unknown.
pub fn code_references(description: &Text) -> Vec<(u32, Span)> {
    let text = description.as_str();
    let code = |range: Range<usize>| Some((text[range.clone()].parse().ok()?, description.part(range)));
    prose::references(text).into_iter().filter_map(|reference| code(reference.range)).collect()
}

/// Resolves the error codes of all `pages` of a package. The tables are sorted by their ranges.
pub(super) fn resolve(pages: &[Page]) -> (Vec<ErrorTable>, Vec<Diagnostic>) {
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

fn error_code(
    row: &ErrorCodeRow<'_>,
    class: ErrorClass,
    see_also: Vec<u32>,
    alternatives: Vec<u32>,
) -> ErrorCode {
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

/// True if a cell is empty or contains a dash.
fn is_none(text: &str) -> bool {
    matches!(text, "" | "-" | "–" | "—")
}

/// The state of the resolution.
#[derive(Default)]
struct Resolver {
    diagnostics: Vec<Diagnostic>,
    /// For each code, the location of its first definition, or `None` if the row can't be read.
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
        self.diagnostics.extend(diagnostics);
        self.known.extend(tables.iter().flat_map(|table| &table.unread).map(|code| (*code, None)));
        tables
    }

    /// All rows except rows that repeat a code. Each row has the index of its table.
    fn unique_rows<'t, 'p>(
        &mut self,
        tables: &'t [ErrorCodeTable<'p>],
    ) -> Vec<(usize, &'t ErrorCodeRow<'p>)> {
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
        let Some(block) = table.block.as_ref().filter(|block| !block.codes.contains(&row.code)) else {
            return;
        };
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
                    let problem =
                        Problem::DuplicateAbbreviation { abbreviation: text.to_owned(), code: other.code };
                    self.report_with(
                        problem,
                        row.abbreviation.span(),
                        other.abbreviation.span(),
                        "first used here",
                    );
                }
                None => {
                    first.insert((block.class, text), row);
                }
            }
        }
    }

    /// Reports overlapping blocks from code 256 on. The codes in this range are divided among vendors, so each block
    /// must belong to one vendor.
    fn check_overlaps(&mut self, tables: &[ErrorCodeTable<'_>]) {
        let shared =
            |table: &&ErrorCodeTable<'_>| table.block.as_ref().is_some_and(|block| *block.codes.end() > 255);
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
                self.report_with(Problem::OverlappingBlock { block }, second, first, "the other table");
            }
            if furthest.is_none_or(|(end, _)| end < *codes.end()) {
                furthest = Some((*codes.end(), span));
            }
        }
    }

    /// The references and the alternatives of each row.
    fn codes(&mut self, rows: &[(usize, &ErrorCodeRow<'_>)]) -> Vec<(Vec<u32>, Vec<u32>)> {
        let mut alternatives = Alternatives::default();
        let see_also: Vec<Vec<u32>> =
            rows.iter().map(|(_, row)| self.references(row, &mut alternatives)).collect();
        self.diagnostics.extend(alternatives.check(&self.known));
        let sets = alternatives.closed();
        let of = |row: &ErrorCodeRow<'_>| sets.get(&row.code).map(|set| set.iter().copied().collect());
        rows.iter()
            .zip(see_also)
            .map(|((_, row), see_also)| (see_also, of(row).unwrap_or_default()))
            .collect()
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

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use uavspec_runtime::Severity;

    use super::*;
    use crate::source::SourceMap;

    fn resolve_texts(texts: &[(&str, &str)]) -> (Vec<ErrorTable>, Vec<(&'static str, String)>) {
        let mut sources = SourceMap::default();
        let mut pages = Vec::new();
        for (path, text) in texts {
            let id = sources.add(*path, (*text).into()).expect("valid");
            let (page, diagnostics) = crate::table::parse(&sources, id);
            assert_eq!(diagnostics, []);
            pages.push(page);
        }
        let (tables, mut diagnostics) = resolve(&pages);
        diagnostics.sort_by_key(|diagnostic| diagnostic.span);
        let shown =
            |diagnostic: &Diagnostic| (diagnostic.problem.code(), sources.slice(diagnostic.span).to_owned());
        (tables, diagnostics.iter().map(shown).collect())
    }

    /// Builds a page that contains these rows under a heading for warnings.
    fn warnings(rows: &[&str]) -> String {
        format!("# Warnings (codes 64-127)\n|Code|Abbr|Description|\n|-|-|-|\n{}\n", rows.join("\n"))
    }

    fn codes(tables: &[ErrorTable]) -> Vec<(u32, Vec<u32>, Vec<u32>)> {
        let codes = tables.iter().flat_map(|table| &table.codes);
        codes.map(|code| (code.code, code.see_also.clone(), code.alternatives.clone())).collect()
    }

    #[test]
    fn all_forms_of_a_page_produce_the_same_model() {
        let markdown = "# Boats\n\n## Warnings (codes 64-127)\n\n| Code | Abbr | Description |\n|-:|--|--|\n\
            | 65 | LEAK | Water in the hull (since 2.10). Use this error code only if it floats; otherwise use code 130. |\n\
            | 64 | | See code 65. |\n\n\
            ## Errors (codes 128–191)\n\nCode|Abbreviation|Description\n-|-|-\n\
            130|LEAK|`Sinking`. Use this error code only if it sinks; otherwise use code 65.\n";
        let asciidoc = "= Boats\n\n== Warnings (codes 64-127)\n\n|===\n|Code |Abbr |Description\n\n\
            |65\n|LEAK\n|Water in the hull (since 2.10).\nUse this error code only if it floats;\notherwise use code 130.\n\n\
            |64 | |See code 65.\n|===\n\n\
            == Errors (codes 128-191)\n[%header,cols=3*]\n|===\n|Code\n|Abbr\n|Description\n\
            |130\n|LEAK\n|`Sinking`. Use this error code only if it sinks; otherwise use code 65.\n|===\n";
        let flattened = "Boats\nWarnings (codes 64-127)\nCode | Abbr | Description |\n---|---|---|\n65 |\nLEAK |\n\
            Water in the hull (since 2.10). Use this error code only\nif it floats; otherwise use code 130. |\n\
            64 |\n|\nSee code 65. |\nErrors (codes 128-191)\nCode | Abbr | Description |\n---|---|---|\n130 |\nLEAK |\n\
            Sinking. Use this error code only if it sinks; otherwise use code 65.";
        let model = |path: &str, text: &str| {
            let (mut tables, diagnostics) = resolve_texts(&[(path, text)]);
            assert_eq!(diagnostics, [("missing-abbreviation", String::new())], "{path}");
            for table in &mut tables {
                table.span = Span::default();
                table.codes.iter_mut().for_each(|code| code.span = Span::default());
            }
            tables
        };
        let expected = model("a.md", markdown);
        assert_eq!(
            codes(&expected),
            [(64, vec![65], vec![]), (65, vec![130], vec![130]), (130, vec![65], vec![65])]
        );
        assert_eq!(expected[0].codes[1].since.as_deref(), Some("2.10"));
        assert_eq!(expected[1].title, "Errors");
        assert_eq!(expected[1].codes[0].severity(), Severity::Error);
        assert_eq!(model("a.adoc", asciidoc), expected);
        assert_eq!(model("a.txt", flattened), expected);
    }

    #[test]
    fn all_errors_of_all_pages_are_reported() {
        let first = warnings(&[
            "|64|A|see code 9|",
            "|65|A|x|",
            "|200|B|x|",
            "|x|C|x|",
            "|66|D|",
            "|67|E|see codes 66 and 300|",
        ]);
        let second = "# Boats (codes 512-767)\nCode|Abbr|Description\n-|-|-\n512|A|x\n64|B|x\n\n\
            # Ships (codes 600-700)\nCode|Abbr|Description\n-|-|-\n600||x\n\n\
            # Rafts\nCode|Abbr|Description\n-|-|-\n900|R|see code 512\n";
        let (tables, diagnostics) =
            resolve_texts(&[("a.md", &first), ("b.md", second), ("c.md", "# Nothing")]);
        let expected = [
            ("dangling-code", "9"),
            ("duplicate-abbreviation", "A"),
            ("code-outside-class", "200"),
            ("invalid-code", "x"),
            ("table-shape", "66|D"),
            ("dangling-code", "300"),
            ("code-outside-class", "64"),
            ("duplicate-code", "64"),
            ("overlapping-block", "Ships (codes 600-700)"),
            ("missing-abbreviation", ""),
            ("unknown-class", "Rafts"),
        ];
        assert_eq!(diagnostics, expected.map(|(code, text)| (code, text.to_owned())));
        let sizes: Vec<(&str, usize)> =
            tables.iter().map(|table| (&table.title[..], table.codes.len())).collect();
        assert_eq!(sizes, [("Warnings", 4), ("Boats", 1), ("Ships", 1)]);
    }

    #[test]
    fn listed_codes_become_mutual_alternatives() {
        let text = warnings(&[
            "|64|A|Use this error code only if afloat; otherwise use code 65 or 66.|",
            "|65|B|Use this error code only if sinking; otherwise use codes 64 or 66.|",
            "|66|C|Use this error code only if sunk; otherwise use code 64 or code 65.|",
        ]);
        let (tables, diagnostics) = resolve_texts(&[("a.md", &text)]);
        assert_eq!(diagnostics, []);
        let all = |others: [u32; 2]| (others.to_vec(), others.to_vec());
        let expected = [(64, all([65, 66])), (65, all([64, 66])), (66, all([64, 65]))];
        assert_eq!(
            codes(&tables),
            expected.map(|(code, (see_also, alternatives))| (code, see_also, alternatives))
        );
    }

    #[test]
    fn an_error_in_one_set_of_alternatives_does_not_affect_others() {
        let text = warnings(&[
            "|64|A|Use this error code only if afloat; otherwise use code 66.|",
            "|65|B|Use this error code only if sunk; otherwise use code 64.|",
            "|66|C|Unrelated.|",
        ]);
        let (tables, diagnostics) = resolve_texts(&[("a.md", &text)]);
        assert_eq!(diagnostics, ["66", "64"].map(|code| ("one-sided-alternative", code.to_owned())));
        assert_eq!(
            codes(&tables),
            [(64, vec![66], vec![65, 66]), (65, vec![64], vec![64]), (66, vec![], vec![64])]
        );
    }

    #[test]
    fn parts_under_one_heading_are_one_table() {
        let head = "Code|Abbr|Description\n-|-|-\n";
        let first = format!("# Boats (codes 512-767)\n{head}512|A|x\n\nMore:\n\n{head}513|-|x\n");
        let (tables, diagnostics) = resolve_texts(&[
            ("a.md", &first),
            ("b.md", &warnings(&["|65|B|x|"])),
            ("c.md", &warnings(&["|64|C|x|"])),
        ]);
        assert_eq!(diagnostics, []);
        let sizes: Vec<usize> = tables.iter().map(|table| table.codes.len()).collect();
        assert_eq!(sizes, [1, 1, 2]);
        assert_eq!(tables[2].codes[1].abbreviation, None, "a dash means no abbreviation");
    }

    #[test]
    fn a_version_column_overrides_the_description() {
        let text =
            "# Warnings\nCode|Abbr|Description|Since\n-|-|-|-\n|64|A|since 2.1|2.3|\n|65|B|since 2.1||\n";
        let (tables, _) = resolve_texts(&[("a.md", text)]);
        let since: Vec<Option<&str>> = tables[0].codes.iter().map(|code| code.since.as_deref()).collect();
        assert_eq!(since, [Some("2.3"), Some("2.1")]);
    }

    #[test]
    fn time_and_memory_are_linear_in_the_number_of_codes() {
        let mut text = "# Boats (codes 32768 and above)\nCode|Abbr|Description\n-|-|-\n".to_owned();
        let mut all = String::new();
        for code in 40_000..50_000 {
            writeln!(text, "{code}|A{code}|Use it only if afloat; otherwise use code 40000")
                .expect("a string");
            write!(all, "{code}, ").expect("a string");
        }
        writeln!(text, "39999|A|Use it only if afloat; otherwise use codes {all}").expect("a string");
        let (tables, diagnostics) = resolve_texts(&[("a.md", &text)]);
        assert_eq!(tables[0].codes[0].alternatives.len(), 16);
        assert_eq!(tables[0].codes[0].see_also.len(), 10_000);
        let too_many = diagnostics.iter().filter(|(code, _)| *code == "too-many-alternatives").count();
        assert_eq!(too_many, 1, "reported once, not for each code");
    }
}
