//! Requests that a recording stores in pieces.
//!
//! A stream doesn't preserve message boundaries, and some programs record each write or segment as one `raw` text. Such
//! a text may contain a part of a message, or several messages. The request ids are known only after the pieces are
//! joined.

use std::collections::BTreeMap;

use uavspec_model::json::{SyntaxError, TRUNCATED, Tree};
use uavspec_rules::limits::{MAX_CONNECTIONS, MAX_INCOMPLETE};

use crate::limits::{MAX_MESSAGES, MAX_PIECES};

/// The incomplete texts and their numbers of pieces, by connection index.
#[derive(Debug, Default)]
pub(super) struct Pieces(BTreeMap<usize, (String, usize)>);

impl Pieces {
    /// Adds a piece. Returns the texts that are now complete: messages, and texts that no later piece can turn into a
    /// message.
    pub(super) fn add(&mut self, connection: usize, piece: &str) -> Vec<String> {
        let mut done = Vec::new();
        let (mut text, pieces) = self.0.remove(&connection).unwrap_or_default();
        // A whole message never continues another message.
        if is_object(piece) {
            done.extend(unless_blank(&text));
            text.clear();
        }
        text.push_str(piece);
        let incomplete = take_lines(&text, &mut done);
        if incomplete.is_empty() {
            return done;
        }
        let is_too_long = incomplete.len() > MAX_INCOMPLETE || pieces >= MAX_PIECES;
        if is_too_long || self.0.len() >= MAX_CONNECTIONS {
            done.push(incomplete.to_owned());
        } else {
            self.0.insert(connection, (incomplete.to_owned(), pieces + 1));
        }
        done
    }

    /// Removes and returns the incomplete text of a connection, when no other piece can follow.
    pub(super) fn end(&mut self, connection: usize) -> Option<String> {
        self.0.remove(&connection).map(|(text, _)| text)
    }

    /// True if a connection has an incomplete text.
    pub(super) fn is_incomplete(&self, connection: usize) -> bool {
        self.0.contains_key(&connection)
    }
}

/// Moves all complete texts to `done`. Returns the incomplete text at the end, which may be empty.
fn take_lines<'t>(text: &'t str, done: &mut Vec<String>) -> &'t str {
    let (lines, last) = text.rsplit_once('\n').unwrap_or(("", text));
    for line in lines.lines() {
        let (messages, rest) = messages(line);
        take_line(line, messages, rest, done);
    }
    let (messages, rest) = messages(last);
    // Recordings may omit the line break at the end of a message, so only the JSON syntax shows whether more pieces
    // follow.
    match Tree::read(rest) {
        Err(SyntaxError { problem: TRUNCATED, .. }) if !rest.trim().is_empty() => {
            done.extend(messages.into_iter().map(str::to_owned));
            rest
        }
        _ => {
            take_line(last, messages, rest, done);
            ""
        }
    }
}

/// Moves the messages of a complete line to `done`. If other text follows them, a server can't read the line, so the
/// line is moved as a whole.
fn take_line(line: &str, messages: Vec<&str>, rest: &str, done: &mut Vec<String>) {
    if rest.trim().is_empty() {
        done.extend(messages.into_iter().map(str::to_owned));
    } else {
        done.push(line.to_owned());
    }
}

/// The messages at the start of a line, and the remaining text. A server can't read a line with bytes that aren't valid
/// UTF-8. Recordings contain U+FFFD instead of these bytes.
fn messages(line: &str) -> (Vec<&str>, &str) {
    let (mut messages, mut rest) = (Vec::new(), line);
    let is_readable = !line.contains(char::REPLACEMENT_CHARACTER);
    while is_readable && messages.len() < MAX_MESSAGES {
        let end = match Tree::read(rest) {
            Ok(_) => rest.len(),
            Err(error) => error.at,
        };
        let Some((first, after)) = rest.split_at_checked(end).filter(|(first, _)| is_object(first)) else {
            break;
        };
        messages.push(first);
        rest = after;
    }
    (messages, rest)
}

fn is_object(text: &str) -> bool {
    matches!(Tree::read(text), Ok(Tree::Object(_)))
}

fn unless_blank(text: &str) -> Option<String> {
    Some(text.to_owned()).filter(|text| !text.trim().is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn added(pieces: &[&str]) -> (Vec<String>, bool) {
        let mut all = Pieces::default();
        let done = pieces.iter().flat_map(|piece| all.add(0, piece)).collect();
        (done, all.is_incomplete(0))
    }

    #[test]
    fn a_line_with_too_many_messages_stays_whole() {
        let line = "{}".repeat(MAX_MESSAGES);
        assert_eq!(added(&[&line]).0.len(), MAX_MESSAGES);
        let longer = line + "{}";
        assert_eq!(added(&[&longer]).0, [longer]);
    }

    #[test]
    fn joins_pieces_and_splits_lines() {
        let one = r#"{"id":"a b"}"#;
        let two = r#"{"id":"c"}"#;
        for cut in 1..one.len() {
            let (start, end) = one.split_at(cut);
            assert_eq!(added(&[start, end]), (vec![one.to_owned()], false), "{cut}");
            let (last, next) = (format!("{end}\n{two}\n"), vec![one.to_owned(), two.to_owned()]);
            assert_eq!(added(&[start, &last]), (next, false), "{cut}");
        }
        assert_eq!(added(&[&format!("{one}{two}")]).0, [one, two]);
        assert_eq!(added(&["\n", one, "\r\n", two]).0, [one, two]);
    }

    #[test]
    fn returns_text_that_is_not_a_message() {
        assert_eq!(added(&["not a message", r#"{"id":"#]), (vec!["not a message".to_owned()], true));
        assert_eq!(added(&["{\"id\":\n", "1}"]).0, ["{\"id\":", "1}"]);
        assert_eq!(added(&[r#"{"id":"#, r#"{"id":1}"#]).0, [r#"{"id":"#, r#"{"id":1}"#]);
        // Text after a message makes the line unreadable.
        let line = r#"{"id":1}]"#;
        assert_eq!(added(&[line]).0, [line]);
        assert_eq!(added(&[r#"{"id":1}{"#, "]\n"]).0, [r#"{"id":1}"#, "{]"]);
        assert_eq!(added(&["{\"id\":1}{\n", "{\"id\":2}"]).0, ["{\"id\":1}{", "{\"id\":2}"]);
        let line = "{\"id\":\"\u{fffd}\"}{\"id\":1}";
        assert_eq!(added(&[line]).0, [line]);
    }

    #[test]
    fn stores_a_bounded_text() {
        let mut pieces = Pieces::default();
        let long = format!("{{\"id\":\"{}", "x".repeat(MAX_INCOMPLETE));
        assert_eq!(pieces.add(0, &long), [long]);
        for connection in 0..2 * MAX_CONNECTIONS {
            pieces.add(connection, "{");
        }
        assert_eq!(pieces.0.len(), MAX_CONNECTIONS);
    }
}
