//! A message of two sets: which field and which constant of one stands for which in the other.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::order;
use super::order::{MAX_COMPARISONS, align, likeness};
use super::signature::OfSet;
use crate::finding::Sides;
use crate::schema::{Constant, Dialect, Element, Field, Form, Kind, Message, MessageId, Schema, Type};
use crate::source::Span;

/// Between which states versions of messages are judged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Between {
    /// Between commits a changed message has a version that is one higher.
    #[default]
    Commits,
    /// Between releases it may be higher by more: the message may have changed several times.
    Releases,
}

/// Constants that PX4 knows by name, with rules of their own.
pub(super) const VERSION: &str = "MESSAGE_VERSION";
pub(super) const QUEUE_LENGTH: &str = "ORB_QUEUE_LENGTH";

/// From this on, two names are taken for one and the same thing.
const ALIKE: f64 = 0.5;

/// A message that is in both sets.
#[derive(Debug)]
pub(crate) struct Pair<'a> {
    /// The set that it was in.
    pub old_schema: &'a Schema,
    /// The set that it is in.
    pub new_schema: &'a Schema,
    /// As it was.
    pub old: &'a Message,
    /// As it is.
    pub new: &'a Message,
    /// Its fields.
    pub fields: Vec<FieldChange>,
    /// Its constants but those that PX4 knows by name.
    pub constants: Vec<ConstantChange<'a>>,
    /// Between which states versions are judged.
    pub between: Between,
}

/// A field of two sets, or of one, by index.
#[derive(Clone, Copy, Debug)]
pub(crate) enum FieldChange {
    /// In both.
    Kept(Kept),
    /// Only in the old set.
    Removed(usize),
    /// Only in the new set.
    Added(usize),
}

/// A field that is in both sets, under whatever name.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kept {
    /// Its index in the old message.
    pub old: usize,
    /// Its index in the new one.
    pub new: usize,
    /// What became of the type of its elements.
    pub held: Held,
    /// Whether it has to move so that the fields that are kept stand in the old order.
    pub is_moved: bool,
}

/// What became of that which a field holds, in whatever number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Held {
    /// It is the same.
    Same,
    /// It is the same message, but that has other bytes.
    Changed {
        /// In CDR.
        cdr: bool,
        /// In memory.
        uorb: bool,
    },
    /// It is another scalar, string or message.
    Other,
}

/// A constant of two sets, or of one.
#[derive(Clone, Copy, Debug)]
pub(crate) enum ConstantChange<'a> {
    /// Only in the old set.
    Removed(&'a Constant),
    /// Only in the new set.
    Added(&'a Constant),
    /// The same value under another name.
    Renamed(&'a Constant, &'a Constant),
    /// The same value for something else.
    Reused(&'a Constant, &'a Constant),
    /// Under the same name.
    Same(&'a Constant, &'a Constant),
}

impl<'a> Pair<'a> {
    /// The fields that are in both sets.
    pub(crate) fn kept(&self) -> impl Iterator<Item = &Kept> {
        self.fields.iter().filter_map(|change| match change {
            FieldChange::Kept(kept) => Some(kept),
            FieldChange::Removed(_) | FieldChange::Added(_) => None,
        })
    }

    /// The fields that are in both sets, as they were and as they are.
    pub(crate) fn fields(&self) -> impl Iterator<Item = (&'a Field, &'a Field)> {
        self.kept().map(|kept| (&self.old.fields[kept.old], &self.new.fields[kept.new]))
    }

    /// Whether anything changed that PX4 asks a new version for: names, types, lengths or order of fields.
    pub(crate) fn has_changed_fields(&self) -> bool {
        let is_changed = |change: &FieldChange| match change {
            FieldChange::Removed(_) | FieldChange::Added(_) => true,
            FieldChange::Kept(kept) => {
                let (old, new) = (&self.old.fields[kept.old], &self.new.fields[kept.new]);
                old.name != new.name
                    || kept.held == Held::Other
                    || old.ty.shape != new.ty.shape
                    || old.default != new.default
                    || kept.is_moved
            }
        };
        self.fields.iter().any(is_changed)
    }

    /// Its name, as it is now.
    pub(crate) fn name(&self) -> &'a str {
        &self.new.name
    }

    /// The place of the message in the new set.
    pub(crate) fn head(&self) -> Span {
        self.new.span.part(0..0)
    }

    /// Whether it is a message of PX4's uORB.
    pub(crate) fn is_uorb(&self) -> bool {
        let form = self.new_schema.package_of(self.new).form;
        form == Form::Msg(Dialect::Px4) && self.new.kind == Kind::Message
    }

    /// What a field's type was, as a definition writes it.
    pub(crate) fn old_type(&self, ty: Type) -> String {
        self.old_schema.type_text(self.old, ty)
    }

    /// What a field's type is.
    pub(crate) fn new_type(&self, ty: Type) -> String {
        self.new_schema.type_text(self.new, ty)
    }
}

/// Both places.
pub(super) fn both(old: Span, new: Span) -> Sides {
    Sides { old: Some(old), new: Some(new) }
}

/// What pairs are made from.
pub(super) struct PairOf<'a, 'm> {
    pub(super) old: &'a Schema,
    pub(super) new: &'a Schema,
    /// Which message of the new set stands for one of the old.
    pub(super) twins: &'m HashMap<MessageId, MessageId>,
    pub(super) old_signatures: OfSet,
    pub(super) new_signatures: OfSet,
    pub(super) between: Between,
}

impl<'a> PairOf<'a, '_> {
    pub(super) fn pair(&self, old: MessageId, new: MessageId) -> Pair<'a> {
        let (before, after) = (self.old.message(old), self.new.message(new));
        Pair {
            old_schema: self.old,
            new_schema: self.new,
            old: before,
            new: after,
            fields: self.fields(before, after),
            constants: constants(before, after),
            between: self.between,
        }
    }

    fn fields(&self, old: &Message, new: &Message) -> Vec<FieldChange> {
        let mut twin_of = same_names(old, new);
        let is_taken: BTreeSet<usize> = twin_of.values().copied().collect();
        let gone = gaps(&old.fields, |at| twin_of.contains_key(&at));
        let come = gaps(&new.fields, |at| is_taken.contains(&at));
        let mut budget = MAX_COMPARISONS;
        for (anchor, gone) in &gone {
            let Some(come) = come.get(anchor) else { continue };
            let field = |at: usize| &old.fields[gone[at]];
            let can_match = |left: usize, right: usize| {
                let (before, after) = (field(left), &new.fields[come[right]]);
                // What is measured in another unit is another thing, though it may be as wide.
                let is_other_unit =
                    before.unit.is_some() && after.unit.is_some() && before.unit != after.unit;
                before.ty.shape == after.ty.shape
                    && self.is_same(before.ty.element, after.ty.element)
                    && !is_other_unit
            };
            let alike =
                |left: usize, right: usize| likeness(&field(left).name, &new.fields[come[right]].name);
            let renamed = align(gone.len(), come.len(), &mut budget, can_match, alike);
            twin_of.extend(renamed.into_iter().map(|(left, right)| (gone[left], come[right])));
        }
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
        let elements = (old.fields[before].ty.element, new.fields[after].ty.element);
        let held = match elements {
            (old, new) if !self.is_same(old, new) => Held::Other,
            (Element::Message(old), Element::Message(new)) => {
                let cdr = self.old_signatures.cdr(old) != self.new_signatures.cdr(new);
                let uorb = self.old_signatures.uorb(old) != self.new_signatures.uorb(new);
                if cdr || uorb { Held::Changed { cdr, uorb } } else { Held::Same }
            }
            _ => Held::Same,
        };
        Kept { old: before, new: after, held, is_moved }
    }

    fn is_same(&self, old: Element, new: Element) -> bool {
        match (old, new) {
            (Element::Message(old), Element::Message(new)) => self.twins.get(&old) == Some(&new),
            _ => old == new,
        }
    }
}

/// For each field of the old message that of the new one that is called the same.
fn same_names(old: &Message, new: &Message) -> BTreeMap<usize, usize> {
    let by_name: HashMap<&str, usize> =
        new.fields.iter().enumerate().map(|(at, field)| (field.name.as_str(), at)).collect();
    let names = old.fields.iter().enumerate();
    names.filter_map(|(at, field)| Some((at, *by_name.get(field.name.as_str())?))).collect()
}

/// The fields that aren't known, by the name of the known field before them.
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

fn constants<'a>(old: &'a Message, new: &'a Message) -> Vec<ConstantChange<'a>> {
    let plain = |constant: &&Constant| constant.name != VERSION && constant.name != QUEUE_LENGTH;
    let mut after: BTreeMap<&str, &Constant> =
        new.constants.iter().filter(plain).map(|constant| (constant.name.as_str(), constant)).collect();
    let mut changes = Vec::new();
    let mut gone = Vec::new();
    for before in old.constants.iter().filter(plain) {
        match after.remove(before.name.as_str()) {
            Some(after) => changes.push(ConstantChange::Same(before, after)),
            None => gone.push(before),
        }
    }
    // By value, so that each is compared with few.
    let mut come: BTreeMap<String, Vec<&Constant>> = BTreeMap::new();
    for constant in after.into_values() {
        come.entry(constant.value.to_string()).or_default().push(constant);
    }
    for before in gone {
        let candidates = come.get_mut(&before.value.to_string());
        let twin = candidates.and_then(|candidates| take_twin(before, candidates));
        changes.push(match twin {
            Some((after, true)) => ConstantChange::Renamed(before, after),
            Some((after, false)) => ConstantChange::Reused(before, after),
            None => ConstantChange::Removed(before),
        });
    }
    changes.extend(come.into_values().flatten().map(ConstantChange::Added));
    changes
}

/// The most alike of `candidates`, which have the same value, and whether it is the same under another name.
/// One whose name shares nothing, not even its first word, is neither.
fn take_twin<'a>(constant: &Constant, candidates: &mut Vec<&'a Constant>) -> Option<(&'a Constant, bool)> {
    /// More are not compared: enums don't have so many aliases.
    const MAX_CANDIDATES: usize = 100;
    let alike = |other: &Constant| {
        let shared = common_words(&constant.name, &other.name);
        let says_same = !constant.description.is_empty() && constant.description == other.description;
        let letters = likeness(&constant.name[shared..], &other.name[shared..]);
        if says_same { 1.0 } else { letters }
    };
    let scores = candidates.iter().take(MAX_CANDIDATES).enumerate().map(|(at, other)| (at, alike(other)));
    let (at, score) = scores.max_by(|left, right| left.1.total_cmp(&right.1).then(right.0.cmp(&left.0)))?;
    let is_of_one_family = common_words(&constant.name, &candidates[at].name) > 0;
    (score >= ALIKE || is_of_one_family).then(|| (candidates.remove(at), score >= ALIKE))
}

/// Length of the words, up to a `_`, that two names start with.
fn common_words(left: &str, right: &str) -> usize {
    let common = left.bytes().zip(right.bytes()).take_while(|(left, right)| left == right).count();
    left.as_bytes()[..common].iter().rposition(|byte| *byte == b'_').map_or(0, |at| at + 1)
}
