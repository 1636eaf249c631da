//! Hints, and the decisions that follow from them.

use std::collections::BTreeMap;

use uavspec_schema::span::Span;

use crate::conversion::expression::Node;
use crate::conversion::plan::Narrowing;

/// The hints in a file.
#[derive(Clone, Debug, Default)]
pub struct Hints {
    /// The hints about messages.
    pub(in crate::conversion) of_messages: Vec<Hint>,
    /// Old and new names of packages.
    pub(in crate::conversion) packages: Vec<[Key; 2]>,
    /// Mistakes in the file, in line order.
    pub mistakes: Vec<Mistake>,
}

impl Hints {
    /// Adds hints, which take precedence over the existing ones.
    #[must_use]
    pub fn with(mut self, other: Self) -> Self {
        self.of_messages.extend(other.of_messages);
        self.packages.extend(other.packages);
        self.mistakes.extend(other.mistakes);
        self
    }

    /// True if a hint says that a message has another name in the other package. The hint may have either order.
    pub fn renames(&self, one: &str, other: &str) -> bool {
        let is_pair = |hint: &Hint| {
            let [old, new] = &hint.messages;
            (old.text == one && new.text == other) || (old.text == other && new.text == one)
        };
        self.of_messages.iter().any(is_pair)
    }

    /// The names that a package may have in the other version, the most likely first: its new name, the same name, or its old
    /// name.
    pub fn counterparts<'n>(&'n self, package: &'n str) -> impl Iterator<Item = &'n str> {
        let names = |from: usize, to: usize| {
            let pairs = self.packages.iter().filter(move |pair| pair[from].text == package);
            pairs.map(move |pair| pair[to].text.as_str())
        };
        names(0, 1).chain([package]).chain(names(1, 0))
    }
}

/// A mistake in a file with hints.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake {
    /// The location.
    pub span: Span,
    /// The problem.
    pub message: String,
    /// The advice.
    pub help: String,
}

/// A hint about one message.
#[derive(Clone, Debug, Default)]
pub(in crate::conversion) struct Hint {
    /// The old and the new message, which are equal unless the versions use different messages for
    /// a topic.
    pub(in crate::conversion) messages: [Key; 2],
    /// The topic that both messages must have.
    pub(in crate::conversion) topic: Option<Key>,
    /// The highest old version and the lowest new version.
    pub(in crate::conversion) versions: Option<[u32; 2]>,
    /// Old and new names of fields.
    pub(in crate::conversion) rename: Vec<[Key; 2]>,
    /// Values of the fields of the old and of the new message.
    pub(in crate::conversion) values: [Vec<(Key, HintValue)>; 2],
    /// Policies for fields whose type narrows.
    pub(in crate::conversion) narrow: Vec<(Key, Narrowing)>,
    /// Fields and constants that mean the same on both sides.
    pub(in crate::conversion) same: Vec<Key>,
}

/// A name with its location.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(in crate::conversion) struct Key {
    pub(in crate::conversion) text: String,
    pub(in crate::conversion) span: Span,
}

/// The value of a field.
#[derive(Clone, Debug)]
pub(in crate::conversion) enum HintValue {
    /// A default, or a computed value.
    Expression(Node),
    /// Pairs of a constant of the source and a constant of the target.
    Constants(Vec<[Key; 2]>),
}

/// The decisions of all hints that apply to a conversion in one direction, by field of the target.
#[derive(Debug, Default)]
pub(in crate::conversion) struct Decisions<'h> {
    pub(in crate::conversion) values: BTreeMap<&'h str, (&'h Key, &'h HintValue)>,
    /// Maps each renamed target field to the name of its source field.
    pub(in crate::conversion) renamed: BTreeMap<&'h str, &'h str>,
    pub(in crate::conversion) narrow: BTreeMap<&'h str, Narrowing>,
    /// Names that mean the same, and constants that occur in expressions or maps.
    pub(in crate::conversion) same: Vec<&'h str>,
    pub(in crate::conversion) mentioned: Vec<&'h str>,
}

impl<'h> Decisions<'h> {
    /// True if no hint decides anything.
    pub(in crate::conversion) fn is_empty(&self) -> bool {
        self.values.is_empty() && self.renamed.is_empty() && self.narrow.is_empty() && self.same.is_empty()
    }

    /// Adds the decisions of a hint.
    pub(in crate::conversion) fn add(&mut self, hint: &'h Hint, is_forward: bool) {
        let target = usize::from(is_forward);
        for (key, value) in &hint.values[target] {
            self.values.insert(&key.text, (key, value));
        }
        for value in hint.values.iter().flatten().map(|(_, value)| value) {
            match value {
                HintValue::Expression(node) => node.names(&mut |name| self.mentioned.push(&name.text)),
                HintValue::Constants(pairs) => {
                    self.mentioned.extend(pairs.iter().flatten().map(|key| key.text.as_str()));
                }
            }
        }
        for names in &hint.rename {
            self.renamed.insert(&names[target].text, &names[1 - target].text);
        }
        self.narrow.extend(hint.narrow.iter().map(|(key, policy)| (key.text.as_str(), *policy)));
        self.same.extend(hint.same.iter().map(|key| key.text.as_str()));
    }
}
