//! The `x-` annotations: what a definition says beyond what a validator checks.

use super::bounds;
use super::tree::{Member, Node, member};
use crate::schema::{Range, Stated};
use crate::unit;
use crate::value::Value;

/// An annotation, where there is something to say.
pub(super) fn annotation<'s>(name: &'static str, value: Option<impl Into<Node<'s>>>) -> Option<Member<'s>> {
    value.map(|value| member(name, value))
}

/// A text, unless it is empty.
pub(super) fn filled(text: &str) -> Option<&str> {
    Some(text).filter(|text| !text.is_empty())
}

/// A list, unless it is empty.
pub(super) fn list<'s>(nodes: impl IntoIterator<Item = Node<'s>>) -> Option<Node<'s>> {
    let nodes: Vec<Node<'s>> = nodes.into_iter().collect();
    (!nodes.is_empty()).then_some(Node::List(nodes))
}

/// An object of what there is, unless that is nothing.
pub(super) fn object<'s>(members: impl IntoIterator<Item = Option<Member<'s>>>) -> Option<Node<'s>> {
    let members: Vec<Member<'s>> = members.into_iter().flatten().collect();
    (!members.is_empty()).then_some(Node::Object(members))
}

/// The member of a schema that carries its annotations, if it has any.
pub(super) fn annotations<'s>(members: impl IntoIterator<Item = Option<Member<'s>>>) -> Option<Member<'s>> {
    object(members).map(|found| member("$defs", Node::Object(vec![member("annotations", found)])))
}

/// The unit, unless it is the word for none.
pub(super) fn unit(unit: Option<&str>) -> Option<&str> {
    unit.filter(|unit| *unit != unit::NONE)
}

/// Prefixes of an enum's constants, as its annotation lists them.
pub(super) fn prefixes(prefixes: &[String]) -> Option<String> {
    (!prefixes.is_empty()).then(|| prefixes.join(" "))
}

/// The values of a constraint; `instance` makes a single one, or the empty one.
pub(super) fn stated<'s>(
    stated: &'s Stated,
    instance: impl Fn(Option<&'s Value>) -> Option<Node<'s>>,
) -> Option<Node<'s>> {
    match stated {
        Stated::Range(bounds) => Some(range(bounds)),
        Stated::Value(value) => instance(Some(value)),
        Stated::Empty => instance(None),
    }
}

/// Both bounds as the definition states them; one that it leaves out is null.
pub(super) fn range<'s>(range: &Range) -> Node<'s> {
    [&range.low, &range.high]
        .into_iter()
        .map(|bound| bound.as_ref().map_or(Node::Null, bounds::number))
        .collect()
}
