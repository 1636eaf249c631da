//! Excerpts of JSON texts that show one field.

use std::fmt::Write as _;

use super::Tree;

/// The members that are shown next to the field, because they identify a message.
const IDENTIFYING: [&str; 4] = ["type", "id", "refs", "body"];

/// The maximum depth at which identifying members are shown. They appear in a message and in its body.
const MAX_DEPTH: usize = 2;

impl Tree<'_> {
    /// The text, reduced to the field at a JSON pointer and to the members that identify a message. Other members are
    /// replaced by `…`. If there is no such field, the text ends at the last existing part of the pointer.
    pub fn excerpt_at(&self, pointer: &str) -> String {
        let keys: Vec<String> =
            pointer.split('/').skip(1).map(|key| key.replace("~1", "/").replace("~0", "~")).collect();
        let mut text = String::new();
        write(self, Some(&keys), 0, &mut text);
        text
    }
}

/// Writes a value. `keys` is the remaining path to the field, or `None` if the value isn't on this path.
fn write(value: &Tree<'_>, keys: Option<&[String]>, depth: usize, text: &mut String) {
    let next = keys.and_then(<[String]>::split_first);
    if keys.is_some_and(<[String]>::is_empty) && depth > 0 {
        return text.push_str(&value.excerpt());
    }
    match (value, next) {
        (Tree::Object(members), _) if next.is_some() || depth < MAX_DEPTH => {
            let shown = members.iter().map(|(key, value)| {
                let rest = next.filter(|(first, _)| *first == key.as_ref()).map(|(_, rest)| rest);
                let is_shown = rest.is_some() || depth < MAX_DEPTH && IDENTIFYING.contains(&key.as_ref());
                is_shown.then_some((Some(key.as_ref()), value, rest))
            });
            enclosed(['{', '}'], shown, depth, text);
        }
        (Tree::List(values), Some((first, rest))) => {
            let at = first.parse().ok();
            let shown = values
                .iter()
                .enumerate()
                .map(|(index, value)| (Some(index) == at).then_some((None, value, Some(rest))));
            enclosed(['[', ']'], shown, depth, text);
        }
        (Tree::Object(_), _) => text.push_str("{…}"),
        (Tree::List(_), _) => text.push_str("[…]"),
        _ => text.push_str(&value.excerpt()),
    }
}

/// A member or element to write: its key, its value, and the rest of the path if the path continues here.
type Shown<'s, 't> = (Option<&'s str>, &'s Tree<'t>, Option<&'s [String]>);

/// Writes members or elements in brackets. Consecutive hidden ones become one `…`.
fn enclosed<'s, 't: 's>(
    [open, close]: [char; 2],
    items: impl Iterator<Item = Option<Shown<'s, 't>>>,
    depth: usize,
    text: &mut String,
) {
    text.push(open);
    let (mut is_first, mut is_omitting) = (true, false);
    for item in items {
        if item.is_none() && is_omitting {
            continue;
        }
        is_omitting = item.is_none();
        text.push_str(if std::mem::replace(&mut is_first, false) { "" } else { ", " });
        let Some((key, value, rest)) = item else {
            text.push('…');
            continue;
        };
        if let Some(key) = key {
            // Writing to a string can't fail.
            let _ = write!(text, "{:?}: ", super::shortened(key));
        }
        write(value, rest, depth + 1, text);
    }
    text.push(close);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shows_the_field_and_what_identifies_the_message() {
        let text = r#"{"$fw.version":"1.0","id":"s1","refs":"c1","body":{"type":"UAV-INF","time":1,"gone":2,
            "status":{"kite":{"id":"kite","position":[1,2,3,4],"heading":-5},"swift":{}}}}"#;
        let tree = Tree::read(text).expect("JSON");
        let start = r#"{…, "id": "s1", "refs": "c1", "body": {"type": "UAV-INF", …, "#;
        for (pointer, expected) in [
            ("/body/status/kite/heading", r#""status": {"kite": {…, "heading": -5}, …}}}"#),
            ("/body/status/kite/position/3", r#""status": {"kite": {…, "position": […, 4], …}, …}}}"#),
            ("/body/status/none", r#""status": {…}}}"#),
        ] {
            assert_eq!(tree.excerpt_at(pointer), format!("{start}{expected}"));
        }
        let whole = r#"{…, "id": "s1", "refs": "c1", "body": {"type": "UAV-INF", …}}"#;
        assert_eq!(tree.excerpt_at("/error"), whole);
        assert_eq!(tree.excerpt_at(""), whole);
    }

    #[test]
    fn reads_escaped_keys() {
        let tree = Tree::read(r#"{"a/b":{"c~d":1,"e":2}}"#).expect("JSON");
        assert_eq!(tree.excerpt_at("/a~1b/c~0d"), r#"{"a/b": {"c~d": 1, …}}"#);
    }
}
