//! Resolves event metadata: combines the files of a package, and checks types and texts.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, HashMap, HashSet};

use uavspec_runtime::Scalar;
use uavspec_runtime::event::{MAX_ARGUMENTS_SIZE, MAX_SUB_ID, Piece, Profile, Text, sub_id};

use super::package::PackageSource;
use super::resolver::Resolver;
use crate::diagnostic::{Diagnostic, Problem};
use crate::event::file::{ArgumentSource, ComponentSource, EventSource};
use crate::event::{ARMING_CHECK, CHECK_GROUPS, COMMON, Located, scalar};
use crate::limits::{MAX_COMPARED_NAMES, MAX_EVENT_TEXT, MAX_MISTAKES};
use crate::span::Span;
use crate::wording::similar;
use crate::{Event, EventArgument, EventComponent, EventEnumRef, EventKind, Form};

/// The maximum length of a message, in characters, as in libevents' schema.
const MAX_MESSAGE: usize = 120;

impl<'s> Resolver<'s> {
    pub(super) fn events(&mut self, packages: &[PackageSource<'s>]) {
        for (index, source) in packages.iter().enumerate() {
            if source.input.form == Form::Events {
                let sources = source.events.iter().flat_map(|file| &file.components);
                let mut resolver = Events::default();
                resolver.resolve(sources);
                self.schema.packages[index].components = resolver.components;
                self.diagnostics.append(&mut resolver.diagnostics);
            }
        }
    }
}

/// The events of a package.
#[derive(Default)]
struct Events {
    components: Vec<EventComponent>,
    diagnostics: Vec<Diagnostic>,
    /// The index of each component, by namespace.
    by_namespace: HashMap<String, usize>,
    /// The number of names that were compared to find similar names.
    compared: usize,
}

impl Events {
    fn report(&mut self, problem: Problem, span: Span) {
        self.add(Diagnostic::new(problem, span));
    }

    fn add(&mut self, diagnostic: Diagnostic) {
        if self.diagnostics.len() < MAX_MISTAKES {
            self.diagnostics.push(diagnostic);
        }
    }

    fn resolve<'p>(&mut self, sources: impl Iterator<Item = &'p ComponentSource>) {
        // Several files may contain parts of a component.
        let mut by_id: BTreeMap<u8, Vec<&ComponentSource>> = BTreeMap::new();
        for source in sources {
            by_id.entry(source.id).or_default().push(source);
        }
        let mut namespaces: HashMap<&str, u8> = HashMap::new();
        for (id, parts) in &by_id {
            let namespace = &parts[0].namespace;
            let others = parts[1..].iter().filter(|part| part.namespace.text != namespace.text);
            for other in others {
                let name = other.namespace.text.clone();
                let problem = Problem::EventNamespace { id: *id, name, first: namespace.text.clone() };
                self.add(
                    Diagnostic::new(problem, other.namespace.span).with_related(namespace.span, "first"),
                );
            }
            if namespaces.insert(&namespace.text, *id).is_some() {
                self.duplicate("namespace", &namespace.text, namespace.span, None);
            }
            self.declare(*id, parts);
        }
        for (component, parts) in by_id.values().enumerate() {
            let mut names: HashMap<&str, Span> = HashMap::new();
            let mut ids: HashMap<u32, Span> = HashMap::new();
            let mut events: Vec<Event> = Vec::new();
            for source in parts.iter().flat_map(|part| &part.events) {
                if let Some(first) = ids.insert(source.sub_id, source.span) {
                    self.duplicate("event id", &source.sub_id.to_string(), source.span, Some(first));
                    continue;
                }
                if let Some(first) = names.insert(&source.name.text, source.name.span) {
                    self.duplicate("event", &source.name.text, source.name.span, Some(first));
                }
                events.extend(self.event(source, component));
            }
            events.sort_by(|left, right| left.name.cmp(&right.name));
            self.components[component].events = events;
        }
    }

    fn duplicate(&mut self, what: &'static str, name: &str, span: Span, first: Option<Span>) {
        let mut diagnostic =
            Diagnostic::new(Problem::DuplicateInEvents { what, name: name.to_owned() }, span);
        if let Some(first) = first {
            diagnostic = diagnostic.with_related(first, "first defined here");
        }
        self.add(diagnostic);
    }

    /// Adds a component without its events. The events are resolved later, when all enums are
    /// known.
    fn declare(&mut self, id: u8, parts: &[&ComponentSource]) {
        let namespace = parts[0].namespace.text.clone();
        let mut enums = BTreeMap::new();
        for declared in parts.iter().flat_map(|part| &part.enums) {
            match enums.entry(declared.name.as_str()) {
                Entry::Vacant(free) => _ = free.insert(declared),
                Entry::Occupied(first) => {
                    self.duplicate("enum", &declared.name, declared.span, Some(first.get().span));
                }
            }
        }
        let component = self.components.len();
        self.by_namespace.entry(namespace.clone()).or_insert(component);
        let mode_groups: BTreeMap<u8, Vec<u32>> =
            parts.iter().flat_map(|part| part.mode_groups.clone()).collect();
        let mut protocols: Vec<String> = parts.iter().flat_map(|part| part.protocols.clone()).collect();
        protocols.sort();
        protocols.dedup();
        self.components.push(EventComponent {
            id,
            namespace,
            enums: enums.into_values().cloned().collect(),
            events: Vec::new(),
            mode_groups: mode_groups.into_iter().collect(),
            protocols,
            span: parts[0].span,
        });
    }

    /// Resolves an event. `None` if its arguments can't be decoded.
    fn event(&mut self, source: &EventSource, component: usize) -> Option<Event> {
        let EventComponent { id, namespace, .. } = &self.components[component];
        let expected = sub_id(&source.name.text);
        let (id, is_numbered) = (u32::from(*id) * (MAX_SUB_ID + 1) + source.sub_id, namespace == COMMON);
        if source.sub_id != expected && !is_numbered {
            let (name, found) = (source.name.text.clone(), source.sub_id);
            self.report(Problem::EventId { name, found, expected }, source.span);
        }
        let arguments = self.arguments(source, component);
        let count = source.arguments.len();
        if source.message.text.contains('\n') {
            self.report(Problem::EventLine { what: "message" }, source.message.span);
        }
        let length = source.message.text.chars().count();
        if !(1..=MAX_MESSAGE).contains(&length) {
            self.report(Problem::EventMessageLength { length, max: MAX_MESSAGE }, source.message.span);
        }
        let message = self.text(&source.message, count);
        let description = source.description.as_ref().map(|text| self.text(text, count)).unwrap_or_default();
        let instance = source.instance_argument.and_then(|(index, span)| {
            let index = usize::try_from(index).ok().filter(|index| *index < count);
            if index.is_none() {
                self.report(Problem::EventInstance { count }, span);
            }
            index
        });
        let event = Event {
            id,
            name: source.name.text.clone(),
            group: source.group.clone(),
            kind: source.kind.map_or(EventKind::Plain, |(kind, _)| kind),
            message,
            description,
            arguments: arguments?,
            instance_argument: instance,
            span: source.span,
        };
        if event.size() > MAX_ARGUMENTS_SIZE {
            let (size, name) = (event.size(), event.name);
            self.report(Problem::EventSize { name, size, max: MAX_ARGUMENTS_SIZE }, source.name.span);
            return None;
        }
        self.check_kind(&event, source);
        Some(event)
    }

    fn arguments(&mut self, source: &EventSource, component: usize) -> Option<Vec<EventArgument>> {
        let mut offset = 0;
        let mut arguments = Vec::new();
        let mut names = HashMap::new();
        for argument in &source.arguments {
            if let Some(first) = names.insert(argument.name.text.as_str(), argument.name.span) {
                self.duplicate("argument", &argument.name.text, argument.name.span, Some(first));
            }
            let Some((scalar, enumeration)) = self.argument_type(argument, component) else { continue };
            arguments.push(EventArgument {
                name: argument.name.text.clone(),
                scalar,
                enumeration,
                description: argument.description.as_ref().map(|text| text.text.clone()).unwrap_or_default(),
                offset,
                span: argument.name.span,
            });
            offset += scalar.size();
        }
        (arguments.len() == source.arguments.len()).then_some(arguments)
    }

    fn argument_type(
        &mut self,
        argument: &ArgumentSource,
        component: usize,
    ) -> Option<(Scalar, Option<EventEnumRef>)> {
        let name = argument.ty.text.as_str();
        if let Some(scalar) = scalar(name) {
            return Some((scalar, None));
        }
        let (component, name) = match name.split_once("::") {
            Some((namespace, name)) => (self.by_namespace.get(namespace).copied(), name),
            None => (Some(component), name),
        };
        let enums = component.map_or(&[][..], |component| &self.components[component].enums);
        let index = enums.binary_search_by(|known| known.name.as_str().cmp(name)).ok();
        let Some((component, index)) = component.zip(index) else {
            let problem = Problem::UnknownEventType { name: argument.ty.text.clone() };
            let known = enums.iter().map(|known| known.name.as_str());
            let mut diagnostic = Diagnostic::new(problem, argument.ty.span);
            self.compared += enums.len();
            if self.compared <= MAX_COMPARED_NAMES
                && let Some(similar) = similar(name, known)
            {
                diagnostic = diagnostic.with_hint(format!("did you mean `{similar}`?"));
            }
            self.add(diagnostic);
            return None;
        };
        Some((enums[index].scalar, Some(EventEnumRef { component, index })))
    }

    /// Checks the syntax of a text. An overlong text is dropped, because reading it would take too long.
    fn text(&mut self, source: &Located, count: usize) -> String {
        let length = source.text.len();
        if length > MAX_EVENT_TEXT {
            self.report(Problem::EventTextLength { length, max: MAX_EVENT_TEXT }, source.span);
            return String::new();
        }
        for what in mistakes(Text::new(&source.text), count) {
            self.report(Problem::EventText { what }, source.span);
        }
        source.text.clone()
    }

    /// Checks an event whose type or group has a special meaning.
    fn check_kind(&mut self, event: &Event, source: &EventSource) {
        let group = event.group.as_str();
        let is_in_report = CHECK_GROUPS.contains(&group);
        if let Some((kind, span)) = source.kind
            && is_in_report != (kind == EventKind::Summary)
        {
            self.report(Problem::EventType { name: kind.name().to_owned(), group: group.to_owned() }, span);
            return;
        }
        let names: &[&str] = match (event.kind, group) {
            (EventKind::Summary, ARMING_CHECK) => &["chunk_idx", "error", "warning", "can_arm", "can_run"],
            (EventKind::Summary, _) => &["chunk_idx", "is_present", "error", "warning"],
            (EventKind::Plain, _) if is_in_report => &["modes", "health_component_index"],
            (EventKind::AppendChecks, _) => &["mode"],
            (EventKind::Plain, _) => return,
        };
        let is_bits = |argument: &EventArgument| {
            let found =
                argument.enumeration.map(|found| &self.components[found.component].enums[found.index]);
            found.is_some_and(|found| found.separator.is_some())
        };
        let is_right = |(index, name): (usize, &&str)| {
            let Some(argument) = event.arguments.get(index) else { return false };
            match *name {
                "modes" => is_bits(argument),
                "mode" => argument.scalar == Scalar::UInt32 && argument.enumeration.is_none(),
                "chunk_idx" | "health_component_index" => {
                    argument.scalar == Scalar::UInt8
                        && argument.enumeration.is_none()
                        && argument.name == *name
                }
                _ => is_bits(argument) && argument.name == *name,
            }
        };
        if !names.iter().enumerate().all(is_right) {
            let (name, expected) = (event.name.clone(), names.join(", "));
            self.report(Problem::EventArguments { name, expected }, source.name.span);
        }
    }
}

/// The distinct mistakes in a text of an event with `count` arguments.
fn mistakes(text: Text<'_>, count: usize) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    let pieces: Vec<Piece<'_>> = text.pieces().collect();
    let [has_tag, has_brace] = ["<", "{"].map(|start| pieces.contains(&Piece::Stray(start)));
    for piece in pieces {
        match piece {
            Piece::Plain(plain) => {
                // Report a stray end character only without a stray start character, which would
                // explain both.
                let stray = plain.chars().filter(|c| *c == '>' && !has_tag || *c == '}' && !has_brace);
                found.extend(stray.map(|stray| {
                    format!("`{stray}` has no matching start; write `\\{stray}` for the character")
                }));
                if ["http://", "https://"].iter().any(|start| plain.contains(start)) {
                    found.push("an address is outside of a tag; write `<a>ADDRESS</a>`".to_owned());
                }
            }
            Piece::Escaped("") => found.push("`\\` is the last character".to_owned()),
            Piece::Escaped(_) => {}
            Piece::Stray("{") => {
                found.push(
                    "`{` doesn't start a placeholder such as `{1}` or `{2:.1m/s}`; write `\\{` for the character"
                        .to_owned(),
                );
            }
            Piece::Stray(_) => {
                found.push("`<` starts a tag that isn't closed; write `\\<` for the character".to_owned());
            }
            Piece::Placeholder(placeholder) => {
                if placeholder.number > count {
                    let number = placeholder.text;
                    found.push(format!("`{number}` refers to none of the {count} arguments"));
                }
            }
            Piece::Tag(tag) => {
                let name = tag.name;
                match name {
                    "profile" => {
                        let profile = tag.attribute.map_or("", |(_, value)| value.trim_start_matches('!'));
                        let is_known = Profile::ALL.iter().any(|known| known.name() == profile);
                        if !is_known || tag.attribute.is_none_or(|(attribute, _)| attribute != "name") {
                            found.push(
                                "a profile is `name=\"dev\"` or `name=\"normal\"`, with `!` for all others"
                                    .to_owned(),
                            );
                        }
                        found.append(&mut mistakes(Text::new(tag.content), count));
                    }
                    "a" | "param" => {}
                    _ => found.push(format!("the tag `<{name}>` is unknown, so readers omit its content")),
                }
                if tag.content.contains(&format!("<{name}")) {
                    found.push(format!("the tag `<{name}>` is in a tag of the same name"));
                }
            }
        }
    }
    let mut known = HashSet::new();
    found.retain(|what| known.insert(what.clone()));
    found
}
