//! Messages from a server, reduced to data about the fleet. The size of this data is limited.

use uavspec_flockwave::limits::MAX_ID;
use uavspec_model::json::Tree;

use super::roster::List;
use super::state::State;
use super::words::truncated;
use crate::limits::MAX_UAVS;

/// A message.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// The id of the request that this message answers.
    pub refs: Option<String>,
    /// The content.
    pub content: Content,
}

/// The content of a message.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    /// The server software and its version (SYS-VER).
    Server(String),
    /// The server's clock, in milliseconds since 1970 (SYS-TIME).
    Time(i64),
    /// All UAVs (UAV-LIST).
    List(List),
    /// The states of UAVs, or the reasons why states are missing (UAV-INF).
    States(Vec<(String, Result<State, String>)>),
    /// Removed UAVs (OBJ-DEL).
    Gone(Vec<String>),
    /// The reason why the server is about to close the connection (SYS-CLOSE).
    Closing(String),
    /// The reason why the server refused a request (ACK-NAK).
    Refused(String),
    /// Another message.
    Other,
    /// Data that is not a message.
    Unreadable,
}

impl Message {
    /// Parses a message.
    pub fn read(bytes: &[u8]) -> Self {
        let tree = std::str::from_utf8(bytes).ok().and_then(|text| Tree::read(text).ok());
        let Some(tree @ Tree::Object(_)) = tree else {
            return Self { refs: None, content: Content::Unreadable };
        };
        let refs = tree.get("refs").and_then(Tree::as_str).filter(|refs| refs.len() <= MAX_ID);
        Self { refs: refs.map(str::to_owned), content: content(&tree) }
    }
}

fn content(message: &Tree<'_>) -> Content {
    if let Some(error) = message.get("error").filter(|_| message.get("refs").is_some()) {
        return Content::Refused(error.get("message").map_or_else(String::new, text));
    }
    // Responses over HTTP may have no envelope.
    let body = message.get("body").unwrap_or(message);
    match body.get("type").and_then(Tree::as_str) {
        Some("SYS-VER") => Content::Server(server(body)),
        Some("SYS-TIME") => time(body),
        Some("UAV-LIST") => body.get("ids").and_then(list).map_or(Content::Other, Content::List),
        Some("UAV-INF") => Content::States(states(body)),
        Some("OBJ-DEL") => {
            body.get("ids").and_then(list).map_or(Content::Other, |list| Content::Gone(list.ids))
        }
        Some("SYS-CLOSE") => Content::Closing(body.get("reason").map_or_else(String::new, text)),
        Some("ACK-NAK") => Content::Refused(body.get("reason").map_or_else(String::new, text)),
        Some(_) => Content::Other,
        None => Content::Unreadable,
    }
}

/// The text of a string, or a description of any other value.
fn text(value: &Tree<'_>) -> String {
    value.as_str().map_or_else(|| truncated(&value.to_string()), truncated)
}

fn server(body: &Tree<'_>) -> String {
    let parts = [body.get("software"), body.get("version")];
    parts.into_iter().map(|part| part.map_or_else(|| "?".to_owned(), text)).collect::<Vec<_>>().join(" ")
}

fn time(body: &Tree<'_>) -> Content {
    match body.get("timestamp") {
        Some(Tree::Int(time)) => i64::try_from(*time).map_or(Content::Other, Content::Time),
        _ => Content::Other,
    }
}

fn list(value: &Tree<'_>) -> Option<List> {
    let Tree::List(values) = value else { return None };
    let ids = values.iter().filter_map(Tree::as_str).filter(|id| id.len() <= MAX_ID).take(MAX_UAVS);
    let ids: Vec<String> = ids.map(str::to_owned).collect();
    let is_whole = ids.len() == values.len();
    Some(List { ids, is_whole })
}

fn states(body: &Tree<'_>) -> Vec<(String, Result<State, String>)> {
    let members = |key| match body.get(key) {
        Some(Tree::Object(members)) => members.as_slice(),
        _ => &[],
    };
    let reported = members("status").iter().map(|(id, state)| (id, State::read(state).unwrap_or_default()));
    let reported = reported.map(|(id, state)| (id, Ok(state)));
    let refused = members("error").iter().map(|(id, reason)| (id, Err(text(reason))));
    let all = reported.chain(refused).filter(|(id, _)| id.len() <= MAX_ID).take(MAX_UAVS);
    all.map(|(id, state)| (id.clone().into_owned(), state)).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn read(text: &str) -> Content {
        Message::read(text.as_bytes()).content
    }

    #[test]
    fn reads_messages_with_and_without_an_envelope() {
        let body = r#"{"type": "SYS-VER", "software": "sky", "version": "2.1"}"#;
        for text in [body.to_owned(), format!(r#"{{"id": "a", "refs": "b", "body": {body}}}"#)] {
            assert_eq!(read(&text), Content::Server("sky 2.1".to_owned()));
        }
        let list = read(r#"{"type": "UAV-LIST", "ids": ["glider-1", 7]}"#);
        assert_eq!(list, Content::List(List { ids: vec!["glider-1".to_owned()], is_whole: false }));
        let states =
            read(r#"{"type": "UAV-INF", "status": {"a": {}, "b": 7}, "error": {"c": "no\u001bne"}}"#);
        let (reported, refused) = (Ok(State::default()), Err("no\\u{1b}ne".to_owned()));
        let expected = [("a", reported.clone()), ("b", reported), ("c", refused)];
        assert_eq!(states, Content::States(expected.map(|(id, state)| (id.to_owned(), state)).into()));
        assert_eq!(read(r#"{"refs": "a", "error": {"message": "no"}}"#), Content::Refused("no".to_owned()));
        assert_eq!(read(r#"{"body": {"type": "SYS-CLOSE"}}"#), Content::Closing(String::new()));
        assert_eq!(read(r#"{"body": {"type": "SYS-TIME", "timestamp": "now"}}"#), Content::Other);
        for unreadable in ["", "[]", "{}", "{\"body\": 7}", "glider", "{\"type\": 7}"] {
            assert_eq!(read(unreadable), Content::Unreadable, "{unreadable}");
        }
        assert_eq!(Message::read(b"\xff").content, Content::Unreadable);
    }

    #[test]
    fn limits_the_length_of_lists() {
        let ids: Vec<String> = (0..=MAX_UAVS).map(|number| format!("\"{number}\"")).collect();
        let Content::List(list) = read(&format!(r#"{{"type": "UAV-LIST", "ids": [{}]}}"#, ids.join(",")))
        else {
            panic!("a list");
        };
        assert_eq!((list.ids.len(), list.is_whole), (MAX_UAVS, false));
        let states: Vec<String> = ids.iter().map(|id| format!("{id}: {{}}")).collect();
        let states = read(&format!(r#"{{"type": "UAV-INF", "status": {{{}}}}}"#, states.join(",")));
        assert!(matches!(states, Content::States(states) if states.len() == MAX_UAVS));
    }

    proptest! {
        #[test]
        fn accepts_arbitrary_input(bytes in any::<Vec<u8>>(), text in r#"[\[\]{}:,"a0\\ -]{0,40}"#) {
            Message::read(&bytes);
            Message::read(text.as_bytes());
        }
    }
}
