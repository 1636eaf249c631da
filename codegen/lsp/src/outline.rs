//! Symbols of documents and of the workspace, and foldable parts.

use lsp_types::{
    BaseSymbolInformation, DocumentSymbol, FoldingRange, FoldingRangeKind, SymbolKind, WorkspaceSymbol,
    WorkspaceSymbolLocation,
};
use uavspec_schema::source::Span;
use uavspec_schema::table::{self, Page, error_code};
use uavspec_schema::{Form, Message, MessageId, Schema};

use super::events;
use super::snapshot::{Document, Snapshot};

/// The maximum number of symbols in the answer to a search. Editors search again as the user types.
const MAX_SYMBOLS: usize = 1_000;

/// The symbols of a document: messages with their constants and fields, headings with their error codes, or components
/// with their events and enums.
pub(super) fn symbols(document: &Document<'_>) -> Vec<DocumentSymbol> {
    match document.form() {
        Some(Form::Msg(_)) => {
            document.messages().into_iter().map(|(id, span)| message(document, id, span)).collect()
        }
        Some(Form::Table) => headings(document),
        Some(Form::Events) => events::symbols(document),
        None => Vec::new(),
    }
}

fn message(document: &Document<'_>, id: MessageId, span: Span) -> DocumentSymbol {
    let schema = &document.snapshot.schema;
    let message = schema.message(id);
    let constants = message.constants.iter().map(|constant| {
        let detail = constant.value.to_string();
        symbol(document, &constant.name, SymbolKind::Constant, detail, constant.span, constant.span)
    });
    let fields = message.fields.iter().map(|field| {
        let unit = field.unit.as_ref().map(|unit| format!(" [{unit}]")).unwrap_or_default();
        let detail = schema.type_text(message, field.ty) + &unit;
        symbol(document, &field.name, SymbolKind::Field, detail, field.span, field.span)
    });
    let mut children: Vec<DocumentSymbol> = constants.chain(fields).collect();
    children.sort_by_key(|child| child.range);
    let start = Span { start: span.start, end: span.start };
    let detail = message.docs.summary.clone();
    let own = symbol(document, &message.name, SymbolKind::Struct, detail, span, start);
    DocumentSymbol { children: Some(children), ..own }
}

#[allow(deprecated)] // `deprecated` must be set
pub(super) fn symbol(
    document: &Document<'_>,
    name: &str,
    kind: SymbolKind,
    detail: String,
    whole: Span,
    name_span: Span,
) -> DocumentSymbol {
    DocumentSymbol {
        name: name.to_owned(),
        detail: Some(detail).filter(|detail| !detail.is_empty()),
        kind,
        tags: None,
        deprecated: None,
        range: document.range(whole),
        selection_range: document.range(name_span),
        children: None,
    }
}

/// The headings of a page as a tree. The codes of a table belong to its heading.
fn headings(document: &Document<'_>) -> Vec<DocumentSymbol> {
    let (page, _) = table::parse(&document.snapshot.loaded.sources, document.id);
    let (tables, _) = error_code::read(&page);
    let mut roots: Vec<DocumentSymbol> = Vec::new();
    let mut above: Vec<(usize, DocumentSymbol)> = Vec::new();
    for (at, heading) in page.headings.iter().enumerate() {
        while above.last().is_some_and(|(level, _)| *level >= heading.level) {
            close(&mut above, &mut roots);
        }
        let (span, name) = (heading.text.span(), heading.text.as_str());
        if name.is_empty() {
            continue;
        }
        let whole = span.to(section_end(document, &page, at));
        let mut own = symbol(document, name, SymbolKind::Namespace, String::new(), whole, span);
        let rows = tables.iter().filter(|table| table.span == span).flat_map(|table| &table.rows);
        let codes = rows.map(|row| {
            let detail = row.abbreviation.as_str().to_owned();
            symbol(document, &row.code.to_string(), SymbolKind::EnumMember, detail, row.span, row.span)
        });
        own.children = Some(codes.collect());
        above.push((heading.level, own));
    }
    while !above.is_empty() {
        close(&mut above, &mut roots);
    }
    roots
}

/// Moves the last open heading into the heading above it.
fn close(above: &mut Vec<(usize, DocumentSymbol)>, roots: &mut Vec<DocumentSymbol>) {
    let Some((_, done)) = above.pop() else { return };
    let parent = above.last_mut().map_or(roots, |(_, parent)| parent.children.get_or_insert_default());
    parent.push(done);
}

/// The end of the section under a heading.
fn section_end(document: &Document<'_>, page: &Page, at: usize) -> Span {
    let level = page.headings[at].level;
    let next = page.headings[at + 1..].iter().find(|heading| heading.level <= level);
    let whole = document.whole();
    let end = next.map_or(whole.end, |heading| {
        // The section ends before the line of the next heading.
        let start = document.snapshot.offsets(document.id, heading.text.span()).start;
        let line = document.lines.start(document.lines.line_of(start));
        document.span(line.saturating_sub(1)..line).start
    });
    Span { start: end, end }
}

/// The messages, constants, types, error codes, events and enums of events whose name contains a text, ignoring case.
pub(super) fn search(snapshot: &Snapshot, query: &str) -> Vec<WorkspaceSymbol> {
    let query = query.to_lowercase();
    let matches = |name: &str| name.to_lowercase().contains(&query);
    all(&snapshot.schema)
        .filter(|(name, ..)| matches(name))
        .filter_map(|(name, kind, container, span)| {
            Some(WorkspaceSymbol {
                location: WorkspaceSymbolLocation::Location(snapshot.location(span)?),
                data: None,
                base_symbol_information: BaseSymbolInformation {
                    name,
                    kind,
                    tags: None,
                    container_name: Some(container),
                },
            })
        })
        .take(MAX_SYMBOLS)
        .collect()
}

/// The named items of a schema: name, kind, container and location.
fn all(schema: &Schema) -> impl Iterator<Item = (String, SymbolKind, String, Span)> {
    let package = |message: &Message| schema.package_of(message).name.clone();
    let messages = schema.messages.iter().flat_map(move |message| {
        let start = Span { start: message.span.start, end: message.span.start };
        let own = (message.name.clone(), SymbolKind::Struct, package(message), start);
        let constants = message.constants.iter().map(|constant| {
            (constant.name.clone(), SymbolKind::Constant, message.name.clone(), constant.span)
        });
        let fields = message
            .fields
            .iter()
            .map(|field| (field.name.clone(), SymbolKind::Field, message.name.clone(), field.span));
        std::iter::once(own).chain(constants).chain(fields)
    });
    let types = schema
        .json_types
        .iter()
        .map(|ty| (ty.name.clone(), SymbolKind::Class, schema.packages[ty.package].name.clone(), ty.span));
    let pages = schema.json_messages.iter().map(|message| {
        (message.name.clone(), SymbolKind::Event, schema.packages[message.package].name.clone(), message.span)
    });
    let codes = schema.packages.iter().flat_map(|package| {
        package.error_tables.iter().flat_map(|table| &table.codes).map(|code| {
            let abbreviation = code.abbreviation.as_deref().unwrap_or_default();
            let name = format!("{} {abbreviation}", code.code).trim_end().to_owned();
            (name, SymbolKind::EnumMember, package.name.clone(), code.span)
        })
    });
    let events = schema.packages.iter().flat_map(|package| &package.components).flat_map(|component| {
        let symbol = |name: &String, kind, span| (name.clone(), kind, component.namespace.clone(), span);
        let events =
            component.events.iter().map(move |event| symbol(&event.name, SymbolKind::Event, event.span));
        let enums =
            component.enums.iter().map(move |found| symbol(&found.name, SymbolKind::Enum, found.span));
        events.chain(enums)
    });
    messages.chain(types).chain(pages).chain(codes).chain(events)
}

/// The parts of a document that an editor can fold: comments and blocks of declarations, or sections of a page. Editors
/// fold JSON without help.
pub(super) fn folds(document: &Document<'_>) -> Vec<FoldingRange> {
    match document.form() {
        Some(Form::Msg(_)) => {}
        Some(Form::Table) => return sections(document),
        Some(Form::Events) | None => return Vec::new(),
    }
    let lines = 0..document.lines.count();
    let kinds: Vec<LineKind> = lines.map(|line| LineKind::of(document.lines.line(line))).collect();
    let mut folds = Vec::new();
    let mut start = 0;
    for run in kinds.chunk_by(|left, right| left == right) {
        let kind = match run[0] {
            LineKind::Comment => Some(FoldingRangeKind::Comment),
            LineKind::Declaration => Some(FoldingRangeKind::Region),
            LineKind::Other => None,
        };
        folds.extend(kind.and_then(|kind| fold(start, start + run.len() - 1, kind)));
        start += run.len();
    }
    folds
}

/// The kind of a line of a definition.
#[derive(Clone, Copy, PartialEq, Eq)]
enum LineKind {
    Comment,
    Declaration,
    /// An empty line or a separator.
    Other,
}

impl LineKind {
    fn of(line: &str) -> Self {
        match line.trim_start() {
            "" | "---" => Self::Other,
            text if text.starts_with('#') => Self::Comment,
            _ => Self::Declaration,
        }
    }
}

fn sections(document: &Document<'_>) -> Vec<FoldingRange> {
    let (page, _) = table::parse(&document.snapshot.loaded.sources, document.id);
    let line = |span: Span| document.lines.line_of(document.snapshot.offsets(document.id, span).start);
    let section = |at: usize| {
        let end = line(section_end(document, &page, at));
        fold(line(page.headings[at].text.span()), end, FoldingRangeKind::Region)
    };
    (0..page.headings.len()).filter_map(section).collect()
}

/// The fold from the first to the last line. `None` for a single line.
fn fold(first: usize, last: usize, kind: FoldingRangeKind) -> Option<FoldingRange> {
    let line = |line: usize| u32::try_from(line).unwrap_or(u32::MAX);
    (last > first).then(|| FoldingRange {
        start_line: line(first),
        end_line: line(last),
        kind: Some(kind),
        ..FoldingRange::default()
    })
}
