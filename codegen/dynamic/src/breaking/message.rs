//! Matches the fields and constants of a message in two versions.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use uavspec_schema::finding::Sides;
use uavspec_schema::source::Span;
use uavspec_schema::{Constant, Dialect, Element, Field, Form, Kind, Message, MessageId, Schema, Type};

use super::order;
use super::order::{align, likeness};
use super::signature::{SchemaSignatures, plain};
use crate::limits::MAX_REORDERINGS;

/// The kind of versions compared (commits or releases), which determines how `MESSAGE_VERSION` may change.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Between {
    /// Two commits: a changed message must raise its version by exactly one.
    #[default]
    Commits,
    /// Two releases: a changed message must raise its version by one or more.
    Releases,
}

/// Constants with a special meaning in PX4, which are checked by separate rules.
pub(super) const VERSION: &str = "MESSAGE_VERSION";
pub(super) const QUEUE_LENGTH: &str = "ORB_QUEUE_LENGTH";

/// The minimum similarity between a renamed item and the original.
const ALIKE: f64 = 0.5;

/// A message in both versions.
#[derive(Debug)]
pub(crate) struct Pair<'a> {
    /// The old schema.
    pub old_schema: &'a Schema,
    /// The new schema.
    pub new_schema: &'a Schema,
    /// The old message.
    pub old: &'a Message,
    /// The new message.
    pub new: &'a Message,
    /// The ids of the old and the new message.
    pub ids: (MessageId, MessageId),
    /// The fields.
    pub fields: Vec<FieldChange>,
    /// The constants, except constants with a special meaning in PX4.
    pub constants: Vec<ConstantChange<'a>>,
    /// The new names of renamed fields and constants, by their old names.
    pub renamed: HashMap<&'a str, &'a str>,
    /// The kind of versions compared.
    pub between: Between,
}

/// A field in one or both versions, given by its index.
#[derive(Clone, Copy, Debug)]
pub(crate) enum FieldChange {
    /// In both versions.
    Kept(Kept),
    /// Only in the old version.
    Removed(usize),
    /// Only in the new version.
    Added(usize),
}

/// A field in both versions, possibly renamed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kept {
    /// The index in the old message.
    pub old: usize,
    /// The index in the new message.
    pub new: usize,
    /// The change to the field's element type.
    pub held: Held,
    /// True if the field moved relative to the other fields that exist in both versions.
    pub is_moved: bool,
}

/// The change to a field's element type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Held {
    /// An unchanged type.
    Same,
    /// A nested message whose bytes changed.
    Changed {
        /// True if its CDR bytes changed.
        cdr: bool,
        /// True if its memory layout changed.
        uorb: bool,
    },
    /// A change to a different scalar, string or message type.
    Other,
}

/// A constant in one or both versions.
#[derive(Clone, Copy, Debug)]
pub(crate) enum ConstantChange<'a> {
    /// Only in the old version.
    Removed(&'a Constant),
    /// Only in the new version.
    Added(&'a Constant),
    /// A renamed constant with the old value.
    Renamed(&'a Constant, &'a Constant),
    /// A new constant with the value of a removed constant.
    Reused(&'a Constant, &'a Constant),
    /// A constant whose name is unchanged.
    Same(&'a Constant, &'a Constant),
}

impl<'a> Pair<'a> {
    /// The fields in both versions.
    pub(crate) fn kept(&self) -> impl Iterator<Item = &Kept> {
        self.fields.iter().filter_map(|change| match change {
            FieldChange::Kept(kept) => Some(kept),
            FieldChange::Removed(_) | FieldChange::Added(_) => None,
        })
    }

    /// The old and the new definition of each field that exists in both versions.
    pub(crate) fn fields(&self) -> impl Iterator<Item = (&'a Field, &'a Field)> {
        self.kept().map(|kept| (&self.old.fields[kept.old], &self.new.fields[kept.new]))
    }

    /// True if two frames are equal, or if both are references, such as `@frame`, to the same renamed field or
    /// constant.
    pub(crate) fn is_same_frame(&self, old: &str, new: &str) -> bool {
        let references = old.strip_prefix('@').zip(new.strip_prefix('@'));
        old == new
            || references.is_some_and(|(old, new)| self.renamed.get(old).is_some_and(|name| *name == new))
    }

    /// True if the names, types, lengths or order of fields changed, in which case PX4 requires a new message version.
    pub(crate) fn has_changed_fields(&self) -> bool {
        let is_changed = |change: &FieldChange| match change {
            FieldChange::Removed(_) | FieldChange::Added(_) => true,
            FieldChange::Kept(kept) => {
                let (old, new) = (&self.old.fields[kept.old], &self.new.fields[kept.new]);
                old.name != new.name
                    || kept.held == Held::Other
                    || old.ty.written().shape != new.ty.written().shape
                    || old.default != new.default
                    || kept.is_moved
            }
        };
        self.fields.iter().any(is_changed)
    }

    /// The new name.
    pub(crate) fn name(&self) -> &'a str {
        &self.new.name
    }

    /// The message's location in the new version.
    pub(crate) fn head(&self) -> Span {
        self.new.span.part(0..0)
    }

    /// True if the fields or their nested messages changed. PX4's hash covers the names and types of all nested fields.
    pub(crate) fn has_changes(&self) -> bool {
        self.has_changed_fields() || self.old.hash != self.new.hash
    }

    /// True for a uORB message.
    pub(crate) fn is_uorb(&self) -> bool {
        is_uorb(self.new_schema, self.new)
    }

    /// The old type of a field, in the syntax of definitions.
    pub(crate) fn old_type(&self, ty: Type) -> String {
        self.old_schema.type_text(self.old, ty)
    }

    /// The new type of a field.
    pub(crate) fn new_type(&self, ty: Type) -> String {
        self.new_schema.type_text(self.new, ty)
    }
}

/// The locations in both versions.
pub(super) fn both(old: Span, new: Span) -> Sides {
    Sides { old: Some(old), new: Some(new) }
}

/// True for a uORB message.
pub(super) fn is_uorb(schema: &Schema, message: &Message) -> bool {
    schema.package_of(message).form == Form::Msg(Dialect::Px4) && message.kind == Kind::Message
}

/// Maps the index of each matched old field to the index of its new field.
pub(super) type Matched = BTreeMap<usize, usize>;

/// The context for matching the fields of messages.
pub(super) struct Matching<'a, 'm> {
    pub(super) old: &'a Schema,
    pub(super) new: &'a Schema,
    /// Maps each matched old message to its new message.
    pub(super) twins: &'m HashMap<MessageId, MessageId>,
}

impl<'a> Matching<'a, '_> {
    /// Matches the fields of two messages.
    pub(super) fn fields(&self, old: MessageId, new: MessageId) -> Matched {
        let (old, new) = (self.old.message(old), self.new.message(new));
        let mut twin_of = same_names(old, new);
        let is_taken: BTreeSet<usize> = twin_of.values().copied().collect();
        let removed = gaps(&old.fields, |at| twin_of.contains_key(&at));
        let added = gaps(&new.fields, |at| is_taken.contains(&at));
        let mut budget = MAX_REORDERINGS;
        for (anchor, removed) in &removed {
            let Some(added) = added.get(anchor) else { continue };
            let field = |at: usize| &old.fields[removed[at]];
            let can_match = |left: usize, right: usize| {
                let (before, after) = (field(left), &new.fields[added[right]]);
                let (old_type, new_type) = (before.ty.written(), after.ty.written());
                // A field with a different unit is a different field, even if it has the same type.
                let is_other_unit =
                    before.unit.is_some() && after.unit.is_some() && before.unit != after.unit;
                old_type.shape == new_type.shape
                    && self.is_same((old, old_type.element), (new, new_type.element))
                    && !is_other_unit
            };
            let similarity =
                |left: usize, right: usize| likeness(&field(left).name, &new.fields[added[right]].name);
            let renamed = align(removed.len(), added.len(), &mut budget, can_match, similarity);
            twin_of.extend(renamed.into_iter().map(|(left, right)| (removed[left], added[right])));
        }
        twin_of
    }

    /// The old name of each new field. An added field keeps its own name, which no old field has.
    pub(super) fn old_names(&self, old: MessageId, new: MessageId, fields: &Matched) -> Vec<&'a str> {
        let (old, new) = (self.old.message(old), self.new.message(new));
        let mut names: Vec<&str> = new.fields.iter().map(|field| field.name.as_str()).collect();
        for (before, after) in fields {
            names[*after] = &old.fields[*before].name;
        }
        names
    }

    /// True if two types are the same.
    fn is_same(&self, (old, before): (&Message, Element), (new, after): (&Message, Element)) -> bool {
        match (before, after) {
            (Element::Message(before), Element::Message(after)) => self.twins.get(&before) == Some(&after),
            _ => before == after || plain(self.old, old, before) == plain(self.new, new, after),
        }
    }
}

/// The context for comparing messages.
pub(super) struct PairOf<'a, 'm> {
    pub(super) matching: Matching<'a, 'm>,
    pub(super) old_signatures: SchemaSignatures,
    pub(super) new_signatures: SchemaSignatures,
    pub(super) between: Between,
}

impl<'a> PairOf<'a, '_> {
    pub(super) fn pair(&self, old: MessageId, new: MessageId, fields: &Matched) -> Pair<'a> {
        let (old_schema, new_schema) = (self.matching.old, self.matching.new);
        let (before, after) = (old_schema.message(old), new_schema.message(new));
        let constants = constants(before, after);
        Pair {
            old_schema,
            new_schema,
            old: before,
            new: after,
            ids: (old, new),
            fields: self.changes(before, after, fields),
            renamed: renamed((before, after), fields, &constants),
            constants,
            between: self.between,
        }
    }

    fn changes(&self, old: &Message, new: &Message, twin_of: &Matched) -> Vec<FieldChange> {
        let positions: Vec<usize> = twin_of.values().copied().collect();
        let mut moved = order::moved(&positions).into_iter();
        let is_kept: BTreeSet<usize> = positions.into_iter().collect();
        let mut changes = Vec::new();
        for at in 0..old.fields.len() {
            changes.push(match twin_of.get(&at) {
                Some(twin) => {
                    FieldChange::Kept(self.kept(old, new, (at, *twin), moved.next().unwrap_or(false)))
                }
                None => FieldChange::Removed(at),
            });
        }
        let added = (0..new.fields.len()).filter(|at| !is_kept.contains(at));
        changes.extend(added.map(FieldChange::Added));
        changes
    }

    fn kept(&self, old: &Message, new: &Message, (before, after): (usize, usize), is_moved: bool) -> Kept {
        let elements = (old.fields[before].ty.written().element, new.fields[after].ty.written().element);
        let held = match elements {
            _ if !self.matching.is_same((old, elements.0), (new, elements.1)) => Held::Other,
            (Element::Message(old), Element::Message(new)) => {
                let cdr = self.old_signatures.cdr(old) != self.new_signatures.cdr(new);
                let uorb = self.old_signatures.uorb(old) != self.new_signatures.uorb(new);
                if cdr || uorb { Held::Changed { cdr, uorb } } else { Held::Same }
            }
            _ => Held::Same,
        };
        Kept { old: before, new: after, held, is_moved }
    }
}

/// Maps the index of each old field to the index of the new field with the same name.
fn same_names(old: &Message, new: &Message) -> Matched {
    let by_name: HashMap<&str, usize> =
        new.fields.iter().enumerate().map(|(at, field)| (field.name.as_str(), at)).collect();
    let names = old.fields.iter().enumerate();
    names.filter_map(|(at, field)| Some((at, *by_name.get(field.name.as_str())?))).collect()
}

/// The unmatched fields, grouped by the name of the matched field that precedes them.
fn gaps(fields: &[Field], is_known: impl Fn(usize) -> bool) -> BTreeMap<&str, Vec<usize>> {
    let mut gaps: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    let mut anchor = "";
    for (at, field) in fields.iter().enumerate() {
        if is_known(at) {
            anchor = &field.name;
        } else {
            gaps.entry(anchor).or_default().push(at);
        }
    }
    gaps
}

/// The new names of renamed fields and constants, by their old names.
fn renamed<'a>(
    (old, new): (&'a Message, &'a Message),
    fields: &Matched,
    constants: &[ConstantChange<'a>],
) -> HashMap<&'a str, &'a str> {
    let constants = constants.iter().filter_map(|change| match *change {
        ConstantChange::Renamed(old, new) => Some((old.name.as_str(), new.name.as_str())),
        _ => None,
    });
    let fields =
        fields.iter().map(|(at, twin)| (old.fields[*at].name.as_str(), new.fields[*twin].name.as_str()));
    // If a field and a constant have the same name, a reference means the field.
    constants.chain(fields.filter(|(old, new)| old != new)).collect()
}

fn constants<'a>(old: &'a Message, new: &'a Message) -> Vec<ConstantChange<'a>> {
    let plain = |constant: &&Constant| constant.name != VERSION && constant.name != QUEUE_LENGTH;
    let mut after: BTreeMap<&str, &Constant> =
        new.constants.iter().filter(plain).map(|constant| (constant.name.as_str(), constant)).collect();
    let mut changes = Vec::new();
    let mut removed = Vec::new();
    for before in old.constants.iter().filter(plain) {
        match after.remove(before.name.as_str()) {
            Some(after) => changes.push(ConstantChange::Same(before, after)),
            None => removed.push(before),
        }
    }
    // Constants are grouped by value to limit the number of comparisons.
    let mut added: BTreeMap<String, Vec<&Constant>> = BTreeMap::new();
    for constant in after.into_values() {
        added.entry(constant.value.to_string()).or_default().push(constant);
    }
    for before in removed {
        let candidates = added.get_mut(&before.value.to_string());
        let twin = candidates.and_then(|candidates| take_twin(before, candidates));
        changes.push(match twin {
            Some((after, true)) => ConstantChange::Renamed(before, after),
            Some((after, false)) => ConstantChange::Reused(before, after),
            None => ConstantChange::Removed(before),
        });
    }
    changes.extend(added.into_values().flatten().map(ConstantChange::Added));
    changes
}

/// Removes and returns the candidate that is most similar to `constant`. All `candidates` have the value of `constant`.
/// The returned flag is true if the candidate is the same constant under a different name. Candidates with a dissimilar
/// name and a different first word are ignored.
fn take_twin<'a>(constant: &Constant, candidates: &mut Vec<&'a Constant>) -> Option<(&'a Constant, bool)> {
    /// The maximum number of compared candidates; real enums have fewer aliases than this.
    const MAX_CANDIDATES: usize = 100;
    let similarity = |other: &Constant| {
        let shared = common_words(&constant.name, &other.name);
        let has_same_comment = !constant.description.is_empty() && constant.description == other.description;
        let letters = likeness(&constant.name[shared..], &other.name[shared..]);
        if has_same_comment { 1.0 } else { letters }
    };
    let scores =
        candidates.iter().take(MAX_CANDIDATES).enumerate().map(|(at, other)| (at, similarity(other)));
    let (at, score) = scores.max_by(|left, right| left.1.total_cmp(&right.1).then(right.0.cmp(&left.0)))?;
    let is_related = common_words(&constant.name, &candidates[at].name) > 0;
    (score >= ALIKE || is_related).then(|| (candidates.remove(at), score >= ALIKE))
}

/// The length of the common prefix of two names, up to the last complete word.
fn common_words(left: &str, right: &str) -> usize {
    let common = left.bytes().zip(right.bytes()).take_while(|(left, right)| left == right).count();
    left.as_bytes()[..common].iter().rposition(|byte| *byte == b'_').map_or(0, |at| at + 1)
}
