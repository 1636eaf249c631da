//! Ordered JSON with unresolved references.
//!
//! Each definition is printed twice: to its file, and to the bundle of its package. References differ between these two
//! documents, so the printer resolves them.

use std::borrow::Cow;

use serde::{Serialize, Serializer};
use uavspec_schema::json_text;

use super::address::Target;

/// A member of an object.
pub(super) type Member<'s> = (Cow<'s, str>, Node<'s>);

/// A JSON value.
#[derive(Clone, Debug)]
pub(super) enum Node<'s> {
    Null,
    Bool(bool),
    Integer(i128),
    /// A finite number.
    Float(f64),
    Text(Cow<'s, str>),
    List(Vec<Node<'s>>),
    Object(Vec<Member<'s>>),
    /// Members shared by several trees.
    Shared(&'s [Member<'s>]),
    /// A reference to a definition. The URL depends on the document in which it is printed.
    Reference(Target),
}

impl<'s> From<&'s str> for Node<'s> {
    fn from(text: &'s str) -> Self {
        Self::Text(Cow::Borrowed(text))
    }
}

impl From<String> for Node<'_> {
    fn from(text: String) -> Self {
        Self::Text(Cow::Owned(text))
    }
}

impl From<bool> for Node<'_> {
    fn from(value: bool) -> Self {
        Self::Bool(value)
    }
}

impl From<u32> for Node<'_> {
    fn from(value: u32) -> Self {
        Self::Integer(value.into())
    }
}

impl<'s> FromIterator<Node<'s>> for Node<'s> {
    fn from_iter<I: IntoIterator<Item = Node<'s>>>(nodes: I) -> Self {
        Self::List(nodes.into_iter().collect())
    }
}

/// Creates a member with a fixed name.
pub(super) fn member<'s>(name: &'static str, value: impl Into<Node<'s>>) -> Member<'s> {
    (Cow::Borrowed(name), value.into())
}

/// Prints `members` as one object, indented by two spaces per level, with a final line end.
pub(super) fn print(members: Vec<Member<'_>>, address: &dyn Fn(Target) -> String) -> String {
    json_text::pretty(&Printed { node: &Node::Object(members), address })
}

/// A value with the URLs of one document.
struct Printed<'p, 's> {
    node: &'p Node<'s>,
    address: &'p dyn Fn(Target) -> String,
}

impl<'p, 's> Serialize for Printed<'p, 's> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { node, address } = *self;
        let printed = |node| Printed { node, address };
        let object = |serializer: S, members: &'p [Member<'s>]| {
            serializer.collect_map(members.iter().map(|(name, value)| (name, printed(value))))
        };
        match node {
            Node::Null => serializer.serialize_unit(),
            Node::Bool(value) => serializer.serialize_bool(*value),
            Node::Integer(value) => serializer.serialize_i128(*value),
            Node::Float(value) => serializer.serialize_f64(*value),
            Node::Text(text) => serializer.serialize_str(text),
            Node::List(nodes) => serializer.collect_seq(nodes.iter().map(printed)),
            Node::Object(members) => object(serializer, members),
            Node::Shared(members) => object(serializer, members),
            Node::Reference(target) => serializer.serialize_str(&address(*target)),
        }
    }
}

/// An alternative that accepts any value of a type: the last alternative of an open set.
pub(super) fn any_of_type<'s>(ty: impl Into<Node<'s>>) -> Node<'s> {
    Node::Object(vec![member("type", ty)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prints_like_serde_json() {
        let text = "plain \"quoted\" back\\slash\nnew\tline\r \u{1}\u{7f} é µ \u{1f681}";
        let members = vec![
            member("text", text),
            member(
                "list",
                Node::List(vec![Node::Null, true.into(), Node::Integer(u64::MAX.into()), Node::Float(-1.5)]),
            ),
            member("empty list", Node::List(Vec::new())),
            member("empty object", Node::Object(Vec::new())),
            member(
                "nested",
                Node::Object(vec![member("a", Node::Float(3.402_823_5e38)), member("b", 7_u32)]),
            ),
        ];
        let printed = print(members, &|_| String::new());
        let read: serde_json::Value = serde_json::from_str(&printed).expect("JSON");
        assert_eq!(read["text"], text);
        let again = serde_json::to_string_pretty(&read).expect("JSON") + "\n";
        assert_eq!(printed.replace("\\u007f", "\u{7f}"), again);
    }

    #[test]
    fn escapes_direction_marks_without_loss() {
        let members = vec![member("a", "x\u{202e}y\u{feff}")];
        let printed = print(members, &|_| String::new());
        assert!(printed.is_ascii(), "{printed}");
        let read: serde_json::Value = serde_json::from_str(&printed).expect("JSON");
        assert_eq!(read["a"], "x\u{202e}y\u{feff}");
    }
}
