//! The `x-` annotations: parts of a definition that validators don't check.

use uavspec_schema::value::Value;
use uavspec_schema::{Range, Stated, unit};

use super::bounds;
use super::tree::{Member, Node, member};

/// An annotation, or `None` if it has no value.
pub(super) fn annotation<'s>(name: &'static str, value: Option<impl Into<Node<'s>>>) -> Option<Member<'s>> {
    value.map(|value| member(name, value))
}

/// The text, or `None` if it is empty.
pub(super) fn filled(text: &str) -> Option<&str> {
    Some(text).filter(|text| !text.is_empty())
}

/// A list, or `None` if it is empty.
pub(super) fn list<'s>(nodes: impl IntoIterator<Item = Node<'s>>) -> Option<Node<'s>> {
    let nodes: Vec<Node<'s>> = nodes.into_iter().collect();
    (!nodes.is_empty()).then_some(Node::List(nodes))
}

/// An object with the present members, or `None` if no member is present.
pub(super) fn object<'s>(members: impl IntoIterator<Item = Option<Member<'s>>>) -> Option<Node<'s>> {
    let members: Vec<Member<'s>> = members.into_iter().flatten().collect();
    (!members.is_empty()).then_some(Node::Object(members))
}

/// The `$defs` member with the annotations, or `None` if there are no annotations.
pub(super) fn annotations<'s>(members: impl IntoIterator<Item = Option<Member<'s>>>) -> Option<Member<'s>> {
    object(members).map(|found| member("$defs", Node::Object(vec![member("annotations", found)])))
}

/// The unit, or `None` if the symbol means "no unit".
pub(super) fn unit(unit: Option<&str>) -> Option<&str> {
    unit.filter(|unit| *unit != unit::NONE)
}

/// The prefixes of an enum, in the notation of the `@enum` annotation.
pub(super) fn prefixes(prefixes: &[String]) -> Option<String> {
    (!prefixes.is_empty()).then(|| prefixes.join(" "))
}

/// The values of a constraint. `instance` converts a single value; its argument is `None` if the constraint states the
/// empty value.
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

/// Both bounds as declared. A missing bound is null.
pub(super) fn range<'s>(range: &Range) -> Node<'s> {
    [&range.low, &range.high]
        .into_iter()
        .map(|bound| bound.as_ref().map_or(Node::Null, bounds::number))
        .collect()
}
