//! Ordered JSON with unresolved references.
//!
//! Each definition is printed twice: to its file, and to the bundle of its package. References differ between these two
//! documents, so the printer resolves them.

use std::borrow::Cow;
use std::fmt::Write as _;

use uavspec_schema::characters::is_hidden;

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
pub(super) fn print<'m, 's: 'm>(
    members: impl Iterator<Item = &'m Member<'s>>,
    address: &dyn Fn(Target) -> String,
) -> String {
    let mut printer = Printer { text: String::with_capacity(4 << 10), depth: 0, address };
    printer.object(members);
    printer.text.push('\n');
    printer.text
}

struct Printer<'a> {
    text: String,
    depth: usize,
    address: &'a dyn Fn(Target) -> String,
}

impl Printer<'_> {
    fn node(&mut self, node: &Node<'_>) {
        match node {
            Node::Null => self.text.push_str("null"),
            Node::Bool(value) => self.text.push_str(if *value { "true" } else { "false" }),
            Node::Integer(value) => self.display(value),
            Node::Float(value) => match serde_json::Number::from_f64(*value) {
                Some(number) => self.display(&number),
                None => self.text.push_str("null"),
            },
            Node::Text(text) => self.string(text),
            Node::List(nodes) => self.list(nodes),
            Node::Object(members) => self.object(members.iter()),
            Node::Shared(members) => self.object(members.iter()),
            Node::Reference(target) => {
                let address = (self.address)(*target);
                self.string(&address);
            }
        }
    }

    fn display(&mut self, value: &dyn std::fmt::Display) {
        // Writing to a string never fails.
        let _ = write!(self.text, "{value}");
    }

    fn list(&mut self, nodes: &[Node<'_>]) {
        self.text.push('[');
        self.depth += 1;
        for (index, node) in nodes.iter().enumerate() {
            self.line(index == 0);
            self.node(node);
        }
        self.close(nodes.is_empty(), ']');
    }

    fn object<'m, 's: 'm>(&mut self, members: impl Iterator<Item = &'m Member<'s>>) {
        let mut is_empty = true;
        self.text.push('{');
        self.depth += 1;
        for (name, value) in members {
            self.line(is_empty);
            is_empty = false;
            self.string(name);
            self.text.push_str(": ");
            self.node(value);
        }
        self.close(is_empty, '}');
    }

    fn close(&mut self, is_empty: bool, bracket: char) {
        self.depth -= 1;
        if !is_empty {
            self.line(true);
        }
        self.text.push(bracket);
    }

    /// Starts a line, preceded by a comma unless it is the first in its list.
    fn line(&mut self, is_first: bool) {
        self.text.push_str(if is_first { "\n" } else { ",\n" });
        for _ in 0..self.depth {
            self.text.push_str("  ");
        }
    }

    fn string(&mut self, text: &str) {
        self.text.push('"');
        let mut rest = text;
        while let Some(at) = rest.find(needs_escape) {
            let (plain, tail) = rest.split_at(at);
            self.text.push_str(plain);
            let mut characters = tail.chars();
            if let Some(character) = characters.next() {
                self.escape(character);
            }
            rest = characters.as_str();
        }
        self.text.push_str(rest);
        self.text.push('"');
    }

    fn escape(&mut self, character: char) {
        match character {
            '"' => self.text.push_str("\\\""),
            '\\' => self.text.push_str("\\\\"),
            '\n' => self.text.push_str("\\n"),
            '\t' => self.text.push_str("\\t"),
            other => {
                for unit in other.encode_utf16(&mut [0; 2]) {
                    let _ = write!(self.text, "\\u{unit:04x}");
                }
            }
        }
    }
}

/// True for characters that must be escaped in JSON, and for characters that would distort the display.
fn needs_escape(character: char) -> bool {
    matches!(character, '"' | '\\' | '\u{200c}' | '\u{200d}') || is_hidden(character)
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
        let members = [
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
        let printed = print(members.iter(), &|_| String::new());
        let read: serde_json::Value = serde_json::from_str(&printed).expect("JSON");
        assert_eq!(read["text"], text);
        let again = serde_json::to_string_pretty(&read).expect("JSON") + "\n";
        assert_eq!(printed.replace("\\u000d", "\\r").replace("\\u007f", "\u{7f}"), again);
    }

    #[test]
    fn escapes_direction_marks_without_loss() {
        let members = [member("a", "x\u{202e}y\u{feff}")];
        let printed = print(members.iter(), &|_| String::new());
        assert!(printed.is_ascii(), "{printed}");
        let read: serde_json::Value = serde_json::from_str(&printed).expect("JSON");
        assert_eq!(read["a"], "x\u{202e}y\u{feff}");
    }
}
