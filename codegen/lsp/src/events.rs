//! Event metadata: the locations of components, groups, events and enums in a file. The schema contains their meaning.

use jsonc_parser::ast::{Object, ObjectProp, StringLit, Value};
use jsonc_parser::common::{Range, Ranged as _};
use lsp_types::{CompletionItemKind, DocumentSymbol, SymbolKind};
use uavspec_runtime::Scalar;
use uavspec_schema::event::{scalar, scalar_name, syntax};
use uavspec_schema::source::Span;
use uavspec_schema::{EventEnumRef, EventKind};

use super::completion::item::Item;
use super::outline::symbol;
use super::snapshot::Document;
use super::symbol::{Occurrence, Symbol};

/// The members of the object that is the value of `name`. Empty if there is no such object.
fn members<'o, 's>(object: &'o Object<'s>, name: &str) -> &'o [ObjectProp<'s>] {
    object.get_object(name).map_or(&[], |found| &found.properties)
}

/// The value of a member, if it is an object.
fn object<'o, 's>(member: &'o ObjectProp<'s>) -> Option<&'o Object<'s>> {
    member.value.as_object()
}

impl Document<'_> {
    fn span_of(&self, range: Range) -> Span {
        self.span(range.start..range.end)
    }

    /// The location of the text between quotes.
    fn quoted(&self, range: Range) -> Span {
        self.span(range.start + 1..range.end - 1)
    }
}

/// The definitions of events and enums, and the uses of enums as types of arguments.
pub(super) fn occurrences(document: &Document<'_>) -> Vec<Occurrence> {
    let mut found = Vec::new();
    let (Some(package), Some(root)) = (document.package_index(), syntax(document.lines.text())) else {
        return found;
    };
    let mut push = |symbol, span, is_definition| found.push(Occurrence { symbol, span, is_definition });
    let places = Places::new(document, package);
    let components = root.as_object().map_or(&[][..], |root| members(root, "components"));
    for component in components.iter().filter_map(object) {
        for declared in members(component, "enums") {
            let range = declared.name.range();
            if let Some(reference) = places.enumeration(document.span_of(range)) {
                push(Symbol::EventEnum(package, reference), document.quoted(range), true);
            }
        }
        let groups = members(component, "event_groups").iter().filter_map(object);
        for event in groups.flat_map(|group| members(group, "events")) {
            let range = event.name.range();
            let (Some((component, index)), Some(written)) =
                (places.event(document.span_of(range)), object(event))
            else {
                continue;
            };
            let symbol = Symbol::Event(package, component, index);
            push(symbol.clone(), document.quoted(range), true);
            if let Some(name) = written.get_string("name") {
                push(symbol, document.quoted(name.range), false);
            }
            let arguments = written.get_array("arguments").map_or(&[][..], |list| &list.elements);
            let resolved = &document.snapshot.schema.packages[package].components[component].events[index];
            for (argument, resolved) in arguments.iter().zip(&resolved.arguments) {
                let ty = argument.as_object().and_then(|argument| argument.get_string("type"));
                if let (Some(ty), Some(reference)) = (ty, resolved.enumeration) {
                    let span = document.quoted(ty.range);
                    let text = document.text(span);
                    // Skip the namespace, which precedes the name.
                    let start = text.rfind("::").map_or(0, |at| at + "::".len());
                    push(Symbol::EventEnum(package, reference), span.part(start..text.len()), false);
                }
            }
        }
    }
    found
}

/// The events and enums of a package, sorted by location.
struct Places {
    events: Vec<(Span, (usize, usize))>,
    enums: Vec<(Span, EventEnumRef)>,
}

impl Places {
    fn new(document: &Document<'_>, package: usize) -> Self {
        let (mut events, mut enums) = (Vec::new(), Vec::new());
        for (component, found) in document.snapshot.schema.packages[package].components.iter().enumerate() {
            events.extend(found.events.iter().enumerate().map(|(at, event)| (event.span, (component, at))));
            let references = (0..).map(|index| EventEnumRef { component, index });
            enums.extend(found.enums.iter().map(|declared| declared.span).zip(references));
        }
        events.sort_unstable();
        enums.sort_unstable();
        Self { events, enums }
    }

    /// The event at a location: the index of its component, and its index in the component.
    fn event(&self, span: Span) -> Option<(usize, usize)> {
        self.events.binary_search_by_key(&span, |(known, _)| *known).ok().map(|at| self.events[at].1)
    }

    fn enumeration(&self, span: Span) -> Option<EventEnumRef> {
        self.enums.binary_search_by_key(&span, |(known, _)| *known).ok().map(|at| self.enums[at].1)
    }
}

/// The symbols of a file: components, their enums with the entries, and their groups with the events.
pub(super) fn symbols(document: &Document<'_>) -> Vec<DocumentSymbol> {
    let Some(root) = syntax(document.lines.text()) else { return Vec::new() };
    let outline = Outline { document };
    root.as_object()
        .map_or(&[][..], |root| members(root, "components"))
        .iter()
        .map(|member| outline.component(member))
        .collect()
}

struct Outline<'d, 's> {
    document: &'d Document<'s>,
}

impl Outline<'_, '_> {
    fn component(&self, member: &ObjectProp<'_>) -> DocumentSymbol {
        let groups = |name| object(member).map_or(&[][..], |component| members(component, name));
        let enums = groups("enums").iter().map(|declared| {
            let entries = self.children(declared, "entries", SymbolKind::EnumMember, "description");
            DocumentSymbol {
                children: Some(entries),
                ..self.named(declared, SymbolKind::Enum, None, "description")
            }
        });
        let events = groups("event_groups").iter().map(|group| {
            let events = self.children(group, "events", SymbolKind::Event, "message");
            DocumentSymbol { children: Some(events), ..self.named(group, SymbolKind::Package, None, "") }
        });
        let own = self.named(member, SymbolKind::Namespace, Some("namespace"), "");
        DocumentSymbol { children: Some(enums.chain(events).collect()), ..own }
    }

    fn children(
        &self,
        member: &ObjectProp<'_>,
        list: &str,
        kind: SymbolKind,
        detail: &str,
    ) -> Vec<DocumentSymbol> {
        let all = object(member).map_or(&[][..], |found| members(found, list));
        all.iter().map(|child| self.named(child, kind, Some("name"), detail)).collect()
    }

    /// A symbol without children. `name` is the member that contains the name, if the key of the object isn't the name.
    fn named(
        &self,
        member: &ObjectProp<'_>,
        kind: SymbolKind,
        name: Option<&str>,
        detail: &str,
    ) -> DocumentSymbol {
        let text = |name: &str| Some(object(member)?.get_string(name)?.value.as_ref());
        let key = member.name.as_str();
        let name = name.and_then(text).unwrap_or(key);
        let detail = text(detail).unwrap_or_default().to_owned();
        let [whole, key] = [member.range, member.name.range()].map(|range| self.document.span_of(range));
        // Use a placeholder for an empty name, because editors reject a symbol without a name.
        symbol(self.document, if name.is_empty() { "-" } else { name }, kind, detail, whole, key)
    }
}

/// The completion items for the type of an argument, an enum or an event. Also returns the start of the text that they
/// replace, as a position in the line.
pub(super) fn items(document: &Document<'_>, offset: usize) -> Option<(usize, Vec<Item>)> {
    let root = syntax(document.lines.text())?;
    let mut path = Vec::new();
    let text = string_at(&root, offset, &mut path)?;
    let line = document.lines.start(document.lines.line_of(offset));
    let types = || Scalar::ALL.into_iter().map(scalar_name).filter_map(|name| Some((scalar(&name)?, name)));
    let basic = |name: &str| Item::new(name, CompletionItemKind::Keyword, "basic type");
    let items = match path[..] {
        [.., "arguments", "type"] => {
            let package = &document.snapshot.schema.packages[document.package_index()?];
            let own = path.get(1)?.parse();
            let enums = package.components.iter().flat_map(|component| {
                let prefix = if own == Ok(component.id) {
                    String::new()
                } else {
                    format!("{}::", component.namespace)
                };
                component.enums.iter().map(move |declared| {
                    let name = format!("{prefix}{}", declared.name);
                    Item::new(name, CompletionItemKind::Enum, declared.description.as_str())
                })
            });
            types().map(|(_, name)| basic(&name)).chain(enums).collect()
        }
        ["components", _, "enums", _, "type"] => {
            types().filter(|(scalar, _)| !scalar.is_float()).map(|(_, name)| basic(&name)).collect()
        }
        [.., "events", _, "type"] => [EventKind::Summary, EventKind::AppendChecks]
            .map(|kind| Item::new(kind.name(), CompletionItemKind::Keyword, "type of event"))
            .into(),
        _ => return None,
    };
    Some(((text.range.start + 1).checked_sub(line)?, items))
}

/// The string around a byte offset, with the names of the members that lead to it.
fn string_at<'v>(value: &'v Value<'_>, offset: usize, path: &mut Vec<&'v str>) -> Option<&'v StringLit<'v>> {
    let is_around = |range: Range| range.start < offset && offset < range.end;
    match value {
        Value::Object(object) => {
            let member = object.properties.iter().find(|member| is_around(member.value.range()))?;
            path.push(member.name.as_str());
            string_at(&member.value, offset, path)
        }
        Value::Array(list) => {
            string_at(list.elements.iter().find(|element| is_around(element.range()))?, offset, path)
        }
        Value::StringLit(text) => Some(text).filter(|text| is_around(text.range)),
        _ => None,
    }
}
