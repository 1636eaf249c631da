//! Matches the packages, messages, services and error codes of two versions.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use uavspec_runtime::Scalar;
use uavspec_schema::source::Span;
use uavspec_schema::{
    ErrorCode, Event, EventArgument, EventComponent, EventEnum, Interface, Kind, MessageId, Package, Schema,
    Type,
};

use super::message::{Between, Matched, Matching, Pair, PairOf, is_uorb};
use super::order::likeness;
use super::signature::Signatures;
use crate::limits::MAX_COMPARISONS;

/// Two matched versions of definitions.
#[derive(Debug)]
pub(crate) struct Comparison<'a> {
    /// Messages in both versions, including the parts of services and actions.
    pub pairs: Vec<Pair<'a>>,
    /// Messages, services and actions that were added, removed or renamed.
    pub changes: Vec<MessageChange<'a>>,
    /// The error codes.
    pub codes: Vec<CodeChange<'a>>,
    /// The events.
    pub events: Vec<EventChange<'a>>,
    /// The enums of events that both versions have.
    pub event_enums: Vec<(&'a EventEnum, &'a EventEnum)>,
}

/// A message, a service or an action that was added, removed or renamed.
#[derive(Debug)]
pub(crate) enum MessageChange<'a> {
    /// Only in the old version.
    Removed(Named<'a>),
    /// Only in the new version.
    Added(Named<'a>),
    /// In both versions under different names, with similar fields.
    Renamed(Named<'a>, Named<'a>),
}

/// A message, a service or an action.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Named<'a> {
    /// The kind.
    pub kind: Kind,
    /// The name.
    pub name: &'a str,
    /// The file.
    pub span: Span,
    /// True for a uORB message.
    pub is_uorb: bool,
}

/// An error code in one or both versions.
#[derive(Clone, Copy, Debug)]
pub(crate) enum CodeChange<'a> {
    /// Only in the old version.
    Removed(&'a ErrorCode),
    /// Only in the new version.
    Added(&'a ErrorCode),
    /// An abbreviation whose new number was not used before.
    Renumbered(&'a ErrorCode, &'a ErrorCode),
    /// A number with a new meaning.
    Reused(&'a ErrorCode, &'a ErrorCode),
    /// An unchanged number and meaning.
    Same(&'a ErrorCode, &'a ErrorCode),
}

/// An event in one or both versions.
#[derive(Clone, Copy, Debug)]
pub(crate) enum EventChange<'a> {
    /// Only in the old version.
    Removed(&'a Event),
    /// Only in the new version.
    Added(&'a Event),
    /// In both versions, each with its package and its component.
    Same(EventIn<'a>, EventIn<'a>),
}

/// An event, with its component and its package.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EventIn<'a> {
    package: &'a Package,
    component: &'a EventComponent,
    /// The event.
    pub event: &'a Event,
}

impl EventIn<'_> {
    /// The arguments as in a declaration in C: `uint8_t tank, float depth`.
    pub(super) fn arguments(&self) -> String {
        let argument = |argument: &EventArgument| {
            format!("{} {}", self.package.event_type(self.component, argument), argument.name)
        };
        self.event.arguments.iter().map(argument).collect::<Vec<_>>().join(", ")
    }

    /// The scalar types of the arguments, in order. An enum argument has the type of its numbers.
    pub(super) fn layout(&self) -> Vec<Scalar> {
        self.event.arguments.iter().map(|argument| argument.scalar).collect()
    }
}

impl<'a> Comparison<'a> {
    /// Matches two versions.
    pub(crate) fn new(old: &'a Schema, new: &'a Schema, between: Between) -> Self {
        Self::of_packages((old, new), packages(old, new), &[], between)
    }

    /// Matches the contents of pairs of packages. `others` contains further pairs of messages, whose names may differ.
    pub(crate) fn of_packages(
        (old, new): (&'a Schema, &'a Schema),
        packages: Vec<(Option<&'a Package>, Option<&'a Package>)>,
        others: &[(MessageId, MessageId)],
        between: Between,
    ) -> Self {
        let mut matcher = Matcher {
            old,
            new,
            twins: Vec::new(),
            changes: Vec::new(),
            codes: Vec::new(),
            events: Vec::new(),
            event_enums: Vec::new(),
        };
        for (before, after) in packages {
            matcher.messages(before, after);
            matcher.interfaces(before, after);
            matcher.codes(before, after);
            matcher.events(before, after);
        }
        let twin_of: HashMap<MessageId, MessageId> = matcher.twins.iter().copied().collect();
        let matching = Matching { old, new, twins: &twin_of };
        let listed = matcher.twins.iter().chain(others);
        let fields: Vec<Matched> = listed.clone().map(|(old, new)| matching.fields(*old, *new)).collect();
        let mut old_names = HashMap::new();
        for ((before, after), fields) in matcher.twins.iter().zip(&fields) {
            old_names.insert(*after, matching.old_names(*before, *after, fields));
        }
        let mut signatures = Signatures::default();
        let context = PairOf {
            matching,
            old_signatures: signatures.of(old, &HashMap::new()),
            new_signatures: signatures.of(new, &old_names),
            between,
        };
        let pairs =
            listed.zip(&fields).map(|((old, new), fields)| context.pair(*old, *new, fields)).collect();
        let Matcher { changes, codes, events, event_enums, .. } = matcher;
        Self { pairs, changes, codes, events, event_enums }
    }
}

/// Pairs of packages with the same name. If exactly one unpaired package remains in each version, and both use the same
/// definition format, these two are also paired. Unpaired dependencies are ignored.
fn packages<'a>(old: &'a Schema, new: &'a Schema) -> Vec<(Option<&'a Package>, Option<&'a Package>)> {
    let find = |among: &'a Schema, name: &str| among.packages.iter().find(|package| package.name == name);
    let mut pairs: Vec<(Option<&Package>, Option<&Package>)> = Vec::new();
    let unpaired = |among: &'a Schema, others: &'a Schema| {
        let packages = among.packages.iter().filter(|package| !package.is_dependency);
        packages.filter(|package| find(others, &package.name).is_none()).collect::<Vec<&Package>>()
    };
    let (removed, mut added) = (unpaired(old, new), unpaired(new, old));
    for package in &old.packages {
        if let Some(twin) = find(new, &package.name) {
            pairs.push((Some(package), Some(twin)));
        }
    }
    let is_only = removed.len() == 1 && added.len() == 1;
    for package in removed {
        let twin = added.pop_if(|twin| is_only && twin.form == package.form);
        pairs.push((Some(package), twin));
    }
    pairs.extend(added.into_iter().map(|package| (None, Some(package))));
    pairs
}

struct Matcher<'a> {
    old: &'a Schema,
    new: &'a Schema,
    twins: Vec<(MessageId, MessageId)>,
    changes: Vec<MessageChange<'a>>,
    codes: Vec<CodeChange<'a>>,
    events: Vec<EventChange<'a>>,
    event_enums: Vec<(&'a EventEnum, &'a EventEnum)>,
}

impl<'a> Matcher<'a> {
    fn messages(&mut self, old: Option<&'a Package>, new: Option<&'a Package>) {
        let by_name = |schema: &'a Schema, package: Option<&'a Package>| -> BTreeMap<&'a str, MessageId> {
            let ids = package.into_iter().flat_map(|package| &package.messages);
            ids.map(|id| (schema.message(*id).name.as_str(), *id)).collect()
        };
        let (mut before, mut after) = (by_name(self.old, old), by_name(self.new, new));
        let both: Vec<&str> = before.keys().copied().filter(|name| after.contains_key(name)).collect();
        for name in both {
            self.twins.extend(before.remove(name).zip(after.remove(name)));
        }
        if is_partial(old) || is_partial(new) {
            return;
        }
        for (name, twin) in self.renamed(&before, &after) {
            let (Some(old), Some(new)) = (before.remove(name), after.remove(twin)) else { continue };
            self.twins.push((old, new));
            self.changes.push(MessageChange::Renamed(named(self.old, old), named(self.new, new)));
        }
        let removed = before.into_values().map(|id| MessageChange::Removed(named(self.old, id)));
        let added = after.into_values().map(|id| MessageChange::Added(named(self.new, id)));
        self.changes.extend(removed.chain(added));
    }

    /// The old and new names of renamed messages. Renamed messages are detected by their fields, and the most similar
    /// pairs come first.
    fn renamed(
        &self,
        old: &BTreeMap<&'a str, MessageId>,
        new: &BTreeMap<&'a str, MessageId>,
    ) -> Vec<(&'a str, &'a str)> {
        let count = |schema: &Schema, ids: &BTreeMap<&str, MessageId>| -> usize {
            ids.values().map(|id| schema.message(*id).fields.len() + 1).sum()
        };
        let comparisons = count(self.old, old).saturating_mul(new.len());
        if comparisons.saturating_add(count(self.new, new).saturating_mul(old.len())) > MAX_COMPARISONS {
            return Vec::new();
        }
        let fields = |schema: &'a Schema, id: MessageId| -> BTreeSet<(&'a str, String)> {
            let message = schema.message(id);
            let text = |ty: Type| schema.type_text(message, ty);
            message.fields.iter().map(|field| (field.name.as_str(), text(field.ty))).collect()
        };
        let new: Vec<_> = new.iter().map(|(name, id)| (*name, fields(self.new, *id))).collect();
        let mut candidates = Vec::new();
        for (name, id) in old {
            let before = fields(self.old, *id);
            for (twin, after) in &new {
                let common = before.intersection(after).count();
                let max = before.len().max(after.len());
                // Messages with two or three fields are often similar, so their names must be similar as well.
                let is_same = if common > 3 {
                    common * 5 >= max * 4
                } else {
                    common > 1 && common == max && likeness(name, twin) >= 0.5
                };
                if is_same {
                    candidates.push((common * 1000 / max, name.len().abs_diff(twin.len()), *name, *twin));
                }
            }
        }
        candidates
            .sort_by_key(|(share, difference, name, twin)| (usize::MAX - share, *difference, *name, *twin));
        let (mut names, mut twins) = (BTreeSet::new(), BTreeSet::new());
        let mut renamed = Vec::new();
        for (_, _, name, twin) in candidates {
            if !names.contains(name) && !twins.contains(twin) {
                names.insert(name);
                twins.insert(twin);
                renamed.push((name, twin));
            }
        }
        renamed
    }

    fn interfaces(&mut self, old: Option<&'a Package>, new: Option<&'a Package>) {
        let by_name = |package: Option<&'a Package>| -> BTreeMap<(Kind, &'a str), &'a Interface> {
            let interfaces = package.into_iter().flat_map(|package| &package.interfaces);
            interfaces.map(|found| ((found.kind, found.name.as_str()), found)).collect()
        };
        if is_partial(old) || is_partial(new) {
            return;
        }
        let named = |found: &'a Interface| Named {
            kind: found.kind,
            name: &found.name,
            span: found.span,
            is_uorb: false,
        };
        let mut added = by_name(new);
        for (name, before) in by_name(old) {
            match added.remove(&name) {
                Some(after) => {
                    self.twins.extend(before.parts.iter().copied().zip(after.parts.iter().copied()));
                }
                None => self.changes.push(MessageChange::Removed(named(before))),
            }
        }
        self.changes.extend(added.into_values().map(|after| MessageChange::Added(named(after))));
    }

    fn codes(&mut self, old: Option<&'a Package>, new: Option<&'a Package>) {
        let by_code = |package: Option<&'a Package>| -> BTreeMap<u32, &'a ErrorCode> {
            let tables = package.into_iter().flat_map(|package| &package.error_tables);
            tables.flat_map(|table| &table.codes).map(|code| (code.code, code)).collect()
        };
        let (before, mut after) = (by_code(old), by_code(new));
        let mut removed = Vec::new();
        for (number, old) in before {
            match after.remove(&number) {
                Some(new) if is_other(old, new) => self.codes.push(CodeChange::Reused(old, new)),
                Some(new) => self.codes.push(CodeChange::Same(old, new)),
                None => removed.push(old),
            }
        }
        let mut by_abbreviation: BTreeMap<&str, Vec<&'a ErrorCode>> = BTreeMap::new();
        for code in after.values() {
            by_abbreviation.entry(code.abbreviation.as_deref().unwrap_or("")).or_default().push(code);
        }
        for old in removed {
            // Prefers the same severity, then the nearest number.
            let twins = old.abbreviation.as_deref().and_then(|text| by_abbreviation.get(text));
            let twins = twins.into_iter().flatten().filter(|twin| after.contains_key(&twin.code));
            let twin =
                twins.min_by_key(|new| (new.severity() != old.severity(), new.code.abs_diff(old.code)));
            self.codes.push(match twin.map(|twin| twin.code).and_then(|code| after.remove(&code)) {
                Some(new) => CodeChange::Renumbered(old, new),
                None => CodeChange::Removed(old),
            });
        }
        self.codes.extend(after.into_values().map(CodeChange::Added));
    }
}

impl<'a> Matcher<'a> {
    /// Matches events by their ids, which are hashes of their names, and the enums by their names.
    fn events(&mut self, old: Option<&'a Package>, new: Option<&'a Package>) {
        let components = |package: Option<&'a Package>| {
            let package = package.into_iter();
            package.flat_map(|package| package.components.iter().map(move |component| (package, component)))
        };
        let by_id = |package: Option<&'a Package>| -> BTreeMap<u32, EventIn<'a>> {
            let events = components(package).flat_map(|(package, component)| {
                component.events.iter().map(move |event| EventIn { package, component, event })
            });
            events.map(|found| (found.event.id, found)).collect()
        };
        let mut after = by_id(new);
        for (id, before) in by_id(old) {
            self.events.push(match after.remove(&id) {
                Some(after) => EventChange::Same(before, after),
                None => EventChange::Removed(before.event),
            });
        }
        self.events.extend(after.into_values().map(|added| EventChange::Added(added.event)));
        let by_name = |package: Option<&'a Package>| -> BTreeMap<(u8, &'a str), &'a EventEnum> {
            let enums = components(package).flat_map(|(_, component)| {
                component.enums.iter().map(move |found| ((component.id, found.name.as_str()), found))
            });
            enums.collect()
        };
        let after = by_name(new);
        let both = by_name(old).into_iter().filter_map(|(name, before)| Some((before, *after.get(&name)?)));
        self.event_enums.extend(both);
    }
}

/// True if a version contains only some messages of a package. The other messages may exist, so nothing is known about
/// them.
fn is_partial(package: Option<&Package>) -> bool {
    package.is_some_and(|package| package.is_dependency)
}

fn named(schema: &Schema, id: MessageId) -> Named<'_> {
    let message = schema.message(id);
    let is_uorb = is_uorb(schema, message);
    Named { kind: message.kind, name: &message.name, span: message.span, is_uorb }
}

/// True if a code has a different meaning: neither its abbreviation nor its description resembles the old one.
fn is_other(old: &ErrorCode, new: &ErrorCode) -> bool {
    let abbreviations = [old, new].map(|code| code.abbreviation.as_deref().unwrap_or(""));
    abbreviations[0] != abbreviations[1]
        && likeness(abbreviations[0], abbreviations[1]) < 0.5
        && common_words(&old.description, &new.description) < 0.5
}

/// The fraction of words that two texts have in common, from 0 to 1.
pub(super) fn common_words(left: &str, right: &str) -> f64 {
    let words = |text: &str| -> BTreeSet<String> {
        let words = text.split(|c: char| !c.is_alphanumeric()).filter(|word| word.len() > 2);
        words.map(str::to_lowercase).collect()
    };
    let (left, right) = (words(left), words(right));
    let all = left.len() + right.len();
    if all == 0 {
        return 1.0;
    }
    #[allow(clippy::cast_precision_loss)] // word counts are small
    let share = 2.0 * left.intersection(&right).count() as f64 / all as f64;
    share
}
