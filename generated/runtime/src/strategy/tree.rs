//! The values of a message as a tree, and how it is simplified leaf by leaf.

use std::string::String;
use std::vec::Vec;

use super::number::Leaf;
use super::replay::Script;
use crate::Rule;

/// A value of a field, or a message.
pub(super) struct Node {
    /// The rule that is broken in it.
    pub(super) fault: Option<Rule>,
    pub(super) kind: Kind,
}

pub(super) enum Kind {
    Leaf(Leaf),
    /// The fields of a message, or the elements of an array.
    Group(Group),
    /// The elements of a sequence, or the characters of text or of a string.
    List(List),
}

/// Parts of which none can be left out.
pub(super) struct Group {
    parts: Vec<Node>,
    /// The part that is being simplified.
    at: usize,
}

/// Parts that can be left out down to a least number.
pub(super) struct List {
    group: Group,
    form: Form,
    least: usize,
    /// How many parts are tried to be left out at a time; fewer with each round, at last 0.
    share: usize,
    /// Parts from here on have been tried in this round.
    end: usize,
    /// What was left out last, and where.
    left_out: Option<(usize, Vec<Node>)>,
}

/// What a list becomes in a message.
#[derive(Clone, Copy)]
pub(super) enum Form {
    Sequence,
    String,
    /// Text in as many bytes, perhaps followed by a byte that makes it no UTF-8.
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
    /// A message or an array; broken where a part is.
    pub(super) fn group(parts: Vec<Self>) -> Self {
        let fault = parts.iter().find_map(|part| part.fault);
        Self { fault, kind: Kind::Group(Group { parts, at: 0 }) }
    }

    /// A list; broken where a part is.
    pub(super) fn list(parts: Vec<Self>, form: Form, least: usize) -> Self {
        let fault = parts.iter().find_map(|part| part.fault);
        let (share, end) = (parts.len(), parts.len());
        let list = List { group: Group { parts, at: 0 }, form, least, share, end, left_out: None };
        Self { fault, kind: Kind::List(list) }
    }

    /// The same, as a value that breaks `rule`.
    pub(super) fn breaking(self, rule: Rule) -> Self {
        Self { fault: Some(rule), ..self }
    }

    /// What it consists of.
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
        match self.form {
            Form::Sequence => {
                script.numbers.push(self.group.parts.len() as u64);
                self.group.parts.iter().for_each(|part| part.write(script));
            }
            Form::String => script.strings.push(characters()),
            Form::Text { room, bad_byte } => {
                let end = script.numbers.len() + room;
                script.numbers.extend(characters().into_bytes().into_iter().chain(bad_byte).map(u64::from));
                script.numbers.resize(end, 0);
            }
        }
    }

    /// Leaves out all parts, then halves, quarters and so on, then simplifies those that are left.
    fn simplify(&mut self) -> bool {
        self.left_out = None;
        while self.share > 0 {
            if self.leave_out() {
                return true;
            }
        }
        self.group.simplify()
    }

    fn leave_out(&mut self) -> bool {
        let start = self.end.saturating_sub(self.share);
        let parts = &mut self.group.parts;
        let range = start..self.end;
        let is_needed = parts.len() - range.len() < self.least
            || parts[range.clone()].iter().any(|part| part.fault.is_some());
        self.end = start;
        if !range.is_empty() && !is_needed {
            self.left_out = Some((start, parts.drain(range).collect()));
            return true;
        }
        if start == 0 {
            self.share /= 2;
            self.end = parts.len();
        }
        false
    }

    fn complicate(&mut self) -> bool {
        match self.left_out.take() {
            Some((start, parts)) => {
                self.group.parts.splice(start..start, parts);
                true
            }
            None => self.group.complicate(),
        }
    }
}
