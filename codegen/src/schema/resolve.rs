//! Syntax trees to model: names become references, and all that is wrong across lines and files is
//! found. The only place that knows both sides.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::documentation::{self, ItemDocs};
use super::enumeration::{self, ByPrefix, EnumRef};
use super::fingerprint::{self, MAX_NESTED_FIELDS};
use super::layout::{self, MAX_MESSAGE_SIZE};
use super::{
    CdrSize, Constant, Dialect, Element, Field, Form, Interface, Kind, Message, MessageId, Package, Parameter, Range,
    Schema, Special, Type, error_codes,
};
use crate::diagnostic::{Diagnostic, Problem, has_errors};
use crate::msg::annotation::{Note, Prefix, SpecialValue, Statement};
use crate::msg::ast::{self, ConstantType, Definition, Item, Line, Part};
use crate::source::Span;
use crate::table::Page;
use crate::value::Value;
use uavspec_runtime::Scalar;

/// Beyond this many mistakes no similar names are looked for: the search is over all names.
const MAX_SUGGESTIONS: usize = 100;

/// Names that ROS 2 takes without their package, and where they are defined.
const WELL_KNOWN: [(&str, &str, &str); 3] = [
    ("Header", "std_msgs", "Header"),
    ("time", "builtin_interfaces", "Time"),
    ("duration", "builtin_interfaces", "Duration"),
];

/// Types of other languages, and what they are called here.
const FOREIGN: [(&str, &str); 6] = [
    ("float", "float32"),
    ("double", "float64"),
    ("int", "int32"),
    ("boolean", "bool"),
    ("time", "uint64"),
    ("duration", "uint64"),
];

/// A path of a cycle longer than twice this is shown by its ends.
const MAX_CYCLE_END: usize = 8;

/// Most fields that all messages of a run may have together with all that they nest. Their hashes run
/// over each of them; the largest release of PX4 has some thousands.
const MAX_NESTED_FIELDS_IN_ALL: u64 = 1 << 22;

/// Most members that all enums of a run may have together.
const MAX_MEMBERS: usize = 1 << 20;

/// No similar names are looked for that are longer than this: it takes time and room with the product
/// of the lengths.
const MAX_SUGGESTION_LEN: usize = 100;

/// A package before it is resolved.
#[derive(Debug)]
pub struct PackageSource<'s> {
    /// Its name.
    pub name: String,
    /// The form of its definitions.
    pub form: Form,
    /// The name that ROS knows it by, which type hashes contain.
    pub ros_package: String,
    /// Where its definitions come from.
    pub origin: Option<String>,
    /// Which state of the origin they follow.
    pub revision: Option<String>,
    /// Which messages are wanted, with what they refer to; all, where absent.
    pub select: Option<Vec<(String, Span)>>,
    /// Its `.msg` files and their relatives: file stem, kind, span, tree.
    pub files: Vec<(&'s str, Kind, Span, Definition<'s>)>,
    /// Its pages with tables.
    pub pages: Vec<Page>,
}

/// Resolves all packages together. Where an error is among the diagnostics, the schema is not
/// complete, and nothing should be generated from it.
pub fn resolve(mut packages: Vec<PackageSource<'_>>) -> (Schema, Vec<Diagnostic>) {
    packages.sort_by(|left, right| left.name.cmp(&right.name));
    let mut resolver = Resolver::default();
    resolver.declare(&packages);
    resolver.lower(&packages);
    resolver.tables(packages);
    let order = resolver.order();
    resolver.enums();
    resolver.measure(&order);
    if !has_errors(&resolver.diagnostics) {
        resolver.fingerprints();
    }
    resolver.select();
    (resolver.schema, resolver.diagnostics)
}

/// What is still unresolved of a message once its fields are.
struct Pending {
    /// Fields that hold an enum: the field, its prefixes, whether it is a mask, and the annotation.
    enums: Vec<PendingEnum>,
}

struct PendingEnum {
    field: usize,
    /// The message that owns the constants.
    owner: MessageId,
    prefixes: Vec<String>,
    is_flags: bool,
    span: Span,
}

/// Owner, prefixes, type, and whether it is a mask.
type EnumKey = (MessageId, Vec<String>, Scalar, bool);

#[derive(Default)]
struct Resolver<'s> {
    schema: Schema,
    diagnostics: Vec<Diagnostic>,
    /// Messages by package and name.
    by_name: HashMap<(usize, &'s str), MessageId>,
    package_by_name: HashMap<String, usize>,
    /// Where each message comes from, in the order of [`Schema::messages`].
    origins: Vec<Origin>,
    pending: Vec<Pending>,
    claimed: Vec<BTreeSet<String>>,
    suggestions: usize,
    selections: Vec<Option<Vec<(String, Span)>>>,
    /// The constants of the part that is being lowered.
    constants: HashMap<&'s str, Value>,
    /// The enums that have been gathered: none where there is nothing to gather.
    gathered: HashMap<EnumKey, Option<EnumRef>>,
    /// The constants of each message that has enums.
    by_prefix: HashMap<MessageId, ByPrefix>,
    /// How many members they have.
    members: usize,
}

#[derive(Clone, Copy)]
struct Origin {
    package: usize,
    file: usize,
    part: usize,
}

impl<'s> Resolver<'s> {
    /// Gives each message its id, in the order of package, kind and name.
    fn declare(&mut self, packages: &[PackageSource<'s>]) {
        for (package, source) in packages.iter().enumerate() {
            self.package_by_name.insert(source.name.clone(), package);
            self.selections.push(source.select.clone());
            let mut files: Vec<usize> = (0..source.files.len()).collect();
            files.sort_by_key(|file| (source.files[*file].1, source.files[*file].0));
            let mut interfaces = Vec::new();
            let mut messages = Vec::new();
            let mut first: BTreeMap<(Kind, String), (&str, Span)> = BTreeMap::new();
            for file in files {
                let (stem, kind, span, ref definition) = source.files[file];
                self.check_message_name(stem, source.form, span);
                if let Some((earlier, place)) = first.insert((kind, stem.to_lowercase()), (stem, span)) {
                    let problem = Problem::DuplicateMessage { name: stem.to_owned(), package: source.name.clone() };
                    let mut diagnostic = Diagnostic::new(problem, span.part(0..0)).with_related(place.part(0..0), "the first one");
                    if earlier != stem {
                        let hint = format!("on some systems `{earlier}` and `{stem}` are one file: rename one of them");
                        diagnostic = diagnostic.with_hint(hint);
                    }
                    self.report(diagnostic);
                    continue;
                }
                let mut parts = Vec::new();
                for (part, suffix) in kind.part_suffixes().iter().enumerate().take(definition.parts.len()) {
                    let id = id(self.schema.messages.len());
                    self.origins.push(Origin { package, file, part });
                    self.schema.messages.push(empty_message(package, kind, format!("{stem}{suffix}"), span));
                    parts.push(id);
                }
                if kind == Kind::Message {
                    self.by_name.insert((package, stem), parts[0]);
                    messages.append(&mut parts);
                } else {
                    interfaces.push(Interface { name: stem.to_owned(), kind, parts, type_hash: None, span });
                }
            }
            self.schema.packages.push(Package {
                name: source.name.clone(),
                form: source.form,
                ros_package: source.ros_package.clone(),
                origin: source.origin.clone(),
                revision: source.revision.clone(),
                messages,
                interfaces,
                error_tables: Vec::new(),
            });
        }
    }

    fn check_message_name(&mut self, stem: &str, form: Form, span: Span) {
        let is_pascal_case = stem.starts_with(|c: char| c.is_ascii_uppercase()) && !stem.contains('_');
        let stem_text = stem.to_owned();
        let problem = if !is_identifier(stem) {
            Problem::MessageName { stem: stem_text }
        } else if is_pascal_case {
            return;
        } else if form == Form::Msg(Dialect::Ros2) {
            Problem::NameStyleRos { name: stem_text, style: "PascalCase" }
        } else {
            Problem::MessageNameStyle { stem: stem_text }
        };
        let diagnostic = Diagnostic::new(problem, span.part(0..0));
        self.report(if is_identifier(stem) { diagnostic.with_hint("rename the file") } else { diagnostic });
    }

    /// Fills in fields, constants, groups and topics of each message.
    fn lower(&mut self, packages: &[PackageSource<'s>]) {
        self.claimed = vec![BTreeSet::new(); self.schema.messages.len()];
        for index in 0..self.schema.messages.len() {
            let origin = self.origins[index];
            let source = &packages[origin.package];
            let Form::Msg(dialect) = source.form else { continue };
            let part = &source.files[origin.file].3.parts[origin.part];
            let pending = self.lower_part(index, part, dialect);
            self.pending.push(pending);
        }
    }

    fn lower_part(&mut self, index: usize, part: &Part<'s>, dialect: Dialect) -> Pending {
        let commentary = documentation::read(part, dialect);
        let mut pending = Pending { enums: Vec::new() };
        let duplicates = self.duplicates(part);
        // Before all fields: an annotation may name a constant that stands below.
        self.constants = part.lines.iter().filter_map(constant).map(|found| (found.name.text, found.value.clone())).collect();
        let items = part.lines.iter().filter(|line| line.item.is_some());
        for (line, docs) in items.zip(commentary.items) {
            match &line.item {
                Some(Item::Field(field)) if !duplicates.contains(&field.name.span) => {
                    self.field(index, line, field, docs, &mut pending);
                }
                Some(Item::Constant(constant)) if !duplicates.contains(&constant.name.span) => {
                    self.constant(index, line, constant, docs);
                }
                _ => {}
            }
        }
        let message = &mut self.schema.messages[index];
        message.docs = commentary.docs;
        message.groups = commentary.groups;
        if dialect == Dialect::Px4 && message.kind == Kind::Message {
            self.topics(index, &commentary.topics);
            self.known_constants(index);
        }
        self.counts(index, part);
        pending
    }

    /// The second and further declarations of a name, by its place.
    fn duplicates(&mut self, part: &Part<'s>) -> BTreeSet<Span> {
        let mut fields: HashMap<&str, Span> = HashMap::new();
        let mut constants: HashMap<&str, Span> = HashMap::new();
        let mut duplicates = BTreeSet::new();
        for item in part.lines.iter().filter_map(|line| line.item.as_ref()) {
            let (known, name, whole) = match item {
                Item::Field(field) => (&mut fields, field.name, field.ty.span.to(field.name.span)),
                Item::Constant(constant) => (&mut constants, constant.name, constant.name.span.to(constant.value_span)),
            };
            let Some(first) = known.get(name.text) else {
                known.insert(name.text, whole);
                continue;
            };
            let problem = match item {
                Item::Field(_) => Problem::DuplicateField { name: name.text.to_owned() },
                Item::Constant(_) => Problem::DuplicateConstant { name: name.text.to_owned() },
            };
            self.diagnostics.push(Diagnostic::new(problem, name.span).with_related(*first, "the first one"));
            duplicates.insert(name.span);
        }
        duplicates
    }

    fn field(&mut self, index: usize, line: &Line<'s>, field: &ast::Field<'s>, docs: ItemDocs, pending: &mut Pending) {
        let Some(ty) = self.field_type(index, &field.ty) else { return };
        let mut lowered = Field {
            name: field.name.text.to_owned(),
            ty,
            default: field.default.clone(),
            description: docs.description,
            group: docs.group,
            unit: None,
            range: None,
            invalid: None,
            uncontrolled: None,
            frame: None,
            enum_prefixes: Vec::new(),
            enumeration: None,
            counts: None,
            span: field.ty.span.to(field.name.span),
        };
        if let Some(note) = note(line) {
            self.annotate(index, &mut lowered, note, pending);
        }
        self.schema.messages[index].fields.push(lowered);
    }

    fn field_type(&mut self, index: usize, ty: &ast::Type<'s>) -> Option<Type> {
        let element = match ty.element {
            ast::Element::Scalar(scalar) => Element::Scalar(scalar),
            ast::Element::String { wide, bound } => Element::String { wide, bound },
            ast::Element::Message { package, name } => Element::Message(self.reference(index, package, name, ty.span)?),
        };
        Some(Type { element, shape: ty.shape })
    }

    fn reference(&mut self, index: usize, package: Option<&'s str>, name: &'s str, span: Span) -> Option<MessageId> {
        let own = self.schema.messages[index].package;
        let found = match package {
            Some(package) => {
                let Some(package) = self.package_by_name.get(package).copied() else {
                    self.report(Diagnostic::new(Problem::UnknownPackage { package: package.to_owned() }, span));
                    return None;
                };
                (package, self.by_name.get(&(package, name)).copied())
            }
            None => (own, self.by_name.get(&(own, name)).copied().or_else(|| self.well_known(own, name))),
        };
        if let (package, None) = found {
            let problem =
                Problem::UnknownType { name: name.to_owned(), package: self.schema.packages[package].name.clone() };
            let diagnostic = Diagnostic::new(problem, span);
            let is_ros2 = self.schema.packages[package].form == Form::Msg(Dialect::Ros2);
            let well_known = WELL_KNOWN.iter().find(|(short, ..)| is_ros2 && *short == name);
            let hint = match well_known {
                Some((_, package, message)) => {
                    Some(format!("it stands for `{package}/{message}`: add that package to the inputs"))
                }
                None => self.similar(package, name).map(|similar| format!("did you mean `{similar}`?")),
            };
            self.report(Diagnostic { hint, ..diagnostic });
        }
        found.1
    }

    /// The message behind a name that ROS 2 takes without its package.
    fn well_known(&self, package: usize, name: &str) -> Option<MessageId> {
        if self.schema.packages[package].form != Form::Msg(Dialect::Ros2) {
            return None;
        }
        let (_, package, name) = *WELL_KNOWN.iter().find(|(short, ..)| *short == name)?;
        self.by_name.get(&(*self.package_by_name.get(package)?, name)).copied()
    }

    /// A known type whose name is close to `name`.
    fn similar(&mut self, package: usize, name: &str) -> Option<String> {
        self.suggestions += 1;
        if self.suggestions > MAX_SUGGESTIONS || name.len() > MAX_SUGGESTION_LEN {
            return None;
        }
        if let Some((_, meant)) = FOREIGN.iter().find(|(foreign, _)| *foreign == name) {
            return Some((*meant).to_owned());
        }
        let messages = &self.schema.packages[package].messages;
        let mut known: Vec<&str> = messages.iter().map(|id| self.schema.message(*id).name.as_str()).collect();
        known.extend(Scalar::ALL.map(Scalar::name));
        known
            .into_iter()
            .filter(|known| known.len().abs_diff(name.len()) <= 1 + known.len() / 5)
            .map(|known| (strsim::damerau_levenshtein(known, name), known))
            .filter(|(distance, known)| *distance <= 1 + known.len() / 5)
            .min()
            .map(|(_, known)| known.to_owned())
    }

    fn annotate(&mut self, index: usize, field: &mut Field, note: &Note<'s>, pending: &mut Pending) {
        for annotation in &note.annotations {
            match &annotation.statement {
                Statement::Unit(unit) => field.unit = Some((*unit).to_owned()),
                Statement::Range { low, high } => {
                    for bound in [low, high] {
                        self.check_value(bound.as_ref(), field.ty, annotation.span);
                    }
                    field.range = Some(range(low.as_ref(), high.as_ref()));
                }
                Statement::Invalid(special) => field.invalid = self.special(special, field.ty, annotation.span),
                Statement::Uncontrolled(special) => {
                    field.uncontrolled = self.special(special, field.ty, annotation.span);
                }
                Statement::Frame(frame) => field.frame = Some((*frame).to_owned()),
                // Resolved with the whole message: the array may stand below.
                Statement::Count(_) => {}
                Statement::Enum(prefixes) | Statement::Flags(prefixes) => {
                    field.enum_prefixes = prefixes.iter().map(prefix_text).collect();
                    let is_flags = matches!(annotation.statement, Statement::Flags(_));
                    if let Some(owner) = self.enum_owner(index, prefixes, annotation.span) {
                        let prefixes: Vec<String> = prefixes.iter().map(|prefix| prefix.prefix.to_owned()).collect();
                        self.claimed[owner.0 as usize].extend(prefixes.iter().cloned());
                        let field = self.schema.messages[index].fields.len();
                        pending.enums.push(PendingEnum { field, owner, prefixes, is_flags, span: annotation.span });
                    }
                }
            }
        }
    }

    /// The message whose constants are meant: this one, or the one that the prefix names.
    fn enum_owner(&mut self, index: usize, prefixes: &[Prefix<'s>], span: Span) -> Option<MessageId> {
        match prefixes.iter().find_map(|prefix| prefix.message) {
            Some(message) => self.reference(index, None, message, span),
            None => Some(id(index)),
        }
    }

    fn special(&mut self, special: &crate::msg::annotation::Special<'s>, ty: Type, span: Span) -> Option<Special> {
        let text = special.text.to_owned();
        let value = match &special.value {
            SpecialValue::Empty => None,
            SpecialValue::Number(value) => Some(value.clone()),
            SpecialValue::Name(name) => {
                let Some(value) = self.constants.get(name).cloned() else {
                    let problem = Problem::UnknownConstant { name: (*name).to_owned() };
                    self.report(Diagnostic::new(problem, span));
                    return None;
                };
                Some(value)
            }
        };
        self.check_value(value.as_ref(), ty, span);
        Some(Special { value, text })
    }

    /// A field can hold what its annotations say of its values.
    fn check_value(&mut self, value: Option<&Value>, ty: Type, span: Span) {
        if let (Some(value), Element::Scalar(scalar)) = (value, ty.element)
            && !can_hold(scalar, value)
        {
            let problem =
                Problem::AnnotationValueType { text: value.to_string(), type_name: scalar.name().to_owned() };
            self.report(Diagnostic::new(problem, span));
        }
    }

    fn constant(&mut self, index: usize, line: &Line<'s>, constant: &ast::Constant<'s>, docs: ItemDocs) {
        let parameters = note(line).map_or(&[][..], |note| note.parameters.as_slice());
        let parameters = parameters.iter().map(|note| self.parameter(index, note)).collect();
        self.schema.messages[index].constants.push(Constant {
            name: constant.name.text.to_owned(),
            ty: match constant.ty {
                ConstantType::Scalar(scalar) => Element::Scalar(scalar),
                ConstantType::String { wide } => Element::String { wide, bound: None },
            },
            value: constant.value.clone(),
            description: docs.description,
            parameters,
            group: docs.group,
            span: constant.name.span.to(constant.value_span),
        });
    }

    fn parameter(&mut self, index: usize, note: &Note<'s>) -> Parameter {
        let mut parameter = Parameter {
            unit: None,
            range: None,
            invalid: None,
            enum_prefixes: Vec::new(),
            description: note.text.as_ref().to_owned(),
        };
        let number = Type { element: Element::Scalar(Scalar::Float64), shape: ast::Shape::Single };
        for annotation in &note.annotations {
            match &annotation.statement {
                Statement::Unit(unit) => parameter.unit = Some((*unit).to_owned()),
                Statement::Range { low, high } => parameter.range = Some(range(low.as_ref(), high.as_ref())),
                Statement::Invalid(special) => parameter.invalid = self.special(special, number, annotation.span),
                Statement::Enum(prefixes) | Statement::Flags(prefixes) => {
                    parameter.enum_prefixes = prefixes.iter().map(prefix_text).collect();
                    self.claimed[index].extend(prefixes.iter().map(|prefix| prefix.prefix.to_owned()));
                }
                Statement::Uncontrolled(_) | Statement::Frame(_) | Statement::Count(_) => {}
            }
        }
        parameter
    }

    fn topics(&mut self, index: usize, listed: &[(&str, Span)]) {
        let mut topics: Vec<String> = Vec::new();
        let mut first: HashMap<&str, Span> = HashMap::new();
        for (topic, span) in listed {
            let name = (*topic).to_owned();
            if !is_identifier(topic) {
                self.report(Diagnostic::new(Problem::InvalidTopic { topic: name }, *span));
            } else if let Some(earlier) = first.get(topic) {
                let diagnostic = Diagnostic::new(Problem::DuplicateTopic { topic: name }, *span);
                self.report(diagnostic.with_related(*earlier, "the first one"));
            } else {
                first.insert(topic, *span);
                topics.push(name);
            }
        }
        let message = &mut self.schema.messages[index];
        if listed.is_empty() {
            topics.push(default_topic(&message.name));
        }
        message.topics = topics;
    }

    /// `MESSAGE_VERSION` and `ORB_QUEUE_LENGTH`, which PX4 knows by name.
    fn known_constants(&mut self, index: usize) {
        for (what, least) in [("MESSAGE_VERSION", 0), ("ORB_QUEUE_LENGTH", 1)] {
            let message = &mut self.schema.messages[index];
            let Some(constant) = message.constants.iter().find(|constant| constant.name == what) else { continue };
            let value = constant.value.as_int().and_then(|value| u32::try_from(value).ok()).filter(|value| *value >= least);
            let span = constant.span;
            match what {
                "MESSAGE_VERSION" => message.version = value,
                _ => message.queue_length = value,
            }
            if value.is_none() {
                self.report(Diagnostic::new(Problem::InvalidVersion { what, least }, span));
            }
        }
    }

    /// Which fields count the entries in use of an array: as annotated, else by their names.
    fn counts(&mut self, index: usize, part: &Part<'s>) {
        let fields = &self.schema.messages[index].fields;
        let places: HashMap<Span, usize> = fields.iter().enumerate().map(|(at, field)| (field.span, at)).collect();
        let arrays: HashMap<String, usize> = fields
            .iter()
            .enumerate()
            .filter(|(_, field)| field.ty.shape != ast::Shape::Single)
            .map(|(at, field)| (field.name.clone(), at))
            .collect();
        for line in &part.lines {
            let (Some(Item::Field(field)), Some(note)) = (&line.item, note(line)) else { continue };
            let Some(at) = places.get(&field.ty.span.to(field.name.span)) else { continue };
            for annotation in &note.annotations {
                if let Statement::Count(target) = annotation.statement {
                    self.count(index, *at, target, &arrays, annotation.span);
                }
            }
        }
        for field in &mut self.schema.messages[index].fields {
            let counted = field.name.strip_prefix("num_").or_else(|| field.name.strip_suffix("_count"));
            if field.counts.is_none() && is_count(field.ty) {
                field.counts = counted.and_then(|counted| arrays.get(counted)).copied();
            }
        }
    }

    fn count(&mut self, index: usize, field: usize, target: &str, arrays: &HashMap<String, usize>, span: Span) {
        let message = &mut self.schema.messages[index];
        let ty = message.fields[field].ty;
        let problem = match arrays.get(target) {
            None => Problem::UnknownCountTarget { name: target.to_owned() },
            Some(_) if !is_count(ty) => {
                Problem::CountOnNonInteger { type_name: self.schema.type_text(self.schema.message(id(index)), ty) }
            }
            Some(array) => {
                message.fields[field].counts = Some(*array);
                return;
            }
        };
        self.report(Diagnostic::new(problem, span));
    }

    fn tables(&mut self, packages: Vec<PackageSource<'s>>) {
        for (index, source) in packages.into_iter().enumerate() {
            if source.form == Form::Table {
                let (tables, mut diagnostics) = error_codes::resolve(&source.pages);
                self.schema.packages[index].error_tables = tables;
                self.diagnostics.append(&mut diagnostics);
            }
        }
    }

    /// All messages, each after those that it holds. Messages that hold themselves are reported and
    /// left out.
    fn order(&mut self) -> Vec<MessageId> {
        let count = self.schema.messages.len();
        let mut missing: Vec<usize> = vec![0; count];
        let mut holders: Vec<Vec<usize>> = vec![Vec::new(); count];
        for (index, message) in self.schema.messages.iter().enumerate() {
            for nested in nested_ids(message) {
                missing[index] += 1;
                holders[nested.0 as usize].push(index);
            }
        }
        let mut ready: Vec<usize> = (0..count).filter(|index| missing[*index] == 0).collect();
        let mut order = Vec::with_capacity(count);
        while let Some(index) = ready.pop() {
            order.push(id(index));
            for holder in &holders[index] {
                missing[*holder] -= 1;
                if missing[*holder] == 0 {
                    ready.push(*holder);
                }
            }
        }
        self.report_cycles(&missing);
        order
    }

    /// Reports each cycle once. `missing` counts, for each message, the nested ones that no order
    /// could be found for: from a message that has one, each step leads to another.
    fn report_cycles(&mut self, missing: &[usize]) {
        let mut is_done = vec![false; missing.len()];
        for start in 0..missing.len() {
            let mut path: Vec<usize> = Vec::new();
            let mut at = start;
            while missing[at] > 0 && !is_done[at] {
                is_done[at] = true;
                path.push(at);
                let next = nested_ids(&self.schema.messages[at]).map(|id| id.0 as usize).find(|next| missing[*next] > 0);
                let Some(next) = next else { break };
                at = next;
            }
            if let Some(first) = path.iter().position(|index| *index == at).filter(|_| missing[at] > 0) {
                self.report_cycle(&path[first..]);
            }
        }
    }

    fn report_cycle(&mut self, cycle: &[usize]) {
        let messages = &self.schema.messages;
        let closing = |from: usize, to: usize| {
            let holds = |field: &&Field| field.ty.element == Element::Message(id(to));
            messages[from].fields.iter().find(holds).map(|field| field.span)
        };
        let names: Vec<&str> = cycle.iter().chain(&cycle[..1]).map(|index| messages[*index].name.as_str()).collect();
        let mut steps = (0..cycle.len()).filter_map(|at| closing(cycle[at], cycle[(at + 1) % cycle.len()]));
        let Some(span) = steps.next() else { return };
        let mut path = names.clone();
        if path.len() > 2 * MAX_CYCLE_END {
            path.splice(MAX_CYCLE_END..path.len() - MAX_CYCLE_END, ["…"]);
        }
        let mut diagnostic = Diagnostic::new(Problem::Cycle { path: path.join(" → ") }, span);
        for (span, name) in steps.zip(&names[2..]).take(MAX_CYCLE_END) {
            diagnostic = diagnostic.with_related(span, format!("holds `{name}`"));
        }
        self.report(diagnostic);
    }

    fn enums(&mut self) {
        for (index, pending) in std::mem::take(&mut self.pending).into_iter().enumerate() {
            for wanted in pending.enums {
                self.enumeration(index, &wanted);
            }
        }
    }

    fn enumeration(&mut self, index: usize, wanted: &PendingEnum) {
        let field = &self.schema.messages[index].fields[wanted.field];
        let scalar = match field.ty.element {
            Element::Scalar(scalar) if scalar.integer_bounds().is_some() => scalar,
            element => {
                let type_name = match element {
                    Element::Scalar(scalar) => scalar.name(),
                    Element::String { .. } => "string",
                    Element::Message(_) => "message",
                };
                let problem = Problem::EnumOnNonInteger { type_name: type_name.to_owned() };
                self.report(Diagnostic::new(problem, wanted.span));
                return;
            }
        };
        let key = (wanted.owner, wanted.prefixes.clone(), scalar, wanted.is_flags);
        let reference = match self.gathered.get(&key) {
            Some(known) => *known,
            None => self.gather(wanted, scalar),
        };
        self.gathered.insert(key, reference);
        self.schema.messages[index].fields[wanted.field].enumeration = reference;
    }

    /// Gathers an enum that no field has asked for before; none where it has no members.
    fn gather(&mut self, wanted: &PendingEnum, scalar: Scalar) -> Option<EnumRef> {
        let owner = self.schema.message(wanted.owner);
        let by_prefix = self.by_prefix.entry(wanted.owner).or_insert_with(|| {
            enumeration::by_prefix(owner, &self.claimed[wanted.owner.0 as usize])
        });
        for prefix in &wanted.prefixes {
            if !by_prefix.is_used(prefix) {
                let problem = Problem::UnknownEnum { prefix: prefix.clone(), place: owner.name.clone() };
                self.diagnostics.push(Diagnostic::new(problem, wanted.span));
            }
        }
        self.members += wanted.prefixes.iter().map(|prefix| by_prefix.count(prefix)).sum::<usize>();
        if self.members > MAX_MEMBERS {
            let problem = Problem::TooManyMembers { max: MAX_MEMBERS };
            self.diagnostics.push(Diagnostic::new(problem, wanted.span));
            return None;
        }
        let candidate = by_prefix.gather(owner, &wanted.prefixes, scalar, wanted.is_flags);
        for (constant, value) in candidate.out_of_range {
            let constant = &owner.constants[constant];
            let problem = Problem::EnumValueOutOfRange {
                constant: constant.name.clone(),
                value: value.to_string(),
                type_name: scalar.name().to_owned(),
            };
            let diagnostic = Diagnostic::new(problem, wanted.span);
            self.diagnostics.push(diagnostic.with_related(constant.span, "the constant"));
        }
        if candidate.found.members.is_empty() {
            return None;
        }
        let enums = &mut self.schema.messages[wanted.owner.0 as usize].enums;
        enums.push(candidate.found);
        Some(EnumRef { message: wanted.owner, index: enums.len() - 1 })
    }

    /// Layouts, sizes, and the limits on both.
    fn measure(&mut self, order: &[MessageId]) {
        let sizes = layout::cdr(&self.schema, order);
        let mut nested_fields: Vec<u64> = vec![0; self.schema.messages.len()];
        let mut in_all = 0_u64;
        let mut is_too_large = vec![false; self.schema.messages.len()];
        for id in order {
            let index = id.0 as usize;
            let message = &self.schema.messages[index];
            nested_fields[index] = message.fields.len() as u64;
            for nested in nested_ids(message) {
                nested_fields[index] = nested_fields[index].saturating_add(nested_fields[nested.0 as usize]);
            }
            let uorb = layout::uorb(&self.schema, message);
            let size = uorb.as_ref().map_or(0, |layout| layout.size as u64).max(sizes[index].least);
            // What holds a message that is too large is too large itself: one word is enough.
            is_too_large[index] = nested_ids(message).any(|nested| is_too_large[nested.0 as usize]);
            if !is_too_large[index] {
                let was_over = in_all > MAX_NESTED_FIELDS_IN_ALL;
                in_all = in_all.saturating_add(nested_fields[index]);
                let exceeds_all = !was_over && in_all > MAX_NESTED_FIELDS_IN_ALL;
                is_too_large[index] = !self.fits(index, size, nested_fields[index], exceeds_all);
            }
            let message = &mut self.schema.messages[index];
            message.uorb = uorb;
            message.cdr = sizes[index];
        }
    }

    /// Whether a message is within all limits; reports the first that it isn't within.
    fn fits(&mut self, index: usize, size: u64, nested_fields: u64, exceeds_all: bool) -> bool {
        let message = &self.schema.messages[index];
        let name = message.name.clone();
        let problem = if size > MAX_MESSAGE_SIZE {
            Problem::TooLarge { what: format!("the message `{name}`"), max: MAX_MESSAGE_SIZE }
        } else if nested_fields > MAX_NESTED_FIELDS {
            Problem::TooManyFields { name, max: MAX_NESTED_FIELDS }
        } else if exceeds_all {
            Problem::TooMuchNesting { name, max: MAX_NESTED_FIELDS_IN_ALL }
        } else {
            return true;
        };
        let largest = message.fields.iter().max_by_key(|field| match field.ty.shape {
            ast::Shape::Array(length) => length,
            _ => 1,
        });
        let span = largest.map_or(message.span.part(0..0), |field| field.span);
        self.report(Diagnostic::new(problem, span));
        false
    }

    fn fingerprints(&mut self) {
        for index in 0..self.schema.messages.len() {
            let id = id(index);
            let hash = fingerprint::message_hash(&self.schema, self.schema.message(id));
            let type_hash = fingerprint::type_hash(&self.schema, id);
            let message = &mut self.schema.messages[index];
            message.hash = hash;
            message.type_hash = type_hash;
        }
        for package in 0..self.schema.packages.len() {
            let hashes: Vec<Option<String>> = self.schema.packages[package]
                .interfaces
                .iter()
                .map(|interface| fingerprint::service_hash(&self.schema, interface, package))
                .collect();
            for (interface, hash) in self.schema.packages[package].interfaces.iter_mut().zip(hashes) {
                interface.type_hash = hash;
            }
        }
    }

    /// Lists only what is selected in each package, with all that it refers to.
    fn select(&mut self) {
        if self.selections.iter().all(Option::is_none) {
            return;
        }
        let mut open: Vec<MessageId> = Vec::new();
        for (index, selection) in std::mem::take(&mut self.selections).into_iter().enumerate() {
            let package = &mut self.schema.packages[index];
            let Some(selection) = selection else {
                open.extend(package.messages.iter().chain(package.interfaces.iter().flat_map(|interface| &interface.parts)));
                continue;
            };
            let wants = |name: &str| selection.iter().any(|(wanted, _)| wanted == name);
            package.interfaces.retain(|interface| wants(&interface.name));
            open.extend(package.interfaces.iter().flat_map(|interface| &interface.parts));
            let messages = &self.schema.messages;
            open.extend(package.messages.iter().filter(|id| wants(&messages[id.0 as usize].name)));
            for (name, span) in &selection {
                let is_message = package.messages.iter().any(|id| messages[id.0 as usize].name == *name);
                if !is_message && !package.interfaces.iter().any(|interface| interface.name == *name) {
                    let problem = Problem::UnknownType { name: name.clone(), package: package.name.clone() };
                    self.diagnostics.push(Diagnostic::new(problem, *span));
                }
            }
        }
        let mut wanted: BTreeSet<MessageId> = BTreeSet::new();
        while let Some(id) = open.pop() {
            if wanted.insert(id) {
                let message = self.schema.message(id);
                open.extend(nested_ids(message));
                open.extend(message.fields.iter().filter_map(|field| Some(field.enumeration?.message)));
            }
        }
        for package in &mut self.schema.packages {
            package.messages.retain(|id| wanted.contains(id));
        }
    }

    fn report(&mut self, diagnostic: Diagnostic) {
        self.diagnostics.push(diagnostic);
    }
}

/// The id of the message at `index` of [`Schema::messages`]; there are fewer than bytes of sources.
fn id(index: usize) -> MessageId {
    MessageId(u32::try_from(index).unwrap_or(u32::MAX))
}

fn empty_message(package: usize, kind: Kind, name: String, span: Span) -> Message {
    Message {
        package,
        kind,
        name,
        span,
        docs: super::Docs::default(),
        topics: Vec::new(),
        version: None,
        queue_length: None,
        fields: Vec::new(),
        constants: Vec::new(),
        enums: Vec::new(),
        groups: Vec::new(),
        uorb: None,
        cdr: CdrSize::default(),
        hash: 0,
        type_hash: String::new(),
    }
}

fn constant<'l, 's>(line: &'l Line<'s>) -> Option<&'l ast::Constant<'s>> {
    match &line.item {
        Some(Item::Constant(constant)) => Some(constant),
        _ => None,
    }
}

fn note<'l, 's>(line: &'l Line<'s>) -> Option<&'l Note<'s>> {
    line.comment.as_ref()?.note.as_ref()
}

fn range(low: Option<&Value>, high: Option<&Value>) -> Range {
    Range { low: low.cloned(), high: high.cloned() }
}

fn prefix_text(prefix: &Prefix<'_>) -> String {
    prefix.message.map_or_else(|| prefix.prefix.to_owned(), |message| format!("{message}.{}", prefix.prefix))
}

fn nested_ids(message: &Message) -> impl Iterator<Item = MessageId> {
    message.fields.iter().filter_map(|field| match field.ty.element {
        Element::Message(id) => Some(id),
        Element::Scalar(_) | Element::String { .. } => None,
    })
}

fn is_count(ty: Type) -> bool {
    let is_integer = matches!(ty.element, Element::Scalar(scalar) if scalar.integer_bounds().is_some());
    is_integer && ty.shape == ast::Shape::Single
}

fn can_hold(scalar: Scalar, value: &Value) -> bool {
    match (scalar.integer_bounds(), value) {
        (Some((least, greatest)), Value::Int(value)) => (least..=greatest).contains(value),
        (Some(_), Value::Float(value)) => value.fract() == 0.0,
        (None, _) => scalar != Scalar::Bool || matches!(value, Value::Int(0 | 1) | Value::Bool(_)),
        (Some(_), _) => false,
    }
}

fn is_identifier(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_alphabetic()) && text.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
}

/// The topic of a message that lists none: PX4 puts `_` before every capital but the first.
fn default_topic(name: &str) -> String {
    let mut topic = String::with_capacity(name.len() + 4);
    for (at, character) in name.char_indices() {
        if at > 0 && character.is_ascii_uppercase() {
            topic.push('_');
        }
        topic.push(character.to_ascii_lowercase());
    }
    topic
}
