//! A tree of a message's values, which is simplified leaf by leaf.

use std::string::String;
use std::vec::Vec;

use super::number::Leaf;
use super::replay::Script;
use crate::ConstraintKind;

/// A field value or a message.
pub(super) struct Node {
    /// The rule that the value violates.
    pub(super) fault: Option<ConstraintKind>,
    pub(super) kind: Kind,
}

pub(super) enum Kind {
    Leaf(Leaf),
    /// The fields of a message, or the elements of an array.
    Group(Group),
    /// The elements of a sequence, or the characters of text or of a string.
    List(List),
}

/// A fixed number of parts.
pub(super) struct Group {
    parts: Vec<Node>,
    /// The part that is being simplified.
    at: usize,
}

/// Parts that can be removed, down to a minimum number.
pub(super) struct List {
    group: Group,
    kind: ListKind,
    min: usize,
    /// Number of parts to remove in one step. Halved in each round, down to 0.
    chunk_size: usize,
    /// Number of leading parts that have not been tried in this round.
    end: usize,
    /// The most recently removed parts, and their index.
    removed: Option<(usize, Vec<Node>)>,
}

/// The type of a list in a message.
#[derive(Clone, Copy)]
pub(super) enum ListKind {
    Sequence,
    String,
    /// Text in a field of `room` bytes. A `bad_byte` at the end makes the text invalid UTF-8.
    Text {
        room: usize,
        bad_byte: Option<u8>,
    },
}

impl From<Leaf> for Node {
    fn from(leaf: Leaf) -> Self {
        Self { fault: None, kind: Kind::Leaf(leaf) }
    }
}

impl Node {
    /// A message or an array. A fault in a part is also a fault of the node.
    pub(super) fn group(parts: Vec<Self>) -> Self {
        let fault = parts.iter().find_map(|part| part.fault);
        Self { fault, kind: Kind::Group(Group { parts, at: 0 }) }
    }

    /// A list. A fault in a part is also a fault of the node.
    pub(super) fn list(parts: Vec<Self>, kind: ListKind, min: usize) -> Self {
        let fault = parts.iter().find_map(|part| part.fault);
        let (chunk_size, end) = (parts.len(), parts.len());
        let list = List { group: Group { parts, at: 0 }, kind, min, chunk_size, end, removed: None };
        Self { fault, kind: Kind::List(list) }
    }

    /// Marks the node as violating `rule`.
    pub(super) fn violating(self, rule: ConstraintKind) -> Self {
        Self { fault: Some(rule), ..self }
    }

    /// The parts of the node.
    pub(super) fn parts(&self) -> &[Self] {
        match &self.kind {
            Kind::Leaf(_) => &[],
            Kind::Group(group) => &group.parts,
            Kind::List(list) => &list.group.parts,
        }
    }

    pub(super) fn write(&self, script: &mut Script) {
        match &self.kind {
            Kind::Leaf(leaf) => script.numbers.push(leaf.bits()),
            Kind::Group(group) => group.parts.iter().for_each(|part| part.write(script)),
            Kind::List(list) => list.write(script),
        }
    }

    pub(super) fn simplify(&mut self) -> bool {
        match &mut self.kind {
            Kind::Leaf(leaf) => leaf.simplify(),
            Kind::Group(group) => group.simplify(),
            Kind::List(list) => list.simplify(),
        }
    }

    pub(super) fn complicate(&mut self) -> bool {
        match &mut self.kind {
            Kind::Leaf(leaf) => leaf.complicate(),
            Kind::Group(group) => group.complicate(),
            Kind::List(list) => list.complicate(),
        }
    }
}

impl Group {
    fn simplify(&mut self) -> bool {
        while let Some(part) = self.parts.get_mut(self.at) {
            if part.simplify() {
                return true;
            }
            self.at += 1;
        }
        false
    }

    fn complicate(&mut self) -> bool {
        self.parts.get_mut(self.at).is_some_and(Node::complicate)
    }
}

impl List {
    fn write(&self, script: &mut Script) {
        let characters = || -> String {
            let leaf = |part: &Node| match &part.kind {
                Kind::Leaf(leaf) => Some(leaf.as_char()),
                Kind::Group(_) | Kind::List(_) => None,
            };
            self.group.parts.iter().filter_map(leaf).collect()
        };
        match self.kind {
            ListKind::Sequence => {
                script.numbers.push(self.group.parts.len() as u64);
                self.group.parts.iter().for_each(|part| part.write(script));
            }
            ListKind::String => script.strings.push(characters()),
            ListKind::Text { room, bad_byte } => {
                let end = script.numbers.len() + room;
                script.numbers.extend(characters().into_bytes().into_iter().chain(bad_byte).map(u64::from));
                script.numbers.resize(end, 0);
            }
        }
    }

    /// Tries to remove all parts at once, then half of them at a time, then a quarter, and so on. Then simplifies the
    /// remaining parts.
    fn simplify(&mut self) -> bool {
        self.removed = None;
        while self.chunk_size > 0 {
            if self.remove_chunk() {
                return true;
            }
        }
        self.group.simplify()
    }

    fn remove_chunk(&mut self) -> bool {
        let start = self.end.saturating_sub(self.chunk_size);
        let parts = &mut self.group.parts;
        let range = start..self.end;
        let is_needed = parts.len() - range.len() < self.min
            || parts[range.clone()].iter().any(|part| part.fault.is_some());
        self.end = start;
        if !range.is_empty() && !is_needed {
            self.removed = Some((start, parts.drain(range).collect()));
            return true;
        }
        if start == 0 {
            self.chunk_size /= 2;
            self.end = parts.len();
        }
        false
    }

    fn complicate(&mut self) -> bool {
        match self.removed.take() {
            Some((start, parts)) => {
                self.group.parts.splice(start..start, parts);
                true
            }
            None => self.group.complicate(),
        }
    }
}
